"""Bonding of films in their slots: lines of the casting sheet on release, cleaning, priming, drawing in,
curing and testing, and what to buy for them."""

from __future__ import annotations

import math

from skincad.fabrication.drawing_in import (
    HANDLING_SECONDS,
    HIGHEST_FILM_TEMPERATURE,
    POT_SHARE,
    drawing_time,
    lap,
    pull_test,
    strips_per_mix,
)
from skincad.fabrication.electrodes import PITCH, strip_capacitance, tab
from skincad.fabrication.pattern import GLUED_LENGTH
from skincad.fabrication.strips import GRAVITY, strip
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import skin_of
from skincad.solids.inserts import drawing_end

NUMBERS = (
    "number 1 is at the left, seen from end a; nicks in the end plates' edges mark the ends: one at end a, "
    "two at end b, where the reservoir is"
)
TOWARDS = "towards the higher numbers in every slot"  # +x
PRIMER_MIN, PRIMER_H = 60, 8  # assumption: makers ask for 30 to 120 min to dry, and to use it the same day
PRIMER_ML = 0.02  # ml/cm2, assumption: a thin coat, most of which stays in the brush
GLUE_MIN = 10  # min, assumption: thin cyanoacrylate between metal and film, to full grip
MIX_GRAMS = 2.0  # g, assumption: the least that is weighed within 1 % on a balance of 0.01 g
SPARE_SHARE = 0.1  # assumption: of the strips, for those that crease
THREAD_LENGTH = 0.3  # m, assumption: over a rod and tied twice
ALCOHOL_ML = 10.0, 0.5  # ml, assumption: spilt, and for each wipe


def strip_count(design: Design) -> int:
    """Return how many strips go into the skins of a mold."""
    skin = skin_of(design)
    return 2 * skin.count * design.mold.cavities if skin.slot else 0


def release_agent_places(design: Design) -> str:
    """Return where release agent goes, and what it is kept from, so that films hold."""
    if skin_of(design).slot is None:
        return "cavity, end plates and cover; none on the carrier."
    if design.film is None:
        shims = "cover and shims" if design.mold.method == "shim" else "cover"
        return f"cavity, end plates, {shims}; none on the carrier."
    if design.mold.method == "cast-in":
        return (
            "cavity, end plates and cover with a brush, and let it dry; none on the carrier, and none on the "
            "strips, which would not hold."
        )
    return (
        "cavity, end plates and cover with a brush, and let it dry; none on the carrier, and none on the "
        "shims: it would stay on the slots' walls, and no film would hold. Wipe each shim twice with "
        "isopropanol, each time with a fresh wipe, and touch it by its ends from now on. Test that on a "
        "piece of the stock: water must spread, not bead (water-break test)."
    )


def masked_length(design: Design) -> float:
    """Return how much of lead and tab is masked while a strip is drawn in, mm: no mask passes a notch."""
    if design.film is None:
        return 0.0
    bent, lead = design.skin.curvature_radius_y is not None, design.film.lead
    return tab(design.film)[1] + (max(0.0, lead - design.mold.end_plate) if bent else lead)


def preparation_steps(design: Design) -> list[str]:
    """Return how strips are cleaned, masked and primed; nothing without film."""
    film = design.film
    if film is None:
        return []
    if lap(design) is None:
        when, rest = "Make", "between their marks"
        masked = "the lead and both tabs (write number and + side on a tab first) while you prime, and take "
        masked += "it off before they are laid in"
    else:
        when, rest = (
            "Late in the cure, make",
            f"up to the cut-off mark: the {GLUED_LENGTH:g} mm beyond are glued",
        )
        masked = f"the last {masked_length(design):g} mm of the wired end (end {film.wiring_side})"
        masked += ", where it stays for now, its number and + side written on it"
    return [
        f"{when} the film strips ready ({1000 * film.thickness:.0f} µm, numbered in strips.dxf). Wipe "
        "both faces with isopropanol on a lint-free wipe; from now on touch them by their ends. Fold "
        f"low-tack masking tape over {masked}: what is contacted later must stay free of primer and "
        f"silicone. Brush primer thinly onto both faces, {rest}. It dries in {PRIMER_MIN} min at 20 to 25 °C "
        "and 40 % humidity or more; where its data sheet says otherwise, that counts. Use the strips within "
        f"{PRIMER_H} h."
    ]


def gluing_steps(design: Design) -> list[str]:
    """Return how films are glued to their shims; nothing where none is drawn in."""
    joint, film = lap(design), design.film
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


def drawing_step(design: Design) -> str:
    """Return how shims are drawn out, and films in behind them. Call where there are shims."""
    end, straight = drawing_end(design), design.skin.curvature_radius_y is None
    way = f"{'along y' if straight else 'along its arc'}, towards end {end}"
    if lap(design) is None:
        return f"Draw each shim out {way}."
    other = "b" if end == "a" else "a"
    stop = f"skin's end {other} (its cut-off mark is at end {end} then)" if straight else f"end plate {other}"
    return (
        f"Mix {MIX_GRAMS:g} g of the same silicone and draw in {_batches(design)}. Coat both faces of a "
        "strip, all "
        f"but the mask, grip its shim with pliers at end {end}, and draw it out {way}, in "
        f"{drawing_time(design):.2g} s or more: the strip follows it in, wired end last; it is too thin to "
        f"be pushed. Stop when its mask meets the {stop}. If the strip stretches or stays behind, its lap "
        "slips: draw it out, "
        "clean it and begin again. Wipe off what came out at both ends before the next."
    )


def _batches(design: Design) -> str:
    minutes, most, strips = silicone(design).pot_life_min, strips_per_mix(design), strip_count(design)
    seconds = HANDLING_SECONDS + drawing_time(design)
    pace = f"at {seconds:.2g} s each"
    if minutes is None or most is None:
        return f"as many strips as half the pot life on its data sheet takes {pace}, then mix again"
    fresh = f"within {POT_SHARE * minutes:g} min, for later it no longer wets"
    if most >= strips:
        return f"all {strips} strips with it ({strips * seconds / 60:.2g} min {pace}) {fresh}"
    mixes = math.ceil(strips / max(most, 1))
    return f"{most} of the {strips} strips with it, {pace}, {fresh}; then mix again, {mixes} times in all"


def curing_steps(design: Design) -> list[str]:
    """Return the wait after films were drawn in; nothing where none was."""
    material = silicone(design)
    if lap(design) is None:
        return []
    long = "as long as its data sheet asks" if material.cure_h is None else f"{material.cure_h:g} h"
    warm = "room temperature" if material.cure_c is None else f"{material.cure_c:g} °C"
    if material.cure_c is not None and material.cure_c > HIGHEST_FILM_TEMPERATURE:
        long, warm = "as long as its data sheet asks", f"{HIGHEST_FILM_TEMPERATURE:g} °C or less"
    return [
        f"Let the strips cure in, level and untouched: {long} at {warm}. Above "
        f"{HIGHEST_FILM_TEMPERATURE:g} °C film loses its "
        "charge."
        + ("" if design.skin.curvature_radius_y is None else " Then cut the shims off outside the end plate.")
    ]


def pull_test_steps(design: Design) -> list[str]:
    """Return how it is tested that each strip holds; nothing without film."""
    pull = pull_test(design)
    if pull is None:
        return []
    why = "a third of what yields the film" if pull.by_film else "a third of what a fair bond takes in shear"
    first, bad, last = "", "the skin is scrap", ""
    if lap(design) is not None:
        first, last = "Take the masks off. ", " Cut the glued tails off at their marks, flush with the skin. "
        last += "Number and + sign are on the tabs."
        if design.skin.curvature_radius_y is None:
            bad = "ease it out with its shim behind it, which is in place again then, and glue a new one on"
    return [
        f"{first}Pull test: hang {1000 * pull.force / GRAVITY:.3g} g ({pull.force:.2g} N, {why}; the bond is "
        f"sheared by {pull.shear:.2g} MPa) on each lead for 10 s, over a rod, so that it pulls along y. A "
        f"strip that creeps out does not hold: {bad}.{last}",
        _wired(design),
    ]


def _wired(design: Design) -> str:
    """How a strip's electrodes are tested: what a meter between its pads reads."""
    value, error, leads = strip_capacitance(design)
    return (
        "Measure each strip between its two pads with a capacitance meter, 1 kHz, its clips' own capacitance "
        f"taken off: {value:.2g} ± {error:.1g} pF, and up to {leads:.1g} pF more of its leads. Less than "
        "half of it: a lead is torn. No capacitance at all, or less than 100 MΩ: the faces touch at a cut "
        "edge; trim it. Write the values down by strip number: the charge of a strip goes with them."
    )


def bonding_kit(design: Design) -> list[str]:
    """Return what is to be bought so that films go in and hold, with amounts; nothing without film."""
    skin = skin_of(design)
    film, slot, rod, pull = design.film, skin.slot, strip(design), pull_test(design)
    if film is None or slot is None or rod is None or pull is None:
        return []
    strips, cast_in, most = strip_count(design), lap(design) is None, strips_per_mix(design)
    wiped, spare = strips * (1 if cast_in else 3), math.ceil(SPARE_SHARE * strips)
    coat = PRIMER_ML * 2 * (strips + spare) * slot.depth * design.skin.length / 100
    masked = 2 * (film.lead + tab(film)[1] + (20 if cast_in else 0))  # mm, folded over
    sheets = f"{design.mold.cavities} times, " if design.mold.cavities > 1 else ""
    rows = [
        f"{strips} strips of PVDF film, {1000 * film.thickness:.0f} µm, sputtered metal on both faces, "
        f"patterned and cut by strips.dxf or strips.svg, its + side up, {sheets}and {spare} to spare",
        f"{2 * strips} crimp contacts for flat cable, {PITCH:g} mm apart: one for each pad; for each skin a "
        f"pin header of 2 x {2 * skin.count}, {PITCH:g} mm, on a board by strip-board.kicad_mod",
        f"primer that bonds silicone to plastics and metal (silane or titanate type), {max(1.0, coat):.2g} "
        "ml, and a fine brush",
        f"isopropanol, {math.ceil(ALCOHOL_ML[0] + ALCOHOL_ML[1] * wiped)} ml, and {wiped} lint-free wipes",
        f"low-tack masking tape, {(strips + spare) * masked / 1000:.2g} m",
    ]
    if cast_in:
        rows += [
            f"{2 * strips} weights of {rod.hung:.3g} g and {2 * strips * THREAD_LENGTH:.3g} m of thread "
            "to hang "
            "them by; 2 rods of 3 mm for it to run over, on one board with the mold"
        ]
    else:
        mixes = math.ceil(strips / most) if most else 1
        rows += [
            f"thin cyanoacrylate, 1 g, polythene film, flat pliers; {MIX_GRAMS * mixes:g} g more of the "
            "silicone"
        ]
    hung = f"{1000 * pull.force / GRAVITY:.3g} g"
    return [
        *rows,
        f"for the pull test a film clip and weight, {hung} together, and {THREAD_LENGTH:g} m of thread",
    ]
