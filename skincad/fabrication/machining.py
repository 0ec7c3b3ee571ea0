"""Stock and time of a part that is cut: the time follows from rates of removal and of faces.

No slicer says these times; rates are assumptions, and the process's errors as wide.
"""

from __future__ import annotations

import math

import numpy as np

from skincad.fabrication.filament import MachineEffort
from skincad.fabrication.rules_of_machines import extent
from skincad.inputs.process import Process
from skincad.shape import curves
from skincad.shape.curves import Loop, polygon
from skincad.solids.plan import Part, PartRole, Prism, RevolvedBody, bores, plain, unturned

MINUTE = 60.0  # s
_CHORD = 0.01  # mm, of arcs: no rate is that sharp


def machining(part: Part, process: Process) -> MachineEffort:
    """Return the volume of a part's stock, mm3, and how long it is cut, s.

    A mill clears what stock has over the part and finishes all faces. A wire cuts the faces along its way
    alone, and offcuts come off whole. The skin's negative and notches go by the fine tool's rate.
    """
    stock = math.prod(side + 2 * process.allowance for side in extent(part))
    coarse, fine = _faces(part, ends=process.removal_rate > 0)
    minutes = coarse / process.finish_rate + fine / process.fine_rate + len(bores(part)) * process.hole_time
    if process.removal_rate > 0:
        minutes += (stock - part.volume) / process.removal_rate
    return MachineEffort(stock, minutes * MINUTE)


def _faces(part: Part, ends: bool) -> tuple[float, float]:
    """Area of a part's faces beside its bores, mm2, for a coarse tool and for a fine one; with its two `ends`
    or without."""
    body = unturned(part).body
    if not isinstance(body, Prism):
        raise ValueError("a made part is a prism less its cuts")
    long = body.high - body.low
    loops = (body.outline, *body.holes)
    around, fine = math.fsum(map(curves.length, loops)), math.fsum(map(_negative, loops))
    if part.role is PartRole.COMB:
        fine = max(0.0, around - 2 * float(np.ptp(polygon(body.outline, _CHORD), axis=0).sum()))  # notches
    coarse = (around - fine) * long + (2 * body.volume / long if ends else 0.0)
    turned = [cut for cut in map(plain, part.cuts) if isinstance(cut, RevolvedBody)]  # a bowl's trough
    swept = (_negative(cut.outline) * abs(cut.centre) * (cut.high - cut.low) for cut in turned)
    return coarse, fine * long + math.fsum(swept)


def _negative(outline: Loop) -> float:
    """Length of what is the skin's in an outline, mm."""
    return math.fsum(segment.length for segment in outline if segment.kind != "other")
