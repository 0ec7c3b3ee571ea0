"""From a wish to a design: a castable pad of a size, all of whose features touch at a wanted force.

The shape keeps the paper's proportions (wish_shapes.py). How much curvature the force bears is first
estimated in closed form and then checked by a better model; most of the parts have to pass, too.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import product
from operator import itemgetter
from time import perf_counter

import numpy as np

from skincad.base.errors import InputError, RefusedError, require_number
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.base.result import Record, Result, item, record, reported, reported_from
from skincad.fabrication.films import FilmOffers, film_offers
from skincad.fabrication.job import Job
from skincad.inputs.catalog import Own
from skincad.inputs.design import Design
from skincad.inputs.gripper import Gripper, gripper_named
from skincad.inputs.silicone import silicones as listed_silicones
from skincad.mechanics.check import check, mesh_tolerance
from skincad.mechanics.models.pin_cell import hertz
from skincad.mechanics.validity import (
    LARGEST_STRAIN,
    crown_radius,
    limits,
    plane_modulus,
    ridge_strain,
    tipping,
)
from skincad.mechanics.verdict import ContactCheck, Holding
from skincad.shape.skin import skin_of
from skincad.studies.advice import two_digits
from skincad.studies.holding import (
    asked_mass,
    first_grips,
    hears,
    holding_of,
    lift_signal,
    with_signal,
)
from skincad.studies.query import first_able
from skincad.studies.solving import MODELS
from skincad.studies.wish_reasons import (
    BrokenWish,
    Choice,
    broken_wishes,
    choices,
    held_reason,
    thick_warnings,
)
from skincad.studies.wish_shapes import (
    DROP,
    FLAT,
    WHATEVER_THE_RIDGES,
    ObstacleError,
    Wish,
    castable_obstacle,
    combs,
    design_of,
    radius_for,
    relaxed,
    rounded,
    shapes,
    usual_thickness,
)

WISHED = "ridge", "pin"  # families
ROUGH = "linear", "reduced", "winkler"  # the first that takes a design says what another thickness gives
USUAL = "usual"
USUAL_SIZE, USUAL_TOUCH = (24.0, 30.0), 1.0  # mm, N
USUAL_PROCESS, USUAL_FILM = "sla", "pvdf-28um"  # a desktop printer; a gauge that is sold
SMALLEST, LARGEST = 5.0, 200.0  # mm
TOUGH = 3.0  # least elongation at break of a silicone that is chosen: it is pulled out of a mold
PASSING = 0.9  # of all parts
AIM = 0.95  # the same, by the search's model
# standard deviations of a crest that the plate comes down beyond the lowest one: set on the seeds 8000 to
# 8013 of bench/table_wishes.py so that AIM of the parts pass
CREST_SPREADS = 4.5
SEARCH_CHECKS, FORCE_CHECKS = 3, 3
JUST_ENOUGH = 0.9  # the same, of a skin of the usual thickness, which its check judges
ENOUGH = 1.3  # room that a flat design is to have: the closed form may be off by as much
EDGE_SHARE = 1.25  # an outer ridge's force on a flat skin by the closed form's, about
LARGEST_DROP = 0.6  # of the way that the plate comes down
MORE_FORCE = 1.4  # factor of the next force that is tried where one is not enough
MOST_FORMS = 80  # shapes whose mold is looked at
HOLDS = 0.95  # of the drawn lifts: an object's wish is met
FEW_LIFTS, MOST_HELD = 8, 3  # lifts that tell designs apart, and how many others get them
SECONDS = 28.0  # in which a wish is to be answered
LEAST_SECONDS = 6.0  # of the last check
_UNITS = {"": 1.0, "mm": 1.0, "cm": 10.0, "in": 25.4, "um": 1e-3, "µm": 1e-3, "N": 1.0, "mN": 1e-3}
_NUMBER, _LENGTH = r"(\d+(?:\.\d*)?|\.\d+)\s*", r"(mm|cm|in)?\s*"
_SIZE = rf"\s*{_NUMBER}{_LENGTH}[x*\u00d7]\s*{_NUMBER}{_LENGTH}"
_FILM = rf"(?i:(?:pvdf-?)?{_NUMBER}(um|µm|mm)?\s*)"
# a text's pattern, rule and example, and the unit that its number has without one; the ends, and their unit
_AMOUNTS = {
    "touch": (rf"{_NUMBER}(N|mN)?\s*", "a force", "as in 1N or 500mN", "", (0.02, 500.0), "N"),
    "thickness": (rf"{_NUMBER}{_LENGTH}", "a length", "as in 8 or 8mm", "", (1.0, 50.0), "mm"),
    "film": (_FILM, "a thickness, or none", "as in pvdf-28um or 0.028mm", "um", (0.004, 0.5), "mm"),
}


@record()
class WishResult(Result):
    """The design for a wish, with its check."""

    shown_by = "skincad.outputs.studies:WISH"
    design: Design
    check: ContactCheck = item(meaning="of the design, at its force")
    choices: tuple[Choice, ...] = item(meaning="what was chosen, and why")
    trade: tuple[Trade, ...] = item(meaning="what a thinner and a thicker skin would give")
    warnings: tuple[str, ...] = item(meaning="what else is to be known of the pad")
    broken: tuple[BrokenWish, ...] = item(
        meaning="wishes that are not met, or of which that is undecided; none if all are met"
    )
    seconds: dict[str, float] = item(meaning="wall time, s")

    name = reported_from("design.name", meaning="of the design")

    @reported(meaning="whether the design passes its check and meets every wish")
    def passed(self) -> bool:
        """Whether the design passes its check and meets every wish."""
        return not self.broken and meets(self.check)

    @reported(meaning="film that can be bought for it, as check --film has it; null without slots")
    def film_offers(self) -> FilmOffers | None:
        """Film that can be bought for the design; None without slots."""
        return film_offers(self.design) if self.design.slot else None

    @property
    def exit_status(self) -> int:
        """0 where every wish is met, else 1."""
        return 0 if self.passed else 1


@record()
class Trade(Record):
    """The chosen design with another thickness."""

    thickness: float = item("mm", "of the skin under its features")
    all_touch_force: Estimate = item("N", "that all features need")
    passing: Estimate | None = item("1", "share of the parts that pass; null where nobody knows it")


def trade(design: Design, known: ContactCheck) -> tuple[Trade, ...]:
    """Return what half of the usual thickness, the usual one and twice it give, by the model that is quick
    and knows the yield; what is `known` of the design itself is not asked again. Of a thickness that can't
    be, nothing."""
    pitch, rows = design.spacing, []
    for share in (0.5, 1.0, 2.0):
        try:
            other = design.with_(skin={"thickness": rounded(share * usual_thickness(pitch))})
            model = first_able(ROUGH, other)
            again = other != design or known.model != model
            verdict = check(other, model=model, tol=mesh_tolerance(model, None)) if again else known
        except (InputError, RefusedError):
            continue
        parts = verdict.manufacture.passing if verdict.manufacture else None
        thick, needed = other.skin.thickness, verdict.all_touch_force
        rows.append(Trade(thickness=thick, all_touch_force=needed, passing=parts))
    return tuple(rows)


def meets(verdict: ContactCheck, share: float = PASSING) -> bool:
    """Return whether all ridges surely touch, and in at least this share of parts as they come out."""
    parts = verdict.manufacture.passing.value if verdict.manufacture else None
    return verdict.passed and (parts is None or parts >= share)


def design_for(
    *,
    size: str | tuple[float, float] | None = None,
    touch: str | float | None = None,
    silicone: str | None = None,
    process: str = USUAL_PROCESS,
    gripper: str | None = None,
    hold: str | float | None = None,
    film: str | float | None = USUAL,
    family: str = "ridge",
    thickness: str | float | None = None,
    name: str = "pad",
    printer: Own | None = None,
    silicones: Own | None = None,
    grippers: Own | None = None,
    progress: Progress | None = None,
) -> WishResult:
    """Return a castable design for a wish, checked, with what was chosen and why.

    `size` is width by length, as (24, 30) in mm or "24x30" or "2.4x3cm"; if None that of the gripper's face.
    `touch` is the force in N (or "500mN") at which all features are to touch. `silicone` is a name; if None
    the hardest that feels the force. `film` is a strip's thickness, as "pvdf-28um" or 0.028 mm, or "none";
    the usual one is pvdf-28um in ridges, and pins have none. `family` is "ridge" or "pin". `thickness` is the
    skin's under its features, mm; if None the usual one, or thicker where only that is soft enough. Where a
    wish can't be met the nearest design is returned, and `broken` says which wish that is. It takes about
    30 s. `hold` is an object's mass, as "0.3kg", that the `gripper` is to hold: other silicones and shapes
    are tried too, and of those whose films are heard the one that holds most drawn lifts is taken (`check`
    says which lifts these are); met is that where it holds HOLDS of them, and undecided where it
    holds fewer but the share's 95 % interval includes HOLDS. That takes one or two minutes more.
    Raises InputError for a wish that is none, RefusedError where no model can judge any design for it.
    """
    began = perf_counter()
    if family not in WISHED:
        raise InputError("family", "has no wishes", family, f"take {' or '.join(WISHED)}, or --template")
    if film == USUAL:
        film = USUAL_FILM if family == "ridge" else None
    if family == "pin" and film_of(film):
        raise InputError("film", "needs ridges, and pins have none", film, "leave it out")
    own = {"printer": printer, "silicones": silicones, "grippers": grippers}
    wish = Wish(
        *USUAL_SIZE,
        USUAL_TOUCH if touch is None else force_of(touch),
        silicone or "dragon-skin-30",
        process=process,
        gripper=gripper,
        film=film_of(film),
        name=name,
        family=family,
        thickness=None if thickness is None else thickness_of(thickness),
        own=own,
    )
    base = wish.design({})  # raises InputError for names that nobody knows
    face = gripper_named(gripper, base.grippers or {}) if gripper else None
    mass = None if hold is None else held_mass(hold, wish, base)
    width, length = size_of(size, face)
    wish = replace(wish, width=width, length=length)
    # those that can be pulled out of a mold, the hardest first
    rows = listed_silicones(base.silicones)
    tough = [key for key, row in rows.items() if (row.elongation_at_break or 0.0) >= TOUGH]
    tough.sort(key=lambda key: -rows[key].young_modulus.value)
    names = [silicone] if silicone else tough
    search = _Search(wish, names, progress or (lambda *_: None), began)
    design, verdict = search.result()
    for_hold: dict[str, str] = {}
    if mass is not None and gripper is not None and hears(design):
        design, verdict, for_hold = search.holding_most(design, verdict, mass, gripper)
    verdict = with_signal(verdict, design)
    given = {"skin": size, "material.name": silicone, "skin.thickness": thickness}
    return WishResult(
        design=design,
        check=verdict,
        choices=choices(design, [key for key, value in given.items() if value is not None], for_hold),
        trade=trade(design, verdict),
        warnings=thick_warnings(design, face),
        broken=broken_wishes(
            wish, design, search.given_up, verdict, met=meets(verdict), mass=mass, holds=HOLDS
        ),
        seconds={"total": perf_counter() - began},
    )


def held_mass(hold: str | float, wish: Wish, base: Design) -> float:
    """Return the mass, g, of an object to hold; raises InputError for a wish that can't be one of that."""
    if not wish.film:
        rule = "needs films, by which a slip is heard"
        raise InputError("hold", rule, hold, "leave out film = none, and take ridges")
    if wish.gripper is None:
        raise InputError("hold", "needs a gripper that holds it", hold, "name one, as robotiq-2f85")
    return asked_mass(hold, wish.gripper, base.grippers or {})


def size_of(size: str | tuple[float, float] | None, face: Gripper | None = None) -> tuple[float, float]:
    """Return width and length, mm; those of a gripper's face, or the usual ones, where none are given."""
    if size is None:
        return (face.width, face.length) if face else USUAL_SIZE
    if isinstance(size, str):
        match = re.fullmatch(_SIZE, size)
        if match is None:
            raise InputError("size", "must be width x length", size, "as in 24x30 or 2.4x3cm")
        unit = match[4] or match[2] or ""
        size = float(match[1]) * _UNITS[match[2] or unit], float(match[3]) * _UNITS[unit]
    if not isinstance(size, tuple | list) or len(size) != 2:
        raise InputError("size", "must be width and length", size, "as in (24, 30)")
    rule = f"must be {SMALLEST:g} to {LARGEST:g} mm"
    for side in size:
        require_number("size", side, lambda value: SMALLEST <= value <= LARGEST, rule)
    return float(size[0]), float(size[1])


def _amount(key: str, value: str | float) -> float:
    """A number of _AMOUNTS, or a text with a unit, between its ends."""
    pattern, kind, example, usual, (low, high), unit = _AMOUNTS[key]
    if isinstance(value, str):
        match = re.fullmatch(rf"\s*{pattern}", value)
        if match is None:
            raise InputError(key, f"must be {kind}", value, example)
        written = match[2] or usual
        value = float(match[1]) * _UNITS[written if written in _UNITS else written.lower()]
    require_number(key, value, lambda number: low <= number <= high, f"must be {low:g} to {high:g} {unit}")
    return float(value)


def force_of(touch: str | float) -> float:
    """Return a force, N."""
    return _amount("touch", touch)


def thickness_of(thickness: str | float) -> float:
    """Return a skin's thickness, mm."""
    return _amount("thickness", thickness)


def film_of(film: str | float | None) -> float:
    """Return a film's thickness, mm; 0 for none."""
    return 0.0 if film in (None, "none") else _amount("film", film)


@dataclass(frozen=True)
class _Candidate:
    """A design that may hold an object: whether it bears the first grips and is heard, the share of a few
    lifts, its check, and the keys that were chosen for that."""

    promise: tuple[bool, bool]
    share: float
    design: Design
    verdict: ContactCheck
    keys: tuple[str, ...]

    @property
    def enough(self) -> bool:
        """Whether no other design needs to be looked for."""
        return all(self.promise) and self.share >= HOLDS


@dataclass
class _Search:
    """One wish on its way to a design. `names` are the silicones that may be taken, the hardest first;
    `given_up` says which part of the wish each finding cost."""

    asked: Wish
    names: Sequence[str]
    progress: Progress
    began: float
    given_up: dict[str, str] = field(default_factory=dict)
    thickest: float = 1.0  # of the usual thickness: the usual one first
    seen: dict[tuple[Design, str], ContactCheck] = field(default_factory=dict)
    verdict: ContactCheck = field(init=False)  # the search's last

    def result(self) -> tuple[Design, ContactCheck]:
        """Return the design and its check: of the usual thickness where that passes, else thicker."""
        asked = self.asked
        flat = self._flat_design()
        design, enough = self._curved(flat, PASSING)
        if enough:
            return design, self.verdict
        self.asked, self.thickest, self.given_up = asked, math.inf, {}
        flat = self._flat_design()
        design, enough = self._curved(flat)
        if not enough and (later := self.names[self.names.index(str(flat.material.name)) + 1 :]):
            softer = flat.with_(material={"name": later[0]})
            if room(softer):
                flat = softer
                design, enough = self._curved(flat)
        if not enough:
            design = self._at_nearest_force(flat)
        verdict = self._last_check(design)
        if enough and design != flat and not meets(verdict):
            self._check(flat)
            return flat, self._last_check(flat)
        return design, verdict

    def _flat_design(self) -> Design:
        """The first castable flat design that is soft enough by the closed form; or else the nearest."""
        self.progress("shape and mold")
        wish = self.asked = replace(self.asked, silicone=self.names[0])
        while True:
            try:
                return self._best(wish)
            except ObstacleError as obstacle:
                less = relaxed(wish, obstacle)
                if less is None or min(less.width, less.length) < SMALLEST:
                    words, asked = f"has no castable pad ({obstacle.by})", f"{wish.width:g}x{wish.length:g}"
                    raise InputError("size", words, asked, "take a larger one") from None
                for what in ("width", "length", "gripper", "film", "process"):
                    if getattr(less, what) != getattr(wish, what):
                        self.given_up[what] = obstacle.remedy if what == "gripper" else obstacle.by
                wish = less

    def _best(self, wish: Wish) -> Design:
        """The first castable design that is soft enough; where none is, the softest. Raises ObstacleError
        where none of those that are tried is castable."""
        options = [option for option in self._options(wish) if option[2] <= self.thickest]
        least = ENOUGH if self.thickest > 1.0 else JUST_ENOUGH
        enough = sorted((option for option in options if option[1] >= least), key=itemgetter(2))
        others = sorted((option for option in options if option[1] < least), key=itemgetter(1), reverse=True)
        last = ObstacleError("size")
        for design, _, _ in [*enough, *others][:MOST_FORMS]:
            obstacle = castable_obstacle(design)
            if obstacle is None:
                return design
            last = obstacle
            if last.by.startswith(WHATEVER_THE_RIDGES):
                break
        raise last

    def _options(self, wish: Wish) -> Iterator[tuple[Design, float, float]]:
        """Flat designs with their room, 0 for none, and their thickness by the usual one, the best first: of
        several silicones the hardest that does, in the first shape."""
        for end_plates in combs(wish):
            for pitch, count, form in shapes(wish):
                try:
                    design = design_of(wish, pitch, count, form, end_plates)
                except ObstacleError:
                    continue
                thick = form[2] if wish.family == "ridge" else 1.0  # pins are soft by being few
                alike = (design.with_(material={"name": name}) for name in self.names)
                options = [(other, room(other), thick) for other in alike]
                bearing = [option for option in options if option[1]] or options[:1]
                yield next((option for option in bearing if option[1] >= ENOUGH), bearing[-1])

    def _curved(self, flat: Design, share: float = AIM) -> tuple[Design, bool]:
        """The design with as much of the paper's curvature as its force bears, and whether a `share` of its
        parts pass: of the usual thickness as `check` judges it, which is the last word then."""
        if not room(flat):
            return flat, False
        high, down, spread = flat.heights[0], _estimate(flat)[0], _crest_spread(flat)
        drop = min(DROP * high, max(min(down - spread, LARGEST_DROP * down), FLAT * high))
        for left in reversed(range(SEARCH_CHECKS)):
            design = bent(flat, drop)
            verdict = self._check(design)
            if meets(verdict, share) and castable_obstacle(design) is None:
                return design, True
            if drop <= FLAT * high or verdict.out_of_range:
                break
            drop = FLAT * high if left == 1 else max(drop / 2, FLAT * high)
        return flat, False

    def _at_nearest_force(self, flat: Design) -> Design:
        """The flat design at the smallest force, of a few tried, at which enough parts pass."""
        size, force, design = room(flat), self.asked.touch, flat
        if not size:
            flat = bent(flat, DROP * flat.heights[0])
            force /= max(1.0, _estimate(flat)[1])
        elif size < 1.0:
            force /= size
        for _ in range(FORCE_CHECKS):
            design = flat.with_(contact={"force": two_digits(force, up=True)})
            verdict = self._check(design)
            if meets(verdict, AIM) or perf_counter() - self.began > SECONDS:
                break
            force *= 1 / MORE_FORCE if verdict.out_of_range else MORE_FORCE
        return design

    def holding_most(
        self, design: Design, verdict: ContactCheck, mass: float, gripper: str
    ) -> tuple[Design, ContactCheck, dict[str, str]]:
        """The design whose films are heard and which holds most of the drawn lifts, of those that pass; its
        check with the lifts; and the keys that were chosen for it, each with the reason.

        A few lifts tell which designs are worth more. The skin has to bear the drawn first grips, too.
        """
        largest = max(first_grips(mass, gripper, design.grippers or {}))

        def promise(other: Design) -> tuple[bool, bool]:
            return _bears(other, largest), lift_signal(other).heard

        def lifts(other: Design, count: int | None = None) -> Holding:
            def stage(name: str, *_: object) -> None:
                self.progress(f"{other.count} ridges of {other.material.name}, {name}")

            return holding_of(other, mass, gripper, lifts=count, progress=stage)

        def candidate(other: Design, judged: ContactCheck, keys: tuple[str, ...]) -> _Candidate:
            return _Candidate(promise(other), lifts(other, FEW_LIFTS).share or 0.0, other, judged, keys)

        best = candidate(design, verdict, ())
        rivals = [best]
        others = [] if best.enough else [*self._others(design)]
        self.thickest = math.inf  # the search's model judges
        for other, keys in sorted(
            others, key=lambda row: (promise(row[0]), lift_signal(row[0]).level), reverse=True
        ):
            if best.enough or len(rivals) > MOST_HELD:
                break
            if meets(judged := self._check(other)):
                rivals.append(candidate(other, judged, keys))
                best = max(best, rivals[-1], key=lambda row: (row.promise, row.share))
        most = all(row is best or row.share < best.share for row in rivals)
        why = held_reason(best.design, len(rivals), FEW_LIFTS, most=most)
        if best.keys:
            best = replace(best, verdict=self._check(best.design, last=True))
        held = replace(best.verdict, holding=lifts(best.design))
        return best.design, held, dict.fromkeys(best.keys, why)

    def _others(self, design: Design) -> Iterator[tuple[Design, tuple[str, ...]]]:
        """Castable designs that are soft enough, in other silicones, or with larger or smaller ridges; and
        the keys that differ."""
        wish = replace(self.asked, silicone=str(design.material.name))
        drop = max(skin_of(design).crests) - min(skin_of(design).crests)
        options: list[tuple[Design, tuple[str, ...]]] = [
            (design.with_(material={"name": name}), ("material.name",))
            for name in self.names
            if name != design.material.name
        ]
        pitches = {design.spacing}
        for end_plates, (pitch, count, form) in product(combs(wish), shapes(wish)):
            if pitch not in pitches:
                with suppress(ObstacleError):
                    other = bent(design_of(wish, pitch, count, form, end_plates), drop)
                    options.append((other, ("ridge.pitch",)))
                    pitches.add(pitch)
        for other, keys in options:
            if room(other) >= JUST_ENOUGH and castable_obstacle(other) is None:
                self.progress(f"signal of {other.count} ridges of {other.material.name}")
                yield other, keys

    def _check(self, design: Design, last: bool = False) -> ContactCheck:
        """The verdict of the search's model; at last, and while the usual thickness is looked at, that of
        `check`."""
        model = "auto" if last or self.thickest == 1.0 else first_able(MODELS, design)
        if (design, model) not in self.seen:
            radius, force = design.skin.curvature_radius, design.contact.force
            self.progress("last check" if last else f"radius {radius:g} at {force:g} N")
            tol = None if model == "auto" else mesh_tolerance(model, None)
            self.seen[design, model] = check(design, model=model, tol=tol)
        self.verdict = self.seen[design, model]
        return self.verdict

    def _last_check(self, design: Design) -> ContactCheck:
        """The verdict that `check` gives of the design, where there is time, or else the search's last."""
        late = SECONDS - (perf_counter() - self.began) < LEAST_SECONDS
        return self.verdict if late else self._check(design, last=True)


def room(design: Design) -> float:
    """Return how far the plate comes down on the crests at the design's force, by what their scatter asks; in
    closed form. 0 where the ridges would bear too much."""
    try:
        approach, overload, out_of_range = _estimate(design)
    except InputError:  # pressed flat
        return 0.0
    return 0.0 if out_of_range or overload > 1.0 else approach / max(_crest_spread(design), 1e-9)


def _bears(design: Design, force: float) -> bool:
    """Whether a skin bears a force, N, in closed form."""
    try:
        _, overload, out_of_range = _estimate(design.with_(contact={"force": force}))
    except InputError:  # pressed flat
        return False
    return overload <= 1.0 and not out_of_range


def _crest_spread(design: Design) -> float:
    """How far the plate has to come down, mm, for crests that scatter as the mold's process makes them."""
    return CREST_SPREADS * Job(design).cavity_process.crest_sigma


def _estimate(design: Design) -> tuple[float, float, bool]:
    """The closed forms of a design at its force: how far the plate comes down, mm, what the most loaded
    feature bears by what it may, and whether that is beyond their range. A ridge may bear a nominal strain,
    until it tips over; pins shorten as columns, and each tip by Hertz."""
    if design.features.family != "pin":
        verdict = check(design, model="winkler")
        most = max(ridge_strain(design, verdict) / LARGEST_STRAIN, tipping(design, verdict))
        return verdict.approach.value or 0.0, EDGE_SHARE * most, bool(verdict.out_of_range)
    share, ends = design.contact.force / design.count, limits(design)
    strain = ends.strain(share)
    tip = float(hertz(np.array(share), crown_radius(design), plane_modulus(design)))
    most = max(strain / LARGEST_STRAIN, share / ends.buckling)
    return strain * design.heights[0] + tip, EDGE_SHARE * most, False


def bent(flat: Design, drop: float) -> Design:
    """Return a flat design with the curvature at which its outer crests lie `drop` mm lower."""
    reach = (flat.count - 1) * flat.spacing
    if flat.features.family == "pin":
        reach = 2 * max(abs(placed.foot[0]) for placed in skin_of(flat).placed)
    return flat.with_(skin={"curvature_radius": radius_for(drop, reach, flat.skin.width)})
