"""The coupon's sheet says what is drawn, and its forms are what reads them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.base import Stopwatch
from skincad.fabrication import BAR_FORM, PAD_FORM, coupon_forms, coupon_sheet, fit_bar_command
from skincad.fabrication.coupon import APPROACHES, EXTENSIONS, coupon
from skincad.inputs import PROCESSES
from skincad.material import finite_strain_curve, small_strain_curve
from skincad.solids import BAR


@pytest.mark.parametrize("process", PROCESSES)
def test_the_sheet_is_whole_for_every_process(process: str) -> None:
    kit = coupon(process)
    sheet = coupon_sheet(kit)
    assert "\n\n\n" not in sheet
    assert all(f"| {part.name} |" in sheet for part in kit.parts)
    assert all(f"fill in {name}" in sheet for name in coupon_forms(kit))
    assert ("cast a trial drop" in sheet) == (process == "sla")
    assert ("None: the tool of cnc cuts nothing narrower than 0.5 mm" in sheet) == (process == "cnc")
    assert "None}" not in sheet


def test_amounts_by_hand() -> None:
    """Dragon Skin 20: 1080 kg/m3, 1:1, and 8 g for the cup; volumes are test_coupon.py's."""
    kit = coupon("sla")
    density = kit.silicone.density * 1e-6
    total = sum(cut.volume for part in kit.parts for cut in part.cuts) * density + 8
    assert sum(kit.grams.values()) + 8 == pytest.approx(total)
    assert f"{total / 2:.2f} g of A and {total / 2:.2f} g of B" in coupon_sheet(kit)


def test_a_workshops_own_process_is_read_back_with_its_file() -> None:
    kit = coupon("my-resin", printer={"my-resin": {"based_on": "sla", "pixel": 0.03}})
    assert "skincad coupon my-resin --printer FILE --measured DIR" in coupon_sheet(kit)


def filled(name: str, values: np.ndarray) -> str:
    """A form with what was measured in its last, empty column."""
    head, *rows = (line for line in coupon_forms(coupon("sla"))[name].splitlines() if line[0] != "#")
    return "\n".join([head, *(row + f"{value:.4f}" for row, value in zip(rows, values, strict=True))])


def test_a_bars_form_gives_its_modulus(tmp_path: Path) -> None:
    stretch = 1 + np.array(EXTENSIONS) / BAR.gauge_length
    force = BAR.area * 0.4 / 3 * (stretch - stretch**-2)  # neo-Hooke's, Treloar
    (tmp_path / BAR_FORM).write_text(filled(BAR_FORM, force))
    fit = skincad.fit_material(tmp_path / BAR_FORM, gauge_length=BAR.gauge_length, area=BAR.area)
    assert fit.young_modulus.value == pytest.approx(0.4, rel=2e-3)  # forces have four decimals
    assert fit.laws  # strained enough to compare them
    assert fit_bar_command("x") == "skincad fit-material x --gauge-length 20 --area 8"


@pytest.mark.slow  # a finite-strain solve of the pad
def test_a_pads_form_gives_its_modulus(tmp_path: Path) -> None:
    """Forces of the same model at another modulus and first touch: the form's approaches are in its range."""
    pad, clock = coupon("sla").pad, Stopwatch()
    small = small_strain_curve(pad, 0.4, clock)
    far = float(small.force_at(np.array([APPROACHES[-1] + 0.1]))[0])
    curve = finite_strain_curve(small, pad, far, clock)
    force = curve.force_at(np.array(APPROACHES) - 0.03)
    (tmp_path / PAD_FORM).write_text(filled(PAD_FORM, force))
    fit = skincad.fit_material(tmp_path / PAD_FORM, pad)
    assert fit.young_modulus.value == pytest.approx(0.4, rel=5e-3)  # lines between the table's ratios
    assert fit.young_modulus.error is not None
    assert fit.young_modulus.error < 0.1 * 0.4
