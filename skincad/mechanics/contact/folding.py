"""Where a pad's free surface folds, and contact that its model does not know.

A limit of the material, not of the mesh. In plane strain a smooth neo-Hookean surface compressed along itself
to the stretch WRINKLES is unstable at every wavelength (Biot, Appl. Sci. Res. A 12 (1963) 168; 0.544), so the
finer the mesh the more surely it folds there. A defect starts a crease from the stretch 0.646 on (Hong,
Zhao and Suo, Appl. Phys. Lett. 95 (2009) 111901). A crease is contact of the skin with itself, which
no model here knows.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies import plane_body
from skincad.mechanics.bodies.elements import outlines
from skincad.mechanics.contact.frictional_pad import FrictionalPad, FrictionalState
from skincad.mechanics.contact.state import ContactState
from skincad.mechanics.problem import DeformedLoop

WRINKLES = 0.544
LEAST_VOLUME = 0.02  # of an element's at rest, at any of its points; less is hardly a solution
FOOT = 0.2  # of the height; below, strains at the ends of the clamped back are unbounded in any mesh


def pinch(loops: list[DeformedLoop], plate: float) -> tuple[float, Array, bool]:
    """Return the smallest stretch along itself of the free surface, of loops that do not touch the plate at
    the height `plate`; its place `(2,)` at rest, in units; and whether that may touch the plate."""
    top = max(loop.rest[:, 1].max() for loop in loops)
    tightest = np.inf, np.zeros(2), False
    for loop in loops:
        start, end = loop.rest, np.roll(loop.rest, -1, axis=0)
        moved = np.roll(loop.moved, -1, axis=0) - loop.moved
        stretch = np.hypot(*moved.T) / np.hypot(*(end - start).T)
        free = loop.moved[:, 1] < plate - plane_body.THROUGH
        free &= np.roll(free, -1) & (start[:, 1] > FOOT * top)
        i = int(np.where(free, stretch, np.inf).argmin())
        if free[i] and stretch[i] < tightest[0]:
            tightest = float(stretch[i]), (start[i] + end[i]) / 2, bool(loop.touches[i])
    return tightest


def _lowered(
    loops: list[DeformedLoop], pad: FrictionalPad, contact: ContactState, sunk: Array | None
) -> list[DeformedLoop]:
    """The outlines lower by what free ends let the ridges down, and by what masses do, `sunk` `(m,)` mm at
    the contact points: a section at rest knows neither."""
    if sunk is None and not pad.ends.any():
        return loops
    down = pad.ends[pad.x.size :, pad.x.size :] @ contact.normal / pad.unit
    down = down if sunk is None else down + sunk / pad.unit
    x = pad.x / pad.unit
    return [
        replace(
            loop, moved=loop.moved - np.stack([0 * loop.rest[:, 0], np.interp(loop.rest[:, 0], x, down)], 1)
        )
        for loop in loops
    ]


def fold_of(pad: FrictionalPad, state: FrictionalState) -> str | None:
    """Return where the free surface is compressed along itself to less than WRINKLES, or where the skin goes
    through itself; None where neither is so."""
    loops, plate = outlines(pad.rest, state.values), _plate(pad, state)
    if folded := _fold(pad, *pinch(_lowered(loops, pad, state.contact, None), plate)):
        return folded
    depth, place = _crossing(loops)
    return _through(pad, depth, place) if depth > 0 else None


def undetected_contact(
    pad: FrictionalPad,
    state: FrictionalState,
    creases: bool,
    sunk: Array | None = None,
    deepest: float = 0.0,
) -> str | None:
    """Return what a state has that the model does not know: contact of the skin, off its crests, with the
    plate; with `creases` contact with itself and a surface that folds, else one that crosses itself by more
    than `deepest` mm, or an element pressed to less than LEAST_VOLUME. `sunk` `(m,)` mm is how much lower
    masses let the contact points be. None for a sound state."""
    plate = _plate(pad, state)
    loops = _lowered(outlines(pad.rest, state.values), pad, state.contact, sunk)
    if creases and (folded := _fold(pad, *pinch(loops, plate))):
        return folded
    wrong = plane_body.undetected_contact(loops, lambda x: np.full_like(x, plate), with_itself=creases)
    if wrong or creases:
        return wrong
    volume, place = pad.body.least_volume(state.values, FOOT)
    if volume < LEAST_VOLUME:
        return f"at {_named(pad, place)} silicone is pressed to {volume:.2g} of its volume in the model"
    depth, place = _crossing(loops)
    if depth * pad.unit > deepest:
        return f"{_through(pad, depth, place)}, more than a fillet's radius of {deepest:.2g} mm"
    return None


def _crossing(loops: list[DeformedLoop]) -> tuple[float, Array]:
    """How deep the skin's outline or a slot's goes through itself, in units, and where."""
    return max((plane_body.crossing(loop.moved) for loop in loops), key=lambda found: found[0])


def _through(pad: FrictionalPad, depth: float, place: Array) -> str:
    return f"at {_named(pad, place)} the skin goes through itself by {depth * pad.unit:.2g} mm"


def _named(pad: FrictionalPad, place: Array) -> str:
    """The ridge nearest to a place `(2,)`, in units; the place itself where there is but one, or a face."""
    lone = np.ptp(pad.ridge) == 0
    return f"x = {place[0] * pad.unit:.2g} mm" if lone else f"ridge {_ridge_at(pad, place)}"


def _plate(pad: FrictionalPad, state: FrictionalState) -> float:
    """The plate's height, in units."""
    return (pad.top - state.contact.approach) / pad.unit


def _ridge_at(pad: FrictionalPad, place: Array) -> int:
    """The number of the ridge nearest to a place `(2,)`, in units."""
    return int(pad.ridge[int(np.abs(pad.x / pad.unit - place[0]).argmin())])


def _fold(pad: FrictionalPad, stretch: float, place: Array, tip: bool) -> str | None:
    if stretch >= WRINKLES:
        return None
    where = "tip" if tip else "flank or root"
    return (
        f"the surface folds onto itself at ridge {_ridge_at(pad, place)}'s {where}: its stretch there "
        f"is {stretch:.3f}, and below {WRINKLES:g} no free surface stays smooth in plane strain"
    )
