"""A pad on its half against the whole, on a mesh that is its own mirror image."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from netgen.meshing import Element1D, Element2D, FaceDescriptor, Mesh, MeshPoint, Pnt

from skincad.inputs import Design
from skincad.mechanics import (
    Pad,
    PadPiece,
    Request,
    half_of,
    height_of,
    pad_of,
    plane_piece,
    ridge_model,
    unit_of,
)
from skincad.mechanics.bodies import elements, plane_body
from skincad.mechanics.contact import frictionless
from skincad.mechanics.models import linear
from tests.mechanics.designs import THREE, filleted, reference, yamada

FORCE, ORDER = 1.3, 2
ROUNDING = 1e-8  # of a condition of 1e8 and more, the back's corners being small and films stiff


def straight(mesh: Any, image: dict[str, str] | None = None) -> Any:
    """The mesh with straight edges, and with its mirror image where boundaries' names there are given."""
    points = np.array([p.p for p in mesh.Points()])[:, :2]
    names = [mesh.GetBCName(e.index - 1) for e in mesh.Elements1D()]
    edges = [(tuple(v.nr - 1 for v in e.points), n) for e, n in zip(mesh.Elements1D(), names, strict=True)]
    faces = [(e.index, tuple(v.nr - 1 for v in e.vertices)) for e in mesh.Elements2D()]
    if image is not None:
        on_cut = np.abs(points[:, 0]) < 1e-12
        other = np.where(on_cut, np.arange(len(points)), len(points) + np.cumsum(~on_cut) - 1)
        points = np.concatenate([points, points[~on_cut] * [-1, 1]])
        edges = [(pair, name) for pair, name in edges if name != "cut"]
        edges += [((int(other[b]), int(other[a])), image[name]) for (a, b), name in edges]
        faces += [(kind, tuple(int(other[v]) for v in reversed(corners))) for kind, corners in faces]
    mirrored = Mesh(dim=2)
    numbers = [mirrored.Add(MeshPoint(Pnt(x, z, 0))) for x, z in points.tolist()]
    for kind in sorted({kind for kind, _ in faces}):
        mirrored.Add(FaceDescriptor(surfnr=kind, domin=kind, bc=kind))
        mirrored.SetMaterial(kind, ("skin", "film")[kind - 1])
    for kind, corners in faces:
        mirrored.Add(Element2D(kind, [numbers[v] for v in corners]))
    kinds = sorted({name for _, name in edges})
    for i, name in enumerate(kinds):
        mirrored.SetBCName(i, name)
    for (a, b), name in edges:
        mirrored.Add(Element1D([numbers[a], numbers[b]], index=kinds.index(name) + 1))
    return mirrored


def both(pad: Pad, fineness: float = 0.25) -> tuple[PadPiece, PadPiece]:
    """The half of a pad, and the whole of it on the same triangles and their images, in the half's unit."""
    half = plane_piece(pad, fineness)
    assert half.mirrored
    numbers = pad.ridges
    image = {f"contact{a}": f"contact{b}" for a, b in zip(numbers, reversed(numbers), strict=True)}
    image |= {name: name for name in ("back", "free", "inside")}
    whole = PadPiece(pad, pad, False, half.unit, straight(half.mesh, image))
    return PadPiece(pad, half.pad, True, half.unit, straight(half.mesh)), whole


CASES = {
    "odd": lambda: reference().with_(**THREE),
    "even": lambda: filleted().with_(ridge={"count": 4}, skin={"width": 6.0}),
    "films": lambda: yamada().with_(**THREE),
    "two": lambda: reference().with_(ridge={"count": 2}, skin={"width": 4.0}),
}


@cache
def solved(name: str) -> tuple[Pad, linear.PlaneSolution, linear.PlaneSolution]:
    """A pad, its half's solution and the whole's."""
    pad = pad_of(CASES[name]())
    half, whole = (linear.level(piece, ORDER, FORCE) for piece in both(pad))
    return pad, half, whole


@pytest.mark.parametrize("name", CASES)
def test_the_half_tells_of_the_whole(name: str) -> None:
    _, half, exact = solved(name)
    assert half.approach == pytest.approx(exact.approach, rel=ROUNDING)
    scale = ROUNDING * FORCE
    assert half.all_touch_force == pytest.approx(exact.all_touch_force, rel=ROUNDING, abs=scale)
    assert half.ridge_force == pytest.approx(exact.ridge_force, abs=scale)
    assert (half.touching, half.fault) == (exact.touching, exact.fault)
    right = exact.x >= 0
    order, same = np.argsort(exact.x[right]), np.argsort(half.x)
    assert half.x[same] == pytest.approx(exact.x[right][order], abs=1e-9)
    wanted = exact.pressure[right][order]
    assert half.pressure[same] == pytest.approx(
        wanted, abs=1e2 * ROUNDING * wanted.max()
    )  # of a small weight


@pytest.mark.parametrize("name", CASES)
def test_loads_on_one_side_are_the_wholes(name: str) -> None:
    """Symmetric and antisymmetric loads of the half give what one load does on either side of the whole."""
    pad, half, exact = solved(name)
    flexibility, gap, of_point = frictionless.on_both_sides(half.ridges, half.half, pad.ridges)
    off = np.abs(half.x) > 1e-9
    x = np.concatenate([half.x, -half.x[off]])
    mine, theirs = np.argsort(x), np.argsort(exact.x)
    assert x[mine] == pytest.approx(exact.x[theirs], abs=1e-9)
    wanted = exact.ridges.flexibility[np.ix_(theirs, theirs)]
    largest = ROUNDING * np.abs(wanted).max()
    assert np.abs(flexibility[np.ix_(mine, mine)] - wanted).max() <= largest
    assert (of_point[mine] == exact.ridges.of_point[theirs]).all()
    assert gap[mine] == pytest.approx(exact.ridges.gap[theirs], abs=1e-12)


@pytest.mark.parametrize("name", ["odd", "even"])
def test_the_yields_model_is_the_wholes(name: str) -> None:
    pad, half, exact = solved(name)
    model = linear.reduced_model(pad, half, FORCE, {})
    largest = max(FORCE, exact.all_touch_force or 0.0)
    wanted = ridge_model(*exact.ridges.points, largest, exact.unit, exact.scale)
    for mine, theirs in ((model.coupling, wanted.coupling), (model.indentation, wanted.indentation)):
        assert np.abs(mine - theirs).max() <= ROUNDING * np.abs(theirs).max()
    assert model.gap == pytest.approx(wanted.gap, abs=1e-12)
    assert (model.unit, model.scale) == pytest.approx((wanted.unit, wanted.scale), rel=1e-12)


def bent(design: Design) -> Pad:
    return pad_of(design.with_(contact={"plate": {"shape": "cylinder", "radius": 50.0}}))


def test_what_is_not_its_own_image_is_meshed_whole() -> None:
    design = reference().with_(**THREE)
    pad = pad_of(design)
    assert half_of(bent(design)) is None
    assert not plane_piece(bent(design), 0.25).mirrored
    assert not plane_piece(pad, 0.25, whole=True).mirrored
    piece = plane_piece(pad, 0.25)
    assert piece.unit == unit_of(piece.pad)
    with pytest.raises(ValueError, match="zip"):
        linear.level(piece, ORDER, FORCE, (0.0, 0.01, 0.0))
    low = linear.solve(pad, Request(FORCE, 0.05, crest_offsets=(0.0, 0.0, 0.03)))
    shares = [f.value or 0.0 for f in low.ridge_force]
    assert shares[2] < shares[0]  # crests of one part are not mirrored, nor what they bear


def test_what_crosses_the_middle_of_a_half_meets_its_image() -> None:
    piece = plane_piece(pad_of(CASES["even"]()), 0.25)
    system = elements.assemble(elements.curved(piece.mesh, ORDER), ORDER, piece.pad.materials)
    above = 2 * height_of(piece.whole) / piece.unit
    vertices = np.arange(system.mesh.nv)  # in a hierarchical basis 1 at each vertex is a translation
    for shift, wrong in (
        (-2 * plane_body.THROUGH, "two ridges meet in the middle"),
        (-plane_body.THROUGH / 2, None),
        (0.1, None),
    ):
        moved = np.zeros(system.lift.size)
        moved[vertices] = shift
        loops = elements.outlines(system, moved)
        assert plane_body.undetected_contact(loops, lambda x: np.full_like(x, above), mirrored=True) == wrong
        assert plane_body.undetected_contact(loops, lambda x: np.full_like(x, above)) is None
