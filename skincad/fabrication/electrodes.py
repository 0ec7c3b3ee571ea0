"""The electrodes on a strip, its capacitance, and how the leads fan out to a board.

Film feels wherever metal lies on both of its faces. So the leads of the faces are offset, as is usual for
small film (Measurement Specialties, piezo film technical manual, offset lead-attach tabs): the front's runs
along the strip's edge away from the ridge, the back's along the other, and they end in pads beside each other
on a tab. A tab may be wider than the slot: of a strip that is drawn in, the other end goes through the slot.

In a strip's own frame: x along it, 0 in the skin's middle, its wiring side at +x; z across, the ridge below.

How the tabs of a skin's strips come from their slots to a board: turned upright, spread to its grid. At its
slots a tab may stand nearer to the next than a contact is thick, and tabs of leaning slots cross. Leads are
thin across and bend aside by an S of two arcs: that needs lead.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import shapely

from skincad.circuit.network import PICO, capacitance, electrode
from skincad.fabrication.films import GAUGE_TOLERANCE, LEAST_LEAD, least_width
from skincad.fabrication.job import Job
from skincad.fabrication.rules import Finding, error, note, warning
from skincad.inputs.skin_tables import Film
from skincad.shape.curves import Loop, Point, loop, rectangle
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import section
from skincad.solids.inserts import PITCH, fan_lead, fan_offset

PAD = (3.0, 1.5)  # mm, length and width; assumption: those crimps' conductors are 1.27 wide (TE 108-9024)
EDGE = 0.5  # mm, assumption: bare film round pads on their tab, by which it is held
LINK = 1.0  # mm, assumption: width of the metal from a lead to its pad
SHOULDER = 0.5  # mm, assumption: fillet between strip and tab, or the film tears there
LABEL = (4.5, 1.0)  # mm: room along a tab, in which "15 S2" is 3.9 long; height of letters, assumption
CORNER = 1.0  # mm, assumption: legs of the corner cut off a tab at the ridge's side, to be seen and felt
PERMITTIVITY = (12.5, 0.5)  # relative, and its error; source: data sheets of PVDF film, 12 to 13
COPLANAR = 0.12  # pF/mm of lead, source: see circuit/network.py, on a half space of film


def half_gap(film: Film, depth: float) -> float:
    """Return half of what lies between the two faces' leads across a strip, mm: each may be off by the
    registration. Where that leaves no lead, a third of the electrode, and `electrode_findings` says so."""
    return min(film.registration, (depth / 2 - film.margin) / 3)


def half_tab(film: Film, depth: float) -> float:
    """Return half the width of the tab, mm: for the pads, and for the label beside the leads."""
    return max((PITCH + PAD[1]) / 2 + _edge(film), label_offset(depth) + LABEL[1] + EDGE)


def label_offset(depth: float) -> float:
    """Return how far from a tab's middle its label begins, mm: clear of the leads, which a mark could cut."""
    return depth / 2 + EDGE / 2


def tab(film: Film) -> tuple[float, float]:
    """Return where the pads begin and where the tab ends, mm beyond the straight lead: first the label, and
    the pads near the end, which crimps and clinchers grip."""
    first = SHOULDER + LABEL[0] + _edge(film)
    return first, first + PAD[0] + CORNER + _edge(film)


def _edge(film: Film) -> float:
    return max(EDGE, film.margin)


def faces(
    film: Film, depth: float, half: float, straight: float
) -> tuple[Loop, Loop, Loop, tuple[Loop, Loop]]:
    """Return the metal of a strip of this `depth` in a skin of length 2 `half`, whose straight part ends at
    x = `straight`, mm: outlines of the front, which is the + side, and of the back, both as seen from the
    front; where they overlap; and their pads.

    A lead fills its half of the strip up to the cut: there the other face is bare, so that no cut shorts it.
    """
    e, inside, i = depth / 2 - film.margin, half - film.margin, half_gap(film, depth)
    first, out = straight + tab(film)[0], (PITCH + PAD[1]) / 2
    pad = (first, out - PAD[1], first + PAD[0], out)
    boxes = [
        (-inside, -e, inside, e),
        (inside, i, first + LINK, min(depth / 2, out)),
        (first, i, first + LINK, out),
        pad,
    ]
    front = _outline(boxes)
    back = _outline([(left, -high, right, -low) for left, low, right, high in boxes])
    left, low, right, high = pad
    pads = rectangle(left, right, low, high), rectangle(left, right, -high, -low)
    return front, back, rectangle(-inside, inside, -e, e), pads


def _outline(boxes: list[tuple[float, float, float, float]]) -> Loop:
    """The outline of boxes that touch each other, counterclockwise."""
    whole = shapely.normalize(shapely.unary_union([shapely.box(*box) for box in boxes]).simplify(0.0))
    return loop([Point(x, z) for x, z in shapely.orient_polygons(whole).exterior.coords[:-1]])


def strip_capacitance(job: Job) -> tuple[float, float, float]:
    """Return what a meter reads between a strip's pads, its error, and what its leads add at most, pF.

    The error: the faces' overlap where both are off by the registration across the strip, the film's
    permittivity and thickness. Call where there are film and slot.
    """
    slot = job.skin.slot
    assert job.design.film is not None
    assert slot is not None
    film = job.design.film
    value = capacitance(electrode(job.design), film.thickness, PERMITTIVITY[0]) / PICO
    narrower = 2 * film.registration / (slot.depth - 2 * film.margin)
    share = math.hypot(narrower, PERMITTIVITY[1] / PERMITTIVITY[0], GAUGE_TOLERANCE)
    return value, share * value, COPLANAR * (job.lead + tab(film)[0])


def masked(job: Job) -> float:
    """Return how much of lead and tab is masked while a strip is drawn in, mm: no mask passes a notch; 0
    without film."""
    if job.design.film is None:
        return 0.0
    plate = job.design.mold.end_plate if job.bent else 0.0
    return tab(job.design.film)[1] + max(0.0, job.lead - plate)


def electrode_findings(job: Job) -> list[Finding]:
    """Return the rules `lead width`, `electrode margin` and `strip tab`; none without film.

    A lead's width is where it leaves its electrode, and along the strip's edge, at the worst of the
    tolerances.
    """
    slot = job.skin.slot
    if job.design.film is None or slot is None:
        return []
    film, findings = job.design.film, list[Finding]()
    needs = film.cut_tolerance + film.registration
    lost = film.registration + max(film.margin, needs)
    narrowest = slot.depth / 2 - lost
    if narrowest < LEAST_LEAD - 1e-9:  # mm, rounding
        deep = math.ceil(1e3 * least_width(lost) - 1e-6) / 1e3
        remedy = f"slot.depth of {deep:g} mm or more, or a finer film.registration and film.cut_tolerance: "
        remedy += "two leads lie side by side in a strip"
        where = "leads of both faces, side by side in a strip"
        findings.append(error("lead width", where, narrowest, LEAST_LEAD, "mm", remedy))
    if film.margin < needs - 1e-9:
        where = "electrodes, bare at a cut edge: a cut through both shorts them"
        remedy = f"leave film.electrode_margin out, or {needs:g} mm; or a finer cutter and registration"
        findings.append(warning("electrode margin", where, film.margin, needs, "mm", remedy))
    return [*findings, *_tab(job, film)]


def _tab(job: Job, film: Film) -> Iterator[Finding]:
    """A tab outside an end plate, which then must slide off its pins along the lead before comb and keeper
    part round it. The end plates of straight shims are off before there is a film."""
    thick, cast_in = job.design.mold.end_plate, job.design.mold.method == "cast-in"
    if not cast_in and not job.bent:
        return
    lead = job.lead
    free = lead if cast_in else lead - thick
    if free < thick:
        where = f"lead between end plate {film.wiring_side} and the tab with the pads"
        remedy = f"film.lead of {lead + thick - free:g} mm or more, for the plate to slide off its pins"
        yield warning("strip tab", where, free, thick, "mm", remedy)


class FanOut(NamedTuple):
    """Strips by x, the least distance of two neighbours' tabs as their slots hold them and between slots, how
    far the outermost is bent aside, and the lead that takes, mm."""

    strips: tuple[SensorPlace, ...]
    tab_gap: float
    spacing: float
    offset: float
    lead: float

    @property
    def first(self) -> str:
        """The first strip's name."""
        return f"{self.strips[0].feature} {self.strips[0].side}"

    @property
    def last(self) -> str:
        """The last strip's name."""
        return f"{self.strips[-1].feature} {self.strips[-1].side}"


def fan_out(job: Job) -> FanOut | None:
    """Return how the strips of one skin spread to a board's grid of `PITCH`; None without film."""
    film, slot = job.design.film, job.skin.slot
    if film is None or slot is None:
        return None
    cast = job.cast if job.design.mold.method == "cast-in" else job.design
    strips = tuple(sorted(section(cast).slots, key=lambda place: place.centre.x))
    half = half_tab(film, slot.depth)
    tabs = [shapely.LineString([s.at(0.0, -half), s.at(0.0, half)]) for s in strips]
    return FanOut(
        strips,
        min(a.distance(b) for a, b in pairwise(tabs)) - film.thickness,
        min(b.centre.x - a.centre.x for a, b in pairwise(strips)),
        fan_offset(cast),
        fan_lead(cast),
    )


def fan_out_findings(job: Job) -> Iterator[Finding]:
    """A note where tabs cross. That contacts side by side need a longer lead, the casting sheet says."""
    spread, film = fan_out(job), job.design.film
    if spread is None or film is None or spread.tab_gap > 0:
        return
    where = "tabs of neighbouring strips, which cross as their slots hold them"
    remedy = "turn each tab upright on its lead before the next one is laid in; or a smaller slot.tilt"
    yield note("strip tabs", where, spread.tab_gap, 0.0, "mm", remedy)
