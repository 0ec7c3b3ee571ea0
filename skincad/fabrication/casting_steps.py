"""Steps of the casting sheet at which strips go in and the mold is opened: words, and the moves they make.

Films are cleaned, primed, laid in or drawn in behind their shims, cured in and tested. A doubly curved mold
has screws, shims as arcs and an order of its own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.fabrication.electrodes import fan_out_steps, past_tabs, strip_capacitance, tab
from skincad.fabrication.fasteners import Screws
from skincad.fabrication.job import Job
from skincad.fabrication.patterns import GLUED_LENGTH, arc_length, arc_radius, shim_length
from skincad.fabrication.pouring import brushing_steps, filling_words, mixing_step, small_batch, weights
from skincad.fabrication.strips import (
    GRAVITY,
    HIGHEST_FILM_TEMPERATURE,
    POT_SHARE,
    deflection,
    drawing_time,
    lap,
    placement_error,
    pull_test,
    release_strain,
    shim_bend,
    strip,
    strip_seconds,
    strips_per_mix,
    weight,
)
from skincad.inputs.skin_tables import Film
from skincad.solids.cavity import split_ridges
from skincad.solids.inserts import GRIP, drawing_end
from skincad.solids.layout import end_angle
from skincad.solids.mold import ClosedMold, Move
from skincad.solids.plan import END_PLATES, CutRole, PartRole, bores

NUMBERS = (
    "number 1 is at the left, seen from end a; nicks in the end plates' edges mark the ends: one at end a, "
    "two at end b, where the reservoir is"
)
TOWARDS = "towards the higher numbers in every slot"  # +x
PRIMER_MIN, PRIMER_H = 60, 8  # assumption: makers ask for 30 to 120 min to dry, and to use it the same day
PRIMER = "primer that bonds silicone to plastics and metal (silane or titanate type)"
PRIMER_ML = 0.02  # ml/cm2, assumption: a thin coat, most of which stays in the brush
GLUE_MIN = 10  # min, assumption: thin cyanoacrylate between metal and film, to full grip
THREAD_LENGTH = 0.3  # m, assumption: over a rod and tied twice
ALCOHOL_ML = 10.0, 0.5  # ml, assumption: spilt, and for each wipe
LOOK = (
    "Look at it under a lamp: no bubble in a crest, no tacky face, no flash on a crest. Any of these is a "
    "fault of the cast; a tacky face means that something kept the silicone from curing."
)


class OpeningStep(NamedTuple):
    """A step of opening: the sheet's words, and the moves that it makes; none where nothing leaves yet."""

    words: str
    moves: tuple[Move, ...]


def opening_steps(job: Job) -> list[OpeningStep]:
    """Return the steps by which a cured skin comes out of its mold, in order; together they make each move of
    `closed.opening` once."""
    by: dict[str, list[Move]] = {"shims": [], "ends": [], "lid": [], "skin": []}
    for move in job.closed.opening:
        role = job.closed.part(move.parts[0]).role
        known = {PartRole.SHIM: "shims", PartRole.COVER: "lid", **dict.fromkeys(END_PLATES, "ends")}
        by[known.get(role, "skin")].append(move)
    shims, straight = tuple(by["shims"]), not job.bent
    first = _without_moves(release_steps(job) if lap(job) is None else preparation_steps(job))
    drawn_in = [*_without_moves(gluing_steps(job)), OpeningStep(drawing_step(job), shims)] if shims else []
    drawn_in += _without_moves(curing_steps(job))
    out, proof = (
        OpeningStep(f"{_skin_removal_words(job)} {LOOK}", tuple(by["skin"])),
        _without_moves(pull_test_steps(job)),
    )
    led = _without_moves(fan_out_steps(job))
    if not straight:
        removal = map(OpeningStep, leave_steps(job.closed), (tuple(by["lid"]), tuple(by["ends"])))
        return [*first, *drawn_in, *removal, out, *proof, *led]
    ends, lid = map(OpeningStep, _removal_words(job), (tuple(by["ends"]), tuple(by["lid"])))
    if lap(job) is None:  # cast in, or no film
        return [*first, ends, *drawn_in, lid, out, *proof, *led]
    return [*first, ends, *drawn_in, *proof, lid, out, *led]


def _without_moves(lines: list[str]) -> list[OpeningStep]:
    """Steps in which no part leaves the mold."""
    return [OpeningStep(words, ()) for words in lines]


def _removal_words(job: Job) -> list[str]:
    """How end plates and cover come off; the cover holds skin and carrier until the shims are out."""
    slides, tabs = "along y,", ""
    if job.skin.slot is not None:
        cast_in = job.design.mold.method == "cast-in" and job.design.film
        tabs = f" {past_tabs(job.design)}" if cast_in else ""
        slides += " over the strips," if cast_in else " over the shims (hold these back by their other ends),"
    fasteners = "clamps" if job.clamped else "bolts"
    return [
        "Take the end plates' bolts out; the cover stays on. "
        + ("Cut the sprue at the gate, and slide" if job.gate else "Slide")
        + f" the end plates off {slides} with a screwdriver in the notches at their sides.{tabs}",
        f"Take the cover's {fasteners} off and lift it where it overhung the end plates, with the foam; the "
        "silicone in the reservoir and the bleeds tears off, or is cut flush.",
    ]


def _skin_removal_words(job: Job) -> str:
    """How the skin and its cavity part."""
    carrier = job.closed.first(PartRole.CARRIER)
    pulls, mount = bores(carrier, CutRole.PULL), bores(carrier, CutRole.MOUNT)
    other = "by two screws in its mount's threads" if mount else "from its two ends"
    how = "by two M3 screws in its blind holes" if pulls else other
    washed = ""
    if "cavity" in printed_parts(job):
        washed = " Wash the crests with soap and water, then isopropanol: release agent makes them slippery."
    if not split_ridges(job.design):
        out = f"Pull the carrier up {how}; the skin comes out of the cavity with it."
        return f"{out} Cut the flash there.{washed}"
    return (
        f"Hold the carrier {how} and draw the base plate off downward. Tilt the two outer pieces of the "
        "cavity off along the outermost splits, then draw the pieces between out of the valleys, each along "
        "its own ridges. Cut the flash at the carrier; that on the split crowns must be thin: wipe it off, "
        f"don't cut into a crown.{washed}"
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


def arcs_to_buy(job: Job) -> list[str]:
    """Return what to buy for the slots: shims cut as arcs, with the radius of each."""
    slot, radius = job.skin.slot, job.design.skin.curvature_radius_y
    if slot is None or radius is None:
        return []
    size = f"{slot.thickness:g} x {slot.depth:g} mm"
    arms = [f"{s.feature} {s.side} {arc_radius(job, s.feature, s.side):.2f}" for s in job.section.slots]
    strain, joint, film = 100 * shim_bend(job), lap(job), job.design.film
    thin = ""
    if joint is not None and film is not None and joint.tail < slot.thickness:
        thin = (
            f", the last {GRIP:g} mm at end {film.wiring_side} thinned to {joint.tail:.3f} mm (etched or "
            "stoned, by micrometer), so that film and shim, glued, pass the notches together"
        )
    return [
        f"{len(arms)} shims of spring steel, {size}, {math.ceil(arc_length(job.closed))} mm long, cut or "
        f"etched as arcs from sheet by film/shims.dxf, deburred{thin}; "
        f"straight stock bent on edge is strained by {strain:.2g} % and buckles between its combs. Radius "
        f"at mid-depth, mm, by ridge and slot: {', '.join(arms)}"
    ]


def close_steps(job: Job, back: str) -> list[str]:
    """Return how the mold is closed and filled, after cleaning."""
    combs, brushed = [], brushing_steps(job)
    if job.skin.slot is None:
        ends = f"Lay the carrier on its ledge ({back}); the end plates lean over it and are screwed on next."
    else:
        combs = [
            "Screw both combs to the cavity's ends. Lay each shim into its notches, its hollow side up and "
            f"{GRIP:g} mm out at both ends."
        ]
        ends = (
            f"Lay the carrier on its ledge ({back}). Then the keepers, which "
            "lean over it: pressed down onto the combs while you tighten."
        )
    rise, tilt = math.degrees(end_angle(job.design)), job.design.mold.pour_tilt
    both = (
        "; end a leans by more than that, so its air leaves slowly, through the gap round the carrier"
        if tilt <= rise
        else ""
    )
    closed = [ends, f"{'Then the foam, cover' if job.closed.of(PartRole.SEAL) else 'Cover'} and bolts."]
    mixed = [mixing_step(job), *brushed]
    return [
        *combs,
        *([*mixed, *closed] if brushed else [*closed, *mixed]),
        f"Raise end b by {tilt:g} degrees (both ends lean by {rise:.3g}{both}). Fill slowly "
        "through the gate at end a, and tape each bleed as silicone shows in it, until silicone stands in "
        f"the reservoir. {filling_words(job)}",
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


def to_buy(job: Job) -> list[str]:
    """Return what to buy to keep the slots of a skin free that is straight along y."""
    slot = job.skin.slot
    if slot is None or job.design.mold.method == "cast-in":
        return []
    size = f"{slot.thickness:g} x {slot.depth:g} mm"
    return [
        f"{strip_count(job)} shims of spring steel, {size}, {shim_length(job)} mm long: "
        "slit or "
        "etched from feeler stock, edges deburred"
    ]


def comb_step(job: Job) -> str:
    """Return how the notches are filled before the keepers are put on."""
    rod = strip(job)
    if rod is None or job.design.mold.method == "shim":
        return (
            f"combs first; lay the shims into the notches, {GRIP:g} mm out at both ends, and pull them "
            "straight; then the keepers, pressed down onto the combs while you tighten."
        )
    load = weight(rod, job.silicone.density)
    return (
        "combs first. Lay each strip, primed and dry, into its notches, + "
        f"side {TOWARDS} ({NUMBERS}). Tie a thread to each tab's hole, lead it along y over a rod that lies "
        "a little below the notches on one board with the mold, so that the strip stays upright, and hang "
        f"{rod.hung:.3g} g on each ({rod.tension:.3g} N, {rod.stress:.3g} MPa): it stands on the notches' "
        f"bottoms, its datum, and is within {placement_error(job):.2g} mm of its place; in silicone it "
        "sags by "
        f"{abs(deflection(rod, load)):.2g} mm at most. Then the keepers, pressed down onto the combs while "
        "you tighten. The weights hang until the silicone has cured."
    )


def release_steps(job: Job) -> list[str]:
    """Return what is done with strips that are cast in before the mold is opened; nothing where none is."""
    if job.design.mold.method != "cast-in" or job.design.film is None:
        return []
    return [
        "Take the weights off and cut off at the strips' marks what they hung on; the tabs with pads, "
        f"number and + sign stay. The skin shortens by {100 * release_strain(job):.2g} %, "
        "when the strips are released."
    ]


def strip_count(job: Job) -> int:
    """Return how many strips go into the skins of a mold."""
    skin = job.skin
    return 2 * skin.count * job.design.mold.cavities if skin.slot else 0


def printed_parts(job: Job) -> list[str]:
    """Return which parts of the mold need release agent: printed ones; silicone leaves metal by itself."""
    made = {"cavity": job.cavity_process, "end plates": job.end_process, "cover": job.lid_process}
    return [name for name, process in made.items() if process.layer]


def release_agent_words(job: Job) -> str:
    """Return where release agent goes, and what it is kept from, so that films hold."""
    printed, film = printed_parts(job), job.design.film is not None
    clean = (
        " Wipe each shim twice with "
        "isopropanol, each time with a fresh wipe, and touch it by its ends from now on. Test that on a "
        "piece of the stock: water must spread, not bead (water-break test)."
    )
    kept = ["none on the carrier"]
    if film and job.inserts:
        kept.append(
            "none on the shims: it would stay on the slots' walls, and no film would hold"
            if job.inserts == "shims"
            else "none on the strips, which would not hold"
        )
    elif job.inserts == "shims":
        printed = [*printed, "shims"]
    if job.inserts:
        kept.append("none in the notches")
    after = clean if film and job.inserts == "shims" else ""
    if not printed:
        return (
            f"Use no release agent: silicone leaves metal by itself, and crests copy what lies on it.{after}"
        )
    where = printed[0] if len(printed) == 1 else f"{', '.join(printed[:-1])} and {printed[-1]}"
    return (
        f"Put release agent for silicone on {where} with a brush, wipe it thin and let it dry; "
        f"{'; '.join(kept)}.{after}"
    )


def masked_length(job: Job) -> float:
    """Return how much of lead and tab is masked while a strip is drawn in, mm: no mask passes a notch."""
    if job.design.film is None:
        return 0.0
    bent, lead = job.bent, job.lead
    return tab(job.design.film)[1] + (max(0.0, lead - job.design.mold.end_plate) if bent else lead)


def preparation_steps(job: Job) -> list[str]:
    """Return how strips are cleaned, masked and primed; nothing without film."""
    film = job.design.film
    if film is None:
        return []
    if lap(job) is None:
        when, rest = "Make", "between their marks"
        masked = "the lead and both tabs (write number and + side on a tab first) while you prime, and take "
        masked += "it off before they are laid in"
    else:
        when, rest = (
            "Late in the cure, make",
            f"up to the cut-off mark: the {GLUED_LENGTH:g} mm beyond are glued",
        )
        masked = f"the last {masked_length(job):g} mm of the wired end (end {film.wiring_side})"
        masked += ", where it stays for now, its number and + side written on it"
    return [
        f"{when} the film strips ready ({1000 * film.thickness:.0f} µm, numbered in film/strips.dxf). "
        f"{_plus_face(film)} Wipe "
        "both faces with isopropanol on a lint-free wipe; from now on touch them by their ends. Fold "
        f"low-tack tape with acrylic adhesive over {masked}: what is contacted later must stay free of "
        f"primer and silicone. Brush primer thinly onto both faces, {rest}. It dries in {PRIMER_MIN} min "
        "at 20 to 25 °C and 40 % humidity or more; where its data sheet says otherwise, that counts. Use "
        f"the strips within {PRIMER_H} h."
    ]


def _plus_face(film: Film) -> str:
    """How the + face of bought film is found: it goes positive as the film is pulled along its draw axis."""
    way = "up" if film.d31 > 0 else "down"
    return (
        "Find the + face on an offcut before you cut: clip an oscilloscope's tip to one face and its ground "
        "to the other, and pull the film quickly and lightly along its draw axis. If the first kick goes "
        f"{way}, the tip is on the + face; mark it."
    )


def gluing_steps(job: Job) -> list[str]:
    """Return how films are glued to their shims; nothing where none is drawn in."""
    joint, film = lap(job), job.design.film
    if joint is None or film is None:
        return []
    passes = (
        f"With its glue the lap is about {joint.stack:.3f} mm thick. No notch is on its way, only the slot, "
        f"whose soft wall stretches by {100 * joint.stretch:.2g} %."
        if joint.notch is None
        else f"Measure each lap: above {joint.notch:.3f} mm it jams in the combs' notches."
    )
    return [
        f"Glue each strip to its own shim's tail at end {film.wiring_side} ({NUMBERS}). Wipe the tail. Lay "
        f"the strip's unwired end on it, {GLUED_LENGTH:g} mm up to the cut-off mark, flat and in line, + "
        "side "
        f"{TOWARDS}, a trace of thin cyanoacrylate between. Press it for 1 min between two slips of "
        f"polythene, which keep it off its neighbours, and leave it for {GLUE_MIN} min. {passes}"
    ]


def drawing_step(job: Job) -> str:
    """Return how shims are drawn out, and films in behind them. Call where there are shims."""
    end, straight = drawing_end(job.design), not job.bent
    way = f"{'along y' if straight else 'along its arc'}, towards end {end}"
    if lap(job) is None:
        return f"Draw each shim out {way}."
    other, grams = "b" if end == "a" else "a", small_batch(job.silicone)
    stop = f"skin's end {other} (its cut-off mark is at end {end} then)" if straight else f"end plate {other}"
    return (
        f"Mix {grams:g} g of the same silicone ({weights(job.silicone, grams)}; stir it for 3 min) and draw "
        f"in {_batches(job)}. Coat both faces of a strip, all "
        f"but the mask, grip its shim with pliers at end {end}, and draw it out {way}, in "
        f"{drawing_time(job):.2g} s or more: the strip follows it in, wired end last; it is too thin to "
        f"be pushed. Stop when its mask meets the {stop}. If the strip stretches or stays behind, its lap "
        "slips: draw it out, "
        "clean it and begin again. Wipe off what came out at both ends before the next."
    )


def _batches(job: Job) -> str:
    minutes, most, strips = job.silicone.pot_life_min, strips_per_mix(job), strip_count(job)
    seconds = strip_seconds(job)
    pace = f"at {seconds:.2g} s each"
    if minutes is None or most is None:
        return f"as many strips as half the pot life on its data sheet takes {pace}, then mix again"
    fresh = f"within {POT_SHARE * minutes:g} min, for later it no longer wets"
    if most >= strips:
        return f"all {strips} strips with it ({strips * seconds / 60:.2g} min {pace}) {fresh}"
    mixes = math.ceil(strips / max(most, 1))
    return f"{most} of the {strips} strips with it, {pace}, {fresh}; then mix again, {mixes} times in all"


def curing_steps(job: Job) -> list[str]:
    """Return the wait after films were drawn in; nothing where none was."""
    material = job.silicone
    if lap(job) is None:
        return []
    long = "as long as its data sheet asks" if material.cure_h is None else f"{material.cure_h:g} h"
    warm = "room temperature" if material.cure_c is None else f"{material.cure_c:g} °C"
    if material.cure_c is not None and material.cure_c > HIGHEST_FILM_TEMPERATURE:
        long, warm = "as long as its data sheet asks", f"{HIGHEST_FILM_TEMPERATURE:g} °C or less"
    return [
        f"Let the strips cure in, level and untouched: {long} at {warm}. Above "
        f"{HIGHEST_FILM_TEMPERATURE:g} °C film loses its "
        "charge." + ("" if not job.bent else " Then cut the shims off outside the end plate.")
    ]


def pull_test_steps(job: Job) -> list[str]:
    """Return how it is tested that each strip holds; nothing without film."""
    pull = pull_test(job)
    if pull is None:
        return []
    why = "a third of what yields the film" if pull.by_film else "a third of what a fair bond takes in shear"
    first, bad, last = "", "the skin is scrap", ""
    if lap(job) is not None:
        first, last = "Take the masks off. ", " Cut the glued tails off at their marks, flush with the skin. "
        last += "Number and + sign are on the tabs."
        if not job.bent:
            bad = "ease it out with its shim behind it, which is in place again then, and glue a new one on"
    return [
        f"{first}Pull test: hang {1000 * pull.force / GRAVITY:.3g} g ({pull.force:.2g} N, {why}; the bond is "
        f"sheared by {pull.shear:.2g} MPa) on each lead for 10 s, over a rod, so that it pulls along y. A "
        f"strip that creeps out does not hold: {bad}.{last}",
        _wired(job),
        "Measure between the pads of neighbouring strips: 100 MΩ or more. Then clip each strip to an "
        "oscilloscope, its + side to the tip, and tap its ridge lightly from above: every strip kicks, all "
        "to the same side. One that kicks to the other side lies turned over; one that doesn't is dead.",
    ]


def _wired(job: Job) -> str:
    """How a strip's electrodes are tested: what a meter between its pads reads."""
    value, error, leads = strip_capacitance(job)
    return (
        "Measure each strip between its two pads with a capacitance meter, 1 kHz, its clips' own capacitance "
        f"taken off: {value:.2g} ± {error:.1g} pF, and up to {leads:.1g} pF more of its leads. Less than "
        "half of it: a lead is torn. No capacitance at all, or less than 100 MΩ: the faces touch at a cut "
        "edge; trim it. Write the values down by strip number: the charge of a strip goes with them."
    )
