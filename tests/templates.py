"""Templates as parameters of tests: a small one of each kind is fast, the others are evidence."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

import skincad
from skincad.inputs import Design, template_names
from tests.families import RIDGED

# The small one of each family and of each way to cast; all others are evidence, a subject each.
FAST = {"yamada-2002", "plain-ridges", "cast-in", "pillars-9", "rings-5", "flat-magnet"}


def template(name: str, *values: Any, tier: str = "fast") -> Any:
    """Return a test's parameter, of this tier, or evidence where a small template shows as much."""
    mark = pytest.mark.evidence(subject=name)
    marks = [mark] if name not in FAST else [pytest.mark.slow] if tier == "slow" else []
    return pytest.param(name, *values, marks=marks)


KINDS = [template(name) for name in RIDGED]
SHIPPED = [template(name) for name in template_names()]

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
