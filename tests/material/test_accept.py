"""Good and faulty parts judged by a press, rows by models other than the judge's; `skincad accept`."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

import skincad
from skincad.base import Array, InputError, Stopwatch
from skincad.inputs import Design, PressCurve, press_curve
from skincad.material import PadCurve, PressModel, accept, acceptance, judge, small_strain_curve
from skincad.material.acceptance import model_for, usable
from skincad.mechanics import level, pad_of, plane_piece, press
from skincad.mechanics.models import reduced
from skincad.outputs import ACCEPTANCE
from tests.conftest import run_skincad
from tests.refusals import refused, refused_by, refused_command

FINE, COARSE = (0.01, 0.002), (0.05, 0.02)  # N, mm
CAUSES = ("modulus", "crests", "ridge", "back", "friction")
RULED_OUT = tuple(word for cause in ("back", "crests", "ridge") for word in ("--ruled-out", cause))  # tilt
THREE = ["ridge.count=3", "skin.width=5.0"]


@dataclass(frozen=True)
class Press:
    """Plain ridges of 0.8 MPa, N and mm, by `check --model corrected-finite-strain --set
    contact.friction=0.0`, within 1 %."""

    settings: tuple[str, ...]
    force: tuple[float, ...]
    approach: tuple[float, ...]

    @property
    def design(self) -> Design:
        return skincad.load("plain-ridges", self.settings)

    @property
    def ten(self) -> Array:
        """Ten forces up to the largest, N."""
        return self.force[-1] / 10 * np.arange(1, 11)

    def rows(
        self,
        modulus: float = 0.8,
        more: Array | float = 0.0,
        errors: tuple[float, float] = FINE,
        seed: int = 1,
    ) -> PressCurve:
        """Ten rows of a part, with `more` `(10,)` mm of approach."""
        rng = np.random.default_rng(seed)
        scale = modulus / 0.8
        force = self.ten * min(1.0, scale)
        approach = PchipInterpolator(np.sqrt(self.force), self.approach)(np.sqrt(force / scale)) + more
        noise = errors[1] * (rng.standard_normal(10) + rng.standard_normal())
        return PressCurve("press.csv", approach + noise, force + errors[0] * rng.standard_normal(10), *errors)

    def write(self, folder: Path, change: Any = lambda a, f: (a, f), head: str = "approach_mm,force_N"):
        """The rows without noise as a file."""
        approach, force = change(np.interp(self.ten, self.force, self.approach), self.ten)
        lines = [f"{a:.5f},{f:.4f}" for a, f in zip(approach, force, strict=True)]
        (folder / "press.csv").write_text("\n".join([head, *lines]))
        return folder / "press.csv"


SMALL = Press(
    tuple(THREE),
    (0.0, 0.15, 0.3, 0.6, 0.9, 1.2, 1.6, 2.0, 2.6),
    (0.0, 0.02619, 0.04491, 0.07997, 0.11314, 0.14559, 0.18748, 0.22807, 0.28704),
)
WHOLE = Press(
    (),
    (0.0, 0.4, 0.8, 1.6, 2.4, 3.2, 4.0, 6.0, 8.0),
    (0.0, 0.04735, 0.07451, 0.1169, 0.1539, 0.1848, 0.2143, 0.2843, 0.3510),
)


PRESSED = pytest.mark.evidence(subject="plain-ridges pressed")


@cache
def model_of(part: Press) -> PressModel:
    return model_for(part.design, part.rows(), Stopwatch(None))[1]


@pytest.fixture(
    params=[
        pytest.param(SMALL, marks=pytest.mark.slow),
        pytest.param(WHOLE, marks=PRESSED),
    ],
    ids=["three ridges", "nine ridges"],
)
def part(request: pytest.FixtureRequest) -> Press:
    return request.param


@pytest.fixture
def model(part: Press) -> PressModel:
    return model_of(part)


def test_the_good_curve_is_that_of_another_model(part: Press, model: PressModel) -> None:
    """Crests that scatter by 0.015 mm are touched earlier, alike at all forces; both err by 1 % besides."""
    more = np.interp(part.force[1:], model.force, model.good) - part.approach[1:]
    assert np.ptp(more) < 0.01 * part.approach[-1]
    assert 0 < more.mean() < 0.015


@pytest.mark.parametrize("modulus", [0.7, 0.8, 0.9])
def test_a_good_part_is_in_where_faults_are_rare(part: Press, model: PressModel, modulus: float) -> None:
    presses = [(model, part.rows(modulus, errors=COARSE))]
    result = judge("plain-ridges", presses, good_share=0.97)
    assert (result.verdict, result.passed, result.exit_status, result.cause) == ("in", True, 0, None)
    assert abs(result.young_modulus.value - modulus) <= result.young_modulus.error
    open_ = judge("plain-ridges", presses)
    assert (open_.verdict, open_.exit_status) == ("can't tell", 1)  # small faults may hide in it
    share = open_.in_from_share
    assert share == pytest.approx(result.in_from_share)
    assert 0.5 < share < 0.97
    assert judge("plain-ridges", presses, good_share=share + 1e-6).verdict == "in"
    assert judge("plain-ridges", presses, good_share=share - 1e-3).verdict == "can't tell"
    total = open_.good_probability + math.fsum(row.probability for row in open_.causes)
    assert total == pytest.approx(1.0, abs=1e-9)
    assert {row.cause for row in open_.causes} == {*CAUSES}


@pytest.mark.parametrize("modulus", [0.4, 1.6])
def test_another_silicone_is_out(part: Press, model: PressModel, modulus: float) -> None:
    ruled_out = ("back",) if part == WHOLE else RULED_OUT[1::2]
    result = judge("plain-ridges", [(model, part.rows(modulus))], ruled_out)
    assert (result.verdict, result.cause, result.alone, result.exit_status) == ("out", "modulus", True, 1)
    size = result.causes[0].size
    assert abs(size.value - modulus) <= size.error
    assert size.error <= 0.12 * modulus
    assert result.measures_modulus


@PRESSED
def test_a_softer_silicone_may_be_a_soft_back() -> None:
    result = judge("plain-ridges", [(model_of(WHOLE), WHOLE.rows(0.4, errors=COARSE))])
    assert (result.verdict, result.alone) == ("out", False)
    assert {row.cause for row in result.causes[:2]} == {"modulus", "back"}


def test_a_soft_back_is_out_and_not_the_silicone(part: Press, model: PressModel) -> None:
    more = 0.32 / part.ten[-1]  # mm/N
    soft = [(model, part.rows(more=more * part.ten))]
    result = judge("plain-ridges", soft)
    assert (result.verdict, result.cause) == ("out", "back")
    size = result.causes[0].size
    assert abs(size.value - more) <= size.error
    assert not result.measures_modulus
    silent = judge("plain-ridges", soft, ruled_out=("back",))
    assert "back" not in {row.cause for row in silent.causes}


@PRESSED
def test_ridges_that_did_not_fill_are_found() -> None:
    """Two whole ones of a batch whose modulus is known; which ones is beyond the model's own error.

    The rows are by a finer mesh than the judge's.
    """
    solution = level(plane_piece(pad_of(WHOLE.design), 0.7, whole=True), 3, 4.0)
    ridges = solution.ridges.lowered(0.5 * (np.eye(9)[3] + np.eye(9)[5]) / solution.unit)
    lacking, whole = (
        [press(r.flexibility, r.gap, f / solution.scale).approach * solution.unit for f in WHOLE.ten]
        for r in (ridges, solution.ridges)
    )
    rows = WHOLE.rows(more=np.subtract(lacking, whole), errors=(0.01, 0.001))
    others = [kind for kind in CAUSES if kind != "ridge"]
    crests = replace(model_of(WHOLE), crests=0.1 * model_of(WHOLE).crests, modulus_range=(0.78, 0.82))
    result = judge("plain-ridges", [(crests, rows)], others)
    assert (result.verdict, result.cause) == ("out", "ridge")
    usual = judge("plain-ridges", [(crests, WHOLE.rows(errors=(0.01, 0.001)))], others)
    assert usual.verdict != "out"


def test_a_curve_like_no_part_has_no_cause(part: Press, model: PressModel) -> None:
    wavy = part.rows(more=0.05 * np.sin(2.4 * np.arange(1, 11)))
    result = judge("plain-ridges", [(model, wavy)])
    assert (result.verdict, result.cause, result.alone) == ("out", None, False)


def test_a_second_curve_is_judged_with_the_first(part: Press, model: PressModel) -> None:
    """Two presses of a part tell more than one: the modulus has a smaller error."""
    first, second = (part.rows(errors=COARSE, seed=seed) for seed in (1, 2))
    one, two = (
        judge("plain-ridges", [(model, first)]),
        judge("plain-ridges", [(model, first), (model, second)]),
    )
    assert two.young_modulus.error < one.young_modulus.error
    assert two.rows_used == 2 * one.rows_used


def test_an_approach_that_noise_turns_back_is_read(tmp_path: Path) -> None:
    noisy = WHOLE.rows(errors=COARSE, seed=4)
    assert (np.diff(noisy.approach) < 0).any()
    file = WHOLE.write(tmp_path, lambda *_: (noisy.approach, noisy.force))
    assert press_curve(file, *COARSE).approach == pytest.approx(noisy.approach, abs=1e-5)


@cache
def small_curve(design: Design, modulus: float) -> PadCurve:
    return small_strain_curve(design, modulus, Stopwatch())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda a, f: (a[:3], f[:3]), "press.csv: must have at least 5 rows"),
        (lambda a, f: (a, f[::-1]), "press.csv, row 10: force_N must not fall, got 0.26"),
        (lambda a, f: (a[::-1], f), "press.csv, row 6: approach_mm must not fall, got"),
        (lambda a, f: (a, f / 9.81e-3), "are forces in g"),
        (lambda a, f: (1000 * a, f), "are approaches in um"),
        (lambda a, f: (a + 1.0, f), "must count from the first touch, which is at about 1"),
        (lambda a, f: (2 * a, 6 * f), "the model ends at"),
        (lambda a, f: (a, 0 * f + 1.0), "force_N must grow from row to row, got 1"),
        (lambda a, f: (0 * a + 1.0, f), "approach_mm must grow from row to row, got 1"),
    ],
)
def test_rows_that_cannot_be_meant_are_refused(
    tmp_path: Path, change: Any, words: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # of one design it is pressed once
    monkeypatch.setattr(acceptance, "small_strain_curve", lambda d, modulus, _: small_curve(d, modulus))
    with refused(words):
        accept(SMALL.design, SMALL.write(tmp_path, change))


MISTAKES = ("none", "tare", "full scale", "position", "unit")
UNITS_OF_FORCE = {"g": 9.80665e-3, "kg": 9.80665, "mN": 1e-3}
UNITS_OF_LENGTH = {"um": 1e-3, "cm": 10.0, "inch": 25.4}


@pytest.mark.parametrize("seed", range(40))
def test_a_press_with_a_zero_a_plateau_or_another_unit_is_told(seed: int, tmp_path: Path) -> None:
    """A dense press of a good part, with rows before the touch, as a test machine writes it: what is wrong
    with it is subtracted, left out or refused, and what is left is the press without it."""
    dice, mistake = np.random.default_rng(seed), MISTAKES[seed % 5]
    errors = (float(dice.choice([0.005, 0.02])), 0.002)
    travel = np.linspace(-float(dice.uniform(0.05, 0.2)), 0.28, int(dice.integers(80, 300)))
    modulus = float(dice.uniform(0.7, 0.9))
    true = modulus / 0.8 * small_curve(SMALL.design, 0.8).force_at(travel)  # without friction it scales
    force = true + errors[0] * dice.standard_normal(travel.size)
    approach = travel + 0.0
    if mistake == "tare":
        force = force + float(dice.uniform(0.1, 0.6)) * float(dice.choice([-1.0, 1.0]))
    if mistake == "full scale":
        force = np.minimum(force, float(dice.uniform(0.4, 0.8)) * true.max())
    if mistake == "position":
        approach = approach + float(dice.uniform(2.0, 50.0))
    unit = ""
    if mistake == "unit":
        unit = str(dice.choice([*UNITS_OF_FORCE, *UNITS_OF_LENGTH]))
        force, approach = force / UNITS_OF_FORCE.get(unit, 1.0), approach / UNITS_OF_LENGTH.get(unit, 1.0)
    path = tmp_path / "press.csv"
    rows = "".join(f"{a:.7g},{f:.7g}\n" for a, f in zip(approach, force, strict=True))
    path.write_text(f"approach_mm,force_N\n{rows}")
    scale = (errors[0] / UNITS_OF_FORCE.get(unit, 1.0), errors[1] / UNITS_OF_LENGTH.get(unit, 1.0))
    if mistake in ("position", "unit"):
        with refused("must count from the first touch" if mistake == "position" else f"in {unit}?"):
            usable(press_curve(path, *scale), small_curve(SMALL.design, 0.8))
        return
    press = usable(press_curve(path, *scale), small_curve(SMALL.design, 0.8))
    told = " ".join(press.notes)
    assert ("before the plate touched: this is subtracted" in told) == (mistake == "tare")
    assert ("the force stays at" in told) == (mistake == "full scale")
    kept = press.force.size
    assert kept == travel.size or (mistake == "full scale" and kept > travel.size // 3)
    assert np.abs(press.force - true[:kept]).max() < 6 * errors[0]


@pytest.mark.parametrize(
    ("design", "options", "words"),
    [
        ("plain-ridges", {"ruled_out": ["ridges"]}, "ruled_out: unknown cause, got 'ridges'; did you mean"),
        ("plain-ridges", {"ruled_out": [*CAUSES]}, "ruled_out: must leave a cause"),
        ("plain-ridges", {"good_share": 1.0}, "good_share: must be above 0 and below 1, got 1"),
        ("plain-ridges", {"force_error": 0.0}, "force_error: must be above 0 N"),
    ],
)
def test_what_it_cannot_judge_is_refused(
    tmp_path: Path, design: str, options: dict[str, Any], words: str
) -> None:
    with refused_by(words):
        accept(skincad.load(design), WHOLE.write(tmp_path), **options)


@pytest.mark.parametrize(
    ("design", "settings", "words"),
    [
        (
            "plain-ridges",
            "skin.curvature_radius_y=60",
            "skin.curvature_radius_y: must not be given to accept",
        ),
        ("plain-ridges", "contact.plate.shape=cylinder", "contact.plate.shape: must be flat or tilted"),
        ("pillars-9", "contact.plate.shape=tilted", "contact.plate.shape: must be flat for pins"),
        ("pillars-9", "contact.plate.shape=cylinder", "contact.plate.shape: must be flat for pins"),
    ],
)
def test_skins_and_plates_without_curves_are_refused(design: str, settings: str, words: str) -> None:
    size = {"cylinder": ["contact.plate.radius=50"], "tilted": ["contact.plate.tilt=1"]}
    more = size.get(settings.rpartition("=")[2], [])
    with refused_by(words):
        accept(skincad.load(design, [settings, *more]), WHOLE.rows())


APPROACHES = (0.0, 0.11089, 0.17347, 0.26749, 0.34538, 0.41262, 0.47098, 0.52717, 0.583, 0.72904, 0.94618)


def rows_of(force: Array, approach: Array, seed: int = 1) -> PressCurve:
    """A press read finely."""
    rng = np.random.default_rng(seed)
    gone = approach + FINE[1] * (rng.standard_normal(force.size) + rng.standard_normal())
    return PressCurve("press.csv", gone, force + FINE[0] * rng.standard_normal(force.size), *FINE)


PINS = "pillars-9", ("contact.friction=0.0",)
PULLED = np.linspace(0.15, 1.5, 10)  # N


@cache
def pins_pressed(modulus: float, drops: tuple[float, ...]) -> Array:
    """Approaches of pins of a modulus, MPa, with crests that scatter and lie lower: by Newton's method on all
    pins in the place of the judge's tables."""
    scatter = 0.015 * np.random.default_rng(4).standard_normal(9)
    model = reduced.pin_model(skincad.load(*PINS)).lowered(tuple((scatter + np.array(drops)).tolist()))
    return np.array([reduced.pressed(model, force * 0.46 / modulus)[1] for force in PULLED])


@cache
def pins_model() -> PressModel:
    good = rows_of(PULLED, pins_pressed(0.46, (0.0,) * 9))
    return model_for(skincad.load(*PINS), good, Stopwatch(None))[1]


@pytest.mark.evidence(subject="pillars-9 pressed")
@pytest.mark.parametrize(
    ("modulus", "drops", "back", "verdict", "cause"),
    [
        (0.46, (0.0,) * 9, 0.0, "in", None),
        (0.16, (0.0,) * 9, 0.0, "out", "modulus"),
        (1.2, (0.0,) * 9, 0.0, "out", "modulus"),
        (0.46, (0.0,) * 4 + (4.7,) + (0.0,) * 4, 0.0, "out", "ridge"),
        (0.46, (-1.0,) * 3 + (0.0,) * 3 + (1.0,) * 3, 0.0, "out", "crests"),
        (0.46, (0.0,) * 9, 0.5, "out", "back"),
    ],
)
def test_pins_are_judged_too(
    modulus: float, drops: tuple[float, ...], back: float, verdict: str, cause: str | None
) -> None:
    press = rows_of(PULLED, pins_pressed(modulus, drops) + back * PULLED)
    result = judge("pillars-9", [(pins_model(), press)], ("friction",), 0.97 if verdict == "in" else 0.5)
    assert result.verdict == verdict
    # what is too soft may be silicone or back, as of ridges
    assert cause in {row.cause for row in result.causes[: 2 if back or modulus < 0.3 else 1]} | {result.cause}
    assert result.family == "pin"
    words = " ".join(ACCEPTANCE.lines(result))
    assert "ridge" not in words
    if cause == "ridge":
        assert result.causes[0].place == "5"
        assert "a pin that did not fill (perhaps 5)" in words
    if result.cause == "modulus":
        assert abs(result.causes[0].size.value - modulus) <= (result.causes[0].size.error or 0.0)


def test_of_very_many_pins_no_press_is_read() -> None:
    many = {"skin": {"width": 38.0, "length": 38.0}}
    press = PressCurve("press.csv", 0.01 * np.arange(10.0), 0.5 * np.arange(10.0), *FINE)
    with pytest.raises(InputError, match=r"^pin: must be at most 1000 to read a press, got 1033; press a"):
        accept(skincad.load("nibs-fine").with_(**many), press)


def test_a_press_of_very_many_rows_is_thinned_by_who_took_it(tmp_path: Path) -> None:
    rows = "\n".join(f"{i / 1e4},{i / 1e3}" for i in range(10001))
    (tmp_path / "press.csv").write_text(f"approach_mm,force_N\n{rows}\n")
    with pytest.raises(InputError, match=r"must have at most 5000 rows, got 10001; keep one in 3"):
        accept(skincad.load("flat-magnet"), tmp_path / "press.csv")


@pytest.mark.slow
def test_rows_beyond_finite_strain_are_refused() -> None:
    """Small strain goes on to 20 N there; finite strain was solved up to 8 N."""
    force = np.linspace(1.0, 12.0, 10)
    press = PressCurve("press.csv", 0.33 * np.sqrt(force), force, *FINE)
    with pytest.raises(InputError, match=r"force_N: the model ends at .* N: beyond, finite strain is not"):
        accept(skincad.load("flat-magnet"), press)


@pytest.mark.evidence(subject="flat-magnet pressed")
def test_a_face_is_judged_too() -> None:
    """Approaches by `check flat-magnet --model corrected-finite-strain --set contact.friction=0.0`."""
    design = skincad.load("flat-magnet", ["contact.friction=0.0"])
    forces = np.array([0.0, 0.3, 0.6, 1.2, 1.8, 2.4, 3.0, 3.6, 4.2, 6.0, 9.0])
    known = np.array(APPROACHES)
    rows = np.linspace(0.4, 4.0, 10)

    def pressed(modulus: float, back: float = 0.0) -> PressCurve:
        scaled = np.sqrt(rows * 0.07 / modulus)
        return rows_of(rows, np.interp(scaled, np.sqrt(forces), known) + back * rows)

    model = model_for(design, pressed(0.07), Stopwatch(None))[1]
    good = judge(design.name, [(model, pressed(0.07))], ("friction",), 0.97)
    assert (good.verdict, good.cause, good.family) == ("in", None, "flat")
    assert abs(good.young_modulus.value - 0.07) <= good.young_modulus.error
    stiff = judge(design.name, [(model, pressed(0.2))], ("friction",))
    assert (stiff.verdict, stiff.cause) == ("out", "modulus")
    soft_back = judge(design.name, [(model, pressed(0.07, 0.2))], ("friction",))
    assert (soft_back.verdict, soft_back.cause) == ("out", "back")
    for result in (good, stiff, soft_back):  # nothing of a face can be missing
        assert {row.cause for row in result.causes} == {"modulus", "crests", "back"}
        assert "the face bends or tilts from side to side" in {row.words for row in result.causes}
    assert "all crests" not in " ".join(good.warnings)


@pytest.mark.evidence(subject="rings-5")
def test_rings_are_judged_too() -> None:
    """Approaches by `check rings-5 --model finite-strain --tol 0.02 --set contact.friction=0.0`."""
    design = skincad.load("rings-5", ["contact.friction=0.0"])
    forces = 0.5 * np.arange(1, 7)
    approach = np.array([0.09231, 0.12583, 0.15605, 0.17482, 0.19180, 0.20792])
    result = accept(design, PressCurve("press.csv", approach, forces, *FINE), good_share=0.9)
    assert result.verdict != "out"
    assert "friction" not in {row.cause for row in result.causes}  # the coefficient is known
    assert abs(result.young_modulus.value - 0.46) <= result.young_modulus.error


@pytest.mark.evidence(subject="layers pressed")
def test_a_layered_part_is_judged_as_a_whole() -> None:
    """Layers of the skin's own silicone change nothing but a note."""
    plain = SMALL.design.with_(contact={"friction": 0.0})
    silicone = {"thickness": 2.0, "young_modulus": 0.8, "poisson_ratio": 0.499}
    one, two = (accept(design, SMALL.rows()) for design in (plain, plain.with_(shot=(silicone,))))
    assert two.verdict == one.verdict
    # another mesh, two of them
    assert float(two.young_modulus) == pytest.approx(float(one.young_modulus), rel=1e-2)
    assert any("all layers alike" in note for note in two.warnings)
    assert not any("all layers alike" in note for note in one.warnings)


JSON_KEYS = {
    *("name", "passed", "verdict", "good_probability", "good_share", "in_from_share", "cause", "cause_alone"),
    *("causes", "young_modulus_MPa", "modulus_range_MPa", "zero_mm", "good_misfit", "rows", "rows_used"),
    *("largest_force_N", "force_error_N", "approach_error_mm", "seconds", "warnings", "file"),
}
UPDATE = ("accept", "press.csv", "plain-ridges", "--update", "mine.toml")
SET = tuple(text for setting in (*THREE, "contact.force=1.5") for text in ("--set", setting))


@pytest.mark.slow
def test_a_soft_part_updates_the_design(tmp_path: Path) -> None:
    """A part of half the modulus."""
    SMALL.write(tmp_path, lambda a, f: (a, f / 2))
    done = run_skincad(*UPDATE, *SET, *RULED_OUT, "--json", cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    result = json.loads(done.stdout)
    assert result.keys() == JSON_KEYS
    assert (result["verdict"], result["cause"], result["file"]) == ("out", "modulus", "mine.toml")
    assert result["causes"][0].keys() >= {"cause", "probability", "size", "unit", "misfit", "place"}
    design = skincad.load(tmp_path / "mine.toml")
    modulus = design.material.young_modulus
    assert modulus.low < 0.4 < modulus.high
    assert "# measured: press press.csv" in (tmp_path / "mine.toml").read_text()
    assert design.contact.force == 1.5
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mine.toml", "press.csv"]


@PRESSED
def test_a_part_is_in_by_the_silicone_that_it_measured(tmp_path: Path) -> None:
    WHOLE.write(tmp_path, lambda a, f: (a, f / 2))
    run_skincad(*UPDATE, "--ruled-out", "back", cwd=tmp_path)
    done = run_skincad("accept", "press.csv", "mine.toml", "--good-share", "0.97", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("IN: the curve is a good part's, by 9")


@PRESSED
def test_a_modulus_that_is_not_the_silicones_is_not_written(tmp_path: Path) -> None:
    SMALL.write(tmp_path, lambda a, f: (a + 0.18 * f, f))  # on a soft back
    fine = ("--force-error", "0.01", "--approach-error", "0.002")
    done = run_skincad(*UPDATE, *SET, *fine, cwd=tmp_path)
    assert (done.returncode, done.stderr) == (1, "")
    assert done.stdout.startswith("OUT: the curve is no good part's. A soft back of 0.")
    assert "not written    mine.toml: another cause" in done.stdout
    assert [p.name for p in tmp_path.iterdir()] == ["press.csv"]


def test_bad_input_is_one_line_and_nothing_is_written(tmp_path: Path) -> None:
    WHOLE.write(tmp_path, head="approach_furlong,force_N")
    assert refused_command(*UPDATE, cwd=tmp_path).startswith(
        "press.csv: must have the columns approach_mm and"
    )
    WHOLE.write(tmp_path)
    (tmp_path / "mine.toml").write_text("")
    assert refused_command(*UPDATE, cwd=tmp_path).startswith("--update: ")


@pytest.mark.slow
def test_a_recording_is_judged_by_another_command(tmp_path: Path) -> None:
    said = refused_command("accept", "--recording", "film.csv", "scene.toml", cwd=tmp_path)
    assert said.startswith("--recording: ")
    assert said.endswith("`skincad listen --taps DESIGN --csv FILE`")
