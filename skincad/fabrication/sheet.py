"""The casting sheet: what to buy, what to mix, in which order to close, pour, wait and open."""

from __future__ import annotations

import math

from skincad.catalog import Silicone, silicone
from skincad.design import Design
from skincad.fabrication.findings import Finding
from skincad.fabrication.void import void
from skincad.section import section
from skincad.solids.inserts import GRIP, PIN_RADIUS
from skincad.solids.mold import Mold
from skincad.solids.plan import Bore

NUT = 4.0  # mm, assumption: nut and washer of an M3 bolt
# mm, source: outer diameters of needle tubing by gauge (Birmingham wire gauge)
TIPS = {10: 3.40, 12: 2.77, 14: 2.11, 16: 1.65, 18: 1.27, 20: 0.91, 22: 0.72, 25: 0.51}
SLACK = 0.1  # mm, assumption: least play of a tip in the gate
LUER = (4.03, 4.48)  # mm, source: ISO 80369-7, male slip, largest at its end, and 7.5 mm of 6 % behind
DEAD_VOLUME = 8.0  # g, assumption: stays in cup and syringe; less can't be weighed or degassed well


def poured_volume(design: Design, closed: Mold) -> float:
    """Return the volume that the silicone fills, mm3: skin, gate, vent and reservoir, the carrier's holes and
    their bleeds, and the flash in the gap round the carrier."""
    return void(design, closed).volume


def casting_sheet(design: Design, closed: Mold, findings: list[Finding], verdict: str, passed: bool) -> str:
    """Return the sheet as Markdown. `verdict` is the contact check's, `passed` that of the whole job."""
    material = silicone(design.material)
    summary = (
        "All checks passed." if passed else "**NOT PASSED: read the findings below before you make it.**"
    )
    lines = [
        f"# Casting sheet: {design.name}",
        "",
        f"{summary} {verdict}",
        "",
        *_parts(design, closed),
        *_mix(material, poured_volume(design, closed)),
        *_order(design),
        *_findings(design, material, findings),
    ]
    return "\n".join(lines) + "\n"


def _parts(design: Design, closed: Mold) -> list[str]:
    skin, choice = design.skin, design.mold
    rows = [f"| {p.name} | {p.volume / 1000:.3f} |" for p in closed.parts if p.made == "made"]
    through = skin.length + 2 * choice.end_plate
    upright = section(design).top + choice.floor + choice.carrier_thickness + choice.cover
    pins: dict[str, int] = {}
    for part in closed.parts:
        if isinstance(part.body, Bore):
            size = f"{math.floor(10 * part.body.length) / 10:g} mm"
            pins[size] = pins.get(size, 0) + 1
    lengths = ", ".join(f"{count} of at most {size}" for size, count in pins.items())
    bought = [
        f"M3 bolts with nuts: 4 of at least {math.ceil(through + NUT)} mm along y, "
        f"2 of at least {math.ceil(upright + NUT)} mm for the cover (their nuts stand out of the floor)",
        f"dowel pins of {2 * PIN_RADIUS:g} mm: {lengths}; ream the cavity's ends and the cover for a press "
        "fit, end plates and cavity's top for a sliding one",
        f"release agent, {_tip(design)}tape for the bleeds, nitrile gloves (latex inhibits platinum "
        "silicone)",
    ]
    if design.slot:
        count = 2 * design.ridge.count
        size = f"{design.slot.thickness:g} x {design.slot.depth:g} mm"
        bought.append(
            f"{count} shims of spring steel, {size}, {math.ceil(through + GRIP)} mm long: slit or etched "
            "from feeler stock, edges deburred"
        )
    return [
        "## Parts",
        "",
        f"End plates and cavity by {choice.process}; cover and carrier are plain plates, by any process:",
        "",
        "| part | cm3 |",
        "|---|---|",
        *rows,
        "",
        "To buy:",
        "",
        *(f"- {row}" for row in bought),
        "",
    ]


def _tip(design: Design) -> str:
    """What goes into the gate: the luer slip itself where it seats, or the widest blunt tip that fits."""
    gate = design.mold.gate
    if design.mold.pour == "open":
        return ""
    if LUER[0] <= gate <= LUER[1]:
        return "a syringe whose luer slip seats in the gate, a plug for the gate, "
    fits = [f"a blunt tip of {n} gauge ({d:g} mm)" for n, d in TIPS.items() if d + SLACK <= gate]
    what = fits[0] if fits and gate < LUER[0] else f"a tube of {gate - SLACK:g} mm"
    return f"a syringe with {what} for the gate, a plug for the gate, "


def _mix(material: Silicone, volume: float) -> list[str]:
    grams = volume * material.density * 1e-6
    total = grams + DEAD_VOLUME
    parts = f"mix {total:.2f} g by its data sheet"
    if material.mix:
        a, b = (total * share / sum(material.mix) for share in material.mix)
        parts = f"weigh {a:.2f} g of A and {b:.2f} g of B, {total:.2f} g"
    pot = f"{material.pot_life_min:g} min" if material.pot_life_min else "by its data sheet"
    cure = f"{material.cure_h:g} h" if material.cure_h else "by its data sheet"
    return [
        "## Silicone",
        "",
        f"{material.name}, {material.density:g} kg/m3; the mold takes {volume / 1000:.3f} cm3, "
        f"{grams:.2f} g.",
        f"With {DEAD_VOLUME:g} g more for cup and syringe: {parts}.",
        f"Pot life {pot}; cure {cure} at room temperature.",
        "",
    ]


def _order(design: Design) -> list[str]:
    slots = design.slot is not None
    back = (
        "its holes widen upward and hold the skin like rivets"
        if design.mold.carrier == "perforated"
        else "prime its lower face for silicone, or the skin comes off"
    )
    combs = (
        "combs first; lay the shims into the notches, their long end out at end b, and pull them straight; "
        "then the keepers, pressed down onto the combs while you tighten."
    )
    close = [
        ("End a has the gate. " if design.mold.pour == "syringe" else "")
        + "Clean and dry all parts; release agent on cavity, end plates, cover"
        + (" and shims" if slots else "")
        + ", none on the carrier.",
        "Bolt the end plates to the cavity" + (f": {combs}" if slots else "."),
        *(_by_syringe if design.mold.pour == "syringe" else _open)(design, back),
        "Lay the mold level to cure. Top up the reservoir over the vent: it feeds what shrinks and what "
        "bubbles leave.",
    ]
    draw = "Draw the shims out along y, towards end b."
    if design.film:
        draw = (
            f"Glue each film strip ({design.film.thickness * 1000:.0f} um, numbered in strips.dxf) to the "
            "short tail of its shim at end a, wet it with fresh silicone, and draw the shim out along "
            "y, towards end b: the strip follows it in. It is too thin to be pushed. Mark its polarity; the "
            "same side faces +x in every slot."
        )
    leave = [
        *([draw] if slots else []),
        "Take all bolts out, the cover's first. "
        + ("Cut the sprue at the gate, take" if design.mold.pour == "syringe" else "Take")
        + " the end plates off along y.",
        "Take the cover off upward; what stood in reservoir and bleeds tears, or is cut flush.",
        "Push the carrier up from its two ends; the skin leaves the cavity with it. Cut the flash there.",
    ]
    steps = [f"{i}. {text}" for i, text in enumerate([*close, *leave], 1)]
    return ["## In this order", "", *steps, ""]


def _by_syringe(design: Design, back: str) -> list[str]:
    return [
        f"Lay the carrier on its ledge ({back}), then cover and bolts.",
        f"Degas the mix. Raise end b by {design.mold.pour_tilt:g} degrees, fill slowly through the gate at "
        "end a, and tape each bleed as silicone shows in it, until silicone stands in the reservoir.",
        "Plug the gate or leave the syringe in it: it is the lowest point.",
    ]


def _open(design: Design, back: str) -> list[str]:
    return [
        "Degas the mix. Lay the mold level and pour in a thin stream along one side, until the silicone "
        "stands a little above the ledge; degas once more, pierce what bubbles stay on ridges and shims.",
        f"Raise end b by {design.mold.pour_tilt:g} degrees. Set the carrier down at end a first and lower it "
        f"slowly onto its ledge, so that it drives the air towards end b ({back}).",
        "Cover and bolts; silicone rises in the bleeds and in the reservoir. Fill up through the reservoir.",
    ]


def _findings(design: Design, material: Silicone, findings: list[Finding]) -> list[str]:
    notes = [f"- {finding}" for finding in findings]
    if design.mold.carrier == "perforated":
        notes.append("- The carrier is held by rivets of silicone: a light pull test before use.")
    if material.platinum_cure and design.mold.process == "sla":
        notes.append(
            "- Platinum silicone does not cure against many SLA resins: wash, post-cure and bake the parts, "
            "seal them, and cast a trial first."
        )
    notes.append(
        f"- Inspect: skin {design.skin.width:g} x {design.skin.length:g} mm across the back, "
        f"{section(design).top:.3f} mm to the middle crest; no ridge torn."
    )
    return ["## Watch", "", *notes]
