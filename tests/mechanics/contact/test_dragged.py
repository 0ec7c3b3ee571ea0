"""The neo-Hookean pad under a plate with friction: closed forms, tangent, invariants, steps that are cut."""

from __future__ import annotations

from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from skincad import mechanics as mech
from skincad.mechanics.bodies import elements, plane_body
from skincad.mechanics.contact import folding, frictional_pad
from skincad.mechanics.contact import newton as pressing
from skincad.mechanics.contact.relaxation import relaxed
from skincad.mechanics.problem import DeformedLoop
from tests.mechanics import closed_forms
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.contact.travel import advance_to
from tests.mechanics.designs import filleted, yamada

CONE = mech.FrictionCoefficients(0.5, 0.5)
STICKY = mech.FrictionCoefficients(20.0, 20.0)
COARSE = 0.35  # fineness: 0.1 s a step
SMOOTH = mech.FrictionCoefficients(0.0, 0.0)


def whole(
    pad: mech.Pad, fineness: float = 0.5, order: int = 2, sizes: mech.Sizes | None = None
) -> mech.FrictionalPad:
    unit = mech.unit_of(pad)
    mesh = elements.curved(mech.triangles(pad, sizes or mech.default_sizes(pad, fineness)), order)
    scale = pad.young_modulus * unit * pad.length
    materials = {"skin": (1.0, pad.poisson_ratio), "film": (3750.0, 0.35)}
    return mech.frictional_pad_of(plane_body.body(mesh, order, materials), pad.top, unit, scale)


@cache
def three() -> tuple[mech.Pad, mech.FrictionalPad]:
    """Three ridges, as coarse as can be."""
    pad = mech.pad_of(filleted().with_(ridge={"count": 3}, skin={"width": 5.0}))
    return pad, whole(pad, COARSE)


def march(
    pad: mech.FrictionalPad,
    drives: list[mech.Drive],
    cone: mech.FrictionCoefficients,
    start: mech.FrictionalState | None = None,
) -> list[mech.FrictionalState]:
    states = [start or frictional_pad.unloaded(pad)]
    for before, after in pairwise([mech.Drive(0.0, 0.0), *drives] if start is None else drives):
        states.append(advance_to(pad, states[-1], before, after, cone))
    return states[1:]


@cache
def pulled() -> list[mech.FrictionalState]:
    """Pressed by 1.2 N in three steps, pulled to 0.54 N of 0.6 in six."""
    drives = [mech.Drive(0.4 * i, 0.0) for i in (1, 2, 3)] + [mech.Drive(1.2, 0.09 * i) for i in range(1, 7)]
    return march(three()[1], drives, CONE)


def test_a_block_sheared_with_stick_is_simple_shear() -> None:
    """Bonded by friction, pressed to l h, then dragged by s: P_xz = G s / h and P_zz = G (l - 1 / l) +
    lambda (l - 1) in its middle, for F = [[1, s / h], [0, l]]. 1e-3: its ends, 8 heights away.
    """
    pad = block(8.0, 0.5, 0.3)
    what = whole(pad, sizes=mech.Sizes(0.1, 0.1, 0.1, 0.1))
    drives = [mech.Drive(1.0, travel=0.0), *(mech.Drive(1.0, travel=0.05 * i) for i in (1, 2))]
    state = march(what, drives, STICKY)[-1]
    shear, rest = closed_forms.lame(0.7, 0.3)
    stretch = 1 - state.contact.approach / 0.5
    middle = np.abs(what.x) < 0.3
    nodal = what.weight[middle] * pad.length
    along = state.contact.tangential[middle] / nodal
    normal = -state.contact.normal[middle] / nodal
    assert (state.contact.status == mech.STICK)[middle].all()
    assert along.mean() == pytest.approx(closed_forms.neo_hookean_shear(0.2, shear), rel=1e-3)
    assert normal.mean() == pytest.approx(shear * (stretch - 1 / stretch) + rest * (stretch - 1), rel=1e-3)


def test_without_friction_it_is_the_finite_strain_model() -> None:
    """On one mesh, to ten times the residuals."""
    pad, what = three()
    unit = mech.unit_of(pad)
    mesh = elements.curved(mech.triangles(pad, mech.default_sizes(pad, COARSE)), 2)
    wanted = pressing.press_to(
        pressing.PressedPad(plane_body.body(mesh, 2, {"skin": (1.0, pad.poisson_ratio)}), pad.top / unit),
        1.2 / what.scale,
    )
    state = march(what, [mech.Drive(0.6, 0.0), mech.Drive(1.2, 0.0)], SMOOTH)[-1]
    assert state.values == pytest.approx(
        wanted.values, abs=10 * pressing.RESIDUAL * np.abs(wanted.values).max()
    )
    assert state.contact.normal.sum() == pytest.approx(1.2, rel=1e-10)
    assert not state.contact.tangential.any()


@pytest.mark.slow
def test_small_loads_are_small_strain_to_first_order() -> None:
    """The relative distance of travels and films' stresses halves with the load: order 1 within 0.15."""
    design = yamada().with_(ridge={"count": 3}, skin={"width": 5.0})
    piece = mech.piece_of(*mech.filled_pad(design), halved=False)
    mesh = mech.triangles(piece.pad, mech.default_sizes(piece.pad, COARSE))
    small = mech.sliding(piece, mesh, 2, True)
    stiff = {"skin": (1.0, piece.pad.poisson_ratio), "film": (3750.0, 0.35)}
    scale = piece.pad.young_modulus * piece.unit * piece.pad.length
    what = mech.frictional_pad_of(
        plane_body.body(elements.curved(mesh, 2), 2, stiff), piece.pad.top, piece.unit, scale
    )
    assert piece.pad.materials == {name: pytest.approx(moduli) for name, moduli in stiff.items()}
    strips = mech.strip_stress(what.body, 2, piece)
    differences = []
    for force in (1e-3, 5e-4, 2.5e-4):
        # one touching point moves on to the next as it grows: bonded points make the contact the same
        drives = [mech.Drive(force, travel=0.0), mech.Drive(force, 0.3 * force)]
        state = march(what, drives, STICKY)[-1]
        skin = mech.Compliance(small.compliance, small.gap, np.zeros(2 * small.gap.size))
        linear = mech.solve_contact(skin, frictional_pad.unloaded(what).contact, drives[0], STICKY)
        linear = mech.solve_contact(skin, linear, drives[1], STICKY)
        assert (linear.status == state.contact.status).all()
        stress = small.strips @ np.concatenate([linear.tangential, -linear.normal])
        films = strips.at(state.values) * piece.pad.young_modulus
        largest = np.abs(stress).max()
        differences.append([state.contact.travel / linear.travel - 1, np.abs(films - stress).max() / largest])
    rates = np.log2(np.abs(np.array(differences[:-1]) / np.array(differences[1:])))
    assert np.abs(differences[-1]).max() < 0.02
    assert rates == pytest.approx(np.ones_like(rates), abs=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("drives", [(0.3, None), (None, 0.7)], ids=["stick", "slip"])
def test_tangent_is_the_derivative(drives: tuple[float | None, float | None]) -> None:
    """What the linearised contact predicts for a change of the drive by 1e-5, against central differences.

    In stick the pull changes; in slip, where all slides, the normal force. 1e-3: what the states' residuals
    of 1e-9 and the change's second order leave of the difference.
    """
    what, (pull, travel) = three()[1], drives
    cone = STICKY if pull else mech.FrictionCoefficients(0.3, 0.3)
    steps = [mech.Drive(1.0, travel=0.0), mech.Drive(1.0, travel=(travel or 0.1) / 2)]
    start = march(what, [*steps, mech.Drive(1.0, pull, travel)], cone)[-1]
    change = 1e-5

    def drive(share: float) -> mech.Drive:
        more = share * change
        return mech.Drive(1.0, pull + more) if pull else mech.Drive(1.0 + more, travel=(travel or 0.0) + 0.05)

    here = frictional_pad.newton(what, start, drive(0.0), cone)
    frictional_pad.linearised(what, here.values, what.body.residual(here.values))
    skin = predicted(what, here)
    ahead, back = (frictional_pad.newton(what, start, drive(s), cone).contact for s in (1.0, -1.0))
    guess = mech.solve_contact(skin, start.contact, drive(1.0), cone)
    assert (ahead.status == back.status).all()
    assert guess.slips[guess.touches].all() != bool(pull)
    for name in ("approach", "travel"):
        slope = (getattr(ahead, name) - getattr(back, name)) / 2
        largest = abs(ahead.approach - back.approach) + abs(ahead.travel - back.travel)
        assert getattr(guess, name) - getattr(here.contact, name) == pytest.approx(slope, abs=1e-3 * largest)


def predicted(what: mech.FrictionalPad, here: mech.FrictionalState) -> mech.Compliance:
    """The linearised contact at a state, which is in balance with its contact forces."""
    linear = what.tangents[0]
    force = np.concatenate([here.contact.tangential, -here.contact.normal])
    place = what.rows @ here.values[what.contact] * what.unit
    return mech.Compliance(linear.compliance, what.gap, place - linear.compliance @ force)


@pytest.mark.slow
def test_every_accepted_step_meets_contact_friction_and_balance() -> None:
    """Checked apart from the solver's own measure, to its 1e-9."""
    what = three()[1]
    m = what.gap.size
    for state in pulled():
        contact = state.contact
        moved = what.rows @ state.values[what.contact] * what.unit
        gap = what.gap - contact.approach - moved[m:]
        length, largest = np.ptp(what.gap), contact.normal.max()
        assert gap.min() >= -1e-9 * length
        assert np.abs(gap * contact.normal).max() <= 1e-9 * length * largest
        assert (np.abs(contact.tangential) - 0.5 * contact.normal).max() <= 1e-9 * largest
        assert (contact.tangential * contact.slipped).max() <= 1e-9 * length * largest
        assert state.residual <= pressing.RESIDUAL
        assert state.dissipated >= -1e-9 * largest * length


@pytest.mark.slow
def test_a_held_load_does_not_creep() -> None:
    what = three()[1]
    first = state = pulled()[-2]
    drive = mech.Drive(1.2, 0.45)
    for _ in range(20):
        before, state = state, frictional_pad.newton(what, state, drive, CONE)
        assert state.iterations == 1
        change = np.abs(state.values - before.values).max()
        assert change <= 10 * pressing.RESIDUAL * np.abs(state.values).max()
    stuck = first.contact.status == mech.STICK
    assert stuck.any()
    assert (first.contact.anchor[stuck] == state.contact.anchor[stuck]).all()
    assert state.contact.travel == pytest.approx(first.contact.travel, rel=10 * pressing.RESIDUAL)


@pytest.mark.slow
def test_gross_slip_tells_the_state_that_slips() -> None:
    with pytest.raises(mech.GrossSlip) as end:
        advance_to(three()[1], pulled()[-1], mech.Drive(1.2, 0.54), mech.Drive(1.2, 0.61), CONE)
    last = end.value.last
    assert isinstance(last, mech.FrictionalState)
    assert last.contact.slips.all() or last.contact.gross
    assert last.contact.tangential.sum() == pytest.approx(0.6, rel=1e-9)
    assert last.residual <= pressing.RESIDUAL


@pytest.mark.slow
def test_lifting_the_plate_forgets_it() -> None:
    what = three()[1]
    pressed = march(what, [mech.Drive(0.8, 0.0)], CONE)[-1]
    lifted = advance_to(what, pressed, mech.Drive(0.8, 0.0), mech.Drive(0.0, 0.0), CONE)
    assert not lifted.values.any()
    assert not lifted.contact.normal.any()


@pytest.mark.slow
def test_a_step_without_equilibrium_is_refused() -> None:
    """More than the skin bears: an accepted state balances, so this is an error, not a state."""
    with pytest.raises(mech.ContactError):
        advance_to(
            three()[1],
            frictional_pad.unloaded(three()[1]),
            mech.Drive(0.0, 0.0),
            mech.Drive(60.0, 0.0),
            SMOOTH,
            0,
        )


def affine(what: mech.FrictionalPad, gradient: np.ndarray, pressure: float) -> np.ndarray:
    """The state of one displacement gradient and pressure, the clamped back along with it."""
    import ngsolve as ng

    field = ng.GridFunction(what.body.space)
    place = ng.CF((ng.x, ng.y))
    # Set() keeps clamped unknowns at zero: the strips are far from the back
    field.components[0].Set(ng.CF(tuple(map(tuple, gradient)), dims=(2, 2)) * place)
    field.components[1].Set(ng.CF(pressure))
    return np.array(field.vec.FV().NumPy())


@pytest.mark.slow
def test_a_step_that_does_not_converge_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first tries are made to fail: the halves then are what the step took."""
    tries = []

    def failing(pad: Any, before: mech.FrictionalState, end: mech.Drive, *more: Any) -> mech.FrictionalState:
        tries.append(end.normal)
        if len(tries) == 1:
            raise mech.ContactError("made to fail")
        return newton(pad, before, end, *more)

    newton = frictional_pad.newton
    monkeypatch.setattr(frictional_pad, "newton", failing)
    what = three()[1]
    state = advance_to(what, frictional_pad.unloaded(what), mech.Drive(0.0, 0.0), mech.Drive(0.4, 0.0), CONE)
    assert tries == [0.4, 0.2, 0.4]
    first = newton(what, frictional_pad.unloaded(what), mech.Drive(0.2, 0.0), CONE)
    second = newton(what, first, mech.Drive(0.4, 0.0), CONE)
    assert state.values == pytest.approx(second.values, abs=1e-8 * np.abs(second.values).max())
    assert state.dissipated == pytest.approx(first.dissipated + second.dissipated, rel=1e-6)
    assert state.iterations > second.iterations


@pytest.mark.slow
def test_a_guess_that_turns_an_element_inside_out_is_not_taken() -> None:
    what = three()[1]
    first = frictional_pad.newton(what, frictional_pad.unloaded(what), mech.Drive(0.2, 0.0), CONE)
    inside_out = np.random.default_rng(1).standard_normal(first.values.size)
    assert not np.isfinite(what.body.residual(inside_out)).all()
    what.tangents.clear()
    wanted = frictional_pad.newton(what, first, mech.Drive(0.4, 0.0), CONE)
    what.tangents.clear()
    state = frictional_pad.newton(what, first, mech.Drive(0.4, 0.0), CONE, inside_out)
    assert (state.values == wanted.values).all()


@pytest.mark.slow
def test_a_pull_that_does_not_converge_is_driven_by_travel(monkeypatch: pytest.MonkeyPatch) -> None:
    """Newton is made to fail under every tangential force: the travel finds the same state.

    1e-6: steps of the travel are other steps of friction than the one of the force.
    """
    what, start = three()[1], pulled()[4]
    wanted = advance_to(what, start, mech.Drive(1.2, 0.18), mech.Drive(1.2, 0.22), CONE)

    def failing(pad: Any, before: mech.FrictionalState, end: mech.Drive, *more: Any) -> mech.FrictionalState:
        if end.tangential is not None:
            raise mech.ContactError("made to fail")
        return newton(pad, before, end, *more)

    newton = frictional_pad.newton
    monkeypatch.setattr(frictional_pad, "newton", failing)
    state = advance_to(what, start, mech.Drive(1.2, 0.18), mech.Drive(1.2, 0.22), CONE)
    assert state.contact.tangential.sum() == pytest.approx(0.22, abs=2e-9)
    assert state.contact.travel == pytest.approx(wanted.contact.travel, rel=1e-6)
    with pytest.raises(mech.ContactError, match=r"the pull cannot grow beyond 0\.\d+ N|Newton finds no"):
        advance_to(what, start, mech.Drive(1.2, 0.18), mech.Drive(1.2, 0.7), CONE)


def test_damping_stores_half_the_square_of_what_moves() -> None:
    """A rigid shift by (a, b) of all but the clamped back, whose share cancels: two dampings are compared."""
    what = whole(block(8.0, 0.5, 0.3), sizes=mech.Sizes(0.1, 0.1, 0.1, 0.1))
    body, hold = what.body.damped
    rest, moved = np.zeros(what.body.free.size), affine(what, np.diag([0.01, -0.02]), 0.0)
    hold(rest, 30.0)
    stored = body.energy(moved) - what.body.energy(moved)
    x, z = 8.0 / what.unit, 0.5 / what.unit  # of sides x and z, about x = 0 and from z = 0
    assert stored == pytest.approx(15 * (0.01**2 * x**3 * z / 12 + 0.02**2 * z**3 * x / 3), rel=0.02)
    hold(moved, 30.0)
    assert body.energy(moved) == pytest.approx(what.body.energy(moved), rel=1e-9)
    assert body.residual(moved) == pytest.approx(what.body.residual(moved), abs=1e-12)


@pytest.mark.slow
def test_a_pad_comes_to_rest_where_newton_finds_it() -> None:
    """Without friction, where no way counts; and a step of a pull, which the way changes a little."""
    what = three()[1]
    # frictionless to what the residual leaves of the least stiff forces
    for before, drive, cone, off in (
        (frictional_pad.unloaded(what), mech.Drive(0.4, 0.0), SMOOTH, 1e-6),
        (pulled()[5], mech.Drive(1.2, 0.36), CONE, 0.02),
    ):
        what.tangents.clear()
        wanted = frictional_pad.newton(what, before, drive, cone)
        found = relaxed(what, before, drive, cone)
        assert found.residual <= 1e-9
        assert found.contact.residual <= 1e-9
        assert found.contact.normal.sum() == pytest.approx(drive.normal, rel=1e-9)
        assert found.contact.tangential.sum() == pytest.approx(drive.tangential, abs=1e-9)
        size = np.abs(wanted.contact.force).max()
        assert np.abs(found.contact.force - wanted.contact.force).max() < off * size
        if cone is CONE:  # else any will do
            assert found.contact.travel == pytest.approx(wanted.contact.travel, rel=off)


@pytest.mark.slow
def test_what_never_comes_to_rest_is_refused() -> None:
    """More than the skin bears."""
    what = three()[1]
    with pytest.raises(mech.ContactError, match="does not come to rest"):
        relaxed(what, frictional_pad.unloaded(what), mech.Drive(60.0, 0.0), SMOOTH)


def test_least_volume_is_that_of_a_uniform_strain() -> None:
    what = whole(block(8.0, 0.5, 0.3), sizes=mech.Sizes(0.1, 0.1, 0.1, 0.1))
    strained = affine(what, np.array([[0.1, 0.02], [0.0, -0.4]]), 0.0)
    volume, place = what.body.least_volume(strained, 0.5)
    assert volume == pytest.approx(1.1 * 0.6, rel=1e-6)
    assert place[1] > 0.5 * 0.5 / what.unit
    # lower down the clamped back, which is not strained along with it, counts too
    assert what.body.least_volume(strained, 0.0)[0] < volume


@pytest.mark.parametrize(
    ("loop", "depth"),
    [
        ([(0, 0), (2, 0), (2, 1), (0, 1)], 0.0),
        # two prongs that overlap by 0.2
        ([(0, 0), (4, 0), (4, 3), (1.9, 3), (1.9, 1), (2.1, 1), (2.1, 3.5), (0, 3.5)], 0.2),
    ],
)
def test_a_crossing_is_as_deep_as_its_overlap_is_wide(loop: list[tuple[float, float]], depth: float) -> None:
    for way in (1, -1):
        found, place = plane_body.crossing(np.array(loop[::way], dtype=float))
        assert found == pytest.approx(depth, rel=0.02)
        if depth:
            assert place[0] == pytest.approx(2.0, abs=0.1)


def loop(stretch: float, height: float) -> DeformedLoop:
    """A rectangle whose upper side's middle part is shorter by `stretch`, under a plate at 2."""
    x = np.array([0.0, 1.0, 1.0, 0.8, 0.6, 0.4, 0.2, 0.0])
    z = np.array([0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    moved = np.column_stack([x, z * height])
    moved[4, 0] = 0.4 + 0.2 * stretch
    return DeformedLoop(np.column_stack([x, z]), moved, np.arange(8) == 4)


def test_pinch_finds_the_most_compressed_free_surface() -> None:
    stretch, place, tip = folding.pinch([loop(0.5, 1.0)], 2.0)
    assert stretch == pytest.approx(0.5)
    assert place == pytest.approx([0.5, 1.0])
    assert tip
    # what bears on the plate cannot fold
    assert folding.pinch([loop(0.5, 1.0)], 1.0)[0] == np.inf


def test_the_limit_is_biots() -> None:
    """A half-space in plane strain, l its stretch: surface waves where l^6 + l^4 + 3 l^2 = 1."""
    roots = np.roots([1.0, 1.0, 3.0, -1.0])
    square = roots[np.isreal(roots)].real.max()
    assert np.sqrt(square) == pytest.approx(folding.WRINKLES, abs=5e-4)


@pytest.mark.slow
def test_much_friction_folds_the_surface_and_the_reason_names_the_place() -> None:
    """Pulled by travel at a coefficient of 1: smooth at 0.4 mm, folded by 0.6."""
    what, cone = three()[1], mech.FrictionCoefficients(1.0, 1.0)
    state = march(what, [mech.Drive(0.6, 0.0), mech.Drive(1.2, 0.0)], cone)[-1]
    words = None
    for travel in (0.1, 0.2, 0.3, 0.4, 0.5, 0.55, 0.6):
        drive = mech.Drive(1.2, travel=state.contact.travel)
        state = advance_to(what, state, drive, mech.Drive(1.2, travel=travel), cone)
        words = folding.undetected_contact(what, state, True)
        if words:
            break
    assert travel > 0.4
    assert "the surface folds onto itself at ridge " in words
    assert folding.undetected_contact(what, state, False) is None
    assert 0.5 < state.contact.tangential.sum() / 1.2 < 0.75
