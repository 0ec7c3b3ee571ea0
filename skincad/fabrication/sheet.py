"""The casting sheet: what to buy, what to mix, in which order to close, pour, wait and open."""

from __future__ import annotations

import math

from skincad.base.reading import markdown_text
from skincad.base.version import __version__
from skincad.fabrication.bent_steps import DEGAS, arcs_to_buy, bent_screws, close_steps, under_heads
from skincad.fabrication.bond_steps import bonding_kit, preparation_steps, release_agent_places
from skincad.fabrication.drawing_in import lap
from skincad.fabrication.estimates import ProcessEstimate, lines
from skincad.fabrication.fasteners import cover_screws, dowels, end_screws
from skincad.fabrication.finding import Finding, counted
from skincad.fabrication.first_steps import preparation
from skincad.fabrication.inspection import Inspection
from skincad.fabrication.inspection_form import inspection_lines
from skincad.fabrication.mounting import cleanliness_steps, screws_to_buy
from skincad.fabrication.opening import opening_steps
from skincad.fabrication.strip_steps import comb_step, filling_time_words, to_buy
from skincad.fabrication.tolerances import process_words
from skincad.fabrication.void import perforated, single_skin_mold, void
from skincad.inputs.catalog import display_name
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.silicone import Silicone
from skincad.shape.skin import skin_of
from skincad.solids.ends import gate
from skincad.solids.fasteners import BEARING, TAP_RADIUS, torque
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import SQUEEZED_SHARE, cavity_process, end_process, fits, is_clamped, lid_process
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import END_PLATES, CutRole, PartRole, Prism, bores
from skincad.solids.shrinkage import scaled_for_shrinkage, shrinkage
from skincad.solids.skin import skin_part

# mm, source: outer diameters of needle tubing by gauge (Birmingham wire gauge)
TIPS = {10: 3.40, 12: 2.77, 14: 2.11, 16: 1.65, 18: 1.27, 20: 0.91, 22: 0.72, 25: 0.51}
TIP_PLAY = 0.1  # mm, assumption: least play of a tip in the gate
LUER = (4.03, 4.48)  # mm, source: ISO 80369-7, male slip, largest at its end, and 7.5 mm of 6 % behind
DEAD_VOLUME = 8.0  # g, assumption: stays in cup and syringe; less can't be weighed or degassed well


def poured_volume(design: Design, closed: ClosedMold) -> float:
    """Return the volume that the silicone fills, mm3: skin, gate, vent and reservoir, the carrier's holes and
    their bleeds, and the flash in the gap round the carrier; for all skins of a gang, whose cover and seal
    are thicker than those of one."""
    spaces = void(design, single_skin_mold(design, closed)).spaces
    below = math.fsum(space.body.volume for space in spaces if space.beside is not PartRole.COVER)
    lids = closed.of(PartRole.COVER, PartRole.SEAL)
    over = [bore.volume for part in lids for bore in bores(part, CutRole.RESERVOIR, CutRole.BLEED)]
    return design.mold.cavities * below + math.fsum(over)


def casting_sheet(
    design: Design,
    closed: ClosedMold,
    findings: list[Finding],
    verdict: str,
    passed: bool,
    inspected: Inspection | None = None,
    estimates: tuple[ProcessEstimate, ...] = (),
) -> str:
    """Return the sheet as Markdown. `verdict` is the contact check's, `passed` that of the whole job,
    `inspected` what to measure on the skin, `estimates` what each process takes."""
    material = silicone(design)
    summary = f"Mold: {counted(findings)}."
    if not passed:
        summary = f"**Don't make it yet.** {summary}"
    lines = [
        f"# Casting sheet: {display_name(design)}",
        "",
        f"{summary} {verdict}",
        "",
        f"Revision {design.revision} of the design, by skincad {__version__}.",
        "",
        *_parts(design, closed, estimates),
        *_mix(material, poured_volume(design, closed)),
        *_order(design, closed),
        *_findings(closed, findings),
        *(inspection_lines(inspected) if inspected else []),
    ]
    return "\n".join(lines) + "\n"


def _parts(design: Design, closed: ClosedMold, estimates: tuple[ProcessEstimate, ...]) -> list[str]:
    bent = design.skin.curvature_radius_y is not None
    made_parts = (p for p in closed.parts if p.made == "made")
    rows = [f"| {p.name} | {process_words(design, p)} | {p.volume / 1000:.5g} |" for p in made_parts]
    lengths = ", ".join(f"{count} of at most {size:g} mm" for size, count in dowels(closed).items())
    bought = [
        *_bolts(design, closed),
        *_seal(closed),
        f"dowel pins of {2 * PIN_RADIUS:g} mm: {lengths}; ream the cavity's ends and the cover for a press "
        "fit, the end plates and the cavity's top for a sliding fit",
        f"release agent, {_tip(design)}tape for the bleeds, nitrile gloves (latex inhibits platinum "
        "silicone)",
    ]
    bought += (arcs_to_buy if bent else to_buy)(design, closed)
    bought += [*screws_to_buy(design, closed), *bonding_kit(design)]
    return [
        "## Parts",
        "",
        "| part | made by | cm³ |",
        "|---|---|---|",
        *rows,
        "",
        *_effort_lines(design, estimates),
        _shrinkage(design, closed),
        "",
        "To buy:",
        "",
        *(f"- {row}" for row in bought),
        "",
    ]


def _effort_lines(design: Design, estimates: tuple[ProcessEstimate, ...]) -> list[str]:
    """What each process takes, where that was estimated."""
    return [" ".join(["Estimates.", *lines(design, estimates)]), ""] if estimates else []


def _bolts(design: Design, closed: ClosedMold) -> list[str]:
    """What holds the mold together, as the parts have it."""
    holes, process = fits(design, design.mold.process), cavity_process(design)
    hold = f"{holes.insert} inserts in holes of {2 * holes.thread:g} mm" if holes.insert else "tapped holes"
    upper = "two clamps that hold the cover down on the cavity"
    if (lid := cover_screws(design, closed)) is not None:
        upper = f"M3 screws, ISO 4762: {lid.pieces} M3 x {lid.length:g} for the cover, into {hold}"
        upper += under_heads(lid.washers)
    tightest = min(map(torque, (process, end_process(design), lid_process(design))))
    tight = (
        f"for all screws a torque of {tightest:g} N m, dry: 0.2 times 3 mm times the tension at which a head "
        f"presses on its part by {BEARING['plastic']:g} MPa (plastic) or {BEARING['metal']:g} MPa (metal)"
    )
    ends = end_screws(design, closed)
    if design.skin.curvature_radius_y is not None:
        return [bent_screws(ends, hold), upper, tight]
    sunk = sum(cut.role is CutRole.NUT for p in closed.of(*END_PLATES) if p.end == "b" for cut in p.cuts)
    where = f"into M3 threads of end plate b, {2 * TAP_RADIUS:g} mm drilled"
    if ends.nuts:
        where = f"with nuts, {sunk} of them sunk in end plate b"
    kind = "threaded rods with nuts at both ends" if ends.rod else "bolts, ISO 4762"
    return [f"M3 {kind}: {ends.pieces} M3 x {ends.length:g} along y, {where}", upper, tight]


def _seal(closed: ClosedMold) -> list[str]:
    """The foam under the cover, as it is bought and as it lies."""
    highs = [s.body.high - s.body.low for s in closed.of(PartRole.SEAL) if isinstance(s.body, Prism)]
    return [
        f"closed-cell EVA foam, a sheet of {high / SQUEEZED_SHARE:.3g} mm, cut by seal.dxf to carrier and "
        "end plates "
        f"with the cover's holes over them; the closed cover squeezes it to {high:.3g} mm, so it follows "
        "what these stand higher or lower by their processes' tolerances"
        for high in highs
    ]


def _shrinkage(design: Design, closed: ClosedMold) -> str:
    part, cavity = skin_part(design).volume, closed.first(PartRole.SKIN).volume
    share = 100 * shrinkage(design)
    return (
        f"Shrinkage: {share:.3g} % in length, so a skin of {part / 1000:.4f} cm³ comes from a cavity of "
        f"{cavity / 1000:.4f} cm³."
    )


def _tip(design: Design) -> str:
    """What goes into the gate: the luer slip itself where it seats, or the widest blunt tip that fits."""
    wide = gate(design)
    if wide is None:
        return ""
    if LUER[0] <= wide <= LUER[1]:
        return "a syringe whose luer slip seats in the gate, a plug for the gate, "
    fits = [f"a blunt tip of {n} gauge ({d:g} mm)" for n, d in TIPS.items() if d + TIP_PLAY <= wide]
    what = fits[0] if fits and wide < LUER[0] else f"a tube of {wide - TIP_PLAY:g} mm"
    return f"a syringe with {what} for the gate, a plug for the gate, "


def mixing(material: Silicone, total: float) -> tuple[str, str]:
    """Return as words what to weigh for `total` g of a silicone, and its pot life and cure."""
    parts = f"mix {total:.4g} g by its data sheet"
    if material.mix:
        a, b = (total * share / sum(material.mix) for share in material.mix)
        parts = f"weigh {a:.4g} g of A and {b:.4g} g of B, {total:.4g} g"
    pot = f"{material.pot_life_min:g} min" if material.pot_life_min else "by its data sheet"
    return parts, f"Pot life {pot}; cure {cure_words(material)}."


def cure_words(material: Silicone) -> str:
    """Return as words how long a silicone cures, and how warm."""
    cure = f"{material.cure_h:g} h" if material.cure_h else "by its data sheet"
    warm = "room temperature" if material.cure_c is None else f"{material.cure_c:g} °C"
    return f"{cure} at {warm}"


def _mix(material: Silicone, volume: float) -> list[str]:
    grams = volume * material.density * 1e-6
    parts, times = mixing(material, grams + DEAD_VOLUME)
    return [
        "## Silicone",
        "",
        f"{markdown_text(material.name)}, {material.density:g} kg/m³; the mold takes "
        f"{volume / 1000:.4g} cm³, {grams:.4g} g.",
        f"With {DEAD_VOLUME:g} g more for cup and syringe: {parts}.",
        times,
        "",
    ]


def _order(design: Design, closed: ClosedMold) -> list[str]:
    back = (
        "its holes widen upward and hold the skin like rivets"
        if perforated(closed)
        else "prime its lower face for silicone, or the skin comes off"
    )
    close = [
        preparation(design, closed),
        *cleanliness_steps(design, closed),
        ("End a has the gate. " if gate(design) else "")
        + f"Put release agent on {release_agent_places(design)}",
        *([] if lap(design) else preparation_steps(design)),
        *_closing_steps(design, closed, back),
        f"Lay the mold level to cure, {cure_words(silicone(design))}. Top up the reservoir over the vent "
        "while "
        "the mix still flows: it makes up for shrinkage and for bubbles that rise.",
    ]
    leave = [step.words for step in opening_steps(design, closed)]
    steps = [f"{i}. {text}" for i, text in enumerate([*close, *leave], 1)]
    return ["## In this order", "", *steps, ""]


def _closing_steps(design: Design, closed: ClosedMold, back: str) -> list[str]:
    """How the cleaned parts are put together and filled."""
    if design.skin.curvature_radius_y is not None:
        return close_steps(design, closed, back)
    return [
        "Bolt the end plates to the cavity"
        + (f": {comb_step(design)}" if skin_of(design).slot is not None else "."),
        *(_by_syringe if gate(design) else _open)(design, back),
    ]


def _fasteners(design: Design) -> str:
    """What holds the cover down while silicone is filled in and cures."""
    return "clamps" if is_clamped(scaled_for_shrinkage(design)) else "bolts"


def _by_syringe(design: Design, back: str) -> list[str]:
    return [
        f"Lay the carrier on its ledge ({back}), then the foam, cover and {_fasteners(design)}.",
        f"{DEGAS} Raise end b by {design.mold.pour_tilt:g} degrees, fill slowly through the gate at "
        "end a, and tape each bleed as silicone shows in it, until silicone stands in the reservoir."
        + filling_time_words(design),
        "Plug the gate or leave the syringe in it: it is the lowest point.",
    ]


def _open(design: Design, back: str) -> list[str]:
    inserts = "shims" if design.mold.method == "shim" else "strips"
    return [
        f"{DEGAS} Lay the mold level and pour in a thin stream along one side, until the silicone "
        f"stands a little above the ledge; pierce any bubbles left on ridges and {inserts}."
        + filling_time_words(design),
        f"Raise end b by {design.mold.pour_tilt:g} degrees. Set the carrier down at end a first and lower it "
        f"slowly onto its ledge, so that it drives the air towards end b ({back}).",
        f"Lay on the foam, cover and {_fasteners(design)}; silicone rises in the bleeds and in the "
        "reservoir. "
        "Fill up through the reservoir.",
    ]


def _findings(closed: ClosedMold, findings: list[Finding]) -> list[str]:
    notes = [f"- {markdown_text(str(finding))}" for finding in findings]
    if perforated(closed):
        notes.append("- The carrier is held by rivets of silicone: give it a light pull test before use.")
    return ["## Watch", "", *notes, ""]
