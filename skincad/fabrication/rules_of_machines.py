"""Rules of the machine itself: its build volume, and what pixels, a coat and growth leave of a notch."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from skincad.fabrication.finding import Finding
from skincad.fabrication.rules import Case, Rule, coating, grooves, walls_close
from skincad.fabrication.rules_of_layers import on_end
from skincad.inputs.design import Design
from skincad.inputs.process import Process
from skincad.shape.curves import polygon
from skincad.shape.skin import skin_of
from skincad.solids.mold import mold
from skincad.solids.plan import Part, PartRole, Prism, unturned

CHORD = 0.01  # mm, of arcs: no machine's limit is that sharp
UPRIGHT_TOLERANCE = 1e-6  # mm, by which an upright notch's walls may lean from end to end
CLEARANCE_STEP = 1e-3  # mm, to which a remedy's clearance is rounded up
_ROUNDING = 1e-9  # mm


def extent(part: Part) -> tuple[float, float, float]:
    """Return how long a part is along x, y and z, mm, as its body is: before cuts, and before it is turned
    into its mold."""
    body = unturned(part).body
    if not isinstance(body, Prism):
        raise ValueError("a made part is a prism less its cuts")
    (a, b), along = np.ptp(polygon(body.outline, CHORD), axis=0).tolist(), body.high - body.low
    return {"x": (along, a, b), "y": (a, along, b), "z": (a, b, along)}[body.axis]


def _sides(part: Part, process: Process) -> list[tuple[float, float]]:
    """How long a part is as it lies in the machine, and how long it may be, mm. A print lies flat or on end,
    its longer side along the bed's; what is cut from stock is turned as it fits."""
    x, y, z = extent(part)
    longer, shorter = sorted((process.build_x, process.build_y), reverse=True)
    if not process.layer:
        room = sorted((longer, shorter, process.build_z))
        return list(zip(sorted((x, y, z)), room, strict=True))[::-1]
    if on_end(part, process):
        y, z = z, y
    return [(max(x, y), longer), (min(x, y), shorter), (z, process.build_z)]


def _too_long(part: Part, process: Process) -> tuple[float, float] | None:
    """The first side that is longer than the machine takes, and what it takes; 0 is no limit."""
    over = ((size, most) for size, most in _sides(part, process) if most and size > most + _ROUNDING)
    return next(over, None)


def _build_volume(case: Case) -> Iterator[Finding]:
    """An error: the part can't be made on this machine at all."""
    long = _too_long(case.part, case.process)
    if long is None:
        return
    design, remedy = case.design, f"a larger machine (build_x, build_y and build_z in [printer.{case.name}])"
    for count in range(design.mold.cavities - 1, 0, -1):
        fewer = mold(design.with_(mold={"cavities": count}))
        if _too_long(fewer.first(case.part.role), case.process) is None:
            remedy = f"mold.cavities of at most {count}, or {remedy}"
            break
    where = f"{case.part.role.label}, by {case.name}"
    yield Finding("build volume", where, *long, "mm", "error", remedy)


def _pixel_steps(design: Design) -> tuple[float, bool]:
    """How many pixels across a leaning notch its steps take at most, 0 where none leans; and whether one
    stands upright. A notch leans if its walls leave a pixel's column at all."""
    skin = skin_of(design)
    slot = skin.slot
    if slot is None:
        return 0.0, False
    tilt = math.radians(slot.tilt)
    leans = [skin.lean(i) + side * tilt for i in range(1, skin.count + 1) for side in (-1, 1)]
    stepped = [a for a in leans if abs(math.sin(a)) * slot.depth > UPRIGHT_TOLERANCE]
    most = max((abs(math.cos(a)) + abs(math.sin(a)) for a in stepped), default=0.0)
    return most, len(stepped) < len(leans)


def passage(design: Design, width: float, pixel: float) -> float:
    """Return the thickest plate that is sure to pass all notches of this width, mm, as a screen exposes them.

    Upright, a notch is as many whole pixels wide as fit into it, wherever it lies on the screen. In a leaning
    one the corner of a pixel whose middle is outside stands in by up to half its width across, at both walls.
    """
    pixels, upright = _pixel_steps(design)
    whole = math.floor(width / pixel + _ROUNDING) * pixel
    return min([whole] * upright + [width - pixels * pixel] * (pixels > 0))


def _notch(case: Case) -> Iterator[Finding]:
    """What is left of a comb's notch by whole pixels, and by a coat and growth on both walls, against what
    lies in it."""
    process, design, coat = case.process, case.design, coating(case.design, case.process)
    wall = walls_close(design, process)
    pixel = process.pixel if process.tool == "screen" else 0.0
    if case.part.role is not PartRole.COMB or not (pixel or wall):
        return
    (notch,) = grooves(case)
    need = design.core_thickness
    left = max(0.0, (passage(design, notch.width, pixel) if pixel else notch.width) - 2 * wall)
    if left >= need - _ROUNDING or notch.width < process.gap - _ROUNDING:  # the rule `gap` reports the latter
        return
    pixels, upright = _pixel_steps(design)
    wide = need + 2 * wall + pixel * pixels
    if pixel and upright:
        wide = max(wide, math.ceil((need + 2 * wall) / pixel - _ROUNDING) * pixel)
    least = math.ceil((wide - need) / 2 / CLEARANCE_STEP - _ROUNDING) * CLEARANCE_STEP
    ways = ("in whole pixels", pixel), ("under its coat", coat), ("grown", process.growth)
    what = " and ".join(words for words, size in ways if size)
    where = f"{notch.where} {what}"
    yield case.breaks("notch", where, left, need, "mm", f"mold.slit_clearance of {least:.3g} mm")


MACHINE_RULES: tuple[Rule, ...] = (_build_volume, _notch)
