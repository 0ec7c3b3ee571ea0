"""What a skin does in a gripper's hand: a slow lift's signal, the drawn lifts it holds, wishes of them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.circuit import fitted, load_circuit
from skincad.cli import run
from skincad.effects import strip_charges
from skincad.inputs import Design, Gripper, load_design, template_names
from skincad.mechanics import ContactCheck, ContactError, FilmStress, Holding, LiftSignal
from skincad.scenes import LEVELS, Grip, MarchSetup, Scene, carried, carrier, piece_for
from skincad.studies import (
    AMPLIFIER,
    FIRST,
    FRICTION,
    KINDS,
    RISE,
    LiftOutcome,
    Study,
    WishResult,
    drawn_lift,
    hears,
    history,
    holding_of,
    lift_signal,
    lifted,
    mass_of,
    optimise,
    scene_of,
    solve,
    summed,
    sweep,
)
from skincad.studies import holding as studies_holding
from skincad.studies.wish_reasons import broken_wishes, choices, held_reason
from skincad.studies.wish_shapes import Wish
from tests.refusals import refused_by, refused_command

HOLES = {"thread": "M3", "diameter": 12.0, "count": 2}
GRIPPERS: dict[str, dict[str, Any]] = {
    "quick": {"delay": 0.02, "force_rate": 200.0, "force_max": 70.0, **HOLES},
    "strong": {"delay": 0.02, "force_rate": 200.0, "force_max": 200.0, "force_min": 100.0, **HOLES},
    "slack": {"force_max": 70.0, **HOLES},
}
QUICK = Gripper(**GRIPPERS["quick"])
SIGNAL = LiftSignal(
    pull=0.5, rise=0.3, circuit="single-supply", rate=2000.0, ridge=4, signal=2e-4, noise=1e-4, level=4.3,
    level_error=1.5,
)  # fmt: skip
HOLDING = Holding(
    gripper="robotiq-2f85", mass=300.0, lifts=60, held=56, small_slides=56, stayed=57,
    share=56 / 60, low=0.841, high=0.974,
    mean_grip_ratio=1.234, dropped_by={"no alarm": 1, "an alarm too late": 3}, beyond=0, bears=9.3,
    circuit="single-supply", rate=2000.0, seconds=30.0,
)  # fmt: skip


def own(name: str, **tables: Any) -> Design:
    """A template with grippers of which all is known, and one of which little is."""
    return load_design(name).with_(grippers=GRIPPERS, **tables)


@pytest.fixture(scope="module")
def closed_form() -> ContactCheck:
    return skincad.check("yamada-2002", model="winkler")


def lines(check: ContactCheck, head: str) -> list[str]:
    return [row.removeprefix(head).strip() for row in str(check).splitlines() if row.startswith(head)]


def test_a_mass_is_a_number_of_grams_or_has_a_unit() -> None:
    texts = ("0.3kg", " .3 kg", "300g", "300 g", "300", 300, 300.0)
    assert [mass_of(text) for text in texts] == pytest.approx([300.0] * 7)


@pytest.mark.parametrize(
    ("hold", "gripper", "words"),
    [
        ("0", "quick", "hold: must be 15 to 20000 g, got 0"),
        ("-1kg", "quick", "hold: must be 15 to 20000 g, got -1000"),
        (float("nan"), "quick", "hold: must be 15 to 20000 g"),
        ("heavy", "quick", "hold: must be a mass, got 'heavy'; as in 0.3kg, 300g or 300"),
        ("300", None, "gripper: is missing, and yamada-2002 has no mold.mount; name one"),
        ("300", "hand", "gripper: no such gripper, got 'hand'"),
        ("300", "slack", "gripper: has no delay, no force_rate, got 'slack'; give it in a grippers.toml"),
        ("15kg", "quick", "hold: must be at most 14.3 kg, which quick holds with 70 N at a friction of 1"),
        (None, "quick", "gripper: needs a mass to hold, got 'quick'"),
    ],
)
def test_lifts_that_nobody_can_try_are_refused(hold: str | None, gripper: str | None, words: str) -> None:
    with refused_by(words):
        skincad.check(own("yamada-2002"), hold=hold, gripper=gripper)


@pytest.mark.parametrize(
    "design",
    [
        load_design("plain-ridges"),
        load_design("yamada-2002", ["film=none", "contact.film=none"]),
        load_design("pins-dome"),
    ],
    ids=["without films", "with empty slots", "pins"],
)
def test_only_films_in_ridges_hear_a_lift(design: Design) -> None:
    assert not hears(design)
    with refused_by("hold: needs films in straight ridges, and "):
        skincad.check(design, hold=300.0, gripper="plain-plate")
    if design.features.family == "ridge":
        assert skincad.check(design, model="linear", tol=0.3, signal=True).lift_signal is None


def test_the_closed_form_makes_no_mesh_for_a_signal() -> None:
    assert skincad.check("yamada-2002", model="winkler", signal=True).lift_signal is None


def test_a_command_refuses_them_in_one_line(tmp_path: Path) -> None:
    check = ("check", "yamada-2002")
    assert refused_command(*check, "--hold", "-1kg", cwd=tmp_path).startswith("--hold: must be 15 to 20000 g")
    assert refused_command(*check, "--hold", "300", cwd=tmp_path).startswith("--gripper: is missing")
    scene = refused_command("sweep", "drop", "--vary", "plate.mass=1:2:2", "--hold", "300", cwd=tmp_path)
    assert scene.startswith("--hold: is for a design, and drop is a scene")


def test_what_is_heard_and_held_is_a_line_each(closed_form: ContactCheck) -> None:
    assert "lift_signal" not in closed_form.as_json()
    assert "holding" not in closed_form.as_json()
    assert "slow lift" not in str(closed_form)
    both = replace(closed_form, lift_signal=SIGNAL, holding=HOLDING)
    (line,) = lines(both, "  slow lift ")
    of = "over noise in a lift of 0.5 N in 0.3 s, ridge 4 behind single-supply: it"
    assert line == f"signal 4 ± 1.5 dB {of} is too weak to be heard"
    may = "may be too weak to be heard"
    for level, words in ((13.0, "can be heard"), (5.0, may), (7.0, may)):
        other = replace(both, lift_signal=replace(SIGNAL, level=level))
        expected = f"signal {level:g} ± 1.5 dB {of} {words}"
        assert lines(other, "  slow lift ") == [expected]
    (line,) = lines(both, "  lifts ")
    assert line == (
        "holds 93 % (84 to 98 %) of 60 lifts of 0.3 kg with robotiq-2f85, the films behind single-supply, "
        "with a slide under 1 mm; 95 % with any slide; the mean grip is 1.23 times the least; not held for "
        "an alarm too late (3), no alarm (1)"
    )
    told = json.loads(json.dumps(both.as_json()))
    assert told["holding"]["share"] == pytest.approx(56 / 60)
    assert {"gripper", "mass_g", "lifts", "held", "low", "high", "mean_grip_ratio"} <= set(told["holding"])
    assert told["lift_signal"]["signal_to_noise_dB"] == 4.3
    assert (told["lift_signal"]["heard"], told["lift_signal"]["verdict"]) == (False, "too weak")
    # a study may want the share, with its error
    share = both.numbers()["holding.share"]
    assert share.error == pytest.approx(56 / 60 - 0.841)


def test_a_skin_that_holds_few_lifts_is_not_the_last_word(closed_form: ContactCheck) -> None:
    few = {"held": 20, "share": 1 / 3, "low": 0.22, "high": 0.46}
    passes = replace(closed_form, force=6.0, holding=HOLDING)  # N, of which it is sure
    (line,) = lines(passes, "Next: ")
    assert line == "`skincad make DESIGN` makes its mold."
    (line,) = lines(replace(passes, holding=replace(HOLDING, **few)), "Next: ")
    assert line.startswith("`skincad new other.toml --hold 300g --gripper robotiq-2f85` looks for a pad that")
    (weak,) = lines(replace(passes, lift_signal=SIGNAL), "Next: ")
    assert weak == line
    (line,) = lines(replace(passes, lift_signal=SIGNAL, holding=None), "Next: ")
    assert line == "`skincad make DESIGN` makes its mold."


def test_what_a_lift_can_not_tell_is_said(closed_form: ContactCheck) -> None:
    none = replace(
        HOLDING, lifts=2, held=0, stayed=0, not_converged=2, share=0.0, low=0.0, high=0.66,
        mean_grip_ratio=None, dropped_by={"a march that does not converge": 2},
    )  # fmt: skip
    assert lines(replace(closed_form, holding=none), "  lifts ") == [
        "none of 2 lifts of 0.3 kg with robotiq-2f85 converges"
    ]
    one = replace(
        HOLDING, lifts=1, held=0, stayed=0, share=0.0, low=0.0, high=0.794, mean_grip_ratio=None, beyond=1
    )
    (line,) = lines(replace(closed_form, holding=one), "  lifts ")
    assert line.startswith("holds 0 % (0 to 80 %) of 1 lift of 0.3 kg with robotiq-2f85")
    assert line.endswith("; it bears about 9.3 N by small strain")


def test_a_gripper_that_grips_too_hard_lifts_nothing() -> None:
    check = skincad.check(own("yamada-2002"), model="winkler", hold="0.3kg", gripper="strong")
    (line,) = lines(check, "  lifts ")
    least = "strong grips with 100 N at least, and this skin bears 22 N"
    assert line == f"lifts of 0.3 kg with strong are not tried: {least}"
    assert check.holding is not None
    assert (check.holding.lifts, check.holding.share) == (0, None)


def test_what_slides_far_or_does_not_converge_is_not_held() -> None:
    """As the exam of lifts counts; the mean grip is over all lifts that were marched to their end."""
    outcomes = [
        LiftOutcome(stayed=True, slide=0.2, ratio=1.5, lost_by=""),
        LiftOutcome(stayed=True, slide=3.0, ratio=0.9, lost_by="an alarm too late"),
        LiftOutcome(stayed=False, slide=9.0, ratio=0.6, lost_by="no alarm"),
        LiftOutcome(stayed=False, slide=np.inf, ratio=None, lost_by="a march that does not converge"),
    ]
    holding = summed(outcomes, "quick", 300.0, 9.0, "", 1.0)
    assert (holding.lifts, holding.held, holding.small_slides, holding.stayed) == (4, 1, 1, 2)
    assert (holding.share, holding.not_converged) == (0.25, 1)
    assert holding.mean_grip_ratio == pytest.approx(1.0)
    assert sum(holding.dropped_by.values()) == 3


@pytest.mark.slow
def test_a_march_that_does_not_converge_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    def stops(*_: object, **__: object) -> None:
        raise ContactError("no equilibrium")

    monkeypatch.setattr("skincad.scenes.lift.carried", stops)
    holding = holding_of(own("steep-fingertip").with_(name="stops"), 40.0, "quick", lifts=2)
    assert (holding.lifts, holding.held, holding.not_converged, holding.share) == (2, 0, 2, 0.0)
    assert holding.dropped_by == {"a march that does not converge": 2}


def test_lifts_are_drawn_within_their_ranges() -> None:
    drawn = [drawn_lift(np.random.default_rng(seed), 300.0, "quick", QUICK) for seed in range(200)]
    assert {one.kind for one in drawn} == set(KINDS)
    assert all(FRICTION[0] <= one.friction <= FRICTION[1] for one in drawn)
    for one in drawn:
        grip = Grip(**one.grip)
        _, load = grip.points
        assert one.least == pytest.approx(np.max(load) / one.friction, rel=1e-9)
        assert load[0] == 0.0
        assert load[-1] == pytest.approx(1e-3 * 300.0 / 2 * 9.81, rel=1e-9)  # half of the weight
        assert FIRST[0] <= one.grip["force"] / one.least <= FIRST[1]
    firm = replace_forces(QUICK, force_min=8.0, force_max=9.0)
    forces = [
        drawn_lift(np.random.default_rng(seed), 300.0, "firm", firm).grip["force"] for seed in range(50)
    ]
    assert (min(forces), max(forces)) == (8.0, 9.0)


def replace_forces(gripper: Gripper, **forces: float) -> Gripper:
    return gripper.model_copy(update=forces)


@pytest.mark.parametrize("kind", KINDS)
def test_a_load_comes_in_its_time_and_jumps_nowhere(kind: str) -> None:
    for seed in range(20):
        rise = (RISE[0], RISE[1])[seed % 2]
        time, load = history(np.random.default_rng(seed), kind, rise)
        assert (time[0], load[0]) == (0.0, 0.0)
        assert load[-1] == pytest.approx(1.0)
        assert (np.diff(time) > 0).all()
        assert load.min() >= 0.0
        assert load.max() <= 1.5 + 1e-9  # a bump or a swing adds half of the weight at most
        assert time[np.argmax(load > 0.49)] >= rise / 8
    again = history(np.random.default_rng(3), kind, 0.2)
    assert all(
        (a == b).all() for a, b in zip(again, history(np.random.default_rng(3), kind, 0.2), strict=True)
    )


def test_films_are_heard_by_what_the_exported_detector_has() -> None:
    from skincad.cli import detectors

    assert AMPLIFIER == detectors.CIRCUIT


@pytest.mark.parametrize(
    ("wish", "words"),
    [
        ({"hold": "300g"}, "hold: needs a gripper that holds it, got '300g'; name one"),
        ({"hold": "300g", "gripper": "quick", "film": "none"}, "hold: needs films, by which a slip is heard"),
        (
            {"hold": "300g", "gripper": "quick", "family": "pin"},
            "hold: needs films, by which a slip is heard",
        ),
        ({"hold": "0", "gripper": "quick"}, "hold: must be 15 to 20000 g, got 0"),
        ({"hold": "300g", "gripper": "slack"}, "gripper: has no delay"),
        ({"hold": "15kg", "gripper": "quick"}, "hold: must be at most 14.3 kg"),
    ],
)
def test_a_wish_to_hold_what_can_not_be_is_refused(wish: dict[str, Any], words: str) -> None:
    with refused_by(words):
        skincad.design_for(grippers=GRIPPERS, **wish)


FEWER = "95 % was asked; most often the cause is "
TWELVE = "12 of 20 lifts held (38 to 79 %)"


@pytest.mark.parametrize(
    ("change", "given", "why"),
    [
        (
            {},
            TWELVE,
            f"{FEWER}an alarm too late: take a gripper with a shorter delay or a faster force "
            "(delay, force_rate)",
        ),
        (
            {"dropped_by": {"no alarm": 8}},
            TWELVE,
            f"{FEWER}no alarm: the signal of a slow lift is 4 ± 1.5 dB over noise; take a smaller size, "
            "whose ridges bear more each, a thicker film, or an amplifier with less noise, which is not "
            "tried here",
        ),
        (
            {
                "lifts": 0,
                "share": None,
                "high": None,
                "reason": "it grips with 20 N at least, and this skin bears 9 N",
            },
            "no lifts",
            "it grips with 20 N at least, and this skin bears 9 N; take a larger size, a larger touch, for "
            "which a harder silicone will do, or a gripper that grips more softly",
        ),
        (
            {"held": 18, "share": 0.9, "low": 0.699, "high": 0.972, "dropped_by": {"an alarm too late": 2}},
            "18 of 20 lifts held (69 to 98 %)",
            "95 % was asked: undecided; most often the cause is an alarm too late: take a gripper with a "
            "shorter delay or a faster force (delay, force_rate)",
        ),
        ({"held": 19, "share": 0.95}, None, None),
    ],
)
def test_a_wish_that_is_missed_says_by_how_much_and_why(
    change: dict[str, Any], given: str | None, why: str | None, closed_form: ContactCheck
) -> None:
    some = replace(
        HOLDING, lifts=20, held=12, share=0.6, low=0.386, high=0.782,
        dropped_by={"no alarm": 3, "an alarm too late": 5},
    )  # fmt: skip
    held = replace(some, **change)
    verdict = replace(closed_form, force=6.0, lift_signal=SIGNAL, holding=held)  # N, of which it is sure
    design = skincad.load("yamada-2002")
    wish = Wish(11.0, 12.0, design.contact.force, "dragon-skin-30", gripper="robotiq-2f85")
    broken = broken_wishes(wish, design, {}, verdict, met=True, mass=300.0, holds=0.95)
    expected = [] if given is None else [("hold", "300 g with robotiq-2f85", given, why)]
    assert [(b.wish, b.asked, b.given, b.why) for b in broken] == expected
    assert [b.undecided for b in broken] == ["undecided" in (why or "")] * len(broken)
    wish_result = WishResult(
        design=design, check=verdict, choices=(), trade=(), warnings=(), broken=broken, seconds={}
    )
    head = "Met" if why is None else "UNDECIDED: hold" if "undecided" in why else "NOT MET: hold"
    assert str(wish_result).startswith(head)
    assert wish_result.passed == (why is None)


def test_a_choice_by_lifts_says_of_how_many_designs() -> None:
    design = skincad.load("yamada-2002")
    most = held_reason(design, 4, 8, most=True)
    assert most == "of the 4 designs tried it held most of 8 lifts"
    rows = {row.key: row.why for row in choices(design, (), {"material.name": most})}
    assert rows["material.name"] == most
    assert most not in {why for key, why in rows.items() if key != "material.name"}
    first = held_reason(design, 2, 8, most=False)
    assert first.startswith("of the 2 designs tried it comes first: by whether the first grips are borne")


@pytest.mark.slow
def test_the_signal_is_that_of_a_lift_that_sticks() -> None:
    """A slow pull that is marched in time, with friction and viscosity, on a mesh of its own. The contact
    shifts under the pull, which makes one end louder by as much as the other gets quieter."""
    design = own("yamada-2002")
    signal = lift_signal(design)
    load = {"load_time_s": [0.0, 0.3, 0.4], "load_N": [0.0, 0.5, 0.5]}
    acts = {"delay": 0.02, "force_rate": 200.0, "force_max": 70.0}
    scene = Scene(
        name="slow",
        skin=design,
        grip={"gripper": "quick", "policy": "constant", "mass": 100.0, "force": 4.0, **load, **acts},
        effects={
            "friction": {"coefficient": 1.0},
            "film": {},
            "viscosity": {"retardation_time": 5e-4},
            "piezo": {"circuit": AMPLIFIER, "sampling_Hz": 2000.0},
        },
        readout={"ridges": list(range(1, 10)), "bandwidth_Hz": 800.0},
    )
    lift = carried(scene, carrier(scene, MarchSetup(scene, piece_for(scene, {})), LEVELS[0]), rate=2000.0)
    assert not lift.slides.any()
    rises = (lift.time > 0.15) & (lift.time <= 0.4)  # once the object does not swing any more
    pair = np.abs((lift.outputs[rises, :, 0] - lift.outputs[rises, :, 1]).mean(axis=0))
    both = (pair + pair[::-1]) / 2
    assert both.argmax() + 1 == signal.ridge
    assert 20 * np.log10(both.max() / signal.signal) == pytest.approx(0.0, abs=signal.level_error)
    # in closed form a current amplifier gives its feedback resistance times the current
    strips = studies_holding.pull_stress(design)
    charges = strip_charges(fitted(load_circuit(AMPLIFIER), design), design, signal.pull * strips[None])[0]
    current = np.abs(charges[::2] - charges[1::2]) / signal.rise
    assert signal.signal == pytest.approx(1e8 * current.max(), rel=0.01)  # but for the first ms
    # the noise is what the detector computes
    detector = skincad.Detector(design, AMPLIFIER, 2000.0, bandwidth=800.0)
    assert signal.noise == pytest.approx(detector.tuning.noise, rel=1e-9)


WITH_FILMS = [name for name in template_names("designs") if hears(load_design(name))]


@pytest.mark.evidence(subject="mesh of a slow lift's signal, {name}")
@pytest.mark.parametrize("name", WITH_FILMS)
def test_its_coarse_mesh_costs_no_more_than_it_says(name: str) -> None:
    """Against `film_stress`, whose mesh has fine corners at the films and is of fifth order."""
    design = load_design(name)
    signal = lift_signal(design)
    pull = design.contact.force / 4
    pressed, pulled = skincad.film_stress(design, design.contact.force, pull).states
    parts = (("s1", "along1", "lengthwise1"), ("s2", "along2", "lengthwise2"))

    def values(state: FilmStress, key: str) -> list[float]:
        return [float(number) for number in getattr(state, key)]

    by_side = [[np.subtract(values(pulled, k), values(pressed, k)) for k in keys] for keys in parts]
    strips = np.moveaxis(np.array(by_side), (0, 1), (1, 2))  # (ridges, sides, stresses)
    circuit = fitted(load_circuit(AMPLIFIER), design)
    charges = strip_charges(circuit, design, signal.pull / pull * strips.reshape(1, -1, 3))[0]
    current = np.abs(charges[::2] - charges[1::2]).max() / signal.rise
    assert 20 * np.log10(1e8 * current / signal.signal) == pytest.approx(0.0, abs=signal.level_error)


@pytest.mark.slow
def test_a_drawn_lift_is_that_of_its_scene() -> None:
    """What a share counts, `simulate` says of the same scene, marched on its own mesh."""
    design = own("steep-fingertip")
    for seed in (0, 1):
        outcome = lifted(design, 60.0, "quick", seed)
        one = drawn_lift(np.random.default_rng((64, seed)), 60.0, "quick", QUICK)
        scene = scene_of(design, one, seed)
        lift = carried(
            scene, carrier(scene, MarchSetup(scene, piece_for(scene, {})), LEVELS[0]), rate=2e3, seed=seed
        )
        assert (outcome.stayed, bool(outcome.lost_by)) == (lift.held, not outcome.held)
        assert outcome.held == (lift.held and np.abs(lift.slide).max() < 1.0)
        assert outcome.slide == pytest.approx(np.abs(lift.slide).max(), rel=1e-9)


@pytest.mark.slow
def test_a_check_counts_the_lifts_that_are_held(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As many as the budget has time for; a heavier object is held less often."""
    path = tmp_path / "mine.toml"
    path.write_text(own("steep-fingertip", mold={"mount": "quick"}).to_toml())
    asked = ["check", str(path), "--hold", "20g", "--budget", "6", "--model", "linear", "--json"]
    assert run(asked) == 0
    told = json.loads(capsys.readouterr().out)
    held = told["holding"]
    assert held["gripper"] == "quick"
    assert held["lifts"] >= 1
    assert held["share"] == held["held"] / held["lifts"]
    assert 0.0 <= held["low"] <= held["share"] <= held["high"] <= 1.0
    assert sum(held["dropped_by"].values()) == held["lifts"] - held["held"]
    # without a budget, which on a busy machine leaves no time for the signal
    signal = skincad.check(own("steep-fingertip"), model="linear", signal=True).lift_signal
    assert signal is not None
    assert signal.heard


@pytest.mark.slow
def test_a_firm_gripper_holds_all_and_none_holds_what_overloads_it() -> None:
    """A first grip of twice what a friction of 0.2 needs, and one beyond small strain."""
    design = own("steep-fingertip")
    firm = {"firm": {**GRIPPERS["quick"], "force_min": 3.0}}
    light = holding_of(design.with_(grippers=firm), 40.0, "firm", lifts=4)  # needs 1.5 N at most
    assert (light.held, light.small_slides, light.dropped_by) == (4, 4, {})
    assert light.mean_grip_ratio is not None
    assert light.mean_grip_ratio > 2.0
    heavy = holding_of(design, 5000.0, "quick", lifts=4)  # a first grip of 10 N and more
    assert heavy.held == 0
    assert heavy.dropped_by == {"a grip that the skin does not bear": 4}


LIFTED = {"grip.delay": 0.02, "grip.force_rate": 200.0, "grip.force_max": 70.0, "grip.policy": "constant",
          "grip.rise": 0.1, "grip.lift": 0.1, "grip.hold": 0.05, "grip.mass": 60.0, "skin": "steep-fingertip",
          "grip.gripper": "plain-plate", "readout.ridges": [1, 2, 3]}  # fmt: skip


FORCES = {"grip.force": [0.3, 1.0]}  # N; friction of 0.6 needs 0.6


@pytest.mark.slow
@pytest.mark.dear("each value is three marches of a lift")
def test_studies_vary_a_lift_and_want_its_slide() -> None:
    """A firmer grip slides less: in a sweep, as a target and as an objective."""
    settings = [f"{key}={json.dumps(value)}" for key, value in LIFTED.items()]
    scene = skincad.load_scene("lift", settings)
    swept = sweep(scene, FORCES, rank={"slide": "min"})
    (first, *_) = swept.rankings[0].ranks
    assert [row.results["slide_mm"].value for row in swept.rows][1] == 0.0
    assert swept.rows[0].results["slide_mm"].value > 1.0
    assert first is not None
    solved = solve(scene, {"slide": "<=0.5"}, FORCES)
    assert [point.values for point in solved.solutions] == [{"grip.force": 1.0}]
    best = optimise(
        Study(
            name="firm", about="lift", settings=settings, vary=FORCES, evaluations=2,
            objectives=[{"key": "slide"}], constraints=[{"key": "mean_grip_ratio", "at_most": 2.0}],
        )
    )  # fmt: skip
    assert best.front[0].values == {"grip.force": 1.0}


@pytest.mark.slow
@pytest.mark.dear("each value is a few lifts")
def test_studies_want_the_share_that_is_held(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a skin's grippers: one that grips firmly holds what another drops."""
    monkeypatch.setattr(studies_holding, "LIFTS", 3)
    firm = {
        "firm": {**GRIPPERS["quick"], "force_min": 3.0},
        "loose": {**GRIPPERS["quick"], "force_max": 0.3},
    }
    design = load_design("steep-fingertip").with_(grippers=firm, mold={"mount": "loose"})
    path = tmp_path / "mine.toml"
    path.write_text(design.to_toml())
    mounts = {"mold.mount": ["loose", "firm"]}
    swept = sweep(design, mounts, rank={"holding.share": "max"}, model="linear", hold="40g")
    shares = [row.results["holding.share"].value for row in swept.rows]
    assert shares[1] == 1.0
    assert shares[0] < 1.0
    solved = solve(design, {"holding.share": ">=0.99"}, mounts, model="linear", hold="40g")
    assert [point.values for point in solved.solutions] == [{"mold.mount": "firm"}]
    study = Study(
        name="held", about=str(path), vary=mounts, hold="40g", evaluations=2, model="linear", judge="linear",
        objectives=[{"key": "holding.share", "goal": "max"}],
    )  # fmt: skip
    best = optimise(study)
    assert best.front[0].values == {"mold.mount": "firm"}
    assert best.front[0].objectives["holding.share"].value == 1.0


@pytest.mark.slow
@pytest.mark.dear("a wish is met once, with lifts of several designs")
def test_a_wish_to_hold_takes_a_design_that_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(studies_holding, "LIFTS", 4)
    monkeypatch.setattr("skincad.studies.wish.FEW_LIFTS", 2)
    small = {"size": "8x10", "touch": "200mN", "silicone": "ecoflex-00-50", "grippers": GRIPPERS}
    wish = skincad.design_for(**small, hold="20g", gripper="quick", name="light")
    assert wish.check.holding is not None
    assert wish.check.lift_signal is not None
    assert wish.check.holding.lifts == 4
    (line,) = (row for row in str(wish).splitlines() if row.startswith("  lifts "))
    assert " of 4 lifts of 0.02 kg with quick" in line
    held = wish.check.holding.share
    assert wish.passed == (held is not None and held >= 0.95)
    hold = [broken for broken in wish.broken if broken.wish == "hold"]
    assert bool(hold) != wish.passed
