"""The casting sheet: the steps from the printed parts to the cast skin."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from skincad.base.reading import markdown_text
from skincad.base.version import __version__
from skincad.fabrication.bores import (
    PINNED,
    THREADED,
    cover_screws,
    dowels,
    end_screws,
    is_pressed,
    process_of,
    thread,
)
from skincad.fabrication.electrodes import fan_out_steps, past_tabs
from skincad.fabrication.estimates import ProcessEstimate, lines
from skincad.fabrication.filling import perforated, single_skin_mold, void
from skincad.fabrication.finding import Finding, counted
from skincad.fabrication.inspection import Inspection, inspection_lines
from skincad.fabrication.mounting import cleanliness_steps, screws_to_buy
from skincad.fabrication.part_drawing import process_words
from skincad.fabrication.rules import coating
from skincad.fabrication.strip_rules import lap
from skincad.fabrication.strip_steps import (
    DEGAS,
    arcs_to_buy,
    bent_screws,
    bonding_kit,
    close_steps,
    comb_step,
    curing_steps,
    drawing_step,
    filling_time_words,
    gluing_steps,
    leave_steps,
    preparation_steps,
    pull_test_steps,
    release_agent_places,
    release_steps,
    to_buy,
    under_heads,
)
from skincad.inputs.catalog import display_name
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.silicone import Silicone
from skincad.shape.skin import section, skin_of
from skincad.solids.cavity import split_ridges
from skincad.solids.ends import gate
from skincad.solids.fasteners import BEARING, TAP_RADIUS, WASHER, run_out_room, torque
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import (
    MOST_BOW,
    SEAL_PLAY,
    SHEETS,
    SQUEEZED_SHARE,
    STOCK,
    bow,
    cavity_process,
    end_process,
    fits,
    is_clamped,
    layout,
    lid_process,
    stack_error,
    thick_enough,
)
from skincad.solids.mold import ClosedMold, Move, mold
from skincad.solids.plan import END_PLATES, CutRole, Part, PartRole, Prism, bores
from skincad.solids.shrinkage import scaled_for_shrinkage, shrinkage
from skincad.solids.skin import skin_part


def preparation(design: Design, closed: ClosedMold) -> str:
    """Return how the made parts become a mold: degreased, sealed, threaded, pinned, tried, the carrier
    weighed."""
    parts = [part for part in closed.parts if part.made == "made"]
    steps = [*_sealing(design, parts), *_threading(design, parts), *_pinning(parts), _dry_fit(design)]
    last = "Weigh the carrier and write it down: the inspection takes it off the skin's mass."
    return " ".join([*steps, "Degrease all parts and let them dry.", last])


def _sealing(design: Design, parts: list[Part]) -> Iterator[str]:
    """What keeps a resin from stopping the silicone's cure."""
    if not silicone(design).platinum_cure:
        return
    names = [part.name for part in parts if process_of(design, part).inhibits_platinum]
    coats = {coating(design, process_of(design, part)) for part in parts} - {0.0}
    if names:
        which = "all parts" if len(names) == len(parts) else _listed(names)
        seal = "".join(f", then seal with a coat of {coat:g} mm" for coat in sorted(coats))
        yield f"Wash, post-cure and bake {which} by the resin's data sheet{seal}."


def _threading(design: Design, parts: list[Part]) -> Iterator[str]:
    """Threads by what brings them: the tap, or an insert."""
    where: dict[str, list[str]] = {}
    for part in parts:
        for role in sorted(THREADED, key=lambda role: role.name):
            if bores(part, role):
                names = where.setdefault(thread(design, part, role), [])
                names += [part.name] * (part.name not in names)
    for what, names in where.items():
        kind, _, how = what.partition(" insert, ")
        if how:
            yield f"Set the {kind} inserts ({how}) into {_listed(names)}."
            continue
        name, _, deep = what.partition(" x ")
        yield f"Tap the {name} threads of {_listed(names)}" + (f", {deep} mm deep (mount)." if deep else ".")


def _pinning(parts: list[Part]) -> Iterator[str]:
    """Where the pins are pressed in."""
    roles = sorted(PINNED, key=lambda role: role.name)
    names = [p.name for p in parts if any(is_pressed(p, role) and bores(p, role) for role in roles)]
    if names:
        yield f"Press the dowel pins into {_listed(names)}."


def _dry_fit(design: Design) -> str:
    """What must fit before silicone is mixed."""
    slot = skin_of(design).slot
    fits = ["end plates and cover slide onto their pins", "the carrier drops onto its ledge"]
    if slot is not None and design.mold.method == "shim":
        fits.append("each shim drops into its notches by itself")
    elif slot is not None and design.film is not None:
        fits.append("a spare strip drops into each notch by itself")
    return f"Try, dry: {_listed(fits)}."


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]


class OpeningStep(NamedTuple):
    """A step of opening: the sheet's words, and the moves that it makes; none where nothing leaves yet."""

    words: str
    moves: tuple[Move, ...]


def opening_steps(design: Design, closed: ClosedMold) -> list[OpeningStep]:
    """Return the steps by which a cured skin comes out of its mold, in order; together they make each move of
    `closed.opening` once."""
    by: dict[str, list[Move]] = {"shims": [], "ends": [], "lid": [], "skin": []}
    for move in closed.opening:
        role = closed.part(move.parts[0]).role
        known = {PartRole.SHIM: "shims", PartRole.COVER: "lid", **dict.fromkeys(END_PLATES, "ends")}
        by[known.get(role, "skin")].append(move)
    shims, straight = tuple(by["shims"]), design.skin.curvature_radius_y is None
    first = _without_moves(release_steps(design) if lap(design) is None else preparation_steps(design))
    drawn_in = (
        [*_without_moves(gluing_steps(design)), OpeningStep(drawing_step(design), shims)] if shims else []
    )
    drawn_in += _without_moves(curing_steps(design))
    out, proof = (
        OpeningStep(_skin_removal_words(design, closed), tuple(by["skin"])),
        _without_moves(pull_test_steps(design)),
    )
    led = _without_moves(fan_out_steps(design))
    if not straight:
        removal = map(OpeningStep, leave_steps(closed), (tuple(by["lid"]), tuple(by["ends"])))
        return [*first, *drawn_in, *removal, out, *proof, *led]
    ends, lid = map(OpeningStep, _removal_words(design), (tuple(by["ends"]), tuple(by["lid"])))
    if lap(design) is None:  # cast in, or no film
        return [*first, ends, *drawn_in, lid, out, *proof, *led]
    return [*first, ends, *drawn_in, *proof, lid, out, *led]


def _without_moves(lines: list[str]) -> list[OpeningStep]:
    """Steps in which no part leaves the mold."""
    return [OpeningStep(words, ()) for words in lines]


def _removal_words(design: Design) -> list[str]:
    """How end plates and cover come off; the cover holds skin and carrier until the shims are out."""
    slides, tabs = "along y,", ""
    if skin_of(design).slot is not None:
        cast_in = design.mold.method == "cast-in" and design.film
        tabs = f" {past_tabs(design)}" if cast_in else ""
        slides += " over the strips," if cast_in else " over the shims (hold these back by their other ends),"
    fasteners = "clamps" if is_clamped(scaled_for_shrinkage(design)) else "bolts"
    return [
        "Take the end plates' bolts out; the cover stays on. "
        + ("Cut the sprue at the gate, and slide" if gate(design) else "Slide")
        + f" the end plates off {slides} with a screwdriver in the notches at their sides.{tabs}",
        f"Take the cover's {fasteners} off and lift it where it overhung the end plates, with the foam; the "
        "silicone in the reservoir and the bleeds tears off, or is cut flush.",
    ]


def _skin_removal_words(design: Design, closed: ClosedMold) -> str:
    """How the skin and its cavity part."""
    carrier = closed.first(PartRole.CARRIER)
    pulls, mount = bores(carrier, CutRole.PULL), bores(carrier, CutRole.MOUNT)
    other = "by two screws in its mount's threads" if mount else "from its two ends"
    how = "by two M3 screws in its blind holes" if pulls else other
    if not split_ridges(design):
        return f"Pull the carrier up {how}; the skin comes out of the cavity with it. Cut the flash there."
    return (
        f"Hold the carrier {how} and draw the base plate off downward. Tilt the two outer pieces of the "
        "cavity off along the outermost splits, then draw the pieces between out of the valleys, each along "
        "its own ridges. Cut the flash at the carrier; that on the split crowns must be thin: wipe it off, "
        "don't cut into a crown."
    )


def closing_findings(design: Design, closed: ClosedMold | None = None) -> Iterator[Finding]:
    """Yield the warnings `cover bow` and `closing stack`, and the note `thread run-out`.

    A cover of a given thickness bows by more than `MOST_BOW` mm under 10 kPa. Carrier and keepers may stand
    so high or low that no seal both lets the cover lie on the cavity's walls and holds them down. A doubly
    curved mold may have too narrow a top for a seal, or too little thread. `closed` saves its planning.
    """
    cast = scaled_for_shrinkage(design)
    place, _ = layout(cast, section(cast))
    modulus = lid_process(design).part_modulus
    measured = bow(place.spans, place.lid, modulus)
    if measured > MOST_BOW * (1 + 1e-9):
        remedy = (
            f"mold.cover of {thick_enough(place.spans, modulus, STOCK):g} mm, or a stiffer mold.lid_process"
        )
        yield Finding(
            rule="cover bow",
            where="cover, under 10 kPa",
            measured=measured,
            limit=MOST_BOW,
            unit="mm",
            severity="warning",
            remedy=remedy,
        )
    off, most, where = (
        stack_error(cast, place.spans, place.lid),
        SEAL_PLAY * SHEETS[-1],
        "carrier and keepers, under the ",
    )
    bent = design.skin.curvature_radius_y is not None
    closed = (closed or mold(design)) if bent else closed
    if closed and bent and not closed.of(PartRole.SEAL):
        remedy = "lap the carrier's top until the cover lies on the cavity, or make the skin longer, or its "
        remedy += "curvature_radius_y larger, so that the narrow top has room for a seal"
        yield Finding(
            rule="closing stack",
            where=where + "cover, without a seal",
            measured=off,
            limit=0.0,
            unit="mm",
            severity="warning",
            remedy=remedy,
        )
    elif off > most:
        remedy = "finer processes, or a thicker mold.cover"
        yield Finding(
            rule="closing stack",
            where=where + "seal",
            measured=off,
            limit=most,
            unit="mm",
            severity="warning",
            remedy=remedy,
        )
    if closed and bent:
        yield from _run_outs(design, closed)


def _run_outs(design: Design, closed: ClosedMold) -> Iterator[Finding]:
    """A note where the holes of both ends meet before a tap's lead has room: no screw is short enough."""
    screws, process = end_screws(design, closed), cavity_process(design)
    deep = min(bore.length for bore in bores(closed.first(PartRole.CAVITY), CutRole.END_THREAD))
    left = deep + design.mold.end_plate + screws.washers * WASHER - screws.length
    if screws.bottoming and left < run_out_room(process) - 1e-9:
        remedy = "finish these threads by a bottoming tap, as the casting sheet says, or make the skin longer"
        where = "screws of the end plates, from tip to the hole's end"
        yield Finding(
            rule="thread run-out",
            where=where,
            measured=left,
            limit=run_out_room(process),
            unit="mm",
            severity="note",
            remedy=remedy,
        )


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
