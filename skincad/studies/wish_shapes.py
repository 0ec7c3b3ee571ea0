"""Castable shapes for a wish: pads in the paper's proportions, of which machines and mold refuse nothing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from operator import itemgetter
from typing import Any

from skincad.base.errors import InputError
from skincad.fabrication.films import FILM_ROOM
from skincad.fabrication.findings import design_findings
from skincad.fabrication.job import Job
from skincad.fabrication.rules import walls_close
from skincad.inputs.catalog import Own, with_own
from skincad.inputs.design import Design
from skincad.inputs.process import Process, processes

PITCHES = (1.0, 1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0)  # mm
MOST_RIDGES = 9  # the paper's number: each more takes two strips and two channels
COARSEST = 4.0  # mm, the pitch up to which a wide pad gets larger ridges, not more of them
LEAST_RIDGES = 3  # fewer can't tell outer from inner ridges
# of the pitch, as yamada-2002: a ridge's root, crown and fillets, and its slots' place
RIDGE = {"root_width": 0.75, "crown": 0.03, "tip_fillet": 0.05, "root_fillet": 0.08}
SLOT = {"depth": 0.25, "offset": 0.16, "elevation": 0.05}
# a ridge's height and tip by the pitch, and the skin's thickness by four pitches: yamada-2002's first, then
# softer ones
Form = tuple[float, float, float]
FORMS: tuple[Form, ...] = (
    (0.5, 0.5, 1.0),
    (0.7, 0.5, 1.0),
    (0.7, 0.5, 1.5),
    (0.9, 0.4, 2.0),
    (1.0, 0.3, 2.0),
)
THINNEST, THICKEST = 4.0, 10.0  # mm, of the first form
# of a ridge's height: how much lower than the middle crest the outer ones lie at most, as yamada-2002's, and
# on a skin that counts as flat
DROP, FLAT = 0.25, 0.001
# of the pitch: a pin's root, crown and fillet, and its foot's distance from the skin's edge; assumptions
PIN = {"root_diameter": 0.6, "crown": 0.06, "root_fillet": 0.05, "margin": 0.15}
MOST_PINS, LEAST_PINS = 100, 4  # that a pad gets; assumption: each is one place to feel
PIN_PITCHES = (*PITCHES, 10.0, 12.0, 15.0, 20.0, 25.0)  # mm; the last ones for as few pins on the largest pad
SURE_PROCESS = "sla"  # by which a pad is made that the wished process can't make
SMALLEST_RADIUS = 5.5  # by the width, as yamada-2002's: a fan of 10 degrees
SHIMS = (0.03, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)  # mm, precision sheet as it is sold
SLOT_SHARE = 0.05  # slot by pitch, at least
WIRE_SLIT = 0.01  # mm, a side, of shims in combs that are cut and lapped
DIGITS = 2  # of a chosen length
LEANING = 0.75  # of the narrower side, assumption: a higher pad bends more than it shears
STROKE_SHARE = 1 / 3  # of a gripper's opening, assumption: more is missed at the next object


@dataclass(frozen=True)
class Wish:
    """A pad of `width` (across the ridges) by `length` mm whose features of a `family` all touch a flat plate
    at `touch` N.

    `silicone`, `process` and `gripper` are names, `film` is a strip's thickness in mm, 0 for none,
    `thickness` the skin's, mm, None for any; `own` are the lab's own tables, by the design's key.
    """

    width: float
    length: float
    touch: float
    silicone: str
    process: str = "sla"
    gripper: str | None = None
    film: float = 0.028
    name: str = "pad"
    family: str = "ridge"
    thickness: float | None = None
    own: dict[str, Own | None] = field(default_factory=dict, compare=False)

    @cached_property
    def processes(self) -> dict[str, Process]:
        """All processes by name, the lab's own too."""
        return processes(self.design({}).printer)

    def design(self, tables: dict[str, dict[str, Any]]) -> Design:
        """Return a design of these tables, over those that every wish has."""
        data: dict[str, Any] = {
            **feature_tables(self, *next(shapes(self), (PITCHES[3], 1, FORMS[0]))),
            "name": self.name,
            "material": {"name": self.silicone},
            "mold": {"process": self.process},
            "contact": {"force": self.touch},
        }
        for key, table in tables.items():
            data[key] = {**data.get(key, {}), **table}
        if self.thickness is not None:
            data["skin"] = {**data["skin"], "thickness": self.thickness}
        for key in ("printer", "silicones", "grippers"):
            data = with_own(data, key, self.own.get(key))  # type: ignore[arg-type]  # a name of OwnTable
        return Design(**data)


def feature_tables(wish: Wish, pitch: float, count: int, form: Form) -> dict[str, dict[str, Any]]:
    """Return the tables of a flat skin and its features of a pitch, mm; `count` is of ridges alone."""
    height, tip, thickness = form
    high, pins = rounded(height * pitch), wish.family == "pin"
    sizes = {key: rounded(share * pitch) for key, share in (PIN if pins else RIDGE).items()}
    sizes |= {"pitch": pitch, "height": high, "tip_diameter" if pins else "tip_width": rounded(tip * pitch)}
    reach = wish.width if pins else (count - 1) * pitch
    return {
        "skin": {
            "curvature_radius": radius_for(FLAT * high, reach, wish.width),
            "thickness": rounded(thickness * usual_thickness(pitch)),
            "width": wish.width,
            "length": wish.length,
        },
        wish.family: {**sizes, **({"pattern": "hex"} if pins else {"count": count})},
    }


def radius_for(drop: float, reach: float, width: float) -> float:
    """Return the curvature radius, mm, at which the outer of ridges that span `reach` mm lie `drop` mm lower
    than the middle one; no smaller than a skin of this width takes."""
    return rounded(max(reach**2 / (8 * drop), SMALLEST_RADIUS * width))


class ObstacleError(Exception):
    """No shape is castable: `by` names the finding, or the key, that refused the last one, `remedy` what may
    help, and `excess` is by how many mm it is too large."""

    def __init__(self, by: str, remedy: str = "", excess: float = 0.0) -> None:
        self.by, self.remedy, self.excess = by, remedy, excess
        super().__init__(by)


WHATEVER_THE_RIDGES = ("build volume", "mold.mount")  # what blocks one shape blocks them all


def rounded(length: float) -> float:
    """Return a length, mm, of DIGITS digits."""
    return float(f"{length:.{DIGITS}g}")


def usual_thickness(pitch: float) -> float:
    """Return a skin's thickness, mm, with features of a pitch, mm, unless it has to be softer."""
    return min(max(4 * pitch, THINNEST), THICKEST)


def usual_pitch(width: float) -> float:
    """Return the pitch, mm, of the ridges that a width, mm, gets unless something stands against it."""
    return next((p for p in PITCHES if p >= COARSEST or _most(width, p) <= MOST_RIDGES), COARSEST)


def shapes(wish: Wish) -> Iterator[tuple[float, int, Form]]:
    """Yield pitch, count and form for a wish, the most like the paper first: its number of ridges or a few
    less, then larger and softer ones, then finer ones. Of pins as many as a pad gets, or larger ones."""
    width = wish.width
    if wish.family == "pin":
        for pitch in PIN_PITCHES:
            many = width * wish.length / (math.sqrt(0.75) * pitch**2)  # of a hexagonal pattern, about
            if LEAST_PINS <= many <= MOST_PINS:
                yield from ((pitch, 1, form) for form in FORMS[:3])
        return
    usual = usual_pitch(width)
    larger = [pitch for pitch in PITCHES if pitch >= usual]
    steps = [
        (place + softer, pitch, form)
        for place, pitch in enumerate(larger)
        for softer, form in enumerate(FORMS)
    ]
    finer = [(0, pitch, FORMS[0]) for pitch in reversed(PITCHES) if pitch < usual]
    for _, pitch, form in [*sorted(steps, key=itemgetter(0)), *finer]:
        if (count := _most(width, pitch)) >= LEAST_RIDGES:
            yield pitch, count, form


def _most(width: float, pitch: float) -> int:
    """How many ridges of a pitch fit on a width, mm."""
    root = (RIDGE["root_width"] + 2 * RIDGE["root_fillet"]) * pitch
    return max(0, math.floor((0.995 * width - root) / pitch) + 1)


def combs(wish: Wish) -> list[str]:
    """Return by what the end plates may be made, the wish's own machine first: finer ones for fine slots."""
    own = wish.processes.get(wish.process)
    finer = ["edm"] if own is None or not own.layer else ["sla", "edm"]
    return list(dict.fromkeys([wish.process, *finer])) if wish.film else [wish.process]


def castable_obstacle(design: Design) -> ObstacleError | None:
    """Return the rule or the machine that refuses a design's mold by more than a note; None for none."""
    try:
        findings = design_findings(Job(design))
    except InputError as refused:
        return ObstacleError(refused.key, refused.remedy)
    grave = [finding for finding in findings if finding.severity != "note"]
    if not grave:
        return None
    worst = next((f for f in grave if f.rule in WHATEVER_THE_RIDGES), grave[0])
    return ObstacleError(worst.rule, worst.remedy, worst.measured - worst.limit)


def design_of(wish: Wish, pitch: float, count: int, form: Form, end_plates: str) -> Design:
    """Return the wish's design in a shape, flat, with the slots and the play that its machines need. Raises
    ObstacleError where no such skin can be."""
    cutter = wish.processes[wish.process]
    tables = feature_tables(wish, pitch, count, form)
    feature = tables[wish.family]
    tip = max(feature.get("tip_fillet", 0.0), cutter.reach)
    if cutter.groove_ratio:
        tip = max(tip, rounded(feature["height"] / (2 * cutter.groove_ratio) + 0.005))
    if tip:
        feature["tip_fillet"] = tip
    makers = [cutter, *([wish.processes[end_plates]] if wish.film else [])]
    # by how much each wall comes nearer than it is drawn: growth, and a coat where one is needed
    nearer = [walls_close(Job(wish.design({})), maker) for maker in makers]
    play = max(maker.clearance + 2 * wall for maker, wall in zip(makers, nearer, strict=True))
    tables["mold"] = {"clearance": _up(play)}
    if wish.gripper is not None:
        tables["mold"]["mount"] = wish.gripper
    if wish.film:
        thick, comb = max(wish.film + FILM_ROOM, SLOT_SHARE * pitch), makers[-1]
        slot = next((shim for shim in SHIMS if shim >= thick - 1e-9), math.ceil(10 * thick) / 10)
        places = {key: rounded(share * pitch) for key, share in SLOT.items()}
        tables |= {"slot": {"thickness": slot, **places, "tilt": 0.0}, "film": {"thickness": wish.film}}
        slit = comb.tolerance + nearer[-1] if comb.layer else WIRE_SLIT
        if slot + 2 * slit < max(comb.gap, 2 * comb.reach):
            raise ObstacleError("gap")
        tables["mold"]["slit_clearance"] = _up(slit)
        if end_plates != wish.process:
            tables["mold"]["end_plate_process"] = end_plates
    try:
        return wish.design(tables)
    except InputError as refused:
        raise ObstacleError(refused.key, refused.remedy) from None


def _up(length: float) -> float:
    """A length, mm, rounded up to a micrometre."""
    return math.ceil(1000 * length - 1e-6) / 1000


def relaxed(wish: Wish, obstacle: ObstacleError) -> Wish | None:
    """Return the nearest wish without what stands against it; None where nothing is left to give up."""
    if obstacle.by == "build volume":
        longer = "length" if wish.length >= wish.width else "width"
        shorter = math.floor(getattr(wish, longer) - max(obstacle.excess, 1.0))
        return replace(wish, **{longer: shorter})
    if obstacle.by.startswith("mold.mount") and wish.gripper is not None:
        return replace(wish, gripper=None)
    if wish.film:
        return replace(wish, film=0.0)
    return replace(wish, process=SURE_PROCESS) if wish.process != SURE_PROCESS else None
