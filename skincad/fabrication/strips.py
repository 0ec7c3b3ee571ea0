"""Strips and shims between their combs: what they weigh, what the pour does to them, how films are drawn in,
and the rules for all of that.

A strip is a tie-rod under a uniform load across its thickness, its weak way, as if it lay flat: an upright
one sags far less. A film's ends count as hinged, a shim's as built in. The drag is that of slow flow (the
Reynolds number is below 1e-4) past a cylinder half as wide as the strip, the whole front's speed straight
across it: an upper estimate, for in a ridge's groove the silicone flows along the strip. Left out: the pull
of the front where it wets one side first, 2 gamma / gap on the depth, some times the drag in a template but
over a short length and for a moment. What the pour moves comes back with the time constant `settling`.

A film is drawn into its slot behind a shim. The two overlap, glued, and are thicker there than a comb's notch
(0.088 mm in 0.060 for `yamada-2002`). So a straight mold's end plates slide off over the shims first. What is
left on the lap's way is the slot, which is soft: it opens as far as the silicone stretches. Nothing has to be
thinned or widened, and the notch stays the shim's datum; no thread or hook fits a slot of 0.05 mm. The end
plates of a doubly curved mold can't slide over arcs, so there the shim's tail is thinned until the lap passes
the notches of both combs. The film's unwired end goes first, so that its contact never touches wet silicone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

import shapely

from skincad.fabrication.job import Job
from skincad.fabrication.rules import Finding, error, note, slit_play, walls_close, warning
from skincad.inputs.material import layers
from skincad.shape.curves import polygon
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import GUARD_TOLERANCE
from skincad.solids.cavity import SAFE_SHARE
from skincad.solids.gate import GRAVITY
from skincad.solids.plan import CutRole, PartRole, bores

PVDF_DENSITY = 1780.0  # kg/m3, source: piezo film technical manual (Measurement Specialties), table 1
PVDF_YIELD = 45.0  # MPa, source: there, 45 to 55 along the stretch axis
STEEL_DENSITY, STEEL_MODULUS = 7850.0, 200e3  # kg/m3, MPa, source: handbooks, spring steel
MOST_PULL = 1 / 3  # assumption: of the yield stress; more creeps in the hours of a cure
USUAL_PULL = 0.05  # assumption: of the yield stress, where no tension is given: straight, little to release
_STIFF = 1e-2  # u below which the tension's part is lost in rounding; it is u^2 / 2.5 there
_SLACK = 500.0  # u above which 1 / cosh u is below any float
GLUE_THICKNESS = 0.01  # mm, assumption: of thin cyanoacrylate that is pressed out between film and shim
LEAST_TAIL = 0.015  # mm, assumption: the thinnest that can be handled; shim steel is sold from 0.01 mm
LEAST_CONTACT = 2.0  # mm, assumption: of a lead that stays out of a notch and clean, to be contacted
DRAWING_SECONDS = 7.0  # a strip, assumption: to draw it in at best
POT_SHARE = 0.5  # assumption: of the pot life, after which a silicone wets badly
THICKENING = 2.0  # assumption: a mix's viscosity when it is drawn in last, by that of a fresh one
COAT_THICKNESS = 0.01  # mm, assumption: of silicone on each face, to which a soft slot opens at least
# C, source: piezo film technical manual (Measurement Specialties), use of PVDF: -40 to 80
HIGHEST_FILM_TEMPERATURE = 80.0
# MPa, assumption: shear of a primed film; cohesive failure of a silicone is near 1, bare film 0
BOND_STRENGTH = 0.1
STEEL_WEIGHT = 7.85e-6 * 9.81  # N/mm3, source: handbooks, 7850 kg/m3
SHIM_ELASTIC = 0.006  # strain, source: handbooks, hardened spring steel yields at about 1200 of 200e3 MPa
# assumption: of a slot's thickness; a shim that hangs through by more displaces its film
SHIM_SAG_SHARE = 0.5
MOST_RELEASE = 1e-3  # strain, assumption: as much as a silicone shrinks
SAG_SHARE = 0.01  # assumption: of slot.offset, by which a strip may sag while the silicone cures
DRIFT_SHARE = 0.25  # of the silicone beside it; further, a capillary force that grows as 1 / gap pulls it on
PLACE_SHARE = 0.1  # assumption: of slot.offset; more unbalances a pair by more than a fifth
# assumption: by which S1 and S2 may differ; their difference, the signal, is in doubt beyond
MOST_UNBALANCE = 0.5
SETTLING_SHARE = 0.1  # assumption: of the pot life, in which a strip must be back


@dataclass(frozen=True)
class Strip:
    """A film or shim between its combs: mm, MPa, N, and kg/m3."""

    length: float  # between the combs
    depth: float
    thickness: float
    modulus: float
    density: float
    tension: float
    ends: Literal["hinged", "built in"]

    @property
    def section(self) -> float:
        """Area of the section, mm2."""
        return self.depth * self.thickness

    @property
    def bending(self) -> float:
        """Bending stiffness across the thickness, E b t^3 / 12, N mm2."""
        return self.modulus * self.depth * self.thickness**3 / 12

    @property
    def stress(self) -> float:
        """Tension by section, MPa."""
        return self.tension / self.section

    @property
    def hung(self) -> float:
        """Mass of the weight that gives the tension, g."""
        return 1000 * self.tension / GRAVITY


def strip(job: Job) -> Strip | None:
    """Return what lies between the combs: the film where it is cast in, else the shim; None without slots."""
    slot, film, length = job.skin.slot, job.design.film, job.cast.skin.length
    if slot is None:
        return None
    shim = Strip(
        length=length,
        depth=slot.depth,
        thickness=slot.thickness,
        modulus=STEEL_MODULUS,
        density=STEEL_DENSITY,
        tension=0.0,
        ends="built in",
    )
    if job.design.mold.method == "shim" or film is None:
        return shim
    usual = USUAL_PULL * PVDF_YIELD * slot.depth * film.thickness
    tension = film.tension if film.tension is not None else usual
    stiff = {"modulus": film.young_modulus, "density": PVDF_DENSITY, "tension": tension}
    return replace(shim, thickness=film.thickness, ends="hinged", **stiff)


def deflection(rod: Strip, load: float) -> float:
    """Return the deflection in the middle, mm, of a rod under a uniform load in N/mm.

    Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. (1959), articles 2 and 3: with
    u^2 = T l^2 / (4 E I) the beam's 5 q l^4 / (384 E I), or q l^4 / (384 E I) built in, times f(u). Without
    tension that is the beam, with much of it the string's q l^2 / (8 T). Small against the length.
    """
    beam = load * rod.length**4 / (384 * rod.bending)
    u = rod.length / 2 * math.sqrt(rod.tension / rod.bending)
    if rod.ends == "hinged":
        return 5 * beam * _hinged(u)
    return beam * _built_in(u)


def _hinged(u: float) -> float:
    if u < _STIFF:
        return 1 - 61 / 150 * u**2
    return (1 / math.cosh(min(u, _SLACK)) - 1 + u**2 / 2) / (5 * u**4 / 24)


def _built_in(u: float) -> float:
    if u < _STIFF:
        return 1 - u**2 / 10
    return 24 / u**4 * (u**2 / 2 + u / math.sinh(min(u, _SLACK)) - u / math.tanh(u))


def weight(rod: Strip, fluid: float = 0.0) -> float:
    """Return a strip's weight less its buoyancy in a fluid of this density (kg/m3; 0 is air), N/mm; negative
    where it floats."""
    return (rod.density - fluid) * GRAVITY * 1e-9 * rod.section


def straightening_tension(rod: Strip, load: float, most: float) -> float:
    """Return a tension, N, that keeps the sag under a load (N/mm) below `most` mm: the string's, so a little
    more than a strip with stiffness needs."""
    return abs(load) * rod.length**2 / (8 * most)


def drag(viscosity: float, speed: float, width: float, wall: float, *, along: bool = False) -> float:
    """Return the drag, N/mm, on a flat strip of `width` mm in slow flow of `speed` mm/s across it, or along.

    Jeffrey and Onishi, Q. J. Mech. Appl. Math. 34 (1981) 129: a cylinder of radius r at h from a plane wall,
    moving beside it, 4 pi mu U / arcosh(h / r); along itself half of that. A strip drags as a cylinder of
    r = width / 4 (Batchelor, J. Fluid Mech. 44 (1970) 419: half the sum of an ellipse's half axes). `wall`,
    mm, is from the strip's centre to the wall that its edge faces, above width / 2. `viscosity` in Pa s.
    """
    if wall <= width / 4:
        raise ValueError(f"the wall, {wall:g} mm away, must be beyond the cylinder's {width / 4:g} mm")
    cross_drag = 4 * math.pi * viscosity * 1e-6 * speed / math.acosh(4 * wall / width)
    return cross_drag / 2 if along else cross_drag


@dataclass(frozen=True)
class Pour:
    """What the pour does to a strip, at the worst of its places: mm, mm/s, N/mm, s."""

    speed: float  # of the front
    drag: float  # across the strip
    drift: float  # deflection by it
    beside: float  # silicone between the strip and what is next to it
    pull: float  # N, by flow along the strip
    settling: float  # time constant in which it comes back


def pour(job: Job) -> Pour | None:
    """Return what the pour does to a strip; None without slots.

    The front fills the length in `mold.fill_time`. The settling time is that of the first mode under tension,
    zeta l^2 / (pi^2 T), zeta the drag per speed; a beam's with pi^4 E I / l^4 (500.6 built in) in its place.
    """
    rod = strip(job)
    if rod is None:
        return None
    viscosity, speed = job.silicone.viscosity, rod.length / job.design.mold.fill_time
    wall, beside = _surroundings(job)
    cross_drag = drag(viscosity, speed, rod.depth, wall)
    beam = (math.pi**4 if rod.ends == "hinged" else 500.6) * rod.bending / rod.length**4
    stiffness = math.pi**2 * rod.tension / rod.length**2 + beam
    pull = drag(viscosity, speed, rod.depth, wall, along=True) * rod.length
    return Pour(speed, cross_drag, deflection(rod, cross_drag), beside, pull, cross_drag / speed / stiffness)


def _surroundings(job: Job) -> tuple[float, float]:
    """Least distance in mm from a strip's centre to the wall that its edge faces, and from a strip to what it
    could touch."""
    shape = job.section
    body = shapely.Polygon(polygon(shape.outline, GUARD_TOLERANCE))
    solids = [shapely.Polygon(polygon(s.loop(), GUARD_TOLERANCE)) for s in shape.slots]
    tree = shapely.STRtree(solids)
    _, distances = tree.query_nearest(solids, exclusive=True, return_distance=True)
    outline = min(float(body.exterior.distance(solid)) for solid in solids)
    walls = min(_ahead(slot, body) for slot in shape.slots)
    return walls, min(outline, float(distances.min()))


def _ahead(slot: SensorPlace, body: shapely.Polygon) -> float:
    far = math.hypot(*(body.bounds[i + 2] - body.bounds[i] for i in (0, 1)))
    centre = shapely.Point(slot.centre)
    rays = [shapely.LineString([slot.centre, slot.at(0.0, end)]) for end in (-far, far)]
    return min(float(centre.distance(body.exterior.intersection(ray))) for ray in rays)


def release_strain(job: Job) -> float:
    """Return by which strain the skin shortens when its strips, cast in under tension, are let go: the film's
    own, shared with the silicone by their stiffnesses along y, without the carrier. 0 where nothing is cast
    in."""
    rod = strip(job)
    if rod is None or job.design.mold.method != "cast-in":
        return 0.0
    shape = job.section
    film = rod.modulus * rod.section * len(shape.slots)
    rubber = job.silicone.young_modulus.value * shape.area
    return rod.stress / rod.modulus * film / (film + rubber)


class Lap(NamedTuple):
    """Film on its shim's tail: mm, and strain."""

    tail: float  # thickness of the shim there
    stack: float  # shim, glue and film
    notch: float | None  # the narrowest on its way; None where the end plates are off
    stretch: float  # of the slot's girth round it


def lap(job: Job) -> Lap | None:
    """Return the lap by which a film is drawn in; None where none is: without film, or cast in.

    A notch may come out narrower by its process's growth and tolerance, but is lapped until its shim goes in.
    """
    slot, film = job.skin.slot, job.design.film
    if slot is None or film is None or job.design.mold.method != "shim":
        return None
    tail, notch = slot.thickness, None
    if job.bent:
        maker, drawn = job.end_process, slot.thickness + 2 * job.design.mold.slit_clearance
        notch = max(slot.thickness, drawn - 2 * walls_close(job, maker) - maker.tolerance)
        room = notch - film.thickness - GLUE_THICKNESS
        passing = math.floor(1e6 * room + 1e-3) / 1e6  # a nanometre is rounding
        tail = min(slot.thickness, max(LEAST_TAIL, passing))
    stack = tail + GLUE_THICKNESS + film.thickness
    girth = slot.depth + slot.thickness
    return Lap(tail, stack, notch, max(0.0, (stack - slot.thickness) / girth))


def drawing_time(job: Job) -> float:
    """Return the seconds in which a strip is drawn in: `DRAWING_SECONDS`, or more where its drag asks for it.

    Call it where there is a lap.

    Couette flow in the coats on both faces, over the whole length, drags with 2 mu b l^2 / (coat t); that may
    be `MOST_PULL` of the film's yield force. The lap's own friction is the shim's to bear, not the film's.
    """
    slot, film = job.skin.slot, job.design.film
    if slot is None or film is None:
        raise ValueError("without a film nothing is drawn in")
    coat = max((slot.thickness - film.thickness) / 2, COAT_THICKNESS)
    thick = THICKENING * job.silicone.viscosity * 1e-6
    slow = 2 * thick * job.design.skin.length**2 / (coat * MOST_PULL * PVDF_YIELD * film.thickness)
    return max(DRAWING_SECONDS, slow)


def strip_count(job: Job) -> int:
    """Return how many strips go into the skins of a mold."""
    skin = job.skin
    return 2 * skin.count * job.design.mold.cavities if skin.slot else 0


def strips_per_mix(job: Job) -> int | None:
    """Return how many strips are drawn in with one mix of silicone; None where its pot life isn't known."""
    minutes = job.silicone.pot_life_min
    return None if minutes is None else int(60 * minutes * POT_SHARE / strip_seconds(job))


def strip_seconds(job: Job) -> float:
    """Return how long a strip takes with one mix, s: to coat it, to draw it in and to wipe its ends."""
    return job.cavity_process.handling_s + drawing_time(job)


class Pull(NamedTuple):
    """A test that a strip in the skin holds, by its lead."""

    force: float  # N
    by_film: bool  # whether the film is what limits it, not the bond
    shear: float  # MPa, that it puts on the bond's both faces


def pull_test(job: Job) -> Pull | None:
    """Return the pull that shows that a strip holds: `MOST_PULL` of the film's yield force, or of what the
    least bond worth having would take in shear, if that is less. None without film."""
    slot, film = job.skin.slot, job.design.film
    if slot is None or film is None:
        return None
    faces = 2 * slot.depth * job.design.skin.length
    by_film, by_bond = PVDF_YIELD * slot.depth * film.thickness, BOND_STRENGTH * faces
    force = MOST_PULL * min(by_film, by_bond)
    return Pull(force, by_film <= by_bond, force / faces)


RIVET_STRAIN = 0.5  # assumption: of a rivet's neck under the test, well below what breaks silicone
BOND_SHARE = 1 / 3  # assumption: of the least bond worth having, on a primed back


def pull_off(job: Job) -> float:
    """Return the pull, N, that shows that the carrier or bone holds the skin: on rivets' necks or a primed
    face; 0 where a bone's holes are straight, which promise nothing."""
    bone, skin = job.bone, job.design.skin
    if bone is not None and job.design.mold.bone_bond != "rivets":
        return BOND_SHARE * BOND_STRENGTH * float(bone.shadow(2, 0.0).area)
    rivets = bores(job.closed.first(PartRole.CARRIER), CutRole.RIVET)
    necks = bone.locks if bone else [math.pi * bore.radius**2 for bore in rivets]
    if bone or necks:
        behind = layers(job.design)[0] if job.design.shot else job.silicone
        return math.fsum(necks) * behind.young_modulus.value * RIVET_STRAIN
    return BOND_SHARE * BOND_STRENGTH * skin.area


def drift_in(job: Job, seconds: float) -> float:
    """Return by how much strips that are cast in give way, mm, where filling takes this long: as the front's
    speed, so by less than in `mold.fill_time`."""
    flow = pour(job)
    return flow.drift * job.design.mold.fill_time / seconds if flow else 0.0


def cure_of_films(job: Job) -> str:
    """Return how strips that are drawn in cure, as words."""
    material = job.silicone
    long = "as long as its data sheet asks" if material.cure_h is None else f"{material.cure_h:g} h"
    warm = "room temperature" if material.cure_c is None else f"{material.cure_c:g} °C"
    if material.cure_c is not None and material.cure_c > HIGHEST_FILM_TEMPERATURE:
        long, warm = "as long as its data sheet asks", f"{HIGHEST_FILM_TEMPERATURE:g} °C or less"
    return f"{long} at {warm}"


def drawing_findings(job: Job) -> list[Finding]:
    """Return the rules `strip lap`, `strip lead`, `strip batch` and `film heat`; none without film."""
    if job.design.film is None:
        return []
    joint = lap(job)
    if joint is None:  # a film that is drawn in has its own, cooler cure
        stuffs = [job.silicone, *(layers(job.design) if job.design.shot else ())]
        warm, most = max(stuff.cure_c or 0.0 for stuff in stuffs), HIGHEST_FILM_TEMPERATURE
        if warm <= most:
            return []
        remedy = f"a silicone, or a longer cure by its data sheet, at {most:g} °C or less"
        where = "film in the mold while it cures: it loses its charge"
        return [warning("film heat", where, warm, most, "°C", remedy)]
    findings = [*_notches(job, joint), *_slot(job, joint)]
    minutes = job.silicone.pot_life_min
    if minutes is not None and strips_per_mix(job) == 0:
        where, needs = "one strip, drawn in behind its shim", strip_seconds(job)
        remedy = "a thinner silicone or one with a longer pot life, a shorter skin, or a thicker slot"
        findings.append(error("strip batch", where, needs, 60 * minutes * POT_SHARE, "s", remedy))
    return findings


def _notches(job: Job, joint: Lap) -> Iterator[Finding]:
    """The lap against the combs' notches, where they are on its way; and the contact that stays out."""
    slot, film, choice = job.skin.slot, job.design.film, job.design.mold
    if joint.notch is None or slot is None or film is None:
        return
    if joint.stack > joint.notch + 1e-6:  # mm; a nanometre is rounding
        need = LEAST_TAIL + GLUE_THICKNESS + film.thickness
        maker = job.end_process
        least = (need - slot.thickness + maker.tolerance) / 2 + walls_close(job, maker)
        wide = math.ceil(1e3 * least - 1e-6) / 1e3  # whole micrometres
        remedy = (
            f"mold.slit_clearance of {wide:g} mm or more, a thinner film or a thicker slot, or a skin that "
            f"is straight along y; its shim's tail is thinned to {LEAST_TAIL:g} mm already"
        )
        where = "lap of film and shim, in the combs' notches"
        yield error("strip lap", where, joint.stack, joint.notch, "mm", remedy)
    if (out := job.lead - choice.end_plate) < LEAST_CONTACT:
        remedy = f"film.lead of {choice.end_plate + LEAST_CONTACT:g} mm or more"
        where = "lead beyond its end plate, in which it meets wet silicone"
        yield warning("strip lead", where, out, LEAST_CONTACT, "mm", remedy)


def _slot(job: Job, joint: Lap) -> Iterator[Finding]:
    """The lap against the slot's soft walls, which must not tear round it."""
    slot = job.skin.slot
    limit = SAFE_SHARE * job.silicone.elongation_at_break
    if joint.stretch <= limit or slot is None:
        return
    deeper = (joint.stack - slot.thickness) / limit - slot.thickness
    remedy = f"slot.depth of {math.ceil(1e3 * deeper) / 1e3:g} mm or more, a thinner film"
    remedy += ', a silicone that stretches further, or mold.method = "cast-in"'
    where = "lap of film and shim, stretching the slot's walls"
    yield error("strip lap", where, joint.stretch, limit, "", remedy)


def placement_error(job: Job) -> float:
    """Return how far a strip or shim may lie from its place in the section, mm: what growth and a coat
    leave of the slit clearance, and the tolerance of the process that makes the combs."""
    process = job.end_process
    return max(0.0, slit_play(job, process)) + process.tolerance


def strip_findings(job: Job) -> list[Finding]:
    """Return the rules `strip sag`, `strip stress`, `strip drift`, `strip release` and `strip place`, and
    those of drawing in; none without slots."""
    rod, flow = strip(job), pour(job)
    if rod is None or flow is None or job.skin.slot is None:
        return []
    cast = [*_sag(job, rod), *_stress(rod, flow)] if job.design.mold.method == "cast-in" else []
    moved = [*_drift(job, rod, flow), *_release(job, rod), *_place(job)]
    return [*cast, *moved, *drawing_findings(job)]


def _sag(job: Job, rod: Strip) -> Iterator[Finding]:
    """At rest in the silicone, which is how it cures; in air, before, its load is larger, but that passes."""
    slot = job.skin.slot
    load = weight(rod, job.silicone.density)
    sag, limit = abs(deflection(rod, load)), SAG_SHARE * (slot.offset if slot else 0.0)
    if sag > limit:
        remedy = f"film.tension of {straightening_tension(rod, load, limit):.2g} N or more, or a shorter skin"
        where = "strips, under their weight in silicone"
        yield warning("strip sag", where, sag, limit, "mm", remedy)


def _stress(rod: Strip, flow: Pour) -> list[Finding]:
    stress, limit = (rod.tension + flow.pull) / rod.section, MOST_PULL * PVDF_YIELD
    if stress <= limit:
        return []
    least = max(limit * rod.section - flow.pull, 0.0)
    remedy = f"film.tension of at most {least:.2g} N, or a thicker film; it yields at {PVDF_YIELD:g} MPa"
    severity = error if stress > PVDF_YIELD else warning
    return [severity("strip stress", "strips, under their tension", stress, limit, "MPa", remedy)]


def _drift(job: Job, rod: Strip, flow: Pour) -> Iterator[Finding]:
    """While the front passes; and whether a strip is back long before the silicone sets."""
    name = "strips" if job.design.mold.method == "cast-in" else "shims"
    limit = DRIFT_SHARE * flow.beside
    slower = f"mold.fill_time of {job.design.mold.fill_time * flow.drift / limit:.2g} s or more"
    stronger = ", more tension or a thicker film" if rod.tension else ", or a thicker slot"
    if flow.drift > limit:
        where = f"{name}, while silicone is poured round them"
        yield warning("strip drift", where, flow.drift, limit, "mm", slower + stronger)
    pot_life = job.silicone.pot_life_min
    if pot_life is not None and flow.settling > SETTLING_SHARE * 60 * pot_life:
        where, remedy = f"{name}, coming back after the pour", "a thinner silicone" + stronger
        limit = SETTLING_SHARE * 60 * pot_life
        yield warning("strip drift", where, flow.settling, limit, "s", remedy)


def _release(job: Job, rod: Strip) -> Iterator[Finding]:
    """A note: the skin comes out shorter than designed."""
    strain = release_strain(job)
    if strain > MOST_RELEASE:
        where, remedy = "skin, shortened by its strips", f"{rod.tension * MOST_RELEASE / strain:.2g} N"
        yield note("strip release", where, strain, MOST_RELEASE, "", f"film.tension of {remedy}")


def _place(job: Job) -> list[Finding]:
    """A note, or a warning beyond `MOST_UNBALANCE`.

    Stress across the film grows about as its distance from the axis (assumption). So a pair is out of balance
    by up to both errors by the offset.
    """
    slot = job.skin.slot
    off, offset = placement_error(job), slot.offset if slot else math.inf
    if off <= PLACE_SHARE * offset:
        return []
    remedy = (
        f"calibrate each pair: S1 and S2 may differ by {100 * 2 * off / offset:.0f} %; or a smaller "
        "slit_clearance, a finer process for the combs, or a larger design"
    )
    severity = warning if 2 * off / offset > MOST_UNBALANCE + 1e-9 else note
    return [severity("strip place", "strips in their slits", off, PLACE_SHARE * offset, "mm", remedy)]


def shim_sag(job: Job) -> float:
    """Return how far a shim hangs through between its combs, flat and not pulled straight, mm.

    A beam on two supports under its own weight, 5 q l^4 / (384 E I) (handbooks), across its thickness: an
    upright shim hangs by far less. 0 without slots or shims.
    """
    slot = job.skin.slot
    if slot is None or job.design.mold.method != "shim":
        return 0.0
    return 5 / 32 * STEEL_WEIGHT * job.design.skin.length**4 / (STEEL_MODULUS * slot.thickness**2)


def shim_findings(job: Job) -> list[Finding]:
    """Return a warning where a shim is so slender that its own weight moves the slot, and a note where
    straight stock would stay bent."""
    slot, sag, strain, findings = job.skin.slot, shim_sag(job), shim_bend(job), []
    if strain > SHIM_ELASTIC:  # below it buckles sideways, so the casting sheet asks for arcs in any case
        where, remedy = "shims, if bent on edge from straight stock", "cut them as arcs, as the sheet says"
        findings.append(note("shim bend", where, strain, SHIM_ELASTIC, "", remedy))
    if slot is None or sag <= SHIM_SAG_SHARE * slot.thickness:
        return findings
    limit = SHIM_SAG_SHARE * slot.thickness
    most = job.design.skin.length * (limit / sag) ** 0.25
    remedy = f"a skin.length of at most {most:.3g} mm, or a thicker slot; pull shims straight"
    where = "shims, sagging between their combs"
    return [*findings, warning("slender", where, sag, limit, "mm", remedy)]


def edge_strain(job: Job) -> float:
    """Return the strain that a strip takes, bent on edge into its slot's arc: half its depth by the arc's
    radius. 0 where slots are straight, and without any."""
    return job.skin.slot.depth / 2 / job.design.skin.radius_y if job.skin.slot else 0.0


def shim_bend(job: Job) -> float:
    """Return the strain that a straight shim would take, bent on edge into its slot's arc; 0 without
    shims."""
    return edge_strain(job) if job.design.mold.method == "shim" else 0.0
