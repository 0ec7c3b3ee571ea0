"""A free strip between its two combs: what it weighs, what the pour does to it, and the pull that keeps it
straight.

A strip is a tie-rod under a uniform load across its thickness, its weak way, as if it lay flat: an upright
one sags far less. A film's ends count as hinged, a shim's as built in. The drag is that of slow flow (the
Reynolds number is below 1e-4) past a cylinder half as wide as the strip, the whole front's speed straight
across it: an upper estimate, for in a ridge's groove the silicone flows along the strip. Left out: the pull
of the front where it wets one side first, 2 gamma / gap on the depth, some times the drag in a template but
over a short length and for a moment. What the pour moves comes back with the time constant `settling`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import shapely

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.curves import polygon
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import GUARD_TOLERANCE, section, skin_of
from skincad.solids.shrinkage import scaled_for_shrinkage

GRAVITY = 9.81  # m/s2
PVDF_DENSITY = 1780.0  # kg/m3, source: piezo film technical manual (Measurement Specialties), table 1
PVDF_YIELD = 45.0  # MPa, source: there, 45 to 55 along the stretch axis
STEEL_DENSITY, STEEL_MODULUS = 7850.0, 200e3  # kg/m3, MPa, source: handbooks, spring steel
MOST_PULL = 1 / 3  # assumption: of the yield stress; more creeps in the hours of a cure
USUAL_PULL = 0.05  # assumption: of the yield stress, where no tension is given: straight, little to release
_STIFF = 1e-2  # u below which the tension's part is lost in rounding; it is u^2 / 2.5 there
_SLACK = 500.0  # u above which 1 / cosh u is below any float


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


def strip(design: Design) -> Strip | None:
    """Return what lies between the combs: the film where it is cast in, else the shim; None without slots."""
    slot, film, length = skin_of(design).slot, design.film, scaled_for_shrinkage(design).skin.length
    if slot is None:
        return None
    if design.mold.method == "shim" or film is None:
        return Strip(
            length=length,
            depth=slot.depth,
            thickness=slot.thickness,
            modulus=STEEL_MODULUS,
            density=STEEL_DENSITY,
            tension=0.0,
            ends="built in",
        )
    usual = USUAL_PULL * PVDF_YIELD * slot.depth * film.thickness
    tension = film.tension if film.tension is not None else usual
    return Strip(
        length=length,
        depth=slot.depth,
        thickness=film.thickness,
        modulus=film.young_modulus,
        density=PVDF_DENSITY,
        tension=tension,
        ends="hinged",
    )


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


def pour(design: Design) -> Pour | None:
    """Return what the pour does to a strip; None without slots.

    The front fills the length in `mold.fill_time`. The settling time is that of the first mode under tension,
    zeta l^2 / (pi^2 T), zeta the drag per speed; a beam's with pi^4 E I / l^4 (500.6 built in) in its place.
    """
    rod = strip(design)
    if rod is None:
        return None
    viscosity, speed = silicone(design).viscosity, rod.length / design.mold.fill_time
    wall, beside = _surroundings(design)
    cross_drag = drag(viscosity, speed, rod.depth, wall)
    beam = (math.pi**4 if rod.ends == "hinged" else 500.6) * rod.bending / rod.length**4
    stiffness = math.pi**2 * rod.tension / rod.length**2 + beam
    pull = drag(viscosity, speed, rod.depth, wall, along=True) * rod.length
    return Pour(speed, cross_drag, deflection(rod, cross_drag), beside, pull, cross_drag / speed / stiffness)


def _surroundings(design: Design) -> tuple[float, float]:
    """Least distance in mm from a strip's centre to the wall that its edge faces, and from a strip to what it
    could touch."""
    shape = section(design)
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


def release_strain(design: Design) -> float:
    """Return by which strain the skin shortens when its strips, cast in under tension, are let go: the film's
    own, shared with the silicone by their stiffnesses along y, without the carrier. 0 where nothing is cast
    in."""
    rod = strip(design)
    if rod is None or design.mold.method != "cast-in":
        return 0.0
    shape = section(design)
    film = rod.modulus * rod.section * len(shape.slots)
    rubber = silicone(design).young_modulus.value * shape.area
    return rod.stress / rod.modulus * film / (film + rubber)
