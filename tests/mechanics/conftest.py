"""Shared by the tests of this room: how many BLAS threads they take, and triangles of the same pad."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from skincad.base import one_blas_thread
from skincad.mechanics.bodies import mesh
from skincad.mechanics.film import stress
from skincad.mechanics.models import linear
from tests.shared_pads import triangles


@pytest.fixture(scope="module", autouse=True)
def _one_blas_thread() -> Iterator[None]:
    """As every solver of the product has it: what a test calls inside a solver is small and dense, and two
    workers with two threads each mostly wait for each other."""
    with one_blas_thread():
        yield


@pytest.fixture(scope="module", autouse=True)
def _same_triangles() -> Iterator[None]:
    """A pad that was meshed with these sizes is not meshed again: a quarter of the time here is netgen's."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (mesh, stress, linear):
            patch.setattr(module, "triangles", triangles)
        yield
