"""Lines of the casting sheet that differ for a doubly curved mold: screws, shims as arcs, and the order."""

from __future__ import annotations

import math

from skincad.fabrication.drawing_in import lap
from skincad.fabrication.fasteners import Screws
from skincad.fabrication.rules import shim_bend
from skincad.inputs.design import Design
from skincad.shape.skin import section, skin_of
from skincad.solids.inserts import GRIP
from skincad.solids.layout import end_angle
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole, RevolvedBody
from skincad.solids.shrinkage import scaled_for_shrinkage

DEGAS = (
    "Degas the mix in its open cup, four times as high as the mix, for it rises; never put the closed mold, "
    "filled, under vacuum: its silicone would foam out and air come in."
)


def bent_screws(screws: Screws, hold: str) -> str:
    """Return the words for the end plates' screws; `hold` is what they go into."""
    how = ", bottoming tap at last" * screws.bottoming + under_heads(screws.washers)
    return (
        f"M3 screws, ISO 4762: {screws.pieces} M3 x {screws.length:g} for the end plates, square to the "
        f"cavity's leaning ends, into {hold}{how}"
    )


def under_heads(washers: int) -> str:
    """Return the words for washers that keep a screw's tip off the end of its hole."""
    return f", {washers} washers under each head" if washers else ""


def arcs_to_buy(design: Design, closed: ClosedMold) -> list[str]:
    """Return what to buy for the slots: shims cut as arcs, with the radius of each."""
    slot, radius = skin_of(design).slot, design.skin.curvature_radius_y
    if slot is None or radius is None:
        return []
    size = f"{slot.thickness:g} x {slot.depth:g} mm"
    arms = [
        f"{s.feature} {s.side} {arc_radius(design, s.feature, s.side):.2f}" for s in section(design).slots
    ]
    strain, joint, film = 100 * shim_bend(design), lap(design), design.film
    thin = ""
    if joint is not None and film is not None and joint.tail < slot.thickness:
        thin = (
            f", the last {GRIP:g} mm at end {film.wiring_side} thinned to {joint.tail:.3f} mm (etched or "
            "stoned, by micrometer), so that film and shim, glued, pass the notches together"
        )
    return [
        f"{len(arms)} shims of spring steel, {size}, {math.ceil(arc_length(closed))} mm long, cut or etched "
        f"as arcs from sheet by shims.dxf, deburred{thin}; "
        f"straight stock bent on edge is strained by {strain:.2g} % and buckles between its combs. Radius "
        f"at mid-depth, mm, by ridge and slot: {', '.join(arms)}"
    ]


def arc_length(closed: ClosedMold) -> float:
    """Return how long the longest shim of a doubly curved mold is along its outer edge, mm."""
    arcs = [part.body for part in closed.of(PartRole.SHIM) if isinstance(part.body, RevolvedBody)]
    return max((arc.high - arc.low) * (arc.centre - min(s.start.z for s in arc.outline)) for arc in arcs)


def arc_radius(design: Design, ridge: int, side: str) -> float:
    """Return the radius of a slot's shim laid flat, mm: it is a part of a cone whose lines run along its
    depth, so the distance along them from the axis to the middle of the depth."""
    poured_design = scaled_for_shrinkage(design)
    slot = next(s for s in section(poured_design).slots if (s.feature, s.side) == (ridge, side))
    radius = poured_design.skin.curvature_radius_y or math.inf
    return (radius - poured_design.skin.thickness + slot.centre.z) / abs(slot.direction.z)


def close_steps(design: Design, closed: ClosedMold, back: str) -> list[str]:
    """Return how the mold is closed and filled, after cleaning."""
    if skin_of(design).slot is None:
        ends = f"Lay the carrier on its ledge ({back}); the end plates lean over it and are screwed on next."
    else:
        ends = (
            "Screw both combs to the cavity's ends. Lay each shim into its notches, its hollow side up and "
            f"{GRIP:g} mm out at both ends. Lay the carrier on its ledge ({back}). Then the keepers, which "
            "lean over it: pressed down onto the combs while you tighten."
        )
    rise, tilt = math.degrees(end_angle(design)), design.mold.pour_tilt
    both = (
        "; end a leans by more than that, so its air leaves slowly, through the gap round the carrier"
        if tilt <= rise
        else ""
    )
    return [
        ends,
        f"{'Then the foam, cover' if closed.of(PartRole.SEAL) else 'Cover'} and bolts.",
        f"{DEGAS} Raise end b by {tilt:g} degrees (both ends lean by {rise:.3g}{both}). Fill slowly "
        "through the gate at end a, and tape each bleed as silicone shows in it, until silicone stands in "
        "the reservoir.",
        "Plug the gate or leave the syringe in it.",
    ]


def leave_steps(closed: ClosedMold) -> list[str]:
    """Return how the mold is opened, once the shims are out."""
    foam = ", with the foam" if closed.of(PartRole.SEAL) else ""
    return [
        f"Take the cover's bolts out and lift it by its ends, which overhang the end plates{foam}; the "
        "silicone in the reservoir and the bleeds tears off, or is cut flush.",
        "Take the end plates' screws out, cut the sprue at the gate, and take the plates off square to the "
        "cavity's ends, with a screwdriver in the notches at their sides. Where strips' tabs stand outside a "
        "plate, slide it along the leads off its pins, then lift the keeper off and lower the comb.",
    ]
