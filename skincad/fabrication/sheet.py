"""The casting sheet: the steps from the printed parts to the cast skin."""

from __future__ import annotations

import math
from collections.abc import Iterator

from skincad.base.reading import markdown_text
from skincad.base.version import __version__
from skincad.fabrication.casting_steps import (
    PRIMER,
    PRIMER_MIN,
    arcs_to_buy,
    bent_screws,
    close_steps,
    comb_step,
    opening_steps,
    preparation_steps,
    release_agent_words,
    to_buy,
    under_heads,
)
from skincad.fabrication.day_plan import day_plan_lines
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
from skincad.fabrication.filling import perforated
from skincad.fabrication.inspection import Inspection, inspection_lines
from skincad.fabrication.job import Job
from skincad.fabrication.papers import listed
from skincad.fabrication.part_drawing import process_words
from skincad.fabrication.pouring import (
    DEAD_VOLUME,
    USUAL_C,
    batch,
    brushing_steps,
    cure_words,
    filling_words,
    mixing,
    mixing_step,
    poured_volume,
)
from skincad.fabrication.printing import PrintPlate, lapping_words, print_plates, print_settings
from skincad.fabrication.rules import Finding, coating, counted
from skincad.fabrication.shopping import consumables
from skincad.fabrication.strips import BOND_STRENGTH, GRAVITY, lap
from skincad.inputs.catalog import display_name
from skincad.solids.fasteners import BEARING, TAP_RADIUS, torque
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import SQUEEZED_SHARE, fits
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import END_PLATES, CutRole, Part, PartRole, Prism, bores

RIVET_STRAIN = 0.5  # assumption: of a rivet's neck under the test, well below what breaks silicone
BOND_SHARE = 1 / 3  # assumption: of the least bond worth having, on a primed back
POST_CURE = (80, 2, 100, 1)  # C and h, source: silicone makers' technical bulletins, in this order
POST_CURE_STIFFER = 0.05  # assumption: by which it raises E; bars of one's own batch tell (fit-material)
# assumption, as resin makers' guides have it: two baths, drying, ultraviolet light, baking; data sheets count
BATHS, BATH_MIN, DRYING_MIN, LIGHT_MIN, BAKING_H, BAKING_C = 2, 5, 30, 30, 4, 60


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
        *_parts(job, estimates, findings),
        *_mix(job),
        *_order(job),
        *day_plan_lines(job),
        *_record(job),
        "## Watch",
        "",
        *(f"- {markdown_text(str(finding))}" for finding in findings),
        f"- {pull_off_words(job)}",
        "",
        *(inspection_lines(inspected) if inspected else []),
    ]
    return "\n".join(lines) + "\n"


def _prints(job: Job, findings: list[Finding]) -> list[str]:
    """The slicer's settings, and which parts lie on which plate."""
    by_process: dict[str, list[PrintPlate]] = {}
    for plate in print_plates(job):
        by_process.setdefault(plate.process, []).append(plate)
    rows = []
    for name, found in by_process.items():
        supports = any(f.rule == "overhang" and f.where.endswith(f"by {name}") for f in findings)
        on = "; ".join(f"{p.file}: {', '.join(spot.name for spot in p.spots)}" for p in found)
        rows += [f"Print by {name}: {print_settings(job.processes[name], supports)}. Plates: {on}.", ""]
    return rows


def _parts(job: Job, estimates: tuple[ProcessEstimate, ...], findings: list[Finding]) -> list[str]:
    made_parts = (p for p in job.closed.parts if p.made == "made")
    rows = [f"| {p.name} | {process_words(job, p)} | {p.volume / 1000:.5g} |" for p in made_parts]
    lengths = ", ".join(f"{count} of at most {size:g} mm" for size, count in dowels(job.closed).items())
    bought = [
        *_bolts(job),
        *_seal(job.closed),
        f"dowel pins of {2 * PIN_RADIUS:g} mm: {lengths}; {_reamed(job)}",
    ]
    bought += (arcs_to_buy if job.bent else to_buy)(job)
    bought += [*screws_to_buy(job), *(need.words for need in consumables(job))]
    return [
        "## Parts",
        "",
        "| part | made by | cm³ |",
        "|---|---|---|",
        *rows,
        "",
        *([" ".join(["Estimates.", *lines(job, estimates)]), ""] if estimates else []),
        *_prints(job, findings),
        _shrinkage(job),
        "",
        "To buy:",
        "",
        *(f"- {row}" for row in bought),
        "",
    ]


def _reamed(job: Job) -> str:
    """How pin holes are finished."""
    printed = [
        name for name, part in (("cavity", job.cavity_process), ("cover", job.lid_process)) if part.layer
    ]
    if not printed:
        return "their holes come reamed from the shop"
    return (
        f"ream the holes of the printed {listed(printed)} that they are pressed into to {2 * PIN_RADIUS:g} "
        "mm (H7); in the end plates and the cavity's top they slide"
    )


def _bolts(job: Job) -> list[str]:
    """What holds the mold together, as the parts have it."""
    holes, process = fits(job.design, job.design.mold.process), job.cavity_process
    hold = f"{holes.insert} inserts in holes of {2 * holes.thread:g} mm" if holes.insert else "tapped holes"
    upper = "two clamps that hold the cover down on the cavity"
    if (lid := cover_screws(job)) is not None:
        kind = "studs, DIN 976, with a nut each" if lid.rod else "screws, ISO 4762"
        upper = f"M3 {kind}: {lid.pieces} M3 x {lid.length:g} for the cover, into {hold}"
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
    if ends.nuts > ends.pieces or (ends.nuts and not ends.rod):
        where = f"with nuts, {sunk} of them sunk in end plate b"
    kind = "bolts, ISO 4762"
    if ends.rod:
        kind = f"studs, DIN 976, with a nut {'each' if ends.nuts == ends.pieces else 'at both ends'}"
    return [f"M3 {kind}: {ends.pieces} M3 x {ends.length:g} along y, {where}", upper, tight]


def _seal(closed: ClosedMold) -> list[str]:
    """The foam under the cover, as it is bought and as it lies."""
    highs = [s.body.high - s.body.low for s in closed.of(PartRole.SEAL) if isinstance(s.body, Prism)]
    return [
        f"closed-cell EVA foam, a sheet of {high / SQUEEZED_SHARE:.3g} mm, cut by drawings/seal.dxf to "
        "carrier and end plates "
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


def _mix(job: Job) -> list[str]:
    material, volume = job.silicone, poured_volume(job)
    parts, times = mixing(material, batch(job))
    return [
        "## Silicone",
        "",
        f"{markdown_text(material.name)}, {material.density:g} kg/m³; the mold takes "
        f"{volume / 1000:.4g} cm³, {volume * material.density * 1e-6:.4g} g.",
        f"With {DEAD_VOLUME:g} g more for cup and syringe: {parts}.",
        times,
        *_post_cure(job),
        "",
    ]


def _post_cure(job: Job) -> list[str]:
    """An option after the cure, before any film is in."""
    warm, hours, hot, more = POST_CURE
    if lap(job) is None and job.design.film is not None:
        return []  # film is in the mold, and loses its charge
    resin = any(job.process(p).layer for p in job.closed.parts if p.made == "made")
    out = " out of its printed mold" if resin else ""
    last = ", before films go in" if job.design.film is not None else ""
    return [
        f"An option: post-cure the skin{out}{last}, {hours} h at {warm} °C and {more} h at {hot} °C. It "
        f"drives out residues and raises E by about {100 * POST_CURE_STIFFER:.0f} % (assumption: a bar of "
        "the same batch tells), and so all forces of the verdict by as much."
    ]


def _order(job: Job) -> list[str]:
    riveted = perforated(job.closed)
    back = "its holes widen upward and hold the skin like rivets" if riveted else "its primed face down"
    close = [
        preparation(job),
        *cleanliness_steps(job),
        *([] if riveted else [_priming()]),
        ("End a has the gate. " if job.gate else "") + release_agent_words(job),
        *([] if lap(job) else preparation_steps(job)),
        *_closing_steps(job, back),
        f"Lay the mold level to cure, {cure_words(job.silicone)}. Top up the reservoir over the vent while "
        "the mix still flows: it makes up for shrinkage and for bubbles that rise. Pour what is left in the "
        "cup beside it as a puck, 5 mm thick. Don't open the mold before the puck is dry and springs back "
        "under a finger.",
    ]
    leave = [step.words for step in opening_steps(job)]
    trial = _trial(job)
    steps = [f"{i}. {text}" for i, text in enumerate([*trial, *close, *leave], 1 - len(trial))]
    return ["## In this order", "", *steps, ""]


def pull_off(job: Job) -> float:
    """Return the pull, N, that shows that the carrier holds the skin: on the necks of its rivets, or on its
    primed face."""
    necks = bores(job.closed.first(PartRole.CARRIER), CutRole.RIVET)
    if necks:
        area = math.fsum(math.pi * bore.radius**2 for bore in necks)
        return area * job.silicone.young_modulus.value * RIVET_STRAIN
    return (
        BOND_SHARE * BOND_STRENGTH * job.design.skin.width * job.design.skin.length * job.design.mold.cavities
    )


def pull_off_words(job: Job) -> str:
    """Return how it is tested that the carrier holds the skin."""
    how = "its rivets of silicone" if perforated(job.closed) else "its primed face"
    force = pull_off(job)
    return (
        f"The carrier holds by {how}. Before use, hold the skin by its sides and pull the carrier off it "
        f"with {force:.2g} N ({1000 * force / GRAVITY:.3g} g) for 10 s: no edge may lift."
    )


def _record(job: Job) -> list[str]:
    """A table that goes with the part: what nobody can tell afterwards."""
    material, total = job.silicone, batch(job)
    weighed = [("mixed", total)]
    if material.mix:
        weighed = [
            (f"{name}, g", total * part / sum(material.mix))
            for name, part in zip("AB", material.mix, strict=True)
        ]
    rows = [
        ("batch of the silicone, A and B", ""),
        ("date and name", ""),
        ("room, °C", f"{USUAL_C:g}"),
        *((name, f"{grams:.2f}") for name, grams in weighed),
        ("A met B at", ""),
        ("mold full at", ""),
        ("puck dry at", ""),
    ]
    lines = [f"| {what} | {nominal} | |" for what, nominal in rows]
    return ["## Record", "", "| what | nominal | as it was |", "|---|---|---|", *lines, ""]


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
    mixed = [mixing_step(job), *brushing_steps(job)]
    closed = f"Lay the carrier on its ledge ({back}), then the foam, cover and {_fasteners(job)}."
    return [
        *([*mixed, closed] if len(mixed) > 1 else [closed, *mixed]),
        f"Raise end b by {job.design.mold.pour_tilt:g} degrees, fill slowly through the gate at "
        "end a, and tape each bleed as silicone shows in it, until silicone stands in the reservoir. "
        + filling_words(job),
        "Plug the gate or leave the syringe in it: it is the lowest point.",
    ]


def _open(job: Job, back: str) -> list[str]:
    inserts = "shims" if job.design.mold.method == "shim" else "strips"
    return [
        mixing_step(job),
        *brushing_steps(job),
        "Lay the mold level and pour in a thin stream along one side, until the silicone "
        f"stands a little above the ledge; pierce any bubbles left on ridges and {inserts}. "
        + filling_words(job),
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
    pinning = [f"Press the dowel pins into {listed(press_fits)}."] if press_fits else []
    lapping = [words] if (words := lapping_words(job)) else []
    steps = [*_sealing(job, parts), *lapping, *_threading(job, parts), *pinning, _dry_fit(job)]
    last = "Weigh the carrier and write it down: the inspection takes it off the skin's mass."
    return " ".join([*steps, "Degrease all parts and let them dry.", last])


def _sealing(job: Job, parts: list[Part]) -> Iterator[str]:
    """What keeps a resin from stopping the silicone's cure."""
    if not job.silicone.platinum_cure:
        return
    names = [part.name for part in parts if job.process(part).inhibits_platinum]
    coats = {coating(job, job.process(part)) for part in parts} - {0.0}
    if names:
        which = "all parts" if len(names) == len(parts) else listed(names)
        yield (
            f"Wash {which} in {BATHS} baths of isopropanol, {BATH_MIN} min each. Dry them for {DRYING_MIN} "
            f"min, cure them under ultraviolet light for {LIGHT_MIN} min and bake them for {BAKING_H} h at "
            f"{BAKING_C} °C; where the resin's data sheet says otherwise, that counts."
        )
        for coat in sorted(coats):
            yield f"Seal them with a coat of {coat:g} mm and let it cure."


def _trial(job: Job) -> list[str]:
    """A step before all others where something may spoil the cast: a ladder of notches for printed combs, and
    a drop on a resin that may keep the silicone from curing."""
    parts = [part for part in job.closed.parts if part.made == "made"]
    steps = [" ".join([*_notch_trial(job), *_drop_trial(job, parts)])]
    return steps if steps[0] else []


def _notch_trial(job: Job) -> Iterator[str]:
    """What shows that a printer's notches take the shims, before it prints combs."""
    combs = job.closed.of(PartRole.COMB)
    if not combs or not job.process(combs[0]).layer:
        return
    gap, name = job.design.core_thickness + 2 * job.design.mold.slit_clearance, job.maker(combs[0])
    insert = "shim" if job.design.mold.method == "shim" else "strip"
    yield (
        f"Trial of the notches: print the notch ladder of `skincad coupon {name}`. The {insert} must drop "
        f"into its notch of {gap:.3g} mm by itself. If it does not, enter what you measured as its sheet "
        "says, and make the mold again with that printer."
    )


def _drop_trial(job: Job, parts: list[Part]) -> Iterator[str]:
    if not list(_sealing(job, parts)):
        return
    coated = any(coating(job, job.process(part)) for part in parts)
    made = "washed, cured, baked and sealed" if coated else "washed, cured and baked"
    yield (
        f"Trial of the resin: print a small plate of it, {made} as in step 1. Put a "
        f"drop of mixed silicone on it. After {cure_words(job.silicone)} it must be dry to the finger, "
        "underneath too, and peel off. If it is sticky, stop: the mold would spoil the cast. Bake longer; "
        "or seal the parts and give the process that `coating`, so that notches and crests allow for it."
    )


def _priming() -> str:
    """How a plain carrier is made to hold the skin."""
    return (
        f"Prime the carrier's lower face: wipe it with isopropanol, brush {PRIMER} on it thinly, and let it "
        f"dry for {PRIMER_MIN} min. Nothing else holds the skin."
    )


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
            yield f"Set the {kind} inserts ({how}) into {listed(names)}."
            continue
        name, _, deep = what.partition(" x ")
        yield f"Tap the {name} threads of {listed(names)}" + (f", {deep} mm deep (mount)." if deep else ".")


def _dry_fit(job: Job) -> str:
    """What must fit before silicone is mixed."""
    slot = job.skin.slot
    fits = ["end plates and cover slide onto their pins", "the carrier drops onto its ledge"]
    if slot is not None and job.design.mold.method == "shim":
        fits.append("each shim drops into its notches by itself")
    elif slot is not None and job.design.film is not None:
        fits.append("a spare strip drops into each notch by itself")
    return f"Try, dry: {listed(fits)}."
