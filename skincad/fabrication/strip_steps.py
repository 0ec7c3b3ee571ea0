"""What a person does with the strips: lines of the casting sheet."""

from __future__ import annotations

import math

from skincad.fabrication.strip_rules import misplaced
from skincad.fabrication.strips import deflection, pour, released, strip, weight
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.solids.inserts import GRIP

NUMBERS = (
    "number 1 is at the left, seen from end a; nicks in the end plates' edges mark the ends: one at end a, "
    "two at end b, where the reservoir is"
)


def to_buy(design: Design, through: float) -> list[str]:
    """Return what to buy for the slots; `through` is the length over both end plates, mm."""
    if design.slot is None:
        return []
    count = 2 * design.ridge.count * design.mold.cavities
    if design.mold.method == "cast-in" and design.film:
        size = f"{design.film.thickness * 1000:.0f} µm"
        return [
            f"{count} strips of PVDF film, {size}, electrodes on both faces, cut by strips.dxf or "
            "strips.svg, and a weight for each tab"
        ]
    size = f"{design.slot.thickness:g} x {design.slot.depth:g} mm"
    return [
        f"{count} shims of spring steel, {size}, {math.ceil(through + GRIP)} mm long: slit or etched from "
        "feeler stock, edges deburred"
    ]


def laid_in(design: Design) -> str:
    """Return how the notches are filled before the keepers are put on."""
    rod = strip(design)
    if rod is None or design.mold.method == "shim":
        return (
            "combs first; lay the shims into the notches, their long end out at end b, and pull them "
            "straight; then the keepers, pressed down onto the combs while you tighten."
        )
    load = weight(rod, silicone(design).density)
    return (
        "combs first. Prime the strips for silicone between their marks. Lay each into its notches, + "
        f"side to +x ({NUMBERS}), lead the tabs over rods a little below the notches and hang "
        f"{rod.hung:.3g} g on each ({rod.tension:.3g} N, {rod.stress:.3g} MPa): it stands on the notches' "
        f"bottoms, its datum, and is within {misplaced(design):.2g} mm of its place; in silicone it sags by "
        f"{abs(deflection(rod, load)):.2g} mm at most. Then the keepers, pressed down onto the combs while "
        "you tighten. The weights hang until the silicone has cured."
    )


def filled_slowly(design: Design) -> str:
    """Return how fast the silicone may rise round strips that are cast in."""
    flow = pour(design)
    if flow is None or design.mold.method == "shim":
        return ""
    return (
        f" Take {design.mold.fill_time:g} s to fill it: the strips are moved aside by up to "
        f"{flow.drift:.2g} mm and come back within {5 * flow.settling:.2g} s."
    )


def freed(design: Design) -> list[str]:
    """Return what is done with shims or strips before the mold is opened."""
    if design.slot is None:
        return []
    film = design.film
    way = "along y" if design.skin.curvature_radius_y is None else "along its arc"
    if film is None:
        return [f"Draw the shims out {way}, towards end b."]
    if design.mold.method == "cast-in":
        return [
            "Take the weights off and cut the strips' tabs off at their marks, outside the end plates; mark "
            "each lead's number and + side. What is left is straight and slides through its notch. The skin "
            f"shortens by {100 * released(design):.2g} %, when the strips are released."
        ]
    return [
        f"Glue each film strip ({film.thickness * 1000:.0f} µm, numbered in strips.dxf; {NUMBERS}) by its "
        "tail to the short tail of its shim at end a, wet it with fresh silicone, and draw the shim out "
        f"{way}, towards end b: the strip follows it in. It is too thin to be pushed. Mark its polarity; "
        "the same side faces +x in every slot. Cut the glued tail off at its mark."
    ]
