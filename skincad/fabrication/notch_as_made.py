"""How wide a comb's notch comes out, and whether its shim or strip still goes in."""

from __future__ import annotations

import math
from collections.abc import Iterator

from skincad.fabrication.finding import Finding
from skincad.fabrication.rules import Case, Rule, grooves
from skincad.inputs.process import Process
from skincad.solids.roles import PartRole

_ROUNDING = 1e-9  # mm
_STEP = 0.001  # mm; a clearance is proposed in whole micrometres
MOST_CLEARANCE = 0.5  # mm, that mold.slit_clearance takes


def notch_as_made(width: float, process: Process) -> float:
    """Return how wide a notch drawn `width` mm wide comes out, mm; 0 where it grows shut.

    Both of its sides come nearer by the process's growth.
    """
    return max(0.0, width - 2 * process.growth)


def drawn_clearance(wanted: float, process: Process) -> float:
    """Return the clearance a side to draw, mm, so that `wanted` mm a side are left, in whole micrometres."""
    return math.ceil((wanted + process.growth) / _STEP - _ROUNDING) * _STEP


def _shut(case: Case) -> Iterator[Finding]:
    """A warning, as where a gap is too fine: a notch can be lapped."""
    if case.part.role is not PartRole.COMB or not case.process.growth:
        return
    inserted = case.design.core_thickness
    for notch in grooves(case):
        made = notch_as_made(notch.width, case.process)
        if made < inserted - _ROUNDING:
            clearance = drawn_clearance(case.design.mold.slit_clearance, case.process)
            remedy = "lap the notch until the piece goes in"
            if clearance <= MOST_CLEARANCE:
                remedy = f"mold.slit_clearance of {clearance:.3f} mm, which leaves the gap meant; or {remedy}"
            what = f"{notch.where} as it comes out"
            yield case.breaks("notch growth", what, made, inserted, "mm", remedy)


NOTCH_RULES: tuple[Rule, ...] = (_shut,)
