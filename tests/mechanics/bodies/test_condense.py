"""Condensing: one factorisation of the whole, definite or not."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from netgen.geom2d import SplineGeometry
from netgen.meshing import NgException
from ngsolve import Mesh
from scipy import sparse

from skincad import load
from skincad.mechanics import ContactError, default_sizes, pad_of, triangles
from skincad.mechanics.bodies import condense, elements, mesh, plane_body
from tests.mechanics.designs import filleted


def test_only_a_singular_matrix_is_called_singular(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ContactError, match="singular"):
        condense.factors(sparse.csc_matrix(np.zeros((3, 3))))

    def splu(*_: object, **__: object) -> None:
        raise RuntimeError("can't start new thread")

    monkeypatch.setattr(condense, "splu", splu)
    with pytest.raises(RuntimeError, match="thread"):
        condense.factors(sparse.identity(3, format="csc"))


def indefinite(seed: int) -> np.ndarray:
    """Of 12 unknowns, positive definite while the last 4 are held, and with 2 negative eigenvalues."""
    random = np.random.default_rng(seed)
    inner, side = random.standard_normal((8, 8)), random.standard_normal((4, 8))
    inner = inner @ inner.T + 8 * np.eye(8)
    turned = np.linalg.qr(random.standard_normal((4, 4)))[0]
    last = turned @ np.diag([-2.0, -1.0, 1.0, 3.0]) @ turned.T + side @ np.linalg.solve(inner, side.T)
    return np.block([[inner, side.T], [side, last]])


@pytest.mark.parametrize("seed", range(4))
def test_an_indefinite_matrix_is_condensed_and_its_signs_counted(seed: int) -> None:
    whole = indefinite(seed)
    condensed = condense.factorise(sparse.csr_matrix(whole), np.arange(12), 4)
    assert condensed.flexibility == pytest.approx(np.linalg.inv(whole)[-4:, -4:], rel=1e-9)
    assert (int((condensed.pivots[:-4] < 0).sum()), int((condensed.pivots < 0).sum())) == (0, 2)
    loads = np.arange(24.0).reshape(12, 2)
    assert condensed.at_contact(loads) == pytest.approx(np.linalg.solve(whole, loads)[-4:], rel=1e-9)
    with pytest.raises(ContactError, match="not positive definite"):
        condense.condense(sparse.csr_matrix(whole), np.arange(8), np.arange(8, 12))
    one = condense.Front(np.arange(8), np.arange(8, 12), (), np.arange(1))
    factors = condense.factored(lambda _: [(np.arange(12), whole)], [one], lambda functions: functions, 12)
    assert factors.flexibility == pytest.approx(condensed.flexibility, rel=1e-9)
    assert factors.solve(loads[:, 0]) == pytest.approx(np.linalg.solve(whole, loads[:, 0]), rel=1e-9)
    assert factors.negative_eigenvalues == 2


def test_a_tangent_is_singular_only_where_its_library_says_so() -> None:
    """Of a state that is no state NGSolve finds an element's block singular; memory is another matter."""
    square = SplineGeometry()
    square.AddRectangle((0, 0), (1, 1), bcs=("back", "free", "contact1", "free"))
    square.SetMaterial(1, "skin")
    body = plane_body.body(Mesh(square.GenerateMesh(maxh=0.5)), 2, {"skin": (1.0, 0.49)})
    nowhere = np.full(body.free.size, np.nan)
    with pytest.raises(ContactError, match="the tangent stiffness of an element is singular"):
        body.linearised(nowhere, nowhere)


@pytest.mark.parametrize("failure", [NgException("Could not allocate localheap"), MemoryError()])
def test_memory_that_ran_out_is_no_singular_tangent(
    failure: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Form:
        def AssembleLinearization(self, _: object) -> None:  # noqa: N802
            raise failure

    monkeypatch.setattr(plane_body, "_vector", lambda *_: None)
    with pytest.raises(type(failure)):
        plane_body.NeoHookeBody.linearised(SimpleNamespace(form=Form()), np.zeros(1), np.zeros(1))


def test_netgen_without_memory_is_no_bad_section(monkeypatch: pytest.MonkeyPatch) -> None:
    def without(*_: object) -> object:
        raise NgException("std::bad_alloc")

    monkeypatch.setattr(mesh, "_geometry", without)
    pad = pad_of(filleted())
    with pytest.raises(NgException):
        mesh.triangles(pad, mesh.default_sizes(pad, 1.0))


@pytest.mark.parametrize(
    ("springs", "negative_eigenvalues"),
    [([2, 0.5, 3], (0, 0)), ([2, -0.5, 3], (1, 1)), ([2, 0.5, -3], (0, 1))],
)
def test_negative_stiffnesses_are_counted_inside_and_in_all(
    springs: list[float], negative_eigenvalues: tuple[int, int]
) -> None:
    """Of three springs the last is the contact's."""
    small = condense.factorise(sparse.csr_matrix(np.diag(springs)), np.arange(3), 1)
    linear_state = plane_body.PlaneLinearised(None, None, small, small.flexibility, None, None)
    assert linear_state.negative_eigenvalues == negative_eigenvalues


@pytest.mark.parametrize("part", ["interior", "contact"])
def test_a_stiffness_that_is_not_definite_is_refused(part: str) -> None:
    pad = pad_of(load("plain-ridges"))
    curved = elements.curved(triangles(pad, default_sizes(pad, 0.5)), 2)
    system = elements.assemble(curved, 2, pad.materials)
    less = np.zeros(system.lift.size)
    less[getattr(system, part)[::7]] = 1e3
    bad = sparse.csr_matrix(system.matrix - sparse.diags(less))
    with pytest.raises(ContactError, match="not positive definite"):
        condense.condense(bad, system.interior, system.contact)
