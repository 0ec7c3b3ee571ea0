"""What a person does with the strips: lines of the casting sheet."""

from __future__ import annotations

import math

from skincad.fabrication.bent_steps import arc_length
from skincad.fabrication.bond_steps import NUMBERS, TOWARDS, strip_count
from skincad.fabrication.strip_rules import placement_error
from skincad.fabrication.strips import deflection, pour, release_strain, strip, weight
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import skin_of
from skincad.solids.inserts import GRIP
from skincad.solids.mold import ClosedMold
from skincad.solids.shrinkage import scaled_for_shrinkage


def shim_length(design: Design, closed: ClosedMold) -> int:
    """Return how long a shim is, whole mm: it stands out at both ends; along its arc in a bent mold."""
    if design.skin.curvature_radius_y is not None:
        return math.ceil(arc_length(closed))
    return math.ceil(scaled_for_shrinkage(design).skin.length + 2 * design.mold.end_plate + 2 * GRIP)


def to_buy(design: Design, closed: ClosedMold) -> list[str]:
    """Return what to buy to keep the slots of a skin free that is straight along y."""
    slot = skin_of(design).slot
    if slot is None or design.mold.method == "cast-in":
        return []
    size = f"{slot.thickness:g} x {slot.depth:g} mm"
    return [
        f"{strip_count(design)} shims of spring steel, {size}, {shim_length(design, closed)} mm long: "
        "slit or "
        "etched from feeler stock, edges deburred"
    ]


def comb_step(design: Design) -> str:
    """Return how the notches are filled before the keepers are put on."""
    rod = strip(design)
    if rod is None or design.mold.method == "shim":
        return (
            f"combs first; lay the shims into the notches, {GRIP:g} mm out at both ends, and pull them "
            "straight; then the keepers, pressed down onto the combs while you tighten."
        )
    load = weight(rod, silicone(design).density)
    return (
        "combs first. Lay each strip, primed and dry, into its notches, + "
        f"side {TOWARDS} ({NUMBERS}). Tie a thread to each tab's hole, lead it along y over a rod that lies "
        "a little below the notches on one board with the mold, so that the strip stays upright, and hang "
        f"{rod.hung:.3g} g on each ({rod.tension:.3g} N, {rod.stress:.3g} MPa): it stands on the notches' "
        f"bottoms, its datum, and is within {placement_error(design):.2g} mm of its place; in silicone it "
        "sags by "
        f"{abs(deflection(rod, load)):.2g} mm at most. Then the keepers, pressed down onto the combs while "
        "you tighten. The weights hang until the silicone has cured."
    )


def filling_time_words(design: Design) -> str:
    """Return how fast the silicone may rise round strips that are cast in."""
    flow = pour(design)
    if flow is None or design.mold.method == "shim":
        return ""
    return (
        f" Take {design.mold.fill_time:g} s to fill it: the strips are moved aside by up to "
        f"{flow.drift:.2g} mm and come back within {5 * flow.settling:.2g} s."
    )


def release_steps(design: Design) -> list[str]:
    """Return what is done with strips that are cast in before the mold is opened; nothing where none is."""
    if design.mold.method != "cast-in" or design.film is None:
        return []
    return [
        "Take the weights off and cut off at the strips' marks what they hung on; the tabs with pads, "
        f"number and + sign stay. The skin shortens by {100 * release_strain(design):.2g} %, "
        "when the strips are released."
    ]
