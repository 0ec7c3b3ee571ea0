"""The casting sheet: what to buy, what to mix, in which order to close, pour, wait and open."""

from __future__ import annotations

import math

from skincad.catalog import Silicone, silicone
from skincad.design import Design
from skincad.fabrication.findings import Finding
from skincad.section import section
from skincad.solids.inserts import GRIP, PIN_RADIUS
from skincad.solids.mold import Mold
from skincad.solids.plan import Bore

NUT = 4.0  # mm, assumption: nut and washer of an M3 bolt
WASTE = 0.25  # assumption: share of the mix that stays in cup, syringe and gate


def poured_volume(closed: Mold) -> float:
    """Return the volume that the silicone fills, mm3: skin, gate, vent and the holes of the carrier."""
    channels = [
        cut.volume
        for part in closed.parts
        for cut in part.cuts
        if part.name == "carrier" or (isinstance(cut, Bore) and cut.start[0] == 0.0)  # gate and vent: x = 0
    ]
    return closed.part("skin").volume + math.fsum(channels)


def casting_sheet(design: Design, closed: Mold, findings: list[Finding], verdict: str) -> str:
    """Return the sheet as Markdown."""
    material = silicone(design.material)
    lines = [
        f"# Casting sheet: {design.name}",
        "",
        verdict,
        "",
        *_parts(design, closed),
        *_mix(material, poured_volume(closed)),
        *_order(design),
        *_findings(design, material, findings),
    ]
    return "\n".join(lines) + "\n"


def _parts(design: Design, closed: Mold) -> list[str]:
    skin, choice = design.skin, design.mold
    rows = [f"| {p.name} | {p.volume / 1000:.3f} |" for p in closed.parts if p.made == "made"]
    through = skin.length + 2 * choice.end_plate
    upright = section(design).top + choice.floor + choice.carrier_thickness + choice.cover
    bought = [
        f"M3 bolts with nuts: 4 of at least {through + NUT:.0f} mm along y, "
        f"2 of at least {upright + NUT:.0f} mm for the cover",
        f"{sum(p.name.startswith('pin') for p in closed.parts)} dowel pins of {2 * PIN_RADIUS:g} mm, "
        "pressed into the cavity's ends and into the cover",
    ]
    if design.slot:
        count = 2 * design.ridge.count
        size = f"{design.slot.thickness:g} x {design.slot.depth:g} mm"
        bought.append(f"{count} shims, {size}, {through + GRIP:.0f} mm long")
    return [
        "## Parts",
        "",
        f"Made by {choice.process}:",
        "",
        "| part | cm3 |",
        "|---|---|",
        *rows,
        "",
        "Bought:",
        "",
        *(f"- {row}" for row in bought),
        "",
    ]


def _mix(material: Silicone, volume: float) -> list[str]:
    grams = volume * material.density * 1e-6
    total = grams * (1 + WASTE)
    a, b = (total * share / sum(material.mix) for share in material.mix)
    pot = f"{material.pot_life_min:g} min" if material.pot_life_min else "see its data sheet"
    cure = f"{material.cure_h:g} h" if material.cure_h else "see its data sheet"
    return [
        "## Silicone",
        "",
        f"{material.name}, {material.density:g} kg/m3; the mold takes {volume / 1000:.3f} cm3, "
        f"{grams:.2f} g.",
        f"Weigh {a:.2f} g of A and {b:.2f} g of B: {total:.2f} g with {WASTE:.0%} for cup, syringe and gate.",
        f"Pot life {pot}; cure {cure} at room temperature.",
        "",
    ]


def _order(design: Design) -> list[str]:
    slots = design.slot is not None
    back = (
        "its holes are wider on the far side and hold the skin like rivets"
        if design.mold.carrier == "perforated"
        else "prime its lower face for silicone, or the skin comes off"
    )
    close = [
        "Clean and dry all parts; release agent on cavity, end plates and cover, none on the carrier.",
        "Bolt the end plates to the cavity"
        + (": combs first, lay the shims into their notches, then the keepers." if slots else "."),
        f"Lay the carrier on its ledge ({back}), then cover and bolts.",
        "Degas the mix. Tilt the mold so that the vent at end b is highest, and fill slowly through the gate "
        "at end a until silicone stands in the vent.",
        "Let it cure with the vent up.",
    ]
    leave = [
        *(["Draw the shims out along y, towards end b."] if slots else []),
        "Take the end plates off along y, then the cover upward.",
        "Lift the skin out with its carrier, straight up.",
    ]
    if design.film:
        film = design.film.thickness * 1000
        leave.append(
            f"Slide the {film:.0f} um film strips in with a little fresh silicone; strips.dxf numbers them."
        )
    steps = [f"{i}. {text}" for i, text in enumerate([*close, *leave], 1)]
    return ["## In this order", "", *steps, ""]


def _findings(design: Design, material: Silicone, findings: list[Finding]) -> list[str]:
    notes = [f"- {finding}" for finding in findings]
    if material.platinum_cure and design.mold.process == "sla":
        notes.append(
            "- Platinum silicone does not cure against many SLA resins: wash, post-cure and bake the parts, "
            "seal them, and cast a trial first."
        )
    notes.append(
        f"- Inspect: skin {design.skin.width:g} x {design.skin.length:g} mm across the back, "
        f"{section(design).top:.3f} mm to the middle crest; all shims out, no ridge torn."
    )
    return ["## Watch", "", *notes]
