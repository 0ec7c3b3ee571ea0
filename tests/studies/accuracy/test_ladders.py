"""The ladders on a small design: what is on them, and errors that fall as theory says."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from skincad import load
from skincad.base import InputError, Progress
from skincad.effects import EFFECTS
from skincad.inputs import Design
from skincad.mechanics import MODELS, Layers
from skincad.mechanics.models import solid
from skincad.studies import LADDERS, Ladder, Measurement, ladder_of
from skincad.studies.accuracy import circuit, contact, effects, slip, tessellation
from skincad.studies.accuracy.circuit import HOLDS, PER_PERIOD


@pytest.fixture(scope="module")
def small() -> Design:
    """Three ridges, with slots and film."""
    return load("yamada-2002").with_(ridge={"count": 3}, skin={"width": 4.0}, contact={"force": 1.0})


@pytest.fixture(scope="module")
def plain(small: Design) -> Design:
    return small.with_(slot=None, film=None, contact={"film": None})


def teller(told: list[str]) -> Progress:
    """A Progress that keeps the stages."""

    def tell(stage: str, left: float | None = None, /) -> None:
        told.append(stage)

    return tell


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


@pytest.mark.parametrize("name", LADDERS)
def test_every_ladder_of_the_table_has_its_prices(name: str, small: Design, plain: Design) -> None:
    for design in (small, plain):
        once, thrice = (ladder_of(name).prices(design, repeats) for repeats in (1, 3))
        assert all(stage.startswith(f"{name}: ") for stage in once)
        assert all(0 < once[stage] <= thrice[stage] for stage in once)
    assert callable(ladder_of(name).ladder)


def test_an_unknown_ladder_is_refused_with_what_was_meant() -> None:
    with pytest.raises(InputError, match="ladders: unknown ladder, got 'contcat'; did you mean 'contact'"):
        ladder_of("contcat")


@pytest.fixture(scope="module")
def sampled(small: Design) -> Ladder:
    return circuit.ladder(small, 1, None)


def test_holds_converge_at_their_orders(sampled: Ladder) -> None:
    """Zero-order hold 1, the others 2: from 256 to 4096 samples, where higher terms are a few per cent."""
    assert_whole(sampled)
    finer = np.log(PER_PERIOD[-1] / PER_PERIOD[-3])
    for hold, order in zip(HOLDS, (2.0, 1.0, 2.0), strict=True):
        output = errors(sampled, hold, "output")
        assert np.log(output[-3] / output[-1]) / finer == pytest.approx(order, abs=0.05)


def test_the_first_order_hold_is_exact_for_a_kink(sampled: Ladder) -> None:
    """Straight between samples, so only rounding of up to 40 000 steps is left; the others need the rate."""
    assert max(errors(sampled, HOLDS[0], "kink")) < 1e-8
    for hold in HOLDS[1:]:
        kink = errors(sampled, hold, "kink")
        assert all(b < a for a, b in pairwise(kink))
        assert kink[-1] > 1e-6


def test_meshes_keep_their_chord_and_their_volume_follows_it(
    small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tessellation, "CHORDS", dict.fromkeys((3e-2, 3e-3, 3e-4), 0.1))
    rows: list[str] = []
    answer = tessellation.ladder(small, 1, teller(rows))
    assert rows == list(tessellation.prices(small, 1))
    assert_whole(answer)
    chords = [share * small.ridge.height for share in (3e-2, 3e-3, 3e-4)]
    for model in (tessellation.MANIFOLD, tessellation.KERNEL):
        deviation, volume = errors(answer, model, "deviation"), errors(answer, model, "volume")
        # a tenth is the reference's own error, added to all
        assert all(d <= 1.1 * chord * (1 + 1e-9) for d, chord in zip(deviation, chords, strict=True))
        assert all(b < a for a, b in pairwise(volume))
        # a chord cuts off 2/3 of its height on average, so volume follows the chord; not at few chords an arc
        assert volume[-1] < volume[0] / 5


def small_ladders(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two meshes and few steps: what is asked of them here does not hang on how fine they are."""
    monkeypatch.setattr(
        contact,
        "LEVELS",
        {"linear": ((0.5, 2), (0.5, 3), (1.0, 4)), "finite-strain": ((0.5, 2), (0.5, 3), (0.5, 4))},
    )
    monkeypatch.setattr(contact, "MESH", 0.05)
    layers = Layers(0.6, 2.0, 3), Layers(0.3, 1.8, 3)
    monkeypatch.setattr(solid, "REFINEMENTS", (solid.SolidRefinement(0.5, 3, *layers, 1.0),))
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
        rows: list[str] = []
        answer = contact.ladder(plain, 1, teller(rows))
        assert rows == list(contact.prices(plain, 1))
        return answer


def test_the_contact_ladder_tries_every_model_of_the_table() -> None:
    assert sorted(contact.ORDER) == sorted(MODELS)


@pytest.mark.slow
def test_every_model_is_on_the_contact_ladder(pressed: Ladder) -> None:
    assert_whole(pressed)
    assert not pressed.skipped
    assert {trial.model for trial in pressed.trials} == {
        "winkler", "reduced", "linear", "finite-strain", "solid", "corrected", *contact.BEST[:2],
    }  # fmt: skip


@pytest.mark.slow
def test_higher_orders_cost_and_gain(pressed: Ladder) -> None:
    for model in ("linear", "finite-strain"):
        trials = [trial for trial in pressed.trials if trial.model == model]
        lower, higher = trials[:2]
        assert higher.unknowns > lower.unknowns
        assert higher.errors["mesh F9"] < lower.errors["mesh F9"]
        assert higher.errors["mesh approach"] < lower.errors["mesh approach"]


@pytest.mark.slow
def test_no_mesh_buys_what_a_model_leaves_out(pressed: Ladder) -> None:
    """The linear model's whole error is its model's: finer meshes leave it within a twentieth."""
    whole = errors(pressed, "linear", "whole approach")
    assert max(whole) < 1.05 * min(whole)
    for measure in ("whole F9", "whole approach"):
        assert errors(pressed, "corrected", measure)[0] < min(errors(pressed, "linear", measure))
        assert errors(pressed, "corrected", measure)[0] < errors(pressed, "winkler", measure)[0]


@pytest.mark.slow
def test_the_reference_is_named_with_its_own_error(pressed: Ladder) -> None:
    whole = next(measure for measure in pressed.measures if measure.name == "whole F9")
    assert whole.reference.startswith("solid-finite-strain")
    assert 0 < whole.floor < 0.05  # its stated error: the mesh that was asked
    assert not next(m for m in pressed.measures if m.name == "mesh F9").compares


@pytest.mark.slow
def test_what_cannot_judge_a_design_is_skipped_with_its_reason(
    plain: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_ladders(monkeypatch)
    curved = plain.with_(skin={"curvature_radius_y": 40.0})
    answer = contact.ladder(curved, 1, None)
    assert {trial.model for trial in answer.trials} == {"winkler", "solid", "solid-finite-strain"}
    assert set(answer.skipped) >= {"linear", "corrected", "finite-strain"}
    assert all("curvature_radius_y" in why for why in answer.skipped.values())


@pytest.fixture(scope="module")
def slipped(small: Design) -> Ladder:
    with pytest.MonkeyPatch.context() as patch:
        small_ladders(patch)
        rows: list[str] = []
        answer = slip.ladder(small, 1, teller(rows))
        assert rows == list(slip.prices(small, 1))
        return answer


def test_more_steps_find_the_signal(slipped: Ladder) -> None:
    assert_whole(slipped)
    signal = errors(slipped, "time step", "signal")
    assert signal[-1] < signal[0] / 3  # the step moves the slip's instant: first order, ten times the steps
    assert len([r for r in slipped.trials if r.model == "mesh"]) == 1


@pytest.mark.slow
def test_a_skin_without_slots_slips_by_its_travel(plain: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    small_ladders(monkeypatch)
    answer = slip.ladder(plain, 1, None)
    assert not answer.skipped
    assert "travel" in answer.measures[0].what


QUICK = ("film", "friction")


@pytest.mark.parametrize("named", [QUICK, pytest.param(tuple(EFFECTS), marks=pytest.mark.slow)])
def test_every_effect_is_tried_or_skipped_with_a_reason(
    named: tuple[str, ...], small: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    small_ladders(monkeypatch)
    monkeypatch.setattr(effects, "EFFECTS", {name: EFFECTS[name] for name in named})
    answer = effects.ladder(small, 1, None)
    names = {trial.model for trial in answer.trials}
    assert names | set(answer.skipped) == {*named, effects.LAW}
    assert {"friction", "film"} <= names
    left_out = {r.model: r.errors for r in answer.trials if r.setting.startswith("left out")}
    assert left_out["friction"]["signal"] > left_out["film"]["signal"] > 0
    named: list[Measurement] = [r for r in answer.trials if r.setting.startswith("named")]
    assert all(not trial.errors for trial in named)
    price = {trial.model: trial.runs for trial in named}  # a diagram shows what an error costs to be without
    assert all(trial.instead == price[trial.model] for trial in answer.trials if trial.errors)


def test_a_slip_ladders_reference_is_run_once_however_often_the_others_are(small: Design) -> None:
    once, thrice = (slip.prices(small, repeats) for repeats in (1, 3))
    assert all(seconds > 0 for seconds in once.values())
    references = {slip.stage_name(settings[-1][0]) for settings in slip.settings_by_model().values()}
    assert {stage for stage in once if thrice[stage] == once[stage]} >= references
