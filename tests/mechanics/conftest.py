"""Shared by the tests of this room: how many BLAS threads they take."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from skincad.base.blas import one_blas_thread


@pytest.fixture(scope="module", autouse=True)
def _one_blas_thread() -> Iterator[None]:
    """As every solver of the product has it: what a test calls inside a solver is small and dense, and two
    workers with two threads each mostly wait for each other."""
    with one_blas_thread():
        yield
