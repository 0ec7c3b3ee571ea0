"""What may go wrong with film strips: drawn in, cast in, and in place.

A film drawn into its slot behind a shim: the lap that joins them, the gaps it passes, and the bond after.
Film and shim overlap, glued, and are thicker there than a comb's notch (0.088 mm in 0.060 for `yamada-2002`).
So a straight mold's end plates slide off over the shims first. What is left on the lap's way is the slot,
which is soft: it opens as far as the silicone stretches. Nothing has to be thinned or widened, and the notch
stays the shim's datum; no thread or hook fits a slot of 0.05 mm. The end plates of a doubly curved mold can't
slide over arcs, so there the shim's tail is thinned until the lap passes the notches of both combs.

The film's unwired end goes first, so that its contact never touches wet silicone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Literal, NamedTuple

from skincad.fabrication.finding import Finding
from skincad.fabrication.rules import slit_play, walls_close
from skincad.fabrication.strips import (
    MOST_PULL,
    PVDF_YIELD,
    Pour,
    Strip,
    deflection,
    pour,
    release_strain,
    straightening_tension,
    strip,
    weight,
)
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import skin_of
from skincad.solids.cavity import SAFE_SHARE
from skincad.solids.layout import end_process

GLUE_THICKNESS = 0.01  # mm, assumption: of thin cyanoacrylate that is pressed out between film and shim
LEAST_TAIL = 0.015  # mm, assumption: the thinnest that can be handled; shim steel is sold from 0.01 mm
LEAST_CONTACT = 2.0  # mm, assumption: of a lead that stays out of a notch and clean, to be contacted
HANDLING_SECONDS = 7.0  # a strip, assumption: to coat it and wipe its ends
DRAWING_SECONDS = 7.0  # a strip, assumption: to draw it in at best
POT_SHARE = 0.5  # assumption: of the pot life, after which a silicone wets badly
THICKENING = 2.0  # assumption: a mix's viscosity when it is drawn in last, by that of a fresh one
COAT_THICKNESS = 0.01  # mm, assumption: of silicone on each face, to which a soft slot opens at least
# C, source: piezo film technical manual (Measurement Specialties), use of PVDF: -40 to 80
HIGHEST_FILM_TEMPERATURE = 80.0
# MPa, assumption: shear of a primed film; cohesive failure of a silicone is near 1, bare film 0
BOND_STRENGTH = 0.1


class Lap(NamedTuple):
    """Film on its shim's tail: mm, and strain."""

    tail: float  # thickness of the shim there
    stack: float  # shim, glue and film
    notch: float | None  # the narrowest on its way; None where the end plates are off
    stretch: float  # of the slot's girth round it


def lap(design: Design) -> Lap | None:
    """Return the lap by which a film is drawn in; None where none is: without film, or cast in.

    A notch may come out narrower by its process's growth and tolerance, but is lapped until its shim goes in.
    """
    slot, film = skin_of(design).slot, design.film
    if slot is None or film is None or design.mold.method != "shim":
        return None
    tail, notch = slot.thickness, None
    if design.skin.curvature_radius_y is not None:
        maker, drawn = end_process(design), slot.thickness + 2 * design.mold.slit_clearance
        notch = max(slot.thickness, drawn - 2 * walls_close(design, maker) - maker.tolerance)
        room = notch - film.thickness - GLUE_THICKNESS
        passing = math.floor(1e6 * room + 1e-3) / 1e6  # a nanometre is rounding
        tail = min(slot.thickness, max(LEAST_TAIL, passing))
    stack = tail + GLUE_THICKNESS + film.thickness
    girth = slot.depth + slot.thickness
    return Lap(tail, stack, notch, max(0.0, (stack - slot.thickness) / girth))


def drawing_time(design: Design) -> float:
    """Return the seconds in which a strip is drawn in: `DRAWING_SECONDS`, or more where its drag asks for it.

    Call it where there is a lap.

    Couette flow in the coats on both faces, over the whole length, drags with 2 mu b l^2 / (coat t); that may
    be `MOST_PULL` of the film's yield force. The lap's own friction is the shim's to bear, not the film's.
    """
    slot, film = skin_of(design).slot, design.film
    if slot is None or film is None:
        raise ValueError("without a film nothing is drawn in")
    coat = max((slot.thickness - film.thickness) / 2, COAT_THICKNESS)
    thick = THICKENING * silicone(design).viscosity * 1e-6
    slow = 2 * thick * design.skin.length**2 / (coat * MOST_PULL * PVDF_YIELD * film.thickness)
    return max(DRAWING_SECONDS, slow)


def strips_per_mix(design: Design) -> int | None:
    """Return how many strips are drawn in with one mix of silicone; None where its pot life isn't known."""
    minutes = silicone(design).pot_life_min
    return (
        None if minutes is None else int(60 * minutes * POT_SHARE / (HANDLING_SECONDS + drawing_time(design)))
    )


class Pull(NamedTuple):
    """A test that a strip in the skin holds, by its lead."""

    force: float  # N
    by_film: bool  # whether the film is what limits it, not the bond
    shear: float  # MPa, that it puts on the bond's both faces


def pull_test(design: Design) -> Pull | None:
    """Return the pull that shows that a strip holds: `MOST_PULL` of the film's yield force, or of what the
    least bond worth having would take in shear, if that is less. None without film."""
    slot, film = skin_of(design).slot, design.film
    if slot is None or film is None:
        return None
    faces = 2 * slot.depth * design.skin.length
    by_film, by_bond = PVDF_YIELD * slot.depth * film.thickness, BOND_STRENGTH * faces
    force = MOST_PULL * min(by_film, by_bond)
    return Pull(force, by_film <= by_bond, force / faces)


def drawing_findings(design: Design) -> list[Finding]:
    """Return the rules `strip lap`, `strip lead`, `strip batch` and `film heat`; none without film."""
    if design.film is None:
        return []
    joint = lap(design)
    if joint is None:
        return list(_heat(design))
    return [*_notches(design, joint), *_slot(design, joint), *_batch(design)]


def _notches(design: Design, joint: Lap) -> Iterator[Finding]:
    """The lap against the combs' notches, where they are on its way; and the contact that stays out."""
    slot, film, choice = skin_of(design).slot, design.film, design.mold
    if joint.notch is None or slot is None or film is None:
        return
    if joint.stack > joint.notch + 1e-6:  # mm; a nanometre is rounding
        need = LEAST_TAIL + GLUE_THICKNESS + film.thickness
        maker = end_process(design)
        least = (need - slot.thickness + maker.tolerance) / 2 + walls_close(design, maker)
        wide = math.ceil(1e3 * least - 1e-6) / 1e3  # whole micrometres
        remedy = (
            f"mold.slit_clearance of {wide:g} mm or more, a thinner film or a thicker slot, or a skin that "
            f"is straight along y; its shim's tail is thinned to {LEAST_TAIL:g} mm already"
        )
        where = "lap of film and shim, in the combs' notches"
        yield Finding(
            rule="strip lap",
            where=where,
            measured=joint.stack,
            limit=joint.notch,
            unit="mm",
            severity="error",
            remedy=remedy,
        )
    if (out := film.lead - choice.end_plate) < LEAST_CONTACT:
        remedy = f"film.lead of {choice.end_plate + LEAST_CONTACT:g} mm or more"
        where = "lead beyond its end plate, in which it meets wet silicone"
        yield Finding(
            rule="strip lead",
            where=where,
            measured=out,
            limit=LEAST_CONTACT,
            unit="mm",
            severity="warning",
            remedy=remedy,
        )


def _slot(design: Design, joint: Lap) -> Iterator[Finding]:
    """The lap against the slot's soft walls, which must not tear round it."""
    slot = skin_of(design).slot
    limit = SAFE_SHARE * silicone(design).elongation_at_break
    if joint.stretch <= limit or slot is None:
        return
    deeper = (joint.stack - slot.thickness) / limit - slot.thickness
    remedy = f"slot.depth of {math.ceil(1e3 * deeper) / 1e3:g} mm or more, a thinner film"
    remedy += ', a silicone that stretches further, or mold.method = "cast-in"'
    where = "lap of film and shim, stretching the slot's walls"
    yield Finding(
        rule="strip lap",
        where=where,
        measured=joint.stretch,
        limit=limit,
        unit="",
        severity="error",
        remedy=remedy,
    )


def _batch(design: Design) -> Iterator[Finding]:
    """A pot life in which not one strip is drawn in."""
    minutes = silicone(design).pot_life_min
    if minutes is not None and strips_per_mix(design) == 0:
        where, needs = "one strip, drawn in behind its shim", HANDLING_SECONDS + drawing_time(design)
        remedy = "a thinner silicone or one with a longer pot life, a shorter skin, or a thicker slot"
        yield Finding(
            rule="strip batch",
            where=where,
            measured=needs,
            limit=60 * minutes * POT_SHARE,
            unit="s",
            severity="error",
            remedy=remedy,
        )


def _heat(design: Design) -> Iterator[Finding]:
    """A cure that is too hot for a film that is cast in; a film that is drawn in has its own, cooler cure."""
    warm = silicone(design).cure_c
    if warm is not None and warm > HIGHEST_FILM_TEMPERATURE:
        remedy = f"a silicone, or a longer cure by its data sheet, at {HIGHEST_FILM_TEMPERATURE:g} °C or less"
        where = "film in the mold while it cures: it loses its charge"
        yield Finding(
            rule="film heat",
            where=where,
            measured=warm,
            limit=HIGHEST_FILM_TEMPERATURE,
            unit="°C",
            severity="warning",
            remedy=remedy,
        )


MOST_RELEASE = 1e-3  # strain, assumption: as much as a silicone shrinks
SAG_SHARE = 0.01  # assumption: of slot.offset, by which a strip may sag while the silicone cures
DRIFT_SHARE = 0.25  # of the silicone beside it; further, a capillary force that grows as 1 / gap pulls it on
PLACE_SHARE = 0.1  # assumption: of slot.offset; more unbalances a pair by more than a fifth
# assumption: by which S1 and S2 may differ; their difference, the signal, is in doubt beyond
MOST_UNBALANCE = 0.5
SETTLING_SHARE = 0.1  # assumption: of the pot life, in which a strip must be back


def placement_error(design: Design) -> float:
    """Return how far a strip or shim may lie from its place in the section, mm: what growth and a coat
    leave of the slit clearance, and the tolerance of the process that makes the combs."""
    process = end_process(design)
    return max(0.0, slit_play(design, process)) + process.tolerance


def strip_findings(design: Design) -> list[Finding]:
    """Return the rules `strip sag`, `strip stress`, `strip drift`, `strip release` and `strip place`, and
    those of drawing in; none without slots."""
    rod, flow = strip(design), pour(design)
    if rod is None or flow is None or skin_of(design).slot is None:
        return []
    cast = [*_sag(design, rod), *_stress(rod, flow)] if design.mold.method == "cast-in" else []
    moved = [*_drift(design, rod, flow), *_release(design, rod), *_place(design)]
    return [*cast, *moved, *drawing_findings(design)]


def _sag(design: Design, rod: Strip) -> Iterator[Finding]:
    """At rest in the silicone, which is how it cures; in air, before, its load is larger, but that passes."""
    slot = skin_of(design).slot
    load = weight(rod, silicone(design).density)
    sag, limit = (
        abs(deflection(rod, load)),
        SAG_SHARE * (slot.offset if slot else 0.0),
    )
    if sag > limit:
        remedy = f"film.tension of {straightening_tension(rod, load, limit):.2g} N or more, or a shorter skin"
        where = "strips, under their weight in silicone"
        yield Finding(
            rule="strip sag",
            where=where,
            measured=sag,
            limit=limit,
            unit="mm",
            severity="warning",
            remedy=remedy,
        )


def _stress(rod: Strip, flow: Pour) -> list[Finding]:
    stress, limit = (rod.tension + flow.pull) / rod.section, MOST_PULL * PVDF_YIELD
    if stress <= limit:
        return []
    least = max(limit * rod.section - flow.pull, 0.0)
    remedy = f"film.tension of at most {least:.2g} N, or a thicker film; it yields at {PVDF_YIELD:g} MPa"
    severity: Literal["error", "warning"] = "error" if stress > PVDF_YIELD else "warning"
    return [
        Finding(
            rule="strip stress",
            where="strips, under their tension",
            measured=stress,
            limit=limit,
            unit="MPa",
            severity=severity,
            remedy=remedy,
        )
    ]


def _drift(design: Design, rod: Strip, flow: Pour) -> Iterator[Finding]:
    """While the front passes; and whether a strip is back long before the silicone sets."""
    name = "strips" if design.mold.method == "cast-in" else "shims"
    limit = DRIFT_SHARE * flow.beside
    slower = f"mold.fill_time of {design.mold.fill_time * flow.drift / limit:.2g} s or more"
    stronger = ", more tension or a thicker film" if rod.tension else ", or a thicker slot"
    if flow.drift > limit:
        where = f"{name}, while silicone is poured round them"
        yield Finding(
            rule="strip drift",
            where=where,
            measured=flow.drift,
            limit=limit,
            unit="mm",
            severity="warning",
            remedy=slower + stronger,
        )
    pot_life = silicone(design).pot_life_min
    if pot_life is not None and flow.settling > SETTLING_SHARE * 60 * pot_life:
        where, remedy = f"{name}, coming back after the pour", "a thinner silicone" + stronger
        limit = SETTLING_SHARE * 60 * pot_life
        yield Finding(
            rule="strip drift",
            where=where,
            measured=flow.settling,
            limit=limit,
            unit="s",
            severity="warning",
            remedy=remedy,
        )


def _release(design: Design, rod: Strip) -> Iterator[Finding]:
    """A note: the skin comes out shorter than designed."""
    strain = release_strain(design)
    if strain > MOST_RELEASE:
        where, remedy = "skin, shortened by its strips", f"{rod.tension * MOST_RELEASE / strain:.2g} N"
        yield Finding(
            rule="strip release",
            where=where,
            measured=strain,
            limit=MOST_RELEASE,
            unit="",
            severity="note",
            remedy=f"film.tension of {remedy}",
        )


def _place(design: Design) -> list[Finding]:
    """A note, or a warning beyond `MOST_UNBALANCE`.

    Stress across the film grows about as its distance from the axis (assumption). So a pair is out of balance
    by up to both errors by the offset.
    """
    slot = skin_of(design).slot
    off, offset = placement_error(design), slot.offset if slot else math.inf
    if off <= PLACE_SHARE * offset:
        return []
    remedy = (
        f"calibrate each pair: S1 and S2 may differ by {100 * 2 * off / offset:.0f} %; or a smaller "
        "slit_clearance, a finer process for the combs, or a larger design"
    )
    grave: Literal["note", "warning"] = "warning" if 2 * off / offset > MOST_UNBALANCE + 1e-9 else "note"
    return [
        Finding(
            rule="strip place",
            where="strips in their slits",
            measured=off,
            limit=PLACE_SHARE * offset,
            unit="mm",
            severity=grave,
            remedy=remedy,
        )
    ]
