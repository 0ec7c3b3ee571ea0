"""Scenes of this folder share their pads."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.shared_pads import shared


@pytest.fixture(autouse=True, scope="module")
def _shared_pads() -> Iterator[None]:
    with shared():
        yield
