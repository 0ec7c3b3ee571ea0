"""Finite strain in a scene, in each step and in chosen ones: what is told, and where it stops."""

from __future__ import annotations

import re
from functools import cache
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from skincad.base import Array
from skincad.effects import UPDATE_INTERVAL, FiniteStrain, Friction, Share, SmallStrain, Step, chosen_steps
from skincad.mechanics import (
    ContactError,
    Drive,
    FrictionalState,
    FrictionCoefficients,
    default_sizes,
    filled_pad,
    piece_of,
    triangles,
)
from skincad.mechanics.contact import folding
from skincad.mechanics.contact.frictional_pad import unloaded
from skincad.scenes import March
from skincad.scenes.march import march
from tests.mechanics.contact.travel import advance_to, driven
from tests.mechanics.designs import yamada

NORMAL, COEFFICIENT = 1.2, 0.5
PRESSED, PULLED = 8, 20


def drives() -> list[Drive]:
    """Pressed, pulled to gross slip, a third of the pull taken back on the way."""
    ways = [0.0] * (PRESSED + 1) + list(np.linspace(0, 0.8, PULLED)) + [0.7, 0.6, 0.55, 0.6, 0.7]
    ways += list(np.linspace(0.8, 1.0, 8))
    pull = COEFFICIENT * NORMAL * np.array(ways)
    press = NORMAL * np.minimum(np.arange(pull.size) / PRESSED, 1)
    return [Drive(float(n), float(t)) for n, t in zip(press, pull, strict=True)]


def pad_of(law: Any, films: bool = True, film: str = "bonded", halved: bool = False) -> Any:
    """Three ridges, coarse."""
    design = yamada().with_(ridge={"count": 3}, skin={"width": 5.0}, contact={"film": film})
    piece = piece_of(*filled_pad(design), halved=halved)
    return law.marched(piece, triangles(piece.pad, default_sizes(piece.pad, 0.35)), 2, films, [])


def silicone_pad(films: bool = True, creases: str = "pass") -> Any:
    """Silicone in the slots, finite strain in each step."""
    return pad_of(FiniteStrain(creases=creases), films, "ignored", FiniteStrain.halves)


@cache
def marched(steps: str) -> March:
    law = SmallStrain() if steps == "none" else FiniteStrain(steps=steps)
    way = drives()
    return march(pad_of(law), np.arange(float(len(way))), way, [Friction(coefficient=COEFFICIENT)])


def difference(run: March) -> Array:
    """S1 - S2 across, `(steps + 1, 3)` MPa."""
    films = run.column("films")
    return np.asarray(films[:, ::2, 0] - films[:, 1::2, 0])


def missed(run: March) -> Array:
    """The told drift of S1 - S2, `(steps + 1, 3)` MPa."""
    films = np.array([reading.drift.films for reading in run.readings if reading.drift])
    return np.asarray(films[:, ::2, 0] + films[:, 1::2, 0])


@pytest.mark.evidence(subject="chosen steps: drift")
def test_a_few_chosen_steps_tell_what_finite_strain_in_each_tells() -> None:
    """Signals within what is told of their error, ridges' forces within a hundredth, and both far nearer than
    small strain; in a fraction of the steps."""
    every, chosen, small = marched("all"), marched("chosen"), marched("none")
    assert every.stopped == chosen.stopped == "gross slip"
    count = sum(bool(reading.drift and reading.drift.chosen) for reading in chosen.readings)
    assert 5 < count < len(chosen.readings) / 2
    off = np.abs(difference(chosen) - difference(every)).max()
    assert off <= missed(chosen).max()
    assert off < 0.02 * np.abs(difference(every)).max()
    assert off < 0.05 * np.abs(difference(small) - difference(every)).max()
    loads = np.abs(chosen.loads[:, :2] - every.loads[:, :2]).max()
    assert loads < 0.01 * every.loads[:, 0].max()
    assert loads < 0.2 * np.abs(small.loads[:, :2] - every.loads[:, :2]).max()


@pytest.mark.evidence(subject="chosen steps: drift")
def test_nothing_jumps_where_a_step_is_chosen() -> None:
    """The signal's slope changes nowhere by more than at finite strain in each step."""
    every, chosen = marched("all"), marched("chosen")
    bend = [
        np.abs(np.diff(difference(run)[PRESSED + 1 : PRESSED + PULLED], 2, axis=0)).max()
        for run in (every, chosen)
    ]
    assert bend[1] < 1.5 * bend[0]


@pytest.mark.slow
def test_what_the_contact_puts_in_is_stored_and_dissipated() -> None:
    """The energy summed up from the contact's work is the body's own at the last chosen step, to the drift;
    and the plate's work is that and friction's, to the trapezoids' error where points close within a step."""
    run = marched("chosen")
    state = list(run.states.values())[-1]
    body, pad = state.tangent.state, run.pad
    assert isinstance(body, FrictionalState)
    stored = pad.pad.body.energy(body.values) * pad.pad.scale * pad.pad.unit
    at = max(i for i, reading in enumerate(run.readings) if reading.drift and reading.drift.chosen)
    assert run.readings[at].elastic == pytest.approx(stored, rel=0.01)
    normal, along = run.column("normal"), run.column("tangential")
    work = (normal[1:] + normal[:-1]) / 2 @ np.diff(run.column("approach"))
    work += (along[1:] + along[:-1]) / 2 @ np.diff(run.column("travel"))
    assert run.readings[-1].elastic + run.column("dissipated").sum() == pytest.approx(work, rel=2e-3)


@pytest.mark.evidence(subject="chosen steps: drift")
def test_drift_falls_with_the_square_of_the_stride(monkeypatch: pytest.MonkeyPatch) -> None:
    """Between first and third order: pulled at full stick, where no set changes."""
    pull = [Drive(NORMAL * min(i, 10) / 10, 0.012 * max(0, i - 10)) for i in range(41)]
    drifts = []
    for limit in (1 / 12, 1 / 24):
        monkeypatch.setattr("skincad.effects.chosen_steps.UPDATE_INTERVAL", limit)
        pad = pad_of(FiniteStrain(steps="chosen"))
        run = march(pad, np.arange(41.0), pull, [Friction(coefficient=1.5)])
        assert run.stopped is None
        drifts.append(missed(run)[30:].max())
    assert 2 < drifts[0] / drifts[1] < 8


@pytest.mark.slow
def test_where_no_step_can_be_chosen_it_goes_on_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is not looked for again under larger forces; its error grows with the square of what moves."""
    calls = []

    def folded(*_: object) -> str:
        calls.append(1)
        return "the surface folds"

    monkeypatch.setattr(chosen_steps, "undetected_contact", folded)
    way = [Drive(0.1 * i, 0.0) for i in range(9)] + [Drive(0.8, 0.02 * i) for i in range(6)]
    run = march(
        pad_of(FiniteStrain(steps="chosen")), np.arange(float(len(way))), way, [Friction(coefficient=1.0)]
    )
    assert run.stopped is None
    assert len(calls) == 1
    assert run.readings[-1].drift is not None
    assert run.readings[-1].drift.cut == "the surface folds"


@pytest.mark.slow
def test_a_step_is_looked_for_again_under_smaller_forces(monkeypatch: pytest.MonkeyPatch) -> None:
    faults = iter(["the surface folds", None, None, None])
    monkeypatch.setattr(chosen_steps, "undetected_contact", lambda *_: next(faults))
    way = [Drive(0.1 * i, 0.0) for i in (0, 2, 4, 3, 1)]
    run = march(pad_of(FiniteStrain(steps="chosen"), False), np.arange(5.0), way, [Friction(coefficient=1.0)])
    cuts = [reading.drift.cut for reading in run.readings if reading.drift]
    assert any(cuts)
    assert not cuts[-1]


def test_before_the_first_chosen_step_its_error_is_what_has_moved() -> None:
    """A touch too light for any: the drift told is not nothing."""
    way = [Drive(0.002 * i, 0.0) for i in range(4)]
    run = march(pad_of(FiniteStrain(steps="chosen")), np.arange(4.0), way, [Friction(coefficient=0.5)])
    drifts = [reading.drift for reading in run.readings if reading.drift]
    assert [drift.chosen for drift in drifts] == [True, False, False, False]
    assert 0 < drifts[-1].forces[1].max() < UPDATE_INTERVAL * way[-1].normal
    assert drifts[-1].films.max() > 0


@pytest.mark.evidence(subject="chosen steps: drift")
def test_the_same_march_gives_the_same_bits() -> None:
    way = drives()[:8]
    pad = pad_of(FiniteStrain(steps="chosen"))
    once, again = (march(pad, np.arange(8.0), way, [Friction(coefficient=0.5)]) for _ in range(2))
    assert np.array_equal(once.column("films"), again.column("films"))
    assert np.array_equal(once.loads, again.loads)


@pytest.mark.slow
def test_a_march_tells_films_energy_and_gross_slip() -> None:
    what = silicone_pad()
    drives = [Drive(0.3 * min(i, 4), 0.15 * max(0, i - 4)) for i in range(9)]
    run = march(what, np.arange(9.0), drives, [Friction(coefficient=0.4)])
    assert run.stopped == "gross slip"
    assert run.column("normal")[1:] == pytest.approx([d.normal for d in drives[1:]], rel=1e-9)
    assert run.column("tangential")[-1] == pytest.approx(0.48, rel=1e-9)
    assert run.readings[-1].slips[run.readings[-1].touches].all()
    assert run.column("residual").max() <= 1e-9
    assert (run.column("dissipated") >= -1e-12).all()
    films = run.column("films")
    assert films.shape == (9, 6, 3)
    # pressed, the middle ridge's strips are mirror images of each other to the mesh; pulled, they are not
    press, pull = films[4, 2:4, 0], films[-1, 2:4, 0]
    assert press[0] == pytest.approx(press[1], rel=0.03)
    assert abs(pull[0] - pull[1]) > 0.5 * np.abs(pull).max()
    # what the plate does is stored or dissipated, to the trapezoids' error
    normal, along = run.column("normal"), run.column("tangential")
    work = (normal[1:] + normal[:-1]) / 2 @ np.diff(run.column("approach"))
    work += (along[1:] + along[:-1]) / 2 @ np.diff(run.column("travel"))
    energy = run.readings[-1].elastic + run.column("dissipated").sum()
    assert energy == pytest.approx(work, rel=0.02)


def test_without_readout_no_film_is_looked_at() -> None:
    what = silicone_pad(films=False)
    assert what.strips is None
    assert what.reading(what.start(), what.start()).films.shape == (0, 3)


@pytest.mark.slow
def test_where_the_surface_folds_the_march_stops_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(folding, "WRINKLES", 0.99)  # a light load's stretch
    drives = [Drive(0.0, 0.0), Drive(0.3, 0.0), Drive(0.6, 0.0)]
    run = march(silicone_pad(False, "stop"), np.arange(3.0), drives, [Friction(coefficient=1.0)])
    assert run.failed
    assert run.stopped is not None
    assert "the surface folds onto itself at ridge " in run.stopped
    passed = march(silicone_pad(False), np.arange(3.0), drives, [Friction(coefficient=1.0)])
    assert passed.stopped is None
    assert [reading.fold is None for reading in passed.readings] == [True, False, False]
    assert "the surface folds onto itself at ridge " in passed.readings[1].fold


@pytest.mark.evidence(subject="folds: three ridges to gross slip")
def test_a_march_goes_on_beyond_the_fold_and_the_corners_that_snap() -> None:
    """Much friction: at 0.6 of gross slip the surface folds, at 0.7 and 0.8 no equilibrium is near a corner;
    the march ends soon after, where a flank meets the plate. It stopped at the fold before."""
    pulls = np.linspace(0.0, NORMAL, 60)
    way = [Drive(NORMAL * i / 8, 0.0) for i in range(9)] + [Drive(NORMAL, float(t)) for t in pulls[1:]]
    run = march(pad_of(FiniteStrain()), np.arange(float(len(way))), way, [Friction(coefficient=1.0)])
    pulled = run.column("tangential") / NORMAL
    folds = [share for share, reading in zip(pulled, run.readings, strict=True) if reading.fold]
    assert 0.5 < folds[0] < 0.68
    assert pulled[-1] > 0.78
    assert run.stopped is not None
    assert "meets the plate" in run.stopped
    assert (np.diff(run.column("travel"))[9:] > 0).all()
    assert run.column("residual").max() <= 1e-9


@pytest.mark.slow
def test_what_is_no_solution_ends_the_march_and_says_where(monkeypatch: pytest.MonkeyPatch) -> None:
    """Silicone pressed to nothing, and a skin that goes through itself: by limits that a light load meets."""
    drives = [Drive(0.0, 0.0), Drive(0.3, 0.0)]

    def stopped() -> str:
        return march(silicone_pad(False), np.arange(2.0), drives, [Friction(coefficient=1.0)]).stopped or ""

    assert stopped() == ""
    with monkeypatch.context() as light:
        light.setattr(folding, "LEAST_VOLUME", 0.99)
        assert re.search(r"at ridge [123] silicone is pressed to 0\.\d+ of its volume", stopped())
    monkeypatch.setattr(folding.plane_body, "crossing", lambda _: (0.2, np.zeros(2)))
    assert re.search(
        r"at ridge 2 the skin goes through itself by 0\.\d+ mm, more than a fillet's radius of 0\.\d",
        stopped(),
    )


@pytest.mark.parametrize(
    "pad", [lambda: pad_of(FiniteStrain(steps="chosen"), False), lambda: silicone_pad(False)]
)
def test_a_tilting_plate_is_refused(pad: Any) -> None:
    what, tilting = pad(), Step(0.0, 1.0, Drive(0.0, 0.0), Drive(0.3, 0.0, angle=1e-3))
    with pytest.raises(ContactError, match="keeps its angle"):
        what.advanced(what.start(), tilting, Share())


@pytest.mark.evidence(subject="chosen steps: drift")
def test_each_step_is_that_of_the_plates_travel() -> None:
    """Of the last four steps of a pull. 1e-6: steps of the travel are other steps of friction."""
    cone, way = FrictionCoefficients(COEFFICIENT, COEFFICIENT), drives()[: PRESSED + 8]
    run, pad = marched("all"), pad_of(FiniteStrain()).pad
    state = unloaded(pad)
    for i, (start, end) in enumerate(pairwise(way), start=1):
        by_travel = i >= len(way) - 4
        state = driven(pad, state, end, cone) if by_travel else advance_to(pad, state, start, end, cone)
        assert run.readings[i].travel == pytest.approx(state.contact.travel, rel=1e-6, abs=1e-9)
        assert run.readings[i].approach == pytest.approx(state.contact.approach, rel=1e-6)


@pytest.mark.slow
def test_a_step_that_does_not_converge_is_cut(monkeypatch: pytest.MonkeyPatch) -> None:
    """Both tries of the second step are made to fail: its halves add up to what it is in one. 1e-3: friction
    knows the way."""
    newton, tries = chosen_steps.newton, list[float]()

    def failing(pad: Any, before: Any, end: Drive, *more: Any, **how: Any) -> FrictionalState:
        tries.append(end.normal)
        if len(tries) in (2, 3):
            raise ContactError("made to fail")
        return newton(pad, before, end, *more, **how)

    way = [Drive(0.0, 0.0), Drive(0.2, 0.0), Drive(0.4, 0.0)]
    wanted = march(silicone_pad(), np.arange(3.0), way, [Friction(coefficient=0.5)])
    monkeypatch.setattr(chosen_steps, "newton", failing)
    run = march(silicone_pad(), np.arange(3.0), way, [Friction(coefficient=0.5)])
    assert tries == [0.2, 0.4, 0.4, pytest.approx(0.3), 0.4]
    assert run.stopped is None
    assert run.readings[-1].approach == pytest.approx(wanted.readings[-1].approach, rel=1e-3)


@pytest.mark.slow
def test_in_each_step_a_plate_may_wait_and_lift() -> None:
    way = [Drive(0.0, 0.0), Drive(0.0, 0.0), Drive(0.3, 0.0), Drive(0.0, 0.0), Drive(0.2, 0.0)]
    run = march(silicone_pad(), np.arange(5.0), way, [Friction(coefficient=0.5)])
    assert run.stopped is None
    assert run.column("normal") == pytest.approx([drive.normal for drive in way], abs=1e-12)
    assert run.readings[3].elastic == 0.0
    assert not run.readings[3].films.any()


@pytest.mark.slow
def test_gross_slip_is_told_whichever_start_finds_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first start is made to fail: the state that slips is read as any other."""
    newton, tries = chosen_steps.newton, list[float]()

    def failing(pad: Any, before: Any, end: Drive, *more: Any, **how: Any) -> FrictionalState:
        tries.append(end.normal)
        if len(tries) == 2:
            raise ContactError("made to fail")
        return newton(pad, before, end, *more, **how)

    monkeypatch.setattr(chosen_steps, "newton", failing)
    monkeypatch.setattr(chosen_steps.ChosenPad, "_linear_state", lambda _, before, *__: before)
    way = [Drive(0.0, 0.0), Drive(0.3, 0.0), Drive(0.3, 0.2)]
    run = march(silicone_pad(), np.arange(3.0), way, [Friction(coefficient=0.5)])
    assert len(tries) == 3
    assert run.stopped == "gross slip"
    assert run.readings[-1].tangential == pytest.approx(0.15, rel=1e-9)


@pytest.mark.slow
def test_a_chosen_step_begins_without_the_tangent_of_the_one_before(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which Newton might keep, and the steps that follow are linear about it."""
    newton, tangents = chosen_steps.newton, list[int]()

    def watched(pad: Any, *more: Any, **how: Any) -> FrictionalState:
        tangents.append(len(pad.tangents))
        return newton(pad, *more, **how)

    monkeypatch.setattr(chosen_steps, "newton", watched)
    way = [Drive(0.1 * i, 0.0) for i in range(9)] + [Drive(0.8, 0.05 * i) for i in range(1, 5)]
    pad = pad_of(FiniteStrain(steps="chosen"), False)
    march(pad, np.arange(float(len(way))), way, [Friction(coefficient=1.0)])
    assert len(tangents) > 2
    assert not any(tangents)
