"""Pads meshed and condensed once, for all scenes that march on the same: the march is what they look at."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import pytest

from skincad.mechanics.bodies import mesh
from skincad.mechanics.film import sliding

triangles = lru_cache(maxsize=32)(mesh.triangles)
condensed = lru_cache(maxsize=8)(sliding.sliding)


@pytest.fixture(autouse=True, scope="module")
def shared_pads() -> Iterator[None]:
    """Give the same mesh for the same pad and sizes, and of it the same condensed pad for the same order."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mesh, "triangles", triangles)
        patch.setattr(sliding, "sliding", condensed)
        yield
