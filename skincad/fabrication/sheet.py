"""The casting sheet: the steps from the printed parts to the cast skin."""

from __future__ import annotations

import math
from collections.abc import Iterator

from skincad.base.reading import markdown_text
from skincad.base.version import __version__
from skincad.fabrication.casting_steps import (
    DEGAS,
    arcs_to_buy,
    bent_screws,
    bonding_kit,
    close_steps,
    comb_step,
    filling_time_words,
    opening_steps,
    preparation_steps,
    release_agent_places,
    to_buy,
    under_heads,
)
from skincad.fabrication.estimates import ProcessEstimate, lines
from skincad.fabrication.fasteners import (
    PINNED,
    THREADED,
    cleanliness_steps,
    cover_screws,
    dowels,
    end_screws,
    is_pressed,
    screws_to_buy,
    thread,
)
from skincad.fabrication.filling import perforated, void
from skincad.fabrication.inspection import Inspection, inspection_lines
from skincad.fabrication.job import Job
from skincad.fabrication.part_drawing import process_words
from skincad.fabrication.rules import Finding, coating, counted
from skincad.fabrication.strips import lap
from skincad.inputs.catalog import display_name
from skincad.inputs.silicone import Silicone
from skincad.solids.fasteners import BEARING, TAP_RADIUS, torque
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import SQUEEZED_SHARE, fits
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import END_PLATES, CutRole, Part, PartRole, Prism, bores

# mm, source: outer diameters of needle tubing by gauge (Birmingham wire gauge)
TIPS = {10: 3.40, 12: 2.77, 14: 2.11, 16: 1.65, 18: 1.27, 20: 0.91, 22: 0.72, 25: 0.51}
RIVETED = "- The carrier is held by rivets of silicone: give it a light pull test before use."
TIP_PLAY = 0.1  # mm, assumption: least play of a tip in the gate
LUER = (4.03, 4.48)  # mm, source: ISO 80369-7, male slip, largest at its end, and 7.5 mm of 6 % behind
DEAD_VOLUME = 8.0  # g, assumption: stays in cup and syringe; less can't be weighed or degassed well


def poured_volume(job: Job) -> float:
    """Return the volume that the silicone fills, mm3: skin, gate, vent and reservoir, the carrier's holes and
    their bleeds, and the flash in the gap round the carrier; for all skins of a gang, whose cover and seal
    are thicker than those of one."""
    spaces = void(job).spaces
    below = math.fsum(space.body.volume for space in spaces if space.beside is not PartRole.COVER)
    lids = job.closed.of(PartRole.COVER, PartRole.SEAL)
    over = [bore.volume for part in lids for bore in bores(part, CutRole.RESERVOIR, CutRole.BLEED)]
    return job.design.mold.cavities * below + math.fsum(over)


def casting_sheet(
    job: Job,
    findings: list[Finding],
    verdict: str,
    passed: bool,
    inspected: Inspection | None = None,
    estimates: tuple[ProcessEstimate, ...] = (),
) -> str:
    """Return the sheet as Markdown. `verdict` is the contact check's, `passed` that of the whole job,
    `inspected` what to measure on the skin, `estimates` what each process takes."""
    material = job.silicone
    summary = f"Mold: {counted(findings)}."
    if not passed:
        summary = f"**Don't make it yet.** {summary}"
    lines = [
        f"# Casting sheet: {display_name(job.design)}",
        "",
        f"{summary} {verdict}",
        "",
        f"Revision {job.design.revision} of the design, by skincad {__version__}.",
        "",
        *_parts(job, estimates),
        *_mix(material, poured_volume(job)),
        *_order(job),
        "## Watch",
        "",
        *(f"- {markdown_text(str(finding))}" for finding in findings),
        *([RIVETED] if perforated(job.closed) else []),
        "",
        *(inspection_lines(inspected) if inspected else []),
    ]
    return "\n".join(lines) + "\n"


def _parts(job: Job, estimates: tuple[ProcessEstimate, ...]) -> list[str]:
    made_parts = (p for p in job.closed.parts if p.made == "made")
    rows = [f"| {p.name} | {process_words(job, p)} | {p.volume / 1000:.5g} |" for p in made_parts]
    lengths = ", ".join(f"{count} of at most {size:g} mm" for size, count in dowels(job.closed).items())
    bought = [
        *_bolts(job),
        *_seal(job.closed),
        f"dowel pins of {2 * PIN_RADIUS:g} mm: {lengths}; ream the cavity's ends and the cover for a press "
        "fit, the end plates and the cavity's top for a sliding fit",
        f"release agent, {_tip(job)}tape for the bleeds, nitrile gloves (latex inhibits platinum silicone)",
    ]
    bought += (arcs_to_buy if job.bent else to_buy)(job)
    bought += [*screws_to_buy(job), *bonding_kit(job)]
    return [
        "## Parts",
        "",
        "| part | made by | cm³ |",
        "|---|---|---|",
        *rows,
        "",
        *([" ".join(["Estimates.", *lines(job, estimates)]), ""] if estimates else []),
        _shrinkage(job),
        "",
        "To buy:",
        "",
        *(f"- {row}" for row in bought),
        "",
    ]


def _bolts(job: Job) -> list[str]:
    """What holds the mold together, as the parts have it."""
    holes, process = fits(job.design, job.design.mold.process), job.cavity_process
    hold = f"{holes.insert} inserts in holes of {2 * holes.thread:g} mm" if holes.insert else "tapped holes"
    upper = "two clamps that hold the cover down on the cavity"
    if (lid := cover_screws(job)) is not None:
        upper = f"M3 screws, ISO 4762: {lid.pieces} M3 x {lid.length:g} for the cover, into {hold}"
        upper += under_heads(lid.washers)
    tightest = min(map(torque, (process, job.end_process, job.lid_process)))
    tight = (
        f"for all screws a torque of {tightest:g} N m, dry: 0.2 times 3 mm times the tension at which a head "
        f"presses on its part by {BEARING['plastic']:g} MPa (plastic) or {BEARING['metal']:g} MPa (metal)"
    )
    ends = end_screws(job)
    if job.bent:
        return [bent_screws(ends, hold), upper, tight]
    sunk = sum(cut.role is CutRole.NUT for p in job.closed.of(*END_PLATES) if p.end == "b" for cut in p.cuts)
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


def _shrinkage(job: Job) -> str:
    part, cavity = job.skin_part.volume, job.closed.first(PartRole.SKIN).volume
    share = 100 * job.shrinkage
    return (
        f"Shrinkage: {share:.3g} % in length, so a skin of {part / 1000:.4f} cm³ comes from a cavity of "
        f"{cavity / 1000:.4f} cm³."
    )


def _tip(job: Job) -> str:
    """What goes into the gate: the luer slip itself where it seats, or the widest blunt tip that fits."""
    wide = job.gate
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


def _order(job: Job) -> list[str]:
    back = (
        "its holes widen upward and hold the skin like rivets"
        if perforated(job.closed)
        else "prime its lower face for silicone, or the skin comes off"
    )
    close = [
        preparation(job),
        *cleanliness_steps(job),
        ("End a has the gate. " if job.gate else "") + f"Put release agent on {release_agent_places(job)}",
        *([] if lap(job) else preparation_steps(job)),
        *_closing_steps(job, back),
        f"Lay the mold level to cure, {cure_words(job.silicone)}. Top up the reservoir over the vent "
        "while "
        "the mix still flows: it makes up for shrinkage and for bubbles that rise.",
    ]
    leave = [step.words for step in opening_steps(job)]
    steps = [f"{i}. {text}" for i, text in enumerate([*close, *leave], 1)]
    return ["## In this order", "", *steps, ""]


def _closing_steps(job: Job, back: str) -> list[str]:
    """How the cleaned parts are put together and filled."""
    if job.bent:
        return close_steps(job, back)
    return [
        "Bolt the end plates to the cavity" + (f": {comb_step(job)}" if job.skin.slot is not None else "."),
        *(_by_syringe if job.gate else _open)(job, back),
    ]


def _fasteners(job: Job) -> str:
    """What holds the cover down while silicone is filled in and cures."""
    return "clamps" if job.clamped else "bolts"


def _by_syringe(job: Job, back: str) -> list[str]:
    return [
        f"Lay the carrier on its ledge ({back}), then the foam, cover and {_fasteners(job)}.",
        f"{DEGAS} Raise end b by {job.design.mold.pour_tilt:g} degrees, fill slowly through the gate at "
        "end a, and tape each bleed as silicone shows in it, until silicone stands in the reservoir."
        + filling_time_words(job),
        "Plug the gate or leave the syringe in it: it is the lowest point.",
    ]


def _open(job: Job, back: str) -> list[str]:
    inserts = "shims" if job.design.mold.method == "shim" else "strips"
    return [
        f"{DEGAS} Lay the mold level and pour in a thin stream along one side, until the silicone "
        f"stands a little above the ledge; pierce any bubbles left on ridges and {inserts}."
        + filling_time_words(job),
        f"Raise end b by {job.design.mold.pour_tilt:g} degrees. Set the carrier down at end a first and "
        f"lower it slowly onto its ledge, so that it drives the air towards end b ({back}).",
        f"Lay on the foam, cover and {_fasteners(job)}; silicone rises in the bleeds and in the "
        "reservoir. "
        "Fill up through the reservoir.",
    ]


def preparation(job: Job) -> str:
    """Return how the made parts become a mold: degreased, sealed, threaded, pinned, tried, the carrier
    weighed."""
    parts = [part for part in job.closed.parts if part.made == "made"]
    roles = sorted(PINNED, key=lambda role: role.name)
    press_fits = [p.name for p in parts if any(is_pressed(p, role) and bores(p, role) for role in roles)]
    pinning = [f"Press the dowel pins into {_listed(press_fits)}."] if press_fits else []
    steps = [*_sealing(job, parts), *_threading(job, parts), *pinning, _dry_fit(job)]
    last = "Weigh the carrier and write it down: the inspection takes it off the skin's mass."
    return " ".join([*steps, "Degrease all parts and let them dry.", last])


def _sealing(job: Job, parts: list[Part]) -> Iterator[str]:
    """What keeps a resin from stopping the silicone's cure."""
    if not job.silicone.platinum_cure:
        return
    names = [part.name for part in parts if job.process(part).inhibits_platinum]
    coats = {coating(job, job.process(part)) for part in parts} - {0.0}
    if names:
        which = "all parts" if len(names) == len(parts) else _listed(names)
        seal = "".join(f", then seal with a coat of {coat:g} mm" for coat in sorted(coats))
        yield f"Wash, post-cure and bake {which} by the resin's data sheet{seal}."


def _threading(job: Job, parts: list[Part]) -> Iterator[str]:
    """Threads by what brings them: the tap, or an insert."""
    where: dict[str, list[str]] = {}
    for part in parts:
        for role in sorted(THREADED, key=lambda role: role.name):
            if bores(part, role):
                names = where.setdefault(thread(job, part, role), [])
                names += [part.name] * (part.name not in names)
    for what, names in where.items():
        kind, _, how = what.partition(" insert, ")
        if how:
            yield f"Set the {kind} inserts ({how}) into {_listed(names)}."
            continue
        name, _, deep = what.partition(" x ")
        yield f"Tap the {name} threads of {_listed(names)}" + (f", {deep} mm deep (mount)." if deep else ".")


def _dry_fit(job: Job) -> str:
    """What must fit before silicone is mixed."""
    slot = job.skin.slot
    fits = ["end plates and cover slide onto their pins", "the carrier drops onto its ledge"]
    if slot is not None and job.design.mold.method == "shim":
        fits.append("each shim drops into its notches by itself")
    elif slot is not None and job.design.film is not None:
        fits.append("a spare strip drops into each notch by itself")
    return f"Try, dry: {_listed(fits)}."


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
