"""The sheet's steps with film strips: shims, bonds and bent slots."""

from __future__ import annotations

import math

from skincad.fabrication.bores import Screws
from skincad.fabrication.electrodes import PITCH, strip_capacitance, tab
from skincad.fabrication.pattern import GLUED_LENGTH
from skincad.fabrication.rules import shim_bend
from skincad.fabrication.strip_rules import (
    HANDLING_SECONDS,
    HIGHEST_FILM_TEMPERATURE,
    POT_SHARE,
    drawing_time,
    lap,
    placement_error,
    pull_test,
    strips_per_mix,
)
from skincad.fabrication.strips import GRAVITY, deflection, pour, release_strain, strip, weight
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import section, skin_of
from skincad.solids.inserts import GRIP, drawing_end
from skincad.solids.layout import end_angle
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole, RevolvedBody
from skincad.solids.shrinkage import scaled_for_shrinkage

DEGAS = (
    "Degas the mix in its open cup, four times as high as the mix, for it rises; never put the closed mold, "
    "filled, under vacuum: its silicone would foam out and air come in."
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


def arcs_to_buy(design: Design, closed: ClosedMold) -> list[str]:
    """Return what to buy for the slots: shims cut as arcs, with the radius of each."""
    slot, radius = skin_of(design).slot, design.skin.curvature_radius_y
    if slot is None or radius is None:
        return []
    size = f"{slot.thickness:g} x {slot.depth:g} mm"
    arms = [
        f"{s.feature} {s.side} {arc_radius(design, s.feature, s.side):.2f}" for s in section(design).slots
    ]
    strain, joint, film = 100 * shim_bend(design), lap(design), design.film
    thin = ""
    if joint is not None and film is not None and joint.tail < slot.thickness:
        thin = (
            f", the last {GRIP:g} mm at end {film.wiring_side} thinned to {joint.tail:.3f} mm (etched or "
            "stoned, by micrometer), so that film and shim, glued, pass the notches together"
        )
    return [
        f"{len(arms)} shims of spring steel, {size}, {math.ceil(arc_length(closed))} mm long, cut or etched "
        f"as arcs from sheet by shims.dxf, deburred{thin}; "
        f"straight stock bent on edge is strained by {strain:.2g} % and buckles between its combs. Radius "
        f"at mid-depth, mm, by ridge and slot: {', '.join(arms)}"
    ]


def arc_length(closed: ClosedMold) -> float:
    """Return how long the longest shim of a doubly curved mold is along its outer edge, mm."""
    arcs = [part.body for part in closed.of(PartRole.SHIM) if isinstance(part.body, RevolvedBody)]
    return max((arc.high - arc.low) * (arc.centre - min(s.start.z for s in arc.outline)) for arc in arcs)


def arc_radius(design: Design, ridge: int, side: str) -> float:
    """Return the radius of a slot's shim laid flat, mm: it is a part of a cone whose lines run along its
    depth, so the distance along them from the axis to the middle of the depth."""
    poured_design = scaled_for_shrinkage(design)
    slot = next(s for s in section(poured_design).slots if (s.feature, s.side) == (ridge, side))
    radius = poured_design.skin.curvature_radius_y or math.inf
    return (radius - poured_design.skin.thickness + slot.centre.z) / abs(slot.direction.z)


def close_steps(design: Design, closed: ClosedMold, back: str) -> list[str]:
    """Return how the mold is closed and filled, after cleaning."""
    if skin_of(design).slot is None:
        ends = f"Lay the carrier on its ledge ({back}); the end plates lean over it and are screwed on next."
    else:
        ends = (
            "Screw both combs to the cavity's ends. Lay each shim into its notches, its hollow side up and "
            f"{GRIP:g} mm out at both ends. Lay the carrier on its ledge ({back}). Then the keepers, which "
            "lean over it: pressed down onto the combs while you tighten."
        )
    rise, tilt = math.degrees(end_angle(design)), design.mold.pour_tilt
    both = (
        "; end a leans by more than that, so its air leaves slowly, through the gap round the carrier"
        if tilt <= rise
        else ""
    )
    return [
        ends,
        f"{'Then the foam, cover' if closed.of(PartRole.SEAL) else 'Cover'} and bolts.",
        f"{DEGAS} Raise end b by {tilt:g} degrees (both ends lean by {rise:.3g}{both}). Fill slowly "
        "through the gate at end a, and tape each bleed as silicone shows in it, until silicone stands in "
        "the reservoir.",
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
