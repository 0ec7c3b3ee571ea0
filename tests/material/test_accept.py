"""Good and faulty parts judged by a press; rows by models other than the judge's."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import skincad
from skincad.base import Array, InputError, Stopwatch
from skincad.inputs import PressCurve, press_curve
from skincad.inputs.material import silicone
from skincad.material import PressModel, accept, judge
from skincad.material.acceptance import KINDS, model_for
from skincad.mechanics import pad_of, plane_piece, press
from skincad.mechanics.models.linear import level

# plain-ridges at 0.8 MPa by `check --model corrected-finite-strain --set contact.friction=0.0`, within 1 %
FORCE = (0.0, 0.4, 0.8, 1.6, 2.4, 3.2, 4.0, 6.0, 8.0)
APPROACH = (0.0, 0.04735, 0.07451, 0.1169, 0.1539, 0.1848, 0.2143, 0.2843, 0.3510)
TEN = 0.8 * np.arange(1, 11)
FINE = (0.01, 0.002)  # N, mm
COARSE = (0.05, 0.02)


def rows(
    modulus: float = 0.8, more: Array | float = 0.0, errors: tuple[float, float] = FINE, seed: int = 1
) -> PressCurve:
    """Ten rows of a part, with `more` `(10,)` mm of approach."""
    rng = np.random.default_rng(seed)
    scale = modulus / 0.8
    force = TEN * min(1.0, scale)
    approach = PchipInterpolator(np.sqrt(FORCE), APPROACH)(np.sqrt(force / scale)) + more
    noise = errors[1] * (rng.standard_normal(10) + rng.standard_normal())
    return PressCurve("press.csv", approach + noise, force + errors[0] * rng.standard_normal(10), *errors)


@pytest.fixture(scope="module")
def model() -> PressModel:
    return model_for(skincad.load("plain-ridges"), rows(), Stopwatch(None))


def test_the_good_curve_is_that_of_another_model(model: PressModel) -> None:
    """Crests that scatter by 0.015 mm are touched earlier, alike at all forces; both err by 1 % besides."""
    more = np.interp(FORCE[1:], model.force, model.good) - APPROACH[1:]
    assert np.ptp(more) < 0.01 * APPROACH[-1]
    assert 0 < more.mean() < 0.015


@pytest.mark.parametrize("modulus", [0.7, 0.8, 0.9])
def test_a_good_part_is_in_where_faults_are_rare(model: PressModel, modulus: float) -> None:
    part = [(model, rows(modulus, errors=COARSE))]
    result = judge("plain-ridges", part, good_share=0.97)
    assert (result.verdict, result.passed, result.exit_status, result.cause) == ("in", True, 0, None)
    assert abs(result.young_modulus.value - modulus) <= result.young_modulus.error  # type: ignore[operator]
    open_ = judge("plain-ridges", part)
    assert (open_.verdict, open_.exit_status) == ("can't tell", 1)  # small faults may hide in it
    assert open_.in_from_share == pytest.approx(result.in_from_share)
    assert 0.5 < open_.in_from_share < 0.97


def test_a_part_is_in_from_its_share_on(model: PressModel) -> None:
    part = [(model, rows(errors=COARSE))]
    share = judge("plain-ridges", part).in_from_share
    assert judge("plain-ridges", part, good_share=share + 1e-6).verdict == "in"
    assert judge("plain-ridges", part, good_share=share - 1e-3).verdict == "can't tell"


@pytest.mark.parametrize("modulus", [0.4, 1.6])
def test_another_silicone_is_out(model: PressModel, modulus: float) -> None:
    result = judge("plain-ridges", [(model, rows(modulus))], ruled_out=("back",))
    assert (result.verdict, result.cause, result.alone, result.exit_status) == ("out", "modulus", True, 1)
    size = result.causes[0].size
    assert abs(size.value - modulus) <= size.error  # type: ignore[operator]
    assert size.error <= 0.12 * modulus  # type: ignore[operator]
    assert result.measures_modulus


def test_a_softer_silicone_may_be_a_soft_back(model: PressModel) -> None:
    result = judge("plain-ridges", [(model, rows(0.4, errors=COARSE))])
    assert (result.verdict, result.alone) == ("out", False)
    assert {row.cause for row in result.causes[:2]} == {"modulus", "back"}


def test_a_soft_back_is_out_and_not_the_silicone(model: PressModel) -> None:
    more = 0.04  # mm/N
    result = judge("plain-ridges", [(model, rows(more=more * TEN))])
    assert (result.verdict, result.cause) == ("out", "back")
    size = result.causes[0].size
    assert abs(size.value - more) <= size.error  # type: ignore[operator]
    assert not result.measures_modulus
    silent = judge("plain-ridges", [(model, rows(more=more * TEN))], ruled_out=("back",))
    assert "back" not in {row.cause for row in silent.causes}


def test_ridges_that_did_not_fill_are_found(model: PressModel) -> None:
    """Two whole ones of a batch whose modulus is known; which ones is beyond the model's own error.

    The rows are by a finer mesh than the judge's.
    """
    pad = pad_of(skincad.load("plain-ridges"))
    solution = level(plane_piece(pad, 0.7, whole=True), 3, 4.0)
    ridges = solution.ridges.lowered(0.5 * (np.eye(9)[3] + np.eye(9)[5]) / solution.unit)
    lacking, whole = (
        [press(r.flexibility, r.gap, f / solution.scale).approach * solution.unit for f in TEN]
        for r in (ridges, solution.ridges)
    )
    part = rows(more=np.subtract(lacking, whole), errors=(0.01, 0.001))
    others = [kind for kind in KINDS if kind != "ridge"]
    crests = replace(model, crests=0.1 * model.crests, modulus_range=(0.78, 0.82))
    result = judge("plain-ridges", [(crests, part)], others)
    assert (result.verdict, result.cause) == ("out", "ridge")
    usual = judge("plain-ridges", [(crests, rows(errors=(0.01, 0.001)))], others)
    assert usual.verdict != "out"


def test_a_curve_like_no_part_has_no_cause(model: PressModel) -> None:
    wavy = 0.05 * np.sin(3 * TEN)
    result = judge("plain-ridges", [(model, rows(more=wavy))])
    assert (result.verdict, result.cause, result.alone) == ("out", None, False)


def test_probabilities_sum_to_one(model: PressModel) -> None:
    result = judge("plain-ridges", [(model, rows(errors=COARSE))])
    total = result.good_probability + math.fsum(row.probability for row in result.causes)
    assert total == pytest.approx(1.0, abs=1e-9)
    assert {row.cause for row in result.causes} == {*KINDS}


def test_a_second_curve_is_judged_with_the_first(model: PressModel) -> None:
    """Two presses of a part tell more than one: the modulus has a smaller error."""
    one = judge("plain-ridges", [(model, rows(errors=COARSE))])
    two = judge("plain-ridges", [(model, rows(errors=COARSE)), (model, rows(errors=COARSE, seed=2))])
    assert two.young_modulus.error < one.young_modulus.error  # type: ignore[operator]
    assert two.rows_used == 2 * one.rows_used


def written(folder: Path, approach: Array, force: Array, header: str = "approach_mm,force_N") -> Path:
    lines = [f"{a:.5f},{f:.4f}" for a, f in zip(approach, force, strict=True)]
    (folder / "press.csv").write_text("\n".join([header, *lines]))
    return folder / "press.csv"


def test_an_approach_that_noise_turns_back_is_read(tmp_path: Path) -> None:
    part = rows(errors=COARSE, seed=4)
    assert (np.diff(part.approach) < 0).any()
    curve = press_curve(written(tmp_path, part.approach, part.force), *COARSE)
    assert curve.approach == pytest.approx(part.approach, abs=1e-5)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda a, f: (a[:3], f[:3]), "must have at least 5 rows"),
        (lambda a, f: (a, f[::-1]), "force_N must not fall, got"),
        (lambda a, f: (a[::-1], f), "approach_mm must not fall, got"),
        (lambda a, f: (a, f / 9.81e-3), "must be in mm and N: .* are forces in g"),
        (lambda a, f: (1000 * a, f), "must be in mm and N: .* are approaches in um"),
        (lambda a, f: (a + 1.0, f), "must count from the first touch, .*; subtract"),
        (lambda a, f: (2 * a, 6 * f), "the model ends at 18.5 N: .*, got 48"),
    ],
)
def test_rows_that_cannot_be_meant_are_refused(tmp_path: Path, change: object, words: str) -> None:
    file = written(tmp_path, *change(np.interp(TEN, FORCE, APPROACH), TEN))  # type: ignore[operator]
    with pytest.raises(InputError, match=rf"^.*press\.csv.*{words}"):
        accept(skincad.load("plain-ridges"), file)


@pytest.mark.parametrize(
    ("design", "options", "words"),
    [
        ("flat-magnet", {}, "^design: must be ridges or rings"),
        ("pins-dome", {}, "^design: must be ridges or rings"),
        ("plain-ridges", {"ruled_out": ["ridges"]}, "^ruled_out: unknown cause, got 'ridges'; did you mean"),
        ("plain-ridges", {"ruled_out": [*KINDS]}, "^ruled_out: must leave a cause"),
        ("plain-ridges", {"good_share": 1.0}, "^good_share: must be above 0 and below 1, got 1"),
        ("plain-ridges", {"force_error": 0.0}, "^force_error: must be above 0 N"),
    ],
)
def test_what_it_cannot_judge_is_refused(
    tmp_path: Path, design: str, options: dict[str, object], words: str
) -> None:
    file = written(tmp_path, np.interp(TEN, FORCE, APPROACH), TEN)
    with pytest.raises(InputError, match=words):
        accept(skincad.load(design), file, **options)  # type: ignore[arg-type]


@pytest.mark.slow
def test_rings_are_judged_too() -> None:
    """Approaches by `check rings-5 --model finite-strain --tol 0.02 --set contact.friction=0.0`."""
    design = skincad.load("rings-5", ["contact.friction=0.0"])
    forces = 0.5 * np.arange(1, 7)
    approach = np.array([0.09231, 0.12583, 0.15605, 0.17482, 0.19180, 0.20792])
    result = accept(design, PressCurve("press.csv", approach, forces, *FINE), good_share=0.9)
    assert result.verdict != "out"
    assert "friction" not in {row.cause for row in result.causes}  # the coefficient is known
    assert abs(result.young_modulus.value - 0.46) <= result.young_modulus.error  # type: ignore[operator]


def test_a_layered_part_is_judged_as_a_whole(tmp_path: Path) -> None:
    """Layers of the skin's own silicone change nothing but a note."""
    path, plain = tmp_path / "press.csv", skincad.load("plain-ridges")
    stuff = silicone(plain)
    own = {
        "thickness": 2.0, "young_modulus": stuff.young_modulus.value, "poisson_ratio": stuff.poisson_ratio
    }  # fmt: skip
    rows = (f"{0.04 * i:.2f},{0.3 * i:.1f}" for i in range(1, 11))
    path.write_text("\n".join(["approach_mm,force_N", *rows, ""]))
    one, two = (skincad.accept(design, path) for design in (plain, plain.with_(shot=(own,))))
    assert two.verdict == one.verdict
    assert float(two.young_modulus) == pytest.approx(
        float(one.young_modulus), rel=1e-2
    )  # another mesh, two of them
    assert any("all layers alike" in note for note in two.warnings)
    assert not any("all layers alike" in note for note in one.warnings)
