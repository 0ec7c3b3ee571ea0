"""Where a compressed free surface folds onto itself: a limit of the material, not of the mesh.

In plane strain a smooth neo-Hookean surface compressed along itself to the stretch WRINKLES is unstable at
every wavelength (Biot, Appl. Sci. Res. A 12 (1963) 168; 0.544), so the finer the mesh the more surely it
folds there. A defect starts a crease from the stretch CREASES on (Hong, Zhao and Suo, Appl. Phys. Lett. 95
(2009) 111901; 0.646). A crease is contact of the skin with itself, which no model here knows.

Measured on docs/facts.md's section, three ridges at 1.2 N, a coefficient of 1, pulled by travel: the stretch
passes WRINKLES at Ft/Fn 0.666, 0.673, 0.649 and 0.655 (fineness and order 0.5 2, 0.5 3, 1 3, 2 2), first in
the leading root fillet. There finer meshes fold at once: the determinant of F turns negative, on the coarsest
it is 0.5 still. The forces hardly feel it: 0.6 % between four meshes at 0.68. A tip fillet of 0.15 mm, not
0.05, does not help (0.635); at coefficients of 0.8 and 0.6 the tips fold too, at 0.61 and 0.59.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies import folding
from skincad.mechanics.bodies.elements import Outline, outlines
from skincad.mechanics.contact.dragged import FrictionalPad, FrictionalState

WRINKLES = 0.544
CREASES = 0.646
FOOT = 0.2  # of the height; below, strains at the ends of the clamped back are unbounded in any mesh


@dataclass(frozen=True)
class Pinch:
    """The free surface's smallest stretch along itself, at `place` `(2,)` at rest, in units; `tip` whether
    that may touch the plate."""

    stretch: float
    place: Array
    tip: bool


def pinch(loops: list[Outline], plate: float) -> Pinch:
    """Return where loops are compressed most that do not touch the plate at the height `plate`."""
    top = max(loop.rest[:, 1].max() for loop in loops)
    tightest = Pinch(np.inf, np.zeros(2), False)
    for loop in loops:
        start, end = loop.rest, np.roll(loop.rest, -1, axis=0)
        moved = np.roll(loop.moved, -1, axis=0) - loop.moved
        stretch = np.hypot(*moved.T) / np.hypot(*(end - start).T)
        free = loop.moved[:, 1] < plate - folding.THROUGH
        free &= np.roll(free, -1) & (start[:, 1] > FOOT * top)
        if not free.any():
            continue
        i = int(np.where(free, stretch, np.inf).argmin())
        if stretch[i] < tightest.stretch:
            tightest = Pinch(float(stretch[i]), (start[i] + end[i]) / 2, bool(loop.touches[i]))
    return tightest


def fault(pad: FrictionalPad, state: FrictionalState, creases: bool) -> str | None:
    """Return what a state has that the model does not know: contact of the skin with itself or, off its
    crests, with the plate; with `creases` a surface that folds too. None for a sound state."""
    plate = (pad.top - state.grip.approach) / pad.unit
    loops = outlines(pad.rest, state.values)
    least = pinch(loops, plate)
    if creases and least.stretch < WRINKLES:
        ridge = pad.ridge[int(np.abs(pad.x / pad.unit - least.place[0]).argmin())]
        where = "tip" if least.tip else "flank or root"
        return (
            f"the surface folds onto itself at ridge {ridge}'s {where}: its stretch there is "
            f"{least.stretch:.3f}, and below {WRINKLES:g} no free surface stays smooth in plane strain"
        )
    return folding.fault(loops, lambda x: np.full_like(x, plate), with_itself=creases)
