"""The templates with ridges for tests of seconds: those that are another size of a kind of mold are slow."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

import skincad
from skincad.inputs import Design, template_names
from tests.families import RIDGED

# as yamada-2002, by edm; lab-bench and home-printer as plain-ridges, by sla
OTHER_SIZES = {"home-printer", "fingertip-soft", "gripper-pad", "steep-fingertip", "lab-bench"}
MANY_PINS = {"nibs-fine", "pins-dome"}  # whose solids take seconds
KINDS = [pytest.param(name, marks=[pytest.mark.slow] if name in OTHER_SIZES else []) for name in RIDGED]
SHIPPED = [
    pytest.param(name, marks=[pytest.mark.slow] if name in OTHER_SIZES | MANY_PINS else [])
    for name in template_names()
]

# combs by the machine that prints the rest, which does not hold their notches
ONE_PRINTER = {
    "lab-bench": ["mold.end_plate_process=sla", "mold.slit_clearance=0.028"],
    "nozzle-04": ["mold.end_plate_process=fdm", "mold.slit_clearance=0.1"],
}


def of_one_printer(name: str, settings: Sequence[str] = ()) -> Design:
    """A template whose combs come from the machine that prints the rest."""
    given = {setting.partition("=")[0] for setting in settings}
    kept = [one for one in ONE_PRINTER.get(name, ()) if one.partition("=")[0] not in given]
    return skincad.load_design(name, [*kept, *settings])
