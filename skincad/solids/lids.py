"""Carrier, cover and seal, and what is mounted on the carrier.

The mount in a carrier's top: where its threads, its pin's hole and its fiducials lie, and if they fit. x and
y count from the carrier's middle, as the mold's do; a robot sees the carrier's top as the cover does.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import combinations, pairwise
from typing import NamedTuple

import numpy as np

from skincad.base.errors import InputError, refusals
from skincad.inputs.design import Design
from skincad.inputs.mold_table import Mount
from skincad.shape.curves import Point, loop, rectangle
from skincad.solids.bone import KEY, PLAY, check_hold, clear_of, pinned, windowed
from skincad.solids.fasteners import (
    LEAST_UNDER_HOLE,
    METRIC,
    TAP_RADIUS,
    blind_thread,
    pin_depth,
    thread_in,
)
from skincad.solids.inserts import pin
from skincad.solids.kind import kind_of
from skincad.solids.layout import (
    BOLT_RADIUS,
    EDGE,
    PIN_DEPTH,
    PRESS_PRINT,
    Layout,
    cover_pins,
    fits,
    lid_process,
)
from skincad.solids.pins import MAGNET_PLAY, magnet_diameter, pockets
from skincad.solids.plan import Bore, CutRole, Part, PartRole, Prism, Vector, box, disc, drilled, moved
from skincad.solids.shrinkage import on_grid

SCREWS = 4  # source: ISO 9409-1, on the smaller of its bolt circles
STEP = 0.1  # mm, assumption: by which a fiducial goes aside where its corner is taken, and a cup grows
PROUD, OUT = 8.0, 2.0  # mm, assumption: of a core pin over its carrier and its cover, for pliers
ACCESS_PLAY = 0.3  # mm a side, assumption: of cover and seal round what stands out of a carrier
TENTHS = 10  # a mm, assumption: a fiducial's place is written in tenths
# assumption: a fiducial's distance from the middle is at least its corner's by this
INSET_DIVISOR = 3.0

Filled = tuple[str, Vector, float]  # what silicone fills: its name, place and radius, mm


def mount_places(mount: Mount) -> list[tuple[float, float]]:
    """Return (x, y) of a mount's screws, mm: round the circle from its first one, or the rectangle's."""
    if mount.thread is None:
        return []
    if mount.diameter is not None:
        count = mount.count or SCREWS
        first = 180.0 / count if mount.angle is None else mount.angle
        turns = [math.radians(first + 360.0 * i / count) for i in range(count)]
        return [(mount.diameter / 2 * math.cos(a), mount.diameter / 2 * math.sin(a)) for a in turns]
    xs, ys = ((0.0,) if wide is None else (-wide / 2, wide / 2) for wide in (mount.pitch_x, mount.pitch_y))
    return [(x, y) for x in xs for y in ys]


def pin_place(mount: Mount) -> tuple[float, float]:
    """Return (x, y) of a mount's pin, mm: on its circle or its rectangle at +x, or between two in line."""
    side = mount.pitch_x if mount.pitch_y is not None else None
    return (mount.diameter or side or 0.0) / 2, 0.0


def mount_bores(design: Design, place: Layout) -> list[Bore]:
    """Return the threads and the pin's hole in the carrier's top; none without a mount."""
    mount = design.mounting
    if mount is None or mount.thread is None:
        return []
    blind, top = blind_thread(mount.thread, lid_process(design)), place.back
    low = top - blind.depth
    holes = drilled(CutRole.MOUNT, "z", mount_places(mount), low, blind.depth, blind.radius)
    if mount.pin is None:
        return holes
    deep = pin_depth(mount.pin)
    return [*holes, *drilled(CutRole.MOUNT_PIN, "z", [pin_place(mount)], top - deep, deep, mount.pin / 2)]


def check_mount(design: Design, place: Layout, holes: Sequence[Bore], filled: Iterable[Filled]) -> None:
    """Raise InputError for the first hole of a mount that leaves the carrier or comes too near to another, or
    to what silicone fills."""
    if design.mounting is None:
        return
    for hole in holes:
        _inside(design, place, hole)
        for name, at, radius in filled:
            web, least = math.dist(hole.start[:2], at[:2]) - hole.radius - radius, EDGE / 2
            if web < least:
                raise _near(design, hole, web, least, name)
    for one, other in combinations(holes, 2):
        web = math.dist(one.start[:2], other.start[:2]) - one.radius - other.radius
        if web < EDGE:
            raise _near(design, other, web, EDGE, _name(one))


def _inside(design: Design, place: Layout, hole: Bore) -> None:
    """Raise InputError for a hole that is too near to the carrier's edge."""
    mount = design.mounting or Mount()
    room = [half - EDGE - hole.radius for half in _halves(design, place)]
    at = kind_of(design).apart(*hole.start[:2])
    share = [most / abs(v) if v else math.inf for most, v in zip(room, at, strict=True)]
    if min(share) >= 1:
        return
    key = size_key(mount, 1 if share[1] < share[0] else 0)
    size = getattr(mount, key)
    rule = f"leaves less than {EDGE:g} mm between {_name(hole)} and the carrier's edge"
    if (most := math.floor(1000 * min(share) * size) / 1000) > 0:
        rule = f"must be at most {most:g} mm, for {EDGE:g} mm between {_name(hole)} and the carrier's edge"
    short = (2 * max(0.0, abs(v) - most) for most, v in zip(room, at, strict=True))
    sizes = zip(("width", "length"), (design.skin.width, design.skin.length), short, strict=True)
    larger = (f"skin.{side} {math.ceil(10 * (size + s)) / 10:g} mm" for side, size, s in sizes if s > 0)
    raise _of_mount(design, key, rule, "a smaller pattern", f"a larger skin ({', '.join(larger)})")


def _of_mount(design: Design, key: str, rule: str, other: str, larger: str = "a larger skin") -> InputError:
    """The error of a hole: of [mount]'s key, or of the gripper that the mold names."""
    if design.mold.mount is not None:
        remedy = f"take another gripper, {larger}, or [mount] with holes of your own"
        return InputError("mold.mount", f"its {key} {rule}", design.mold.mount, remedy)
    return InputError(f"mount.{key}", rule, getattr(design.mount, key), f"take {other} or {larger}")


def _near(design: Design, hole: Bore, web: float, least: float, other: str) -> InputError:
    mount = design.mounting or Mount()
    x, y = hole.start[:2]
    key = "pin" if hole.role is CutRole.MOUNT_PIN else size_key(mount, 1)
    rule = (
        f"puts {_name(hole)} at ({x:.4g}, {y:.4g}) {max(web, 0.0):.3g} mm from {other}, needed are {least:g}"
    )
    turn = " (mount.angle)" if mount.pattern == "circle" else ""
    return _of_mount(design, key, rule, f"another pattern{turn} or thread")


def _name(hole: Bore) -> str:
    return "the pin's hole" if hole.role is CutRole.MOUNT_PIN else "a thread"


def size_key(mount: Mount, axis: int = 0) -> str:
    """Return the key that gives a pattern's size along x (0) or y (1)."""
    if mount.pattern == "circle":
        return "diameter"
    wanted = ("pitch_x", "pitch_y") if axis == 0 else ("pitch_y", "pitch_x")
    return next(key for key in wanted if getattr(mount, key) is not None)


def _halves(design: Design, place: Layout) -> tuple[float, float]:
    """Half of the carrier's width and length, mm; a round one's radius."""
    half = place.trough - design.mold.clearance
    return half, place.end - design.mold.clearance if kind_of(design).ends else half


def fiducial_bores(design: Design, place: Layout, occupied: Sequence[tuple[Vector, float]]) -> list[Bore]:
    """Return the dimples in three of the carrier's corners, and a fourth between two of them, each as near
    to its corner as it clears what is `taken`, by place and radius. Raises InputError where one finds no
    room."""
    mount = design.mounting
    if mount is None or not mount.fiducials:
        return []
    wide, deep = mount.fiducial_diameter / 2, mount.fiducial_depth
    share = kind_of(design).corner
    x, y = (math.floor(TENTHS * share * (half - EDGE - wide)) / TENTHS for half in _halves(design, place))
    places: list[tuple[float, float]] = []
    for corner in ((x, -y), (-x, -y), (-x, y), (-math.floor(TENTHS * x / 3) / TENTHS, -y))[: mount.fiducials]:
        beside = [*occupied, *(((*at, 0.0), wide + EDGE) for at in places)]
        free = (at for at in _inward(corner) if all(_clear(at, wide, *other) for other in beside))
        if min(x, y) <= 0 or (at := next(free, None)) is None:
            rule = f"finds no room for a dimple of {mount.fiducial_diameter:g} mm in a corner of the carrier"
            remedy = "take a smaller mount.fiducial_diameter, another pattern or a larger skin"
            raise InputError("mount.fiducials", rule, mount.fiducials, remedy)
        places.append(at)
    return drilled(CutRole.FIDUCIAL, "z", places, place.back - deep, deep, wide)


def _inward(corner: tuple[float, float]) -> Iterator[tuple[float, float]]:
    """Places from a corner towards the middle, along y first, to its distance by `INSET_DIVISOR` at least."""
    x, y = corner
    for u in np.arange(abs(x), abs(x) / INSET_DIVISOR - STEP, -STEP).tolist():
        for v in np.arange(abs(y), abs(y) / INSET_DIVISOR, -STEP).tolist():
            yield math.copysign(round(u, 6), x), math.copysign(round(v, 6), y)


def _clear(at: tuple[float, float], wide: float, other: Vector, radius: float) -> bool:
    return math.dist(at, other[:2]) >= wide + radius + EDGE / 2


HOLD = (0.75, 1.25, 4.0)  # mm, assumption: radius at the skin, at the cover, spacing of the carrier's holes
# assumption: a large carrier spaces its holes wider; the kernel's time grows with their square
MOST_HOLES = 24
BLEED = 0.4  # mm, assumption: least radius of the cover's bleed over each of them, which would keep its air
VENT, WIDE_VENT = 1.0, 2.5  # mm, assumption: through which silicone rises without much pressure
LARGE = 5000.0  # mm3, assumption: a skin that shrinks by more than a narrow vent passes before it sets
RISER_SHARE = 0.033  # assumption: of the base's volume, that the cup holds: 3 % of the skin's
LEAST_VENT = 0.3  # mm, assumption: a smaller hole is drilled askew through 4 mm, and silicone closes it
CUP = 2.5  # mm, assumption: least upper radius of the cup; its 50 mm3 are a tenth of a small skin
CUP_RIM = 0.5  # mm, assumption: by which the cup is at least wider above than below, to be filled and cleaned
MARK = 1.0  # mm, assumption: diameter of a dimple that lines two parts up
FLARE = 1.5  # assumption: of the cover's thickness, by which a cup widens at most: a flatter one runs over
OVERLAP = 0.3  # mm, assumption: the cup's reach over the end plate, should the cover sit aside
ROUNDING = 1e-9  # mm, by which a hole may be off the last place that it has
LEAST_PULL = 2.0  # mm, assumption: thread that lifts the skin out


def vent_bore(design: Design, place: Layout) -> Bore:
    """The vent: in the middle of end b, as near to the end plate as the carrier allows, or to the rim of a
    round skin, which is the highest when the mold is tilted."""
    gap = design.mold.clearance
    narrow = min(design.skin.width, 2 * place.end)
    room = narrow - 2 * (gap + EDGE)
    usual = VENT if _skin_volume(design) <= LARGE else WIDE_VENT
    wide = design.mold.vent or min(usual, math.floor(10 * room) / 10)  # a drill
    if design.mold.vent is None and wide < LEAST_VENT:
        key = "skin.width" if narrow == design.skin.width else "skin.length"
        rule = f"leaves {room:.4g} mm for the vent in the carrier, which needs {LEAST_VENT:g} mm"
        raise InputError(key, rule, remedy="enlarge it, or cast a larger skin and cut it to size")
    if wide > room:
        raise InputError("mold.vent", f"must be at most {room:.4g} mm (the skin's back)", wide)
    y = place.end - wide / 2 - (gap + EDGE / 2 if kind_of(design).ends else 0.0)
    return Bore((0.0, y, 0.0), "z", place.back, wide / 2, role=CutRole.VENT)


def _web(cup: Bore, hole: Bore) -> float:
    """What the cover keeps between its cup and another hole, mm."""
    return math.dist(hole.start[:2], cup.start[:2]) - hole.radius - max(cup.radius, cup.far_radius)


def _skin_volume(design: Design) -> float:
    """About how large the skins' base is, mm3."""
    return design.skin.area * design.skin.thickness


def _reservoir(design: Design, place: Layout, vent: Bore) -> Bore:
    """The riser: a cup in the cover, open above, over the vent and the gap at end b, where air collects."""
    end, chosen, inner = place.end, design.mold.reservoir, vent.start[1] - vent.radius
    beside = [abs(x - place.centres[0]) for x, _ in place.bolts] or [place.outer]
    most = min(min(beside) - BOLT_RADIUS, *(x - place.centres[-1] for x in place.lanes[-1:]), math.inf) - EDGE
    rim = min(place.cover, end + design.mold.end_plate) - EDGE / 2
    if not kind_of(design).ends:  # no gap there: the carrier lies on its ledge all round
        end, inner, rim = vent.start[1], inner - OVERLAP, place.cover - EDGE / 2
    most = min(most, rim)  # and off the cover's edge at end a

    def cup(wide: float) -> Bore:
        y = min(end, rim - wide)
        need = max(y - inner, vent.start[1] + vent.radius - y, end + OVERLAP - y)
        return Bore((0.0, y, place.top), "z", place.lid, need, wide, role=CutRole.RESERVOIR)

    def fits(wide: float) -> bool:
        over = cup(wide)
        webs = all(_web(over, hole) >= EDGE / 2 for hole in standing)
        beside_bone = clear_of(design, 0.0, over.start[:2], max(over.radius, over.far_radius))
        return over.radius <= wide <= most and webs and beside_bone

    standing = _access(design, place.top, place.lid)
    wide = chosen / 2 if chosen else min(most, max(CUP, end - inner + CUP_RIM))
    while not chosen and not fits(wide) and cup(wide - STEP).radius <= wide - STEP:
        wide = round(wide - STEP, 6)
    standing += mount_bores(design, place)
    fasteners = [*place.bolts, *cover_pins(place)]

    def grows(wide: float) -> bool:
        over = cup(wide)
        least = over.far_radius + BOLT_RADIUS + EDGE
        clear = all(math.dist((x, over.start[1]), at) >= least for x in place.centres for at in fasteners)
        return fits(wide) and clear and over.far_radius - over.radius <= FLARE * place.lid

    while not chosen and cup(wide).volume < RISER_SHARE * _skin_volume(design) and grows(wide + STEP):
        wide = round(wide + STEP, 6)
    need = cup(wide).radius
    if not need <= wide <= most:
        least = max(end - inner, vent.start[1] + vent.radius - end, OVERLAP)
        least = least if least <= rim - end else (rim - inner) / 2
        rule = f"must be from {2 * least:.4g} to {2 * most:.4g} mm, over vent and gap and clear of the bolts"
        raise InputError("mold.reservoir", rule, 2 * wide)
    return cup(wide)


def _bleed_radius(design: Design) -> float:
    """Radius of a bleed, mm: what the cover's process makes, but no wider than the hole that it bleeds."""
    return min(max(BLEED, lid_process(design).hole / 2), HOLD[1])


def _bleed(design: Design, hole: tuple[float, float]) -> tuple[float, float]:
    """Place of the bleed over a carrier's hole: inside its rim, at end b's side, which is the highest."""
    return hole[0], hole[1] + HOLD[1] - _bleed_radius(design)


def _rivets(design: Design, place: Layout, vent: Bore, cup: Bore) -> list[tuple[float, float]]:
    """Places (x, y) of the carrier's holes; none for a plain carrier. Raises InputError where a carrier that
    shall have holes has no room for one."""
    if design.mold.carrier == "plain" or design.mold.bone is not None:
        return []
    beside = cup.far_radius + _bleed_radius(design) + EDGE / 2
    small, large, spacing = HOLD
    wide, long = design.skin.width - 2 * (small + EDGE), 2 * place.end - 2 * (large + EDGE)
    spacing = max(spacing, math.sqrt(max(wide, 0.0) * max(long, 0.0) / MOST_HOLES))
    places = [
        (x, y)
        for x in _grid(wide, spacing)
        for y in _grid(long, spacing)
        if kind_of(design).apart(x, y)[0] <= design.skin.width / 2 - small - EDGE + ROUNDING
        and math.hypot(x, y - vent.start[1]) > large + vent.radius + EDGE / 2
        and math.dist(_bleed(design, (x, y)), cup.start[:2]) > beside
    ]
    if not places and design.mold.carrier == "perforated":
        raise InputError(
            "mold.carrier",
            "leaves no room for a hole beside the vent, so nothing would hold the skin",
            design.mold.carrier,
            'take carrier = "plain" and a primer, a smaller vent or a larger skin',
        )
    return places


class _Openings(NamedTuple):
    """Vent, reservoir, the places of the carrier's holes, the threads to pull it by, its mount, and the holes
    in which core pins stand."""

    vent: Bore
    cup: Bore
    rivets: list[tuple[float, float]]
    pulls: list[Bore]
    mount: list[Bore]
    cores: list[Bore]


def openings(design: Design, place: Layout) -> _Openings:
    """All openings. Where holes leave the mount or the threads no room, those in their way are left out, as
    long as half of them stay."""
    vent = vent_bore(design, place)
    cup = _reservoir(design, place, vent)
    all_holes = _rivets(design, place, vent, cup)
    mount = mount_bores(design, place)
    cores = core_bores(design, place)
    if not clear_of(design, 0.0, vent.start[:2], vent.radius):
        rule = "reaches behind the back where the carrier has its vent, in the middle of end b"
        raise InputError("mold.bone_at", rule, design.mold.bone_at, "move it, or take a longer skin")
    named = ("the vent", vent), ("the cup", cup), *(("a core pin", core) for core in cores)
    check_mount(design, place, mount, [(name, bore.start, bore.radius) for name, bore in named])
    _check_cores(design, vent, cup)
    check_hold(design, place.top + place.lid)
    all_holes = [
        at
        for at in all_holes
        if all(math.dist(at, core.start[:2]) > core.radius + HOLD[1] + EDGE / 2 for core in cores)
    ]
    rivets = _beside_mount(design, all_holes, mount)
    beside = [(vent.start, vent.radius), (cup.start, cup.radius)]
    heads = _access(design, 0.0, 1.0) if design.mold.bone else []
    beside += [(hole.start, hole.radius + EDGE / 2) for hole in (*mount, *cores, *heads)]
    pulls = pull_threads(design, place, [*beside, *_filled(rivets)])
    if not pulls and (alone := pull_threads(design, place, beside)):
        least_distance = TAP_RADIUS + HOLD[1] + EDGE / 2
        corners = [(x * bore.start[0], bore.start[1]) for bore in alone for x in (-1, 1)]
        fewer = [at for at in rivets if all(math.dist(at, corner) > least_distance for corner in corners)]
        if 2 * len(fewer) >= len(all_holes) > 0:
            rivets, pulls = fewer, alone
    occupied = [*beside, *_filled(rivets), *((bore.start, bore.radius) for bore in pulls)]
    return _Openings(vent, cup, rivets, pulls, [*mount, *fiducial_bores(design, place, occupied)], cores)


def core_bores(design: Design, place: Layout) -> list[Bore]:
    """Return the carrier's through holes in which the pockets' core pins stand, reamed, so narrower in a
    print, and wide enough for magnets; and clearance holes of the screws that hold a bone."""
    narrower = PRESS_PRINT if lid_process(design).layer else 0.0
    pins = [
        Bore((*bore.start[:2], 0.0), "z", place.back, core_hole(design) / 2 - narrower, role=CutRole.CORE)
        for bore in pockets(design, -1.0)
    ]
    screws = [
        Bore((*bore.start[:2], 0.0), "z", place.back, METRIC[name].clearance / 2, role=CutRole.BONE_SCREW)
        for bore, name in bone_screws(design)
    ]
    return [*pins, *screws]


def core_hole(design: Design) -> float:
    """Return the diameter of a core pin's hole once it is reamed, mm: the pin's, or what lets the magnet
    through that goes into its pocket; tape round the pin fills it meanwhile."""
    pocket = design.features.pocket
    if pocket is None:
        raise ValueError("without pockets there are no core pins")
    wide = magnet_diameter(pocket)
    return pocket.diameter if wide is None else wide + MAGNET_PLAY


def core_proud(place: Layout) -> float:
    """Return how far a core pin stands over its carrier, mm: out of the cover, for pliers."""
    return max(PROUD, on_grid(place.top - place.back + place.lid + OUT))


def bone_screws(design: Design) -> list[tuple[Bore, str]]:
    """Return the cores of the screws that hold a bone under its carrier, and their threads."""
    return [(bore, thread_in(2 * (bore.radius + PLAY)) or "") for bore in pinned(design)]


def core_pins(design: Design, place: Layout) -> list[Part]:
    """Return the rods that keep the pockets free, from a pocket's end to where pliers grip them over the
    carrier."""
    return [
        Part(
            f"core-pin-{i}",
            PartRole.CORE_PIN,
            replace(bore, length=on_grid(bore.length) + place.back + core_proud(place), role=None),
        )
        for i, bore in enumerate(pockets(design, -1.0), 1)
    ]


def backing(design: Design, place: Layout) -> list[Part]:
    """Return the carrier and what stands in it: core pins, and the screws that hold a bone, from its holes'
    ends to the carrier's top, without their heads."""
    screws = [
        Part(
            f"bone-screw-{i}", PartRole.BONE_SCREW, replace(bore, length=bore.length + place.back, role=None)
        )
        for i, (bore, _) in enumerate(bone_screws(design), 1)
    ]
    return [carrier(design, place), *core_pins(design, place), *screws]


def _access(design: Design, low: float, thick: float) -> list[Bore]:
    """The holes of seal or cover round what stands out of a carrier."""
    pins = [(bore.start, core_hole(design) / 2) for bore in pockets(design, -1.0)]
    screws = [(bore.start, METRIC[name].head / 2) for bore, name in bone_screws(design)]
    return [
        Bore((x, y, low), "z", thick, radius + ACCESS_PLAY, role=CutRole.ACCESS)
        for (x, y, _), radius in (*pins, *screws)
    ]


def _check_cores(design: Design, vent: Bore, cup: Bore) -> None:
    """Raise InputError for a core pin or a bone's screw that finds no room in the carrier beside its vent, or
    in the cover beside its cup."""
    least = EDGE / 2
    pins = len(pockets(design))
    for number, hole in enumerate(_access(design, 0.0, 1.0)):
        what = "a core pin" if number < pins else "a screw's head"
        key = f"{design.features.family}.pocket" if number < pins else KEY
        (x, y, _), smaller = hole.start, "move it, or take a smaller mold.vent"
        at_vent = _web(vent, hole) + ACCESS_PLAY, "the carrier's vent", smaller
        at_cup = _web(cup, hole), "the riser's cup in the cover", f"{smaller}, and mold.reservoir"
        for web, other, remedy in (at_vent, at_cup):
            if web < least:
                rule = f"puts {what} at ({x:.4g}, {y:.4g}) {max(web, 0.0):.3g} mm from {other}, "
                raise InputError(key, f"{rule}needed are {least:g}", remedy=remedy)


def _filled(rivets: list[tuple[float, float]]) -> list[tuple[Vector, float]]:
    """What silicone fills of the carrier's holes, by place and radius."""
    return [((x, y, 0.0), HOLD[1]) for x, y in rivets]


def _beside_mount(
    design: Design, rivets: list[tuple[float, float]], mount: list[Bore]
) -> list[tuple[float, float]]:
    """The carrier's holes that the mount leaves. Raises InputError where more than half are in its way."""
    remaining = [
        at for at in rivets if all(math.dist(at, m.start[:2]) > m.radius + HOLD[1] + EDGE / 2 for m in mount)
    ]
    if design.mounting and 2 * len(remaining) < len(rivets):
        key, removed = size_key(design.mounting), len(rivets) - len(remaining)
        rule = (
            f"is in the way of {removed} of the {len(rivets)} holes that hold the skin; half of them "
            "must stay"
        )
        remedy = 'take another pattern or a smaller thread, or mold.carrier = "plain" and a primer'
        raise _of_mount(design, key, rule, remedy)
    return remaining


def refused_lids(design: Design, place: Layout) -> Iterator[InputError]:
    """Yield an error for the first bore that finds no room in carrier and cover."""
    yield from refusals(lambda: openings(design, place))


def carrier(design: Design, place: Layout) -> Part:
    """Return the rigid backing in the middle: its holes widen away from the skin, so that the silicone in
    them holds like rivets; blind threads from above lift the skin out, the only grip that it needs, and
    others hold it on a robot."""
    vent, _, rivets, pulls, mount, cores = openings(design, place)
    holes = drilled(CutRole.RIVET, "z", rivets, 0.0, place.back, *HOLD[:2])
    gap = design.mold.clearance
    body = kind_of(design).plate(place.trough - gap, place.end - gap, 0.0, place.back)
    marks = round_marks(design, place)[:1]
    part = Part("carrier", PartRole.CARRIER, body, (vent, *holes, *pulls, *mount, *cores, *marks))
    return windowed(part, design, 0.0, place.back)


def round_marks(design: Design, place: Layout) -> list[Bore]:
    """Return the dimples in a round carrier's top and in its block's, which lie in line once it is turned as
    its skin is; none of a square one, whose vent tells which of two ways is right."""
    if kind_of(design).ends:
        return []
    vent, _, rivets, pulls, mount, cores = openings(design, place)
    radius, inner = MARK / 2, place.trough - design.mold.clearance - EDGE - MARK / 2
    occupied = [(hole.start, hole.radius) for hole in (vent, *pulls, *mount, *cores)] + _filled(rivets)
    outer = [(*at, 0.0) for at in (*place.bolts, *cover_pins(place))]
    for turn in np.radians(np.arange(0.0, 360.0, 5.0)).tolist():
        way = math.cos(turn), math.sin(turn)
        (x, y), (u, v) = ((arm * way[0], arm * way[1]) for arm in (inner, place.trough + EDGE + radius))
        free = all(_clear((x, y), radius, other, r) for other, r in occupied)
        free = free and all(_clear((u, v), radius, other, BOLT_RADIUS) for other in outer)
        if free and clear_of(design, 0.0, (x, y), radius):
            deep = MARK / 2
            on_carrier = Bore((x, y, place.back - deep), "z", deep, radius, role=CutRole.MARK)
            return [on_carrier, Bore((u, v, place.top - deep), "z", deep, radius, role=CutRole.MARK)]
    return []


def pull_threads(design: Design, place: Layout, filled: list[tuple[Vector, float]]) -> list[Bore]:
    """Two tapped holes in the carrier's top that end over the silicone, opposite each other, as near to its
    middle as they clear all that silicone fills, by place and radius; none where they don't."""
    thick = place.back
    x, most = (half - TAP_RADIUS - EDGE for half in _halves(design, place))
    if thick < LEAST_UNDER_HOLE + LEAST_PULL or x < TAP_RADIUS + EDGE / 2:
        return []
    for y in np.arange(0.0, most, TAP_RADIUS / 2).tolist():
        u, v = kind_of(design).along_edge(x, y)
        pair = (-u, -v), (u, v)
        free = all(clear_of(design, 0.0, p, TAP_RADIUS) for p in pair)
        if free and all(math.dist(p, at[:2]) > r + TAP_RADIUS + EDGE / 2 for p in pair for at, r in filled):
            return drilled(CutRole.PULL, "z", pair, LEAST_UNDER_HOLE, thick - LEAST_UNDER_HOLE, TAP_RADIUS)
    return []


def _grid(room: float, spacing: float) -> list[float]:
    count = max(0, math.floor(room / spacing)) + 1 if room >= 0 else 0
    return [(i - (count - 1) / 2) * spacing for i in range(count)]


def cover(design: Design, place: Layout) -> Part:
    """Return the lid: bolts, pins, and over each carrier its reservoir and bleeds. It reaches over the end
    plates: once these are off, it is lifted there."""
    thick, end, low = place.lid, place.cover, place.top
    press = fits(design, design.mold.lid_process or design.mold.process).press
    _, cup, rivets, *_ = openings(design, place)
    bleeds = [_bleed(design, hole) for hole in rivets]
    over = [cup, *drilled(CutRole.BLEED, "z", bleeds, low, thick, _bleed_radius(design))]
    cuts = (
        *drilled(CutRole.COVER_BOLT, "z", place.bolts, low, thick, BOLT_RADIUS),
        *drilled(CutRole.COVER_PIN, "z", cover_pins(place), low, thick, press),
        *(moved(bore, x) for x in place.centres for bore in (*over, *_access(design, low, thick))),
    )
    part = Part("cover", PartRole.COVER, box(place.half, (-end, end), (low, low + thick)), cuts)
    return windowed(part, design, low, low + thick, place.centres)


def seal_sheet(design: Design, place: Layout) -> Part:
    """Return the foam between the cover and what may stand higher or lower than the cavity's top: carriers
    and end plates; round over a round carrier. The cover lies on the cavity's walls beside it; cup and bleeds
    go on through it."""
    half, long, end, web = place.half, place.cover, place.end, place.trough - design.mold.clearance
    out = place.centres[-1] + web
    right = [(half, -long), (half, -end), (out, -end), (out, end), (half, end), (half, long)]
    outline = loop([Point(*p) for p in (*right, *((-x, -y) for x, y in right))])
    between = pairwise(place.centres)
    holes = tuple(rectangle(a + web, b - web, -end, end) for a, b in between)
    _, cup, rivets, *_ = openings(design, place)
    low, thick = place.back, place.top - place.back
    body = Prism(outline, "z", low, place.top, holes)
    if not kind_of(design).ends:
        body = disc(web, low, place.top)
    over = drilled(CutRole.RESERVOIR, "z", [cup.start[:2]], low, thick, cup.radius)
    bleeds = [_bleed(design, hole) for hole in rivets]
    over += drilled(CutRole.BLEED, "z", bleeds, low, thick, _bleed_radius(design))
    over += _access(design, low, thick)
    cuts = tuple(moved(bore, x) for x in place.centres for bore in over)
    return windowed(Part("seal", PartRole.SEAL, body, cuts), design, low, place.top, place.centres)


def cover_dowels(design: Design, place: Layout) -> list[Part]:
    """Return the pins pressed into the cover; they slide in the cavity."""
    length = place.lid + PIN_DEPTH - design.mold.clearance
    low = place.top + place.lid - length
    return [
        pin(PartRole.COVER_PIN, f"pin-cover-{side}", (x, y, low), length)
        for side, (x, y) in zip(("right", "left"), cover_pins(place), strict=True)
    ]
