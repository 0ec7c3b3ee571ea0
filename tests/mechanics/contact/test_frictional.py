"""Contact with friction, by Coulomb, by area and by a table: closed forms, no creep, mirror image."""

from __future__ import annotations

import math
from dataclasses import fields, replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from skincad.mechanics import (
    OPEN,
    RIGHT,
    STICK,
    Compliance,
    ContactError,
    ContactPad,
    ContactState,
    Drive,
    FrictionCoefficients,
    GrossSlip,
    Pad,
    Sizes,
    halved,
    piece_of,
    sliding,
    solve_contact,
    triangles,
)
from skincad.mechanics.contact import frictional
from skincad.mechanics.contact import state as contact_state
from skincad.shape import Point, Section, Segment
from tests.mechanics import closed_forms
from tests.mechanics.bodies.test_elements import cylinder
from tests.mechanics.film.test_sliding import meshed

at_rest, LEFT = contact_state.at_rest, contact_state.LEFT
SPRING = 0.25  # mm/N
MODULUS, RADIUS = 0.8, 10.0  # MPa, mm, of the sphere


def coulomb(coefficient: float) -> FrictionCoefficients:
    return FrictionCoefficients(coefficient, coefficient)


def block() -> Compliance:
    """One point on a spring in x and one in z: a block that a plate drags."""
    return Compliance(np.diag([SPRING, 0.1]), np.zeros(1), np.zeros(2))


def compliance_of(pad: ContactPad, **more: np.ndarray) -> Compliance:
    return Compliance(pad.compliance, pad.gap, np.zeros(2 * pad.gap.size), **more)


def skin() -> Compliance:
    return compliance_of(meshed()[2])


def march(skin: Compliance, drives: list[Drive], cone: FrictionCoefficients) -> list[ContactState]:
    states = [at_rest(skin.gap.size)]
    for before, after in pairwise(drives):
        states.append(halved(lambda _: skin, states[-1], before, after, cone))
    return states


def press_and_pull(force: float, pull: float, steps: int = 10) -> list[Drive]:
    rise = [Drive(force * i / steps, 0.0) for i in range(steps + 1)]
    return rise + [Drive(force, pull * i / steps) for i in range(1, steps + 1)]


def test_a_block_sticks_then_slips_exactly() -> None:
    """By hand: t = s / c up to mu N, and what the plate goes on is slip. 1e-12: rounding."""
    cone, normal = coulomb(0.5), 2.0
    drives = [Drive(0.0, travel=0.0), Drive(normal, travel=0.0)]
    drives += [Drive(normal, travel=0.05 * i) for i in range(1, 11)] + [Drive(normal, travel=0.4)]
    states = march(block(), drives, cone)[2:]
    for state, drive in zip(states[:-1], drives[2:-1], strict=True):
        traction = min(drive.travel / SPRING, cone.static * normal)
        assert state.tangential[0] == pytest.approx(traction, rel=1e-12)
        assert (state.status[0] == STICK) == (drive.travel / SPRING <= 1.0)
    assert sum(state.slipped[0] for state in states) == pytest.approx(-(0.5 - SPRING), rel=1e-12)
    # back by 0.1: it sticks, and the spring gives way from mu N by 0.1 / c
    assert states[-1].tangential[0] == pytest.approx(1.0 - 0.1 / SPRING, rel=1e-12)
    assert states[-1].status[0] == STICK


def test_a_block_breaks_off_at_the_static_and_slides_at_the_kinetic_coefficient() -> None:
    drives = [Drive(0.0, travel=0.0), Drive(2.0, travel=0.0)]
    drives += [Drive(2.0, travel=s) for s in (0.2, 0.24, 0.26, 0.3)]
    states = march(block(), drives, FrictionCoefficients(0.5, 0.3))
    assert [state.tangential[0] for state in states[2:]] == pytest.approx([0.8, 0.96, 0.6, 0.6], rel=1e-12)


def test_more_than_friction_holds_is_gross_slip() -> None:
    before = march(block(), [Drive(0.0, 0.0), Drive(2.0, 0.0), Drive(2.0, 0.99)], coulomb(0.5))[-1]
    assert before.status[0] == STICK
    with pytest.raises(GrossSlip) as end:
        solve_contact(block(), before, Drive(2.0, 1.01), coulomb(0.5))
    assert end.value.last.slips.all()
    assert end.value.last.tangential[0] == pytest.approx(1.0, rel=1e-12)
    with pytest.raises(GrossSlip, match="1 N is all that friction holds at 2 N"):
        solve_contact(block(), at_rest(1), Drive(2.0, 1.0), coulomb(0.5))


@cache
def round_pad() -> ContactPad:
    pad = cylinder(50.0, 0.49999)
    piece = piece_of(pad, 0.0)
    return sliding(piece, triangles(piece.pad, Sizes(0.012, 0.2, 0.6, 0.05)), 3, False)


def pressed_and_pulled(skin: Compliance, load: float, mu: float, shares: np.ndarray) -> list[ContactState]:
    """States of a skin pressed without friction, and then pulled by these shares of what friction holds."""
    state = solve_contact(skin, at_rest(skin.gap.size), Drive(load, 0.0), coulomb(0.0))
    states = [replace(state, status=np.where(state.touches, STICK, OPEN).astype(np.int8))]
    for share in shares.tolist():
        states.append(solve_contact(skin, states[-1], Drive(load, share * mu * load), coulomb(mu)))
    return states[1:]


@pytest.mark.parametrize("share", [0.3, 0.6])
def test_cattaneo_and_mindlin(share: float) -> None:
    """Half-width of the stick zone within 1 %, the issue's.

    mu p - t is, where it sticks, an ellipse of its own; the fit takes points inside.
    """
    pad, mu = round_pad(), 0.4
    load = 10.0 * math.pi * 0.8 / (1 - 0.49999**2) * 0.2**2 / (4 * 50.0)  # Hertz's for a half-width of 0.2 mm
    state = pressed_and_pulled(compliance_of(pad), load, mu, share * np.arange(1, 21) / 20)[-1]
    normal = closed_forms.hertz(load / 10.0, 50.0, 0.8, 0.49999)
    stick = closed_forms.stick_half_width(normal, mu, share * mu * load / 10.0)
    rest = (mu * state.normal - state.tangential) / pad.area
    fitted = closed_forms.fitted_line_contact(pad.x, np.maximum(rest, 0.0))
    assert fitted.half_width == pytest.approx(stick, rel=0.01)
    # where it slips and where it sticks, to one point on either side
    step = np.diff(pad.x[state.touches]).max()
    stuck = np.abs(pad.x[state.status == STICK])
    assert stuck.max() == pytest.approx(stick, abs=step)


def sphere(reach: float, size: float) -> Compliance:
    """A rigid sphere on an incompressible half-space: square patches of `size` mm within `reach` mm of the
    axis, under uniform pressure and traction along x.

    Love, Phil. Trans. R. Soc. A 228 (1929) 377; Johnson, Contact Mechanics, 1985, eqs (3.25), (2.22). At a
    Poisson ratio of one half pressure moves nothing sideways and traction nothing up or down.
    """
    count = int(reach / size)
    line = size * np.arange(-count, count + 1)
    x, y = (centres.ravel() for centres in np.meshgrid(line, line))
    inside = np.hypot(x, y) <= reach
    x, y = x[inside], y[inside]
    m = x.size
    far = np.subtract.outer(x, x), np.subtract.outer(y, y)
    by_x, by_y = np.zeros((m, m)), np.zeros((m, m))
    for side, end in ((a, b) for a in (1, -1) for b in (1, -1)):
        at_x, at_y = far[0] + side * size / 2, far[1] + end * size / 2
        r = np.hypot(at_x, at_y)
        by_x += side * end * at_x * np.log(at_y + r)
        by_y += side * end * at_y * np.log(at_x + r)  # also the integral of x^2 / r^3
    shear = MODULUS / 3
    down = 0.5 * (by_x + by_y) / (2 * np.pi * shear)
    along = (0.5 * (by_x + by_y) + 0.5 * by_y) / (2 * np.pi * shear)
    none = np.zeros((m, m))
    compliance = np.block([[along, none], [none, down]]) / size**2
    return Compliance(compliance, (x**2 + y**2) / (2 * RADIUS), np.zeros(2 * m), area=np.full(m, size**2))


@pytest.mark.slow
def test_cattaneo_and_mindlin_of_a_sphere() -> None:
    """Of a contact 0.95 mm wide: stick radius (1 - Ft / (mu Fn))^(1/3) of it to a fifth of a patch, at each
    pull; travel 3 (2 - nu) mu Fn / (16 G a) (1 - (1 - Ft / (mu Fn))^(2/3)) to 0.3 %, the patches' error, that
    falls to 0.12 % with patches two thirds as wide. Mindlin, J. Appl. Mech. 16 (1949) 259."""
    mu, load, shares = 0.5, 4 * MODULUS / 0.75 * 0.95**3 / (3 * RADIUS), 0.05 * np.arange(1, 20)
    rigid = 3 * 1.5 * mu * load / (16 * MODULUS / 3 * 0.95)
    states = pressed_and_pulled(sphere(1.05, 0.09), load, mu, shares)
    for share, state in zip(shares, states, strict=True):
        ratio = math.sqrt((state.status == STICK).sum() / state.touches.sum())
        assert ratio == pytest.approx((1 - share) ** (1 / 3), abs=0.2 * 0.09 / 0.95)
        assert state.travel == pytest.approx(rigid * (1 - (1 - share) ** (2 / 3)), rel=3e-3)


@pytest.mark.parametrize("by_area", [False, True])
def test_a_held_load_does_not_creep(by_area: bool) -> None:
    """A held step gives back the state it was given, bit for bit: 1e5 of them are as good as one. By area,
    part of it slips."""
    pad, pull, cone = (rough_skin(), 0.35, BY_AREA) if by_area else (skin(), 0.3, coulomb(1.0))
    drive, first = Drive(1.2, pull), march(pad, press_and_pull(1.2, pull), cone)[-1]
    once = solve_contact(pad, first, drive, cone)
    assert once.touches.any()
    assert not once.slips.any()
    stuck = once.status == STICK
    assert stuck.any()
    # exactly, where it sticks: the anchor is kept, not integrated
    assert (first.anchor[stuck] == once.anchor[stuck]).all()
    again = solve_contact(pad, once, drive, cone)
    assert all(np.array_equal(getattr(once, f.name), getattr(again, f.name)) for f in fields(ContactState))
    assert once.travel == pytest.approx(first.travel, rel=1e-12)
    assert not by_area or (once.status >= RIGHT).any()


@pytest.mark.parametrize("by_area", [False, True])
def test_pulling_back_mirrors_everything(by_area: bool) -> None:
    pad, pull, cone = (rough_skin(), 0.4, BY_AREA) if by_area else (skin(), 0.8, coulomb(1.0))
    there, back = (march(pad, press_and_pull(1.2, way * pull), cone)[-1] for way in (1, -1))
    # rounding, against the largest
    assert back.normal == pytest.approx(there.normal[::-1], abs=1e-9 * there.normal.max())
    assert back.tangential == pytest.approx(-there.tangential[::-1], abs=1e-9 * there.normal.max())
    assert there.slips.sum() == back.slips.sum() > 0


def test_every_accepted_step_meets_contact_and_friction() -> None:
    """Checked apart from the solver's own measure, to its 1e-10."""
    here, mu = skin(), 0.7
    for state in march(here, press_and_pull(1.2, 0.7), coulomb(mu))[1:]:
        moved = assert_contact(here, state)
        length, largest = np.ptp(here.gap), state.normal.max()
        assert (np.abs(state.tangential) - mu * state.normal).max() <= 1e-10 * largest
        assert moved[: here.gap.size][state.status == STICK] - state.travel == pytest.approx(
            state.anchor[state.status == STICK], abs=1e-10 * length
        )


def assert_contact(pad: Compliance, state: ContactState) -> np.ndarray:
    """No point lies within the plate, none that is off it bears, and friction takes work, never gives any, to
    1e-10; return how points moved `(2 m,)`."""
    moved = pad.compliance @ np.concatenate([state.tangential, -state.normal])
    gap = pad.gap - state.approach - moved[pad.gap.size :]
    length, largest = np.ptp(pad.gap), state.normal.max()
    assert gap.min() >= -1e-10 * length
    assert np.abs(gap * state.normal).max() <= 1e-10 * length * largest
    assert (state.tangential * state.slipped).max() <= 1e-10 * length * largest
    return moved


@pytest.mark.slow
def test_a_search_of_the_sets_finds_what_sweeps_find(monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps of a press and a pull whose sweeps are made to cycle."""
    drives = press_and_pull(2.0, 0.9, 2)
    wanted = march(skin(), drives, coulomb(0.5))
    swept, sweeps = list[int](), frictional._Step._sweep

    def cycling(step: frictional._Step, *more: object) -> tuple[object, int]:
        swept.append(1)
        return (0.0, 1) if step.before.touches.any() else sweeps(step, *more)

    monkeypatch.setattr(frictional._Step, "_sweep", cycling)
    found = march(skin(), drives, coulomb(0.5))
    assert len(swept) > 4 * (len(drives) - 2)  # each of the starts, but for the first step
    for state, other in zip(found, wanted, strict=True):
        assert (state.status == other.status).all()
        assert state.normal == pytest.approx(other.normal, abs=1e-12)
        assert state.tangential == pytest.approx(other.tangential, abs=1e-12)


def test_same_input_same_bits() -> None:
    one, other = (march(skin(), press_and_pull(1.2, 0.8), coulomb(1.0))[-1] for _ in range(2))
    assert (one.normal == other.normal).all()
    assert (one.tangential == other.tangential).all()


def test_lifting_the_plate_forgets_it() -> None:
    drives = [*press_and_pull(1.2, 0.5), Drive(1.2, 0.0), Drive(0.0, 0.0), Drive(1.2, 0.0)]
    states = march(skin(), drives, coulomb(1.0))
    assert not states[-2].touches.any()
    assert not states[-2].normal.any()
    fresh = march(skin(), [Drive(0.0, 0.0), Drive(1.2, 0.0)], coulomb(1.0))[-1]
    # in one step each, from rest
    assert states[-1].normal == pytest.approx(fresh.normal, abs=1e-9 * fresh.normal.max())


def test_a_pulling_plate_and_a_skin_without_areas_are_refused() -> None:
    with pytest.raises(ContactError, match="must not pull"):
        solve_contact(block(), at_rest(1), Drive(-1.0, 0.0), coulomb(1.0))
    with pytest.raises(ContactError, match="asks for the area"):
        solve_contact(block(), at_rest(1), Drive(1.0, 0.0), BY_AREA)


def test_a_step_that_does_not_settle_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first try is made to fail: the two halves then are what the step took."""
    tries = []

    def failing(*arguments: object) -> ContactState:
        tries.append(arguments)
        if len(tries) == 1:
            raise ContactError("made to fail")
        return solve_contact(*arguments)

    monkeypatch.setattr(frictional, "solve_contact", failing)
    start, end = Drive(2.0, travel=0.0), Drive(2.0, travel=0.5)
    before = solve_contact(block(), at_rest(1), start, coulomb(0.5))
    state = halved(lambda _: block(), before, start, end, coulomb(0.5))
    assert [a[2].travel for a in tries] == [0.5, 0.25, 0.5]
    assert state.slipped[0] == pytest.approx(-(0.5 - SPRING), rel=1e-12)
    assert state.status[0] == RIGHT


@cache
def thin_layer() -> ContactPad:
    """A layer 1 mm thick and 20 mm wide: its middle knows nothing of its ends (they fade by exp(-pi x))."""
    half = 10.0
    corners = [Point(-half, 0.0), Point(half, 0.0), Point(half, 1.0), Point(-half, 1.0)]
    sides = [Segment(a, b) for a, b in pairwise([*corners, corners[0]])]
    sides[0] = replace(sides[0], kind="back")
    sides[2] = replace(sides[2], kind="crown", feature=1, touches=True)
    piece = piece_of(Pad(Section(tuple(sides)), 5.0, 0.8, 0.3), 0.0)
    return sliding(piece, triangles(piece.pad, Sizes(0.4, 0.4, 0.4, 0.1)), 3, False)


@pytest.mark.parametrize(("travel", "slips"), [(0.02, False), (2.0, True)])
def test_frictional_patch(travel: float, slips: bool) -> None:
    """Uniform pressure and traction in stick and in slip to 0.05 %, the issue's (after NAFEMS R0081's).

    By hand, of a wide layer: p = M d / h with M = E (1 - nu) / (1 + nu) / (1 - 2 nu); t = G s / h where it
    sticks, mu p where it slips.
    """
    pad, mu, force = thin_layer(), 0.5, 5.0
    drives = [Drive(0.0, travel=0.0), Drive(force, travel=0.0), Drive(force, travel=travel)]
    layer = compliance_of(pad)
    state = march(layer, drives, coulomb(mu))[-1]
    middle = np.abs(pad.x) < 2.0
    pressure, traction = (
        force_on[middle] / pad.area[middle] for force_on in (state.normal, state.tangential)
    )
    confined = 0.8 * 0.7 / 1.3 / 0.4 * state.approach
    assert pressure == pytest.approx(confined, rel=5e-4)
    expected = mu * confined if slips else 0.8 / 2.6 * travel
    assert traction == pytest.approx(expected, rel=5e-4)
    assert (state.slips[middle] == slips).all()
    assert not slips or state.slips[state.touches].all()


@pytest.mark.parametrize(("coefficient", "weaker"), [(0.2, 0), (frictional.EASY_COEFFICIENT, 0), (0.5, 3)])
def test_sets_that_do_not_settle_are_told_with_all_the_sweeps_tried(
    coefficient: float, weaker: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the last sets, from sliding either way and from sticking; of much friction with less and less too,
    0.4, 0.32 and 0.256, whose sets might be near."""
    swept: list[float] = []

    def never(step: frictional._Step, *_: object) -> tuple[np.ndarray, np.ndarray]:
        swept.append(step.cone.static)
        return np.ones(1), np.full(1, STICK, dtype=np.int8)

    monkeypatch.setattr(frictional._Step, "_violations", never)
    monkeypatch.setattr(frictional, "SWEEPS", 3)
    monkeypatch.setattr(frictional, "SINGLE_SWEEPS", 2)
    with pytest.raises(ContactError, match=r"do not settle in 20 sweeps"):
        solve_contact(block(), at_rest(1), Drive(2.0, travel=0.1), coulomb(coefficient))
    coefficients = [coefficient * frictional.START_SHARE**i for i in range(weaker + 1)]
    assert swept == pytest.approx(np.repeat(coefficients, 4 * 5), rel=1e-12)


@pytest.mark.parametrize(
    ("longer", "stronger"), [(2.0**-40, 1.0), (2.0**40, 1.0), (1.0, 2.0**-40), (1.0, 2.0**40)]
)
def test_the_units_of_length_and_force_do_not_matter(longer: float, stronger: float) -> None:
    """Points of a rough skin, pressed, pulled both ways and let go; powers of two round nothing."""
    dice, m = np.random.default_rng(3), 12
    root = dice.normal(size=(2 * m, 2 * m))
    compliance = root @ root.T / (2 * m) + 0.2 * np.eye(2 * m)
    gap = 0.3 * dice.random(m)
    drives = [Drive(0.0, travel=0.0), Drive(2.0, travel=0.0), Drive(2.0, travel=0.7), Drive(1.5, travel=-0.4)]
    plain = march(
        Compliance(compliance, gap - gap.min(), np.zeros(2 * m)), drives, FrictionCoefficients(0.25, 0.2)
    )
    # the march goes through all
    assert {int(s) for state in plain for s in state.status} == {OPEN, STICK, RIGHT, LEFT}
    changed = march(
        Compliance(compliance * longer / stronger, (gap - gap.min()) * longer, np.zeros(2 * m)),
        [Drive(d.normal * stronger, travel=(d.travel or 0.0) * longer) for d in drives],
        FrictionCoefficients(0.25, 0.2),
    )
    for one, other in zip(plain, changed, strict=True):
        assert (one.status == other.status).all()
        for name, factor in (("normal", stronger), ("tangential", stronger), ("slipped", longer)):
            assert getattr(other, name) == pytest.approx(factor * getattr(one, name), rel=1e-9, abs=0.0)
        assert other.approach == pytest.approx(longer * one.approach, rel=1e-9)
        assert (one.slips == other.slips).all()


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_in_gross_slip_the_plate_is_where_the_last_point_has_just_let_go(way: float) -> None:
    """Two points that bear 1 N each on springs of 0.2 and 0.4 mm/N: held by mu N = 0.5 N they go 0.1 and
    0.2 mm, so the stiffer one has slipped 0.1 mm when the softer one lets go."""
    pair = Compliance(np.diag([0.2, 0.4, 0.1, 0.1]), np.zeros(2), np.zeros(4))
    with pytest.raises(GrossSlip) as end:
        solve_contact(pair, at_rest(2), Drive(2.0, 1.1 * way), coulomb(0.5))
    assert end.value.last.travel == pytest.approx(0.2 * way, rel=1e-12)
    assert end.value.last.slipped == pytest.approx([-0.1 * way, 0.0], abs=1e-12)


CAP = 0.1  # MPa
AREA = 2.0  # mm2
TABLE = ((0.1, 0.1), (0.5, 0.3), (1.0, 0.4))  # MPa: coefficients 1, 0.6 and 0.4


def capped(mu: float, stress: float = CAP, kinetic: float | None = None) -> FrictionCoefficients:
    return FrictionCoefficients(mu, mu if kinetic is None else kinetic, ((stress / mu, stress),))


def sticky_block() -> Compliance:
    return replace(block(), area=np.array([AREA]))


def rough_skin() -> Compliance:
    """The yamada skin's points, of 0.1 mm2 each: by Coulomb and by area both within a ridge."""
    here = skin()
    return replace(here, area=np.full(here.gap.size, 0.05))


BY_AREA = capped(1.0, 0.2)


def dragged_by(load: float, travel: float) -> list[Drive]:
    return [Drive(0.0, travel=0.0), Drive(load, travel=0.0), Drive(load, travel=travel)]


@pytest.mark.parametrize(
    ("normal", "borne"), [(0.1, 0.1), (0.2, 0.2), (0.6, 0.4), (1.0, 0.6), (1.5, 0.7), (2.0, 0.8), (9.0, 0.8)]
)
def test_a_block_bears_what_the_table_says(normal: float, borne: float) -> None:
    """By hand: shear stresses of 0.1, 0.3 and 0.4 MPa at 0.1, 0.5 and 1 MPa, straight between and constant
    beyond, times 2 mm2. Driven by travel, and pulled."""
    cone = FrictionCoefficients(1.0, 1.0, TABLE)
    driven = march(sticky_block(), dragged_by(normal, 1.0), cone)[-1]
    assert driven.tangential[0] == pytest.approx(borne, rel=1e-12)
    assert driven.status[0] == RIGHT
    sticking = march(
        sticky_block(), [Drive(0.0, 0.0), Drive(normal, 0.0), Drive(normal, -0.99 * borne)], cone
    )[-1]
    assert sticking.status[0] == STICK
    with pytest.raises(GrossSlip, match="more than kinetic friction holds") as end:
        solve_contact(sticky_block(), sticking, Drive(normal, -1.01 * borne), cone)
    assert end.value.last.tangential[0] == pytest.approx(-borne, rel=1e-12)
    assert end.value.last.status[0] == LEFT


def test_kinetic_friction_is_the_same_part_of_static_friction_at_any_pressure() -> None:
    """Breaks off at 0.4 N, slides at 0.3 N: 0.75 of 0.2 MPa times 2 mm2, the pressure far above the cap's."""
    cone = capped(4.0, 0.2, 3.0)
    drives = [Drive(0.0, travel=0.0), Drive(2.0, travel=0.0)]
    drives += [Drive(2.0, travel=s * SPRING) for s in (0.2, 0.39, 0.41, 0.8)]
    states = march(sticky_block(), drives, cone)
    assert [state.tangential[0] for state in states[2:]] == pytest.approx([0.2, 0.39, 0.3, 0.3], rel=1e-12)


def test_friction_by_area_of_a_cylinder_follows_the_square_root_of_the_load() -> None:
    """Exponent within 0.01 over a factor of 16 in load: as Hertz's area of contact."""
    pad = round_pad()
    here = compliance_of(pad, area=pad.area)
    widest = 0.19  # mm, half; the mesh is fine up to 0.2
    highest = 10.0 * np.pi * 0.8 / (1 - 0.49999**2) * widest**2 / (4 * 50.0)
    loads = highest * np.geomspace(1 / 16, 1.0, 9)
    states = [march(here, dragged_by(load, 1.0), capped(2.0, 1e-5))[-1] for load in loads]
    pulls = [float(state.tangential.sum()) for state in states]
    assert all((state.status != STICK).all() for state in states)
    assert np.polyfit(np.log(loads), np.log(pulls), 1)[0] == pytest.approx(0.5, abs=0.01)


@pytest.mark.parametrize("kinetic", [0.7, 0.5])
def test_coulomb_is_the_limit_of_a_large_shear_stress(kinetic: float) -> None:
    """1e-10 of the normal force, the issue's."""
    drives = [*press_and_pull(1.2, 0.5), Drive(1.2, -0.3), Drive(0.6, 0.1)]
    plain, limit = (
        march(rough_skin(), drives, cone)
        for cone in (FrictionCoefficients(0.7, kinetic), capped(0.7, 1e6, kinetic))
    )
    assert {int(s) for state in plain for s in state.status} == {OPEN, STICK, RIGHT, LEFT}
    for one, other in zip(plain, limit, strict=True):
        assert (one.status == other.status).all()
        for name in ("normal", "tangential", "slipped"):
            assert getattr(other, name) == pytest.approx(getattr(one, name), abs=1.2e-10)


def test_every_accepted_step_meets_contact_and_the_law() -> None:
    """Checked apart from the solver's own measure, to its 1e-10; points of all kinds occur."""
    here, cone = rough_skin(), FrictionCoefficients(1.5, 1.2, ((0.1, 0.15), (1.1, 0.45)))
    kinds = set[tuple[int, bool]]()
    for state in march(here, press_and_pull(1.2, 0.5), cone)[1:]:
        assert_contact(here, state)
        largest = state.normal.max()
        pressure = state.normal / here.area
        static = here.area * np.minimum(1.5 * pressure, np.minimum(0.12 + 0.3 * pressure, 0.45))
        slides = state.status >= RIGHT
        assert (np.abs(state.tangential) - static).max() <= 1e-10 * largest
        assert np.abs(state.tangential)[slides] == pytest.approx(0.8 * static[slides], abs=1e-10 * largest)
        kinds |= {(int(s), bool(p > 0.1)) for s, p in zip(state.status, pressure, strict=True)}
    assert {(STICK, True), (RIGHT, True), (RIGHT, False), (OPEN, False)} <= kinds


def test_what_gross_slip_takes_does_not_hang_on_the_way_there() -> None:
    """Pulled until it slips, and dragged: the same contact, to the solver's 1e-10."""
    drives = press_and_pull(1.2, 1.2, 30)
    state = at_rest(rough_skin().gap.size)
    with pytest.raises(GrossSlip) as end:
        for before, after in pairwise(drives):
            state = halved(lambda _: rough_skin(), state, before, after, BY_AREA)
    far = march(rough_skin(), dragged_by(1.2, 3.0), BY_AREA)
    assert (far[-1].status != STICK).all()
    assert end.value.last.tangential == pytest.approx(far[-1].tangential, abs=1e-9)
    assert end.value.last.tangential.sum() < 0.9 * 1.2  # less than by Coulomb


@pytest.mark.parametrize("share", [0.95, 0.8, 0.5, 0.45, 0.2])
@pytest.mark.parametrize("breakpoints", [TABLE, TABLE[:1], ()])
def test_a_capped_law_bears_the_smaller_of_both(
    share: float, breakpoints: tuple[tuple[float, float], ...]
) -> None:
    """The sets that it leads to are where the search for a steep law's goes on."""
    area, normal = np.full(40, 2.0), np.linspace(0.0, 8.0, 40)
    cone = FrictionCoefficients(1.0, 0.5, breakpoints)
    part = cone.capped(share)
    wanted = np.minimum(share * normal, cone.sticks * cone.borne(normal, area))
    assert part.sticks * part.borne(normal, area) == pytest.approx(wanted, rel=1e-13)
    assert part.slides / part.sticks == pytest.approx(0.5, rel=1e-14)
