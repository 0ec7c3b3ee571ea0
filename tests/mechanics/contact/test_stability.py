"""Stable under a plate: against the eigenvalues, dense, of the tangent for what the plate allows."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from scipy import linalg

from skincad.inputs import Design
from skincad.mechanics import Layers, body_of, default_sizes, pad_of, triangles, unit_of, validity
from skincad.mechanics.bodies import elements, plane_body, solid_body
from skincad.mechanics.contact import newton, stability
from tests.mechanics.contact.test_mirrored import both
from tests.mechanics.designs import reference

stable = newton.stable  # of which some tests rid the module
SCALE = 0.8 * 12.0  # N for a force of 1 on the reference section, whose unit is a mm


def design_of(count: int) -> Design:
    return reference().with_(ridge={"count": count}, skin={"width": 1.0 + 1.1 * count, "length": 12.0})


@cache
def pad(count: int = 1) -> newton.PressedPad:
    whole = pad_of(design_of(count))
    assert unit_of(whole) * whole.young_modulus * whole.length == pytest.approx(SCALE * unit_of(whole))
    mesh = elements.curved(triangles(whole, default_sizes(whole, 0.25)), 2)
    return newton.PressedPad(
        plane_body.body(mesh, 2, {"skin": (1.0, whole.poisson_ratio)}), whole.top / unit_of(whole)
    )


def spectra(what: newton.PressedPad, state: newton.PressedState) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eigenvalues of the tangent, free and as the plate holds it, and the latter's first vector."""
    body = what.body
    matrix = body.linearised(state.values, body.residual(state.values)).matrix
    whole = matrix[body.order][:, body.order].toarray()
    rows = np.zeros((int(state.contact.active.sum()), body.order.size))
    rows[:, -body.rest.contact.size :] = body.rest.nodes.rows[state.contact.active].toarray()
    allowed = linalg.null_space(np.diff(rows, axis=0))  # what touches moves by the same height
    values, vectors = linalg.eigh(allowed.T @ whole @ allowed)
    mode = np.zeros(state.values.size)
    mode[body.order] = allowed @ vectors[:, 0]
    return linalg.eigvalsh(whole), values, mode


def test_what_the_plate_holds_up_is_stable() -> None:
    state = newton.press_to(pad(), 2.6 / SCALE)
    free, under_plate, _ = spectra(pad(), state)
    assert free[0] < 0 < under_plate[0]
    linear = pad().body.linearised(state.values, pad().body.residual(state.values))
    assert linear.negative_eigenvalues == (0, int((free < 0).sum()))
    assert stable(pad().body, linear, state.ridges, state.contact)


@pytest.mark.slow
def test_what_gives_way_under_the_plate_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(
        newton.DivergedError, match="ridge 1 tips over, no equilibrium beyond is stable"
    ) as caught:
        newton.press_to(pad(), 4.0 / SCALE)
    last = caught.value.reached
    # a column that shears is within 25 % of any ridge higher than wide (validity.buckling_force)
    assert last * SCALE == pytest.approx(validity.buckling_force(design_of(1)), rel=0.25)
    monkeypatch.setattr(newton, "stable", lambda *_, **__: True)
    state = newton.press_to(pad(), 1.1 * last)
    _, under_plate, _ = spectra(pad(), state)
    assert under_plate[0] < 0
    linear = pad().body.linearised(state.values, pad().body.residual(state.values))
    assert not stable(pad().body, linear, state.ridges, state.contact)
    _, under_plate, _ = spectra(pad(), newton.press_to(pad(), last))
    assert under_plate[0] > 0


@pytest.mark.slow
def test_the_ridge_that_tips_over_is_named() -> None:
    what = pad(3)
    state = newton.press_to(what, 4.0 / SCALE)
    _, _, mode = spectra(what, state)
    nearest = np.abs(
        what.body.rest.nodes.position[:, 0] - stability.x_of_largest_displacement(what.body, mode)
    ).argmin()
    linear = what.body.linearised(state.values, what.body.residual(state.values))
    tipping = stability.tipping_ridge(what.body, state.values, linear, state.contact)
    ridge = int(what.body.rest.nodes.ridge[nearest])
    assert ridge != 2
    assert tipping in (ridge, 4 - ridge)  # the pad is symmetric: either, by rounding


def sides(count: int) -> tuple[newton.PressedPad, newton.PressedPad]:
    """The half of a pad and, on its triangles and their images, the whole; in the half's unit."""
    design = design_of(count)
    return tuple(
        newton.PressedPad(
            plane_body.body(elements.curved(piece.mesh, 2), 2, piece.whole.materials),
            piece.whole.top / piece.unit,
        )
        for piece in both(pad_of(design))
    )


def force_of(what: newton.PressedPad, share: float) -> float:
    """A force on what is meshed that is as much on a ridge, in units."""
    return share if what.body.antisymmetric.size == 0 else share / 2


@pytest.mark.parametrize(
    "count",
    [
        pytest.param(1, marks=pytest.mark.slow),
        *(pytest.param(n, marks=pytest.mark.evidence(subject="stability: halves")) for n in (2, 3)),
    ],
)
def test_what_turns_round_is_seen_on_the_half(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The half and the whole are refused at the same force, also where every ridge tips to the same side."""
    limits = []
    for what in sides(count):
        with pytest.raises(newton.DivergedError) as caught:
            newton.press_to(what, force_of(what, 1.2 * count))
        limits.append((caught.value.reached / force_of(what, 1.0), str(caught.value)))
    (half, words), (whole, _) = limits
    assert half == pytest.approx(whole, rel=1e-6)  # the same bisection on the same triangles
    if count != 1:
        return
    assert words.startswith("ridge 1 tips over")
    # its own image cannot tip over: by that alone the half would stand far beyond
    monkeypatch.setattr(plane_body.PlaneLinearised, "antisymmetric", lambda _: None)
    what = sides(count)[0]
    assert newton.press_to(what, force_of(what, 1.5 * half)).force == force_of(what, 1.5 * half)


@pytest.mark.evidence(subject="stability: halves")
def test_what_turns_round_is_seen_on_a_solids_half(monkeypatch: pytest.MonkeyPatch) -> None:
    """One ridge between clamped ends, on the same triangles: the same bisection."""
    limits = []
    for piece in both(pad_of(design_of(1))):
        body = body_of(piece, Layers(2.0, 2.0, 2), clamped_end=True)
        share = piece.whole.length / 2 / piece.unit / piece.sides
        with pytest.raises(newton.DivergedError, match="ridge 1 tips over") as caught:
            newton.press_to(newton.PressedPad(body, piece.whole.top / piece.unit), 1.2 * share)
        limits.append((caught.value.reached / share, body, share, piece))
    (half, body, share, piece), (whole, *_) = limits
    assert half == pytest.approx(whole, rel=1e-6)
    monkeypatch.setattr(solid_body.SolidLinearised, "antisymmetric", lambda _: None)
    what = newton.PressedPad(body, piece.whole.top / piece.unit)
    assert newton.press_to(what, 1.5 * half * share).force == 1.5 * half * share


@pytest.mark.slow
@pytest.mark.parametrize("count", [1, 3])
@pytest.mark.parametrize("share", [0.9, 1.3])
def test_both_kinds_of_movements_are_all_there_are(
    count: int, share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Negative eigenvalues of the whole are those of the half's symmetric and antisymmetric movements
    together, held by the plate or not; the verdict is that of the whole's dense ones."""
    monkeypatch.setattr(newton, "stable", lambda *_, **__: True)
    counted = []
    for what in sides(count):
        state = newton.press_to(what, force_of(what, share * 2.62 / SCALE * count))
        linear = what.body.linearised(state.values, what.body.residual(state.values))
        kinds = [kind for kind in (linear, linear.antisymmetric()) if kind is not None]
        assert len(kinds) == (2 if what.body.antisymmetric.size else 1)
        verdict = stable(what.body, linear, state.ridges, state.contact)
        counted.append((np.sum([kind.negative_eigenvalues for kind in kinds], axis=0).tolist(), verdict))
        free, under_plate, _ = spectra(what, state)
    assert counted[0] == counted[1]
    assert counted[1][0][1] == (free < 0).sum()
    assert counted[1][1] == (under_plate[0] > 0)
