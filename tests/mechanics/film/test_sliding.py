"""The condensed pad of both components, under a plate that slides, and one that turns."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache, partial
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import ngsolve as ngs
import numpy as np
import pytest

from skincad import mechanics as mech
from skincad.effects import CondensedPad, Share, Step
from skincad.mechanics.bodies import elements, film_field
from skincad.mechanics.dynamics import pad as moving_pad
from skincad.mechanics.film import sliding as sliding_pad
from skincad.mechanics.film import stick, stress, turning
from skincad.scenes import LEVELS, at_level
from skincad.shape import Point, Section, Segment
from tests.mechanics.bodies.test_elements import block
from tests.mechanics.designs import yamada
from tests.mechanics.film.test_stress import strips_in_a_block
from tests.small_scene import THIRD, small_scene

ORDER = 3


@cache
def meshed() -> tuple[mech.PadPiece, object, mech.ContactPad]:
    piece = mech.piece_of(*mech.filled_pad(yamada().with_(ridge={"count": 3}, skin={"width": 5.0})))
    mesh = mech.triangles(piece.pad, stress.REFINEMENTS[0].sizes(piece))
    return piece, mesh, mech.sliding(piece, mesh, ORDER, True)


def test_stresses_and_approach_are_the_film_stress_solvers() -> None:
    """The stresses come from one adjoint solve each; there, from the displacements' own integrals."""
    piece, mesh, pad = meshed()
    other = stick.level(piece, mesh, ORDER, 1.2, False)
    m = pad.gap.size
    state = mech.press(pad.compliance[m:, m:], pad.gap, 1.2)
    stress = pad.strips @ np.concatenate([np.zeros(m), -state.force])
    # 1e-9: rounding of two solves with strips 3750 times as stiff as the skin
    assert stress == pytest.approx(
        other.normal_state.strips, abs=1e-9 * np.abs(other.normal_state.strips).max()
    )


def test_pad_is_its_own_mirror_image() -> None:
    _, _, pad = meshed()
    m = pad.gap.size
    turn = np.concatenate([-np.ones(m), np.ones(m)])
    image = np.concatenate([np.arange(m)[::-1], m + np.arange(m)[::-1]])
    mirrored = (turn[:, None] * pad.compliance * turn)[np.ix_(image, image)]
    # rounding: both halves share one solution
    assert mirrored == pytest.approx(pad.compliance, abs=1e-13 * np.abs(pad.compliance).max())
    assert pad.x == pytest.approx(-pad.x[::-1], abs=1e-14)
    assert (pad.ridge == 4 - pad.ridge[::-1]).all()


@pytest.mark.evidence(subject="films: other ways")
def test_the_half_agrees_with_the_whole() -> None:
    """Another mesh and no mirror conditions: a shear of all points and a press, to 0.5 % of mesh."""
    piece, _, half = meshed()
    whole = mech.piece_of(piece.whole, piece.thickness, halved=False)
    pad = mech.sliding(whole, mech.triangles(whole.pad, stress.REFINEMENTS[0].sizes(whole)), ORDER, True)
    answers = []
    for one in (half, pad):
        load = np.concatenate([one.area, -0.5 * one.area]) / one.area.sum()
        moved = (one.compliance @ load).reshape(2, -1)
        answers += [moved @ one.area / one.area.sum(), (one.strips @ load)[:, 0]]
    assert answers[0] == pytest.approx(answers[2], rel=5e-3)
    assert answers[1] == pytest.approx(answers[3], abs=0.02 * np.abs(answers[1]).max())


def force() -> np.ndarray:
    """A press, and a pull that is no mirror image of itself."""
    pad = meshed()[2]
    m = pad.gap.size
    normal = mech.press(pad.compliance[m:, m:], pad.gap, 1.2).force
    return np.concatenate([0.3 * normal * (1 + np.sign(pad.x)), -normal])


def test_contact_points_move_as_the_condensed_pads() -> None:
    part, _, pad = meshed()
    shown = pad.whole.deformed_section(force(), part.whole.top, 0.0)
    moved = (pad.compliance @ force()).reshape(2, -1).T
    points = np.column_stack([pad.x, part.whole.top - pad.gap])
    off = np.hypot(*(shown.place[:, None] - points[None]).transpose(2, 0, 1))
    at = off.argmin(axis=0)
    drawn = off.min(axis=0) < 1e-9  # elements' corners and middles are drawn: of order 3, every third point
    assert drawn.sum() > 0.3 * pad.x.size
    assert {-1.0, 1.0} <= set(np.sign(pad.x[drawn]))
    # rounding of two solves
    assert shown.shift[at[drawn]] == pytest.approx(moved[drawn], abs=1e-9 * np.abs(moved).max())


def test_strips_feel_what_the_condensed_pad_says() -> None:
    part, _, pad = meshed()
    sides = pad.whole.moved(force())
    stresses = []
    for moved in sides:
        film_field.set_state(pad.whole.body, moved)
        average = film_field.averages(pad.whole.body, part)
        stresses.append(
            stick.on_whole(part, stick.in_strip_axes(average * part.pad.young_modulus, part.slots), 1)
        )
    right = np.array([slot.centre.x > 0 for slot in part.whole.section.slots])
    expected = pad.strips @ force()
    whole = np.where(right[:, None], stresses[0], stresses[1])
    assert whole == pytest.approx(expected, abs=1e-8 * np.abs(expected).max())


def test_a_plate_through_the_flanks_is_a_fault() -> None:
    part, _, pad = meshed()
    top, x, whole = part.whole.top, np.array([-1.0, 1.0]), pad.whole
    collision = partial(mech.collision, part, whole.body, whole.moved(0 * force()))
    assert collision(top, 0.0) is None
    # the plate falls towards -x: what is met lies in the mirrored half
    for height, angle in ((top - 0.4, 0.0), (top, 0.3), (top, -0.3)):
        assert "meets the plate" in collision(height, angle)
    # no longer where the ends let every ridge down by as much
    assert collision(top - 0.4, 0.0, (x, np.full(2, 0.4))) is None
    assert "meets the plate" in collision(top - 0.4, 0.0, (x, np.full(2, 0.01)))


FORCE = 0.3  # N


@cache
def block_of_strips(halved: bool) -> tuple[mech.PadPiece, object]:
    pad, thickness = strips_in_a_block(30.0)
    piece = mech.piece_of(replace(pad, density=1000.0, film_density=1780.0), thickness, halved)
    return piece, mech.triangles(piece.pad, mech.Sizes(0.5, 0.5, 0.5, 0.5))


@pytest.mark.parametrize("halved", [False, True])
@pytest.mark.parametrize("pull", [False, True])
def test_it_is_pulled_only_where_that_is_asked(pull: bool, halved: bool) -> None:
    piece, mesh = block_of_strips(halved)
    assert piece.mirrored == halved
    solution = stick.level(piece, mesh, 2, FORCE, pull)
    assert (solution.pull_state is not None) == pull
    # balances, to rounding
    assert solution.normal_state.normal.sum() == pytest.approx(FORCE, rel=1e-9)
    assert solution.normal_state.tangential.sum() == pytest.approx(0.0, abs=1e-9)
    assert solution.normal_state.node.sum() == pytest.approx(FORCE, rel=1e-9)
    if solution.pull_state:
        assert solution.pull_state.tangential.sum() == pytest.approx(1.0, rel=1e-9)
        assert solution.pull_state.normal.sum() == pytest.approx(0.0, abs=1e-9)
    assert solution.residual < 1e-9
    assert set(solution.seconds) == {"assemble", "condense", "contact"}


def test_as_many_contact_unknowns_as_fit_are_taken_and_one_more_is_refused(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for halved in (False, True):
        piece, mesh = block_of_strips(halved)
        points = sliding_pad.sliding(piece, mesh, 2, False).gap.size
        # both components, on both halves of what is halved
        unknowns = 2 * (2 if halved else 1) * elements.contact_unknowns(elements.curved(mesh, 2), 2)
        monkeypatch.setattr(sliding_pad, "MOST_CONTACT_UNKNOWNS", unknowns)
        assert sliding_pad.sliding(piece, mesh, 2, False).gap.size == points
        monkeypatch.setattr(sliding_pad, "MOST_CONTACT_UNKNOWNS", unknowns - 1)
        with pytest.raises(
            mech.SizeError, match=rf"at most {unknowns - 1} contact unknowns.* got {unknowns}"
        ):
            sliding_pad.sliding(piece, mesh, 2, False)
        if not halved:  # enough: it counts whole points
            monkeypatch.undo()
            continue
        monkeypatch.setattr(moving_pad, "MOST_CONTACT_UNKNOWNS", 2 * points)
        assert moving_pad.linear(piece, mesh, 2, False).gap.size == points
        monkeypatch.setattr(moving_pad, "MOST_CONTACT_UNKNOWNS", 2 * points - 1)
        with pytest.raises(
            mech.SizeError, match=rf"at most {2 * points - 1} contact unknowns.* got {2 * points}"
        ):
            moving_pad.linear(piece, mesh, 2, False)
        monkeypatch.undo()


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("degrees", [-150.0, -10.0, 0.0, 1e-6, 30.0, 175.0])
def test_a_cut_curve_is_the_curve(degrees: float, backwards: bool) -> None:
    whole = Segment(Point(1.0, 2.0), Point(-2.0, 2.3), math.tan(math.radians(degrees) / 4), "crown", 3, True)
    if backwards:
        whole = whole.reversed()
    at = [0.5, -1.9, 7.0, 0.999, -2.0, 1.0]  # in any order; what lies outside or on its ends cuts nothing
    pieces = list(stick.cut_at(whole, at))
    heads = [piece.start.x for piece in pieces[1:]]
    assert heads == pytest.approx(sorted([-1.9, 0.5, 0.999], reverse=not backwards), abs=1e-11)
    assert (pieces[0].start, pieces[-1].end) == (whole.start, whole.end)
    assert all(a.end == b.start for a, b in pairwise(pieces))
    assert sum(piece.length for piece in pieces) == pytest.approx(whole.length, rel=1e-12)
    assert sum(piece.sweep for piece in pieces) == pytest.approx(whole.sweep, rel=1e-12)
    for piece in pieces:
        assert (piece.kind, piece.feature) == ("crown", 3)
        assert degrees == 0.0 or piece.radius == pytest.approx(whole.radius, rel=1e-9)


@pytest.mark.parametrize("unit", [1.0, 0.5])
def test_the_top_is_cut_a_step_either_side_of_where_contact_ends(unit: float) -> None:
    """Points of a block's top in any order, of which those from -0.5 to 0.5 mm stick."""
    pad: mech.Pad = block(4.0, 1.0, 0.3)
    piece = mech.PadPiece(pad, pad, False, unit)
    x = np.array([0.5, -2.0, 2.0, -1.0, 1.5, -0.5, 0.0])
    nodes = SimpleNamespace(position=np.column_stack([x, np.ones(7)]) / unit, ridge=np.ones(7, dtype=int))
    body = SimpleNamespace(system=SimpleNamespace(nodes=nodes))
    solution: Any = SimpleNamespace(body=body, bonded=np.abs(x) <= 0.5)
    fine = stick.with_fine_edges(piece, solution)
    top = [s for s in fine.pad.section.outline if s.kind == "crown"]
    # contact ends between -1 and -0.5, a step of 0.5, and between 0.5 and 1.5, a step of 1
    assert [s.start.x for s in top] == pytest.approx([2.0, 1.0, 0.0, -0.25, -0.75, -1.25], abs=1e-11)
    rest = [s for s in pad.section.outline if s.kind != "crown"]
    assert [s for s in fine.pad.section.outline if s.kind != "crown"] == rest
    assert fine.whole is pad  # what is told of the section is told of the uncut one
    all_stick: Any = SimpleNamespace(body=body, bonded=np.ones(7, dtype=bool))
    assert stick.with_fine_edges(piece, all_stick).pad.section == pad.section


def test_each_ridge_is_cut_by_its_own_points() -> None:
    def crown(ridge: int, middle: float) -> Segment:
        return Segment(Point(middle + 1, 1.0), Point(middle - 1, 1.0), 0.0, "crown", ridge, True)

    pad: Any = mech.Pad(Section((crown(2, 3.0), crown(1, 0.0))), 2.0, 0.7, 0.3)
    x = np.array([-0.4, 0.4, 2.6, 3.4])
    nodes = SimpleNamespace(position=np.column_stack([x, x]), ridge=np.array([1, 1, 2, 2]))
    solution: Any = SimpleNamespace(
        body=SimpleNamespace(system=SimpleNamespace(nodes=nodes)), bonded=np.array([True, True, True, False])
    )
    cut = stick.with_fine_edges(mech.PadPiece(pad, pad, False, 1.0), solution).pad.section.outline
    assert [(s.feature, round(s.start.x, 9)) for s in cut] == [
        (2, 4.0),
        (2, 3.8),
        (2, 3.0),
        (2, 2.2),
        (1, 1.0),
    ]


@pytest.mark.slow
def test_a_mesh_takes_four_linear_forms_whatever_strips_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each takes a timer of the library's for good, and after 8192 it says so on every line of a study."""
    forms: list[object] = []
    plain = ngs.LinearForm

    def counted(*arguments: Any, **options: Any) -> Any:
        forms.append(arguments)
        return plain(*arguments, **options)

    monkeypatch.setattr(ngs, "LinearForm", counted)
    at_level(
        small_scene(tmp_path, "yamada-2002-press", "history.steps=2", "readout.ridges=[2]", THIRD), LEVELS[0]
    )
    assert len(forms) == 4


RADIUS, SPACING = 60.0, 0.05


def stiff_circle() -> CondensedPad:
    """Points on a circle, each on stiff springs of its own."""
    angle = np.arange(-80, 81) * SPACING / RADIUS
    x, gap = RADIUS * np.sin(angle), 2 * RADIUS * np.sin(angle / 2) ** 2
    none = np.zeros((0, 3, 2 * x.size))
    ridge = np.ones(x.size, dtype=np.int64)
    return CondensedPad(mech.ContactPad(1e-9 * np.eye(2 * x.size), gap, x, ridge, np.ones(x.size), none, 1))


def marched(
    model: CondensedPad, drives: list[mech.Drive], cone: mech.FrictionCoefficients
) -> list[mech.ContactState]:
    states = [model.start()]
    for before, after in pairwise(drives):
        states.append(model.advanced(states[-1], Step(0.0, 1.0, before, after), Share(cone)))
    return states


@pytest.mark.slow
@pytest.mark.parametrize("way", [1, -1])
def test_a_plane_rolls_on_a_circle(way: int) -> None:
    """By hand: it travels R (sin a - a) along itself, a being minus its angle, and slips nowhere."""
    last = math.radians(3.0)
    drives = [mech.Drive(0.0, 0.0), mech.Drive(1.0, 0.0)]
    drives += [mech.Drive(1.0, 0.0, angle=way * last * i / 300) for i in range(1, 301)]
    states = marched(stiff_circle(), drives, mech.FrictionCoefficients(1.0, 1.0))
    rolled = -way * last
    # points on chords of 0.05 mm instead of the circle: (0.05 / 60)^2 / 24 of the way rolled
    assert states[-1].travel == pytest.approx(RADIUS * (math.sin(rolled) - rolled), abs=1e-5)
    assert abs(states[-1].travel) > 1e-3
    assert not any(state.slips.any() for state in states[2:])
    middle = stiff_circle().pad.x @ states[-1].normal
    # where a polygon's corner meets the plate: to half a chord
    assert middle == pytest.approx(RADIUS * math.sin(rolled), abs=SPACING)


def test_the_frame_turns_with_the_plate() -> None:
    """Against vectors written out: how a force along the plate and one along its normal move the skin."""
    pad, angle = meshed()[2], math.radians(4.0)
    m, seen = pad.gap.size, turning.rotated_pad(meshed()[2], angle)
    along, normal = (
        np.array([math.cos(angle), math.sin(angle)]),
        np.array([-math.sin(angle), math.cos(angle)]),
    )
    force = np.random.default_rng(1).normal(size=(m, 2))  # along, normal
    plain = force[:, :1] * along + force[:, 1:] * normal
    assert turning.in_skin_axes(force.T.ravel(), angle) == pytest.approx(plain.T.ravel(), abs=1e-14)
    moved = (pad.compliance @ plain.T.ravel()).reshape(2, m).T
    expected = np.concatenate([moved @ along, moved @ normal])
    # rounding
    assert seen.compliance @ force.T.ravel() == pytest.approx(expected, abs=1e-12 * np.abs(expected).max())
    place = np.column_stack([pad.x, -pad.gap])
    below = -(place @ normal)
    assert seen.gap == pytest.approx(below - below.min(), abs=1e-12)
    assert seen.free[:m] == pytest.approx(place @ along - pad.x, abs=1e-12)
    assert not seen.free[m:].any()


def test_a_turned_plate_is_a_turned_pull() -> None:
    """A bonded plate that turned by a, pressed along its normal: the same forces as seen by the fixed one."""
    model = stiff_circle()
    one = model.pad
    point = replace(
        one,
        compliance=np.diag([0.3, 0.1]),
        gap=np.zeros(1),
        x=np.zeros(1),
        ridge=one.ridge[:1],
        area=one.area[:1],
        strips=np.zeros((0, 3, 2)),
    )
    angle = math.radians(5.0)
    drives = [mech.Drive(0.0, 0.0), mech.Drive(0.0, 0.0, angle=angle), mech.Drive(2.0, 0.5, angle=angle)]
    state = marched(CondensedPad(point), drives, mech.FrictionCoefficients(1.0, 1.0))[-1]
    x = 2.0 * math.sin(angle) + 0.5 * math.cos(angle)
    z = -2.0 * math.cos(angle) + 0.5 * math.sin(angle)
    by_hand = np.array([0.3 * x, 0.1 * z])
    assert state.approach == pytest.approx(by_hand @ [math.sin(angle), -math.cos(angle)], rel=1e-12)
    assert state.travel == pytest.approx(by_hand @ [math.cos(angle), math.sin(angle)], rel=1e-12)


def test_work_is_what_is_stored_and_lost() -> None:
    """Forces and moment at their mean over a step: what is missing falls with the steps' square."""

    def missing(steps: int) -> float:
        pad = meshed()[2]
        drives = [mech.Drive(1.2 * i / steps, 0.0) for i in range(steps + 1)]
        drives += [mech.Drive(1.2, 0.0, angle=math.radians(2.0) * i / steps) for i in range(1, steps + 1)]
        model = CondensedPad(pad)
        states = marched(model, drives, mech.FrictionCoefficients(0.0, 0.0))
        readings = [model.reading(a, b) for a, b in pairwise([states[0], *states])]
        press_work = 0.5 * sum(
            (a.normal + b.normal) * (b.approach - a.approach) for a, b in pairwise(readings[: steps + 1])
        )
        work = press_work + sum(reading.work or 0.0 for reading in readings)
        turned_work = sum(reading.work or 0.0 for reading in readings)
        assert abs(turned_work) > 0.01 * press_work
        return abs(work - readings[-1].elastic) / work

    coarse, fine = missing(20), missing(40)
    assert fine < 5e-4
    # points close within steps: between first and second order
    assert fine < 0.6 * coarse
