"""Accuracy: the countdown, fronts and laws of time, the ladders of a small design, and the command."""

from __future__ import annotations

import csv
import json
import platform
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from PIL import Image

from bench import holds
from skincad import load
from skincad.base import InputError, replaced
from skincad.effects import EFFECTS
from skincad.inputs import Design
from skincad.mechanics import MODELS, Layers
from skincad.mechanics.models import solid
from skincad.outputs import LADDER_SIZE, STYLES, accuracy_figure, save
from skincad.studies import ErrorMeasure, Ladder, Measurement, slope
from skincad.studies.accuracy import accuracy, circuit, contact, effects, slip, tessellation
from skincad.studies.accuracy.accuracy import Accuracy
from skincad.studies.accuracy.ladder import timed
from tests.conftest import run_skincad
from tests.refusals import refused_command
from tests.shared_pads import shared_pads  # noqa: F401  # a fixture that all tests of this file use

CONTACT = pytest.mark.evidence(subject="ladders: contact")


ALL = ErrorMeasure("all", "error", "1", "the truth", "")


def best(seconds: list[float], errors: list[float]) -> list[int]:
    """Return which trials of one model are on its front."""
    rows = enumerate(zip(seconds, errors, strict=True))
    trials = [Measurement("a", str(i), 1, (s,), {"all": e}) for i, (s, e) in rows]
    return [int(trial.setting) for trial in Ladder("x", "x", tuple(trials), (ALL,)).best(ALL)]


def test_the_front_holds_what_nothing_beats_in_both() -> None:
    # by time; the trials of 3 s, and of 1 s and 2.0, are beaten
    assert best([4.0, 1.0, 2.0, 3.0, 1.0], [0.1, 1.0, 0.5, 0.6, 2.0]) == [1, 2, 0]
    for second in (1.0, 2.0):  # of two equal trials one
        assert best([1.0, second], [0.5, 0.5]) == [0]
    seconds, errors = np.random.default_rng(1).random((2, 50)).tolist()
    front = best(seconds, errors)
    assert all(errors[b] < errors[a] for a, b in pairwise(front))
    for s, e in zip(seconds, errors, strict=True):
        assert any(seconds[i] <= s and errors[i] <= e for i in front)


def laws(sizes: list[int], seconds: list[float]) -> dict[str, Any]:
    trials = [Measurement("a", "", n, (s,), {}) for n, s in zip(sizes, seconds, strict=True)]
    return Ladder("x", "x", tuple(trials), (ALL,)).laws()


def test_a_law_of_time_is_found_with_its_exponent_and_scatter() -> None:
    seconds = [0.1, 1.0, 10.0]
    assert slope(seconds, [3 * s**-1.5 for s in seconds]) == pytest.approx(-1.5)  # rounding
    assert slope(seconds, [0.0, 1.0, 1.0]) == pytest.approx(0.0, abs=1e-12)  # 0 has no logarithm
    assert slope([1.0, 1.0], [1.0, 2.0]) is None
    sizes = [1000, 5000, 20000]
    law = laws(sizes, [2e-6 * n**1.3 for n in sizes])["a"]
    assert (law.factor, law.exponent) == pytest.approx((2e-6, 1.3))
    assert law.scatter == pytest.approx(1.0)
    assert laws([1000, 1000, 1000], [1.0, 2.0, 3.0]) == {}  # one size
    assert laws([1000, 2000], [1.0, 1.0]) == {}  # two
    law = laws([1, 10, 100, 1000], [2.0, 0.5, 2.0, 0.5])["a"]
    assert 1.5 < law.scatter < 2.0  # ratios of 2 about a law that the fit tilts a little


MINE = ErrorMeasure("own", "error", "1", "own finest", "", compares=False)


def test_times_compare_at_matched_error() -> None:
    """By the cheapest trial that is good enough; not below the reference's own error, not of one model."""
    rough, fine = (
        Measurement("a", s, 1, (t,), {"all": e}) for s, t, e in (("r", 1.0, 0.05), ("f", 3.0, 5e-4))
    )
    other = Measurement("b", "", 1, (2.0,), {"all": 0.009})
    ladder = Ladder("x", "x", (rough, fine, other), (MINE, ALL))
    assert ladder.matched(ALL) == {0.1: [rough, other], 0.01: [other, fine]}
    assert ladder.matched(replace(ALL, floor=0.01)) == {0.1: [rough, other]}
    assert ladder.matched(MINE) == {}
    assert replace(ladder, lines=False).matched(ALL) == {}
    matched = ladder.reference()["at_matched_error"]["all"][1]
    assert matched == {"error": 0.01, "seconds": {"b": 2.0, "a": 3.0}}
    # A fast model that is exact in its own terms must not push a better model off its front
    quick = Measurement("quick", "a", 1, (1.0,), {"own": 0.01, "all": 0.5})
    slow = Measurement("slow", "a", 1, (2.0,), {"own": 0.02, "all": 0.6})
    slower = Measurement("slow", "b", 1, (3.0,), {"own": 0.03, "all": 0.1})
    ladder = Ladder("x", "x", (quick, slow, slower), (MINE, ALL))
    assert ladder.best(MINE) == [quick, slow]
    assert ladder.best(ALL) == [quick, slower]
    assert Ladder("x", "x", (quick, slow), (MINE, ALL), lines=False).best(ALL) == []


def test_rows_carry_median_spread_and_the_first_measure() -> None:
    trial = Measurement("quick", "a", 7, (1.0, 5.0, 2.0), {"all": 0.5})
    row = Ladder("x", "x", (trial,), (MINE, ALL)).rows()[0]
    assert (row["seconds"], row["spread_s"], row["repeats"]) == (2.0, 4.0, 3)
    assert row["error"] is None
    assert row["errors"] == {"all": 0.5}
    # short work is warmed up and repeated
    calls: list[int] = []

    def work() -> int:
        calls.append(1)
        return len(calls)

    last, runs = timed(work, 3)
    assert (last, len(runs)) == (4, 3)


@pytest.fixture(scope="module")
def small() -> Design:
    """Three ridges, with slots and film."""
    return load("yamada-2002").with_(ridge={"count": 3}, skin={"width": 4.0}, contact={"force": 1.0})


@pytest.fixture(scope="module")
def plain(small: Design) -> Design:
    return small.with_(slot=None, film=None, contact={"film": None})


def silent(_stage: str) -> None:
    """Nobody hears the stages."""


def errors(found: Ladder, model: str, measure: str) -> list[float]:
    return [trial.errors[measure] for trial in found.trials if trial.model == model]


def assert_whole(found: Ladder) -> None:
    """What every ladder promises: errors by its own measures, each with a reference and how it is known."""
    known = {measure.name for measure in found.measures}
    assert found.trials
    for trial in found.trials:
        assert set(trial.errors) <= known
        assert trial.seconds > 0
        assert all(np.isfinite(error) and error >= 0 for error in trial.errors.values())
    assert all(measure.reference and measure.checked for measure in found.measures)
    assert {row["model"] for row in found.rows() if row["error"] is not None}


def test_the_time_left_goes_by_ladders_and_by_what_the_last_ones_took(
    small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of three ridges 10 s are expected of one ladder, and 20 of the other."""
    now = [0.0]
    prices = {"slip": (30.0, 0.0), "effects": (45.0, 15.0)}  # of nine ridges; three take a third of it
    took = {"slip": 20.0, "effects": 10.0}

    def worker(name: str) -> Any:
        def ladder(_design: Design, _repeats: int, tell: Any) -> Ladder:
            for stage in ("a", "b"):
                tell(stage)
                now[0] += took[name] / 2
            return Ladder(name, name, (), (ALL,))

        return SimpleNamespace(ladder=ladder)

    rows: list[tuple[str, float | None]] = []
    monkeypatch.setattr(accuracy, "LADDERS", prices)
    monkeypatch.setattr(accuracy, "perf_counter", lambda: now[0])
    monkeypatch.setattr(accuracy, "import_module", lambda name: worker(name.rpartition(".")[2]))
    answer = accuracy.accuracy(small, repeats=1, progress=lambda stage, left=None: rows.append((stage, left)))
    # a machine twice as slow takes twice as long
    slower = (accuracy.PRIOR + 20.0) / (accuracy.PRIOR + 10.0)
    assert rows == [
        ("slip: a", pytest.approx(30.0)), ("slip: b", pytest.approx(20.0)),
        ("effects: a", pytest.approx(slower * 20.0)), ("effects: b", pytest.approx(slower * 20.0 - 5.0)),
    ]  # fmt: skip
    assert [ladder.name for ladder in answer.ladders] == list(prices)
    assert answer.seconds == 30.0


def test_an_unknown_ladder_is_refused_and_every_model_is_tried(small: Design) -> None:
    with pytest.raises(InputError, match="ladders: unknown ladder, got 'contcat'; did you mean 'contact'"):
        accuracy.accuracy(small, ["contcat"])
    assert sorted(contact.ORDER) == sorted(MODELS)


@pytest.fixture(scope="module")
def sampled(small: Design) -> Ladder:
    return holds.holds(small, 1)


@pytest.mark.slow
def test_holds_converge_at_their_orders_the_first_order_one_is_exact_for_a_kink(sampled: Ladder) -> None:
    """Zero-order hold 1, the others 2: from 256 to 4096 samples, where higher terms are a few per cent."""
    assert_whole(sampled)
    finer = np.log(circuit.PER_PERIOD[-1] / circuit.PER_PERIOD[-3])
    own = "first-order hold"
    for hold, order in zip((own, *holds.HOLDS), (2.0, 1.0, 2.0), strict=True):
        output = errors(sampled, hold, "output")
        assert np.log(output[-3] / output[-1]) / finer == pytest.approx(order, abs=0.05)
    # Straight between samples, so only rounding of up to 40 000 steps is left; the others need the rate
    assert max(errors(sampled, own, "kink")) < 1e-8
    for hold in holds.HOLDS:
        kink = errors(sampled, hold, "kink")
        assert all(b < a for a, b in pairwise(kink))
        assert kink[-1] > 1e-6


def test_meshes_keep_their_chord(small: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tessellation, "CHORDS", (3e-2, 3e-3, 3e-4))
    answer = holds.kernel_meshes(small, 1)
    assert_whole(answer)
    chords = [share * small.ridge.height for share in (3e-2, 3e-3, 3e-4)]
    for model in ("manifold3d", holds.KERNEL):
        deviation, volume = errors(answer, model, "deviation"), errors(answer, model, "volume")
        # a tenth is the reference's own error, added to all
        assert all(d <= 1.1 * chord * (1 + 1e-9) for d, chord in zip(deviation, chords, strict=True))
        assert all(b < a for a, b in pairwise(volume))
        # a chord cuts off 2/3 of its height on average, so volume follows the chord; not at few chords an arc
        assert volume[-1] < volume[0] / 5


def small_ladders(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two meshes and few steps: what is asked of them here does not hang on how fine they are."""
    levels = {"linear": ((0.5, 2), (0.5, 3), (1.0, 4)), "finite-strain": ((0.5, 2), (0.5, 3), (0.5, 4))}
    monkeypatch.setattr(contact, "LEVELS", levels)
    monkeypatch.setattr(contact, "MESH", 0.05)
    layers = Layers(0.6, 2.0, 3), Layers(0.3, 1.8, 3)
    monkeypatch.setattr(solid, "REFINEMENTS", (solid.MeshRefinement(0.5, 3),))
    monkeypatch.setitem(solid.LAYERS, 0.5, layers)
    monkeypatch.setattr(slip, "MESHES", ((0.5, 2), (0.5, 3)))
    monkeypatch.setattr(slip, "STEPS", (22, 55, 110, 220, 440))
    monkeypatch.setattr(effects, "STEPS", 22)
    monkeypatch.setattr(effects, "FEWER", {})


@pytest.mark.parametrize("model", contact.LEVELS)
def test_levels_are_each_another_and_the_last_is_the_finest(model: str) -> None:
    levels = contact.LEVELS[model]
    assert len(set(levels)) == len(levels)
    assert levels[-1] == (max(fine for fine, _ in levels), max(order for _, order in levels))
    for fine in {fine for fine, _ in levels}:  # orders without a gap, so that each shows what one more gains
        orders = [order for each, order in levels if each == fine]
        assert orders == list(range(orders[0], orders[0] + len(orders)))


@pytest.fixture(scope="module")
def pressed(plain: Design) -> Ladder:
    with pytest.MonkeyPatch.context() as patch:
        small_ladders(patch)
        return contact.ladder(plain, 1, silent)


@CONTACT
def test_every_model_is_on_the_contact_ladder_and_errs_less_by_finer_meshes(pressed: Ladder) -> None:
    assert_whole(pressed)
    assert not pressed.skipped
    assert {trial.model for trial in pressed.trials} == {
        "winkler", "reduced", "linear", "finite-strain", "solid", "corrected", *contact.BEST[:2],
    }  # fmt: skip
    # higher orders cost and gain
    for model in ("linear", "finite-strain"):
        trials = [trial for trial in pressed.trials if trial.model == model]
        lower, higher = trials[:2]
        assert higher.unknowns > lower.unknowns
        assert higher.errors["mesh F9"] < lower.errors["mesh F9"]
        assert higher.errors["mesh approach"] < lower.errors["mesh approach"]
    # The linear model's whole error is its model's: finer meshes leave it within a twentieth
    whole = errors(pressed, "linear", "whole approach")
    assert max(whole) < 1.05 * min(whole)
    for measure in ("whole F9", "whole approach"):
        assert errors(pressed, "corrected", measure)[0] < min(errors(pressed, "linear", measure))
        assert errors(pressed, "corrected", measure)[0] < errors(pressed, "winkler", measure)[0]
    measures = {measure.name: measure for measure in pressed.measures}
    assert measures["whole F9"].reference.startswith("solid-finite-strain")
    assert 0 < measures["whole F9"].floor < 0.05  # its stated error: the mesh that was asked
    assert not measures["mesh F9"].compares


@CONTACT
def test_what_cannot_judge_a_design_is_skipped(plain: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    small_ladders(monkeypatch)
    curved = plain.with_(skin={"curvature_radius_y": 40.0})
    answer = contact.ladder(curved, 1, silent)
    assert {trial.model for trial in answer.trials} == {"winkler", "solid", "solid-finite-strain"}
    assert set(answer.skipped) >= {"linear", "corrected", "finite-strain"}
    assert all("curvature_radius_y" in why for why in answer.skipped.values())


@pytest.fixture(scope="module")
def slipped(small: Design) -> Ladder:
    with pytest.MonkeyPatch.context() as patch:
        small_ladders(patch)
        return slip.ladder(small, 1, silent)


@pytest.mark.slow
def test_more_steps_find_the_signal(slipped: Ladder) -> None:
    assert_whole(slipped)
    signal = errors(slipped, "time step", "signal")
    assert signal[-1] < signal[0] / 3  # the step moves the slip's instant: first order, ten times the steps
    assert len([r for r in slipped.trials if r.model == "mesh"]) == 1


@pytest.mark.evidence(subject="ladders: slip")
def test_a_skin_without_slots_slips_by_its_travel(plain: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    small_ladders(monkeypatch)
    answer = slip.ladder(plain, 1, silent)
    assert not answer.skipped
    assert "travel" in answer.measures[0].what


@pytest.mark.slow
@pytest.mark.parametrize(
    "named",
    [
        ("film", "friction"),
        pytest.param(tuple(EFFECTS), marks=pytest.mark.evidence(subject="ladders: effects")),
    ],
)
def test_every_effect_is_tried_or_skipped(
    named: tuple[str, ...], small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_ladders(monkeypatch)
    monkeypatch.setattr(effects, "EFFECTS", {name: EFFECTS[name] for name in named})
    answer = effects.ladder(small, 1, silent)
    names = {trial.model for trial in answer.trials}
    assert names | set(answer.skipped) == {*named, effects.LAW}
    assert {"friction", "film"} <= names
    left_out = {r.model: r.errors for r in answer.trials if r.setting.startswith("left out")}
    assert left_out["friction"]["signal"] > left_out["film"]["signal"] > 0
    named: list[Measurement] = [r for r in answer.trials if r.setting.startswith("named")]
    assert all(not trial.errors for trial in named)
    price = {trial.model: trial.runs for trial in named}  # a diagram shows what an error costs to be without
    assert all(trial.instead == price[trial.model] for trial in answer.trials if trial.errors)


@pytest.mark.slow
def test_json_files_and_manifest_beside_another_jobs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(circuit, "PER_PERIOD", (16, 64))  # short: what is told of it is the same
    folder = tmp_path / "out" / "plain-ridges"
    with replaced(folder, "make") as staging:
        (staging / "skin.step").write_text("solid")
    before = {path.name for path in folder.iterdir()}
    words = ("accuracy", "plain-ridges", "--ladder", "circuit", "--repeats", "1", "--json")
    done = run_skincad(*words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert all(row["seconds"] > 0 for row in data["rows"])
    assert data["seconds"]["total"] > 0
    assert data["reference"]
    assert done.stderr == ""
    assert (folder / "skin.step").read_text() == "solid"
    assert {Path(file["path"]).name for file in data["files"]} == {"accuracy.csv", "accuracy.png"}
    new = {path.name for path in folder.iterdir()} - before
    assert new == {"accuracy.csv", "accuracy.png", "accuracy.json"}
    assert not platform.node() or platform.node() not in json.dumps(data["machine"])
    assert data["machine"]["cores"] >= 1
    rows = list(csv.DictReader((folder / "accuracy.csv").open()))
    assert [row["setting"] for row in rows] == [row["setting"] for row in data["rows"]]
    first = float(rows[0]["circuit: output"])
    assert first == pytest.approx(data["rows"][0]["error"], rel=1e-3)  # four digits
    with Image.open(folder / "accuracy.png") as picture:
        assert picture.size == (round(100 * LADDER_SIZE[0]), round(100 * LADDER_SIZE[1]))


def test_bad_input_is_one_line(tmp_path: Path) -> None:
    for words, said in (
        ("--ladder contcat", "--ladder: unknown ladder, got 'contcat'; did you mean 'contact'?"),
        ("--repeats 0", "--repeats: must be from 1 to 100, got 0"),
        ("--set ridge.hight=1", "ridge.hight: unknown key; did you mean 'height'?"),
    ):
        assert said in refused_command("accuracy", "plain-ridges", *words.split(), cwd=tmp_path)


@pytest.mark.slow
def test_a_diagram_in_grey_shows_every_trial(tmp_path: Path) -> None:
    """A trial more is ink more, in grey; a ladder without any is a picture that says so. Methods differ by
    marker and dashes."""
    assert len({marker for _, marker, _ in STYLES}) == len({str(d) for _, _, d in STYLES}) == len(STYLES)
    measure = ErrorMeasure("all", "error", "1", "the truth", "")
    trials = tuple(
        Measurement("a", f"{i}", i, (10.0**-i, 2 * 10.0**-i), {"all": 10.0 ** (i - 5)}) for i in range(4)
    )
    other = tuple(Measurement("b", f"{i}", i, (2.0**-i,), {"all": 10.0 ** (i - 4)}) for i in range(4))
    ink = []
    for name, these in (("none", ()), ("one", trials), ("two", trials + other)):
        path = tmp_path / f"{name}.png"
        ladders, where = (Ladder("x", "x", these, (measure,)),), {"processor": "x", "cores": 2}
        drawn = Accuracy(name="x", ladders=ladders, machine=where, repeats=2, seconds=1.0)
        save(accuracy_figure(drawn), path)
        with Image.open(path) as picture:
            ink.append(int((np.asarray(picture.convert("L")) < 160).sum()))
    assert ink[0] < ink[1] < ink[2]
