"""Rules between the tables of a design, beyond each key's own range; broken ones are reported together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import partial

from skincad.base.errors import InputError, refusals
from skincad.inputs.feature_tables import (
    Features,
    Flat,
    Magnetometer,
    Pin,
    Pocket,
    Ring,
    places,
)
from skincad.inputs.gripper import Gripper, check_grippers, gripper_named
from skincad.inputs.mold_table import Mold, Mount
from skincad.inputs.process import Process, check_named, check_own
from skincad.inputs.silicone import Silicone, check_law, check_own_silicones, check_silicone, silicone_of
from skincad.inputs.skin_tables import Base, Contact, Film, Material, Shot, Slot

MOST_RIDGES = 999  # the largest ridge.count that a remedy names
FAN_LIMIT_DEG = 90.0  # assumption: a flat back under a wider fan leaves knife edges at the sides
# mm; ten times the length below which the CAD kernel takes an edge's ends for one point
SMALLEST_FILLET = 1e-6
CORE_SHARE = 0.2  # assumption: least radius of a revolved skin's back, of curvature_radius_y


def processes(mold: Mold, own: Mapping[str, Process]) -> Iterator[InputError]:
    """Yield what a workshop's own processes lack, and names of the mold's that nobody knows."""
    yield from refusals(lambda: check_own(own))
    for key in ("process", "end_plate_process", "block_process", "lid_process"):
        yield from refusals(partial(check_named, f"mold.{key}", getattr(mold, key), own))


def grippers(mold: Mold, mount: Mount | None, own: Mapping[str, Gripper]) -> Iterator[InputError]:
    """Yield what a lab's own grippers lack, a name that nobody knows, and holes that are given twice."""
    yield from refusals(lambda: check_grippers(own))
    if mold.mount is None:
        return
    yield from refusals(lambda: gripper_named(mold.mount or "", own))
    if mount is not None:
        remedy = "leave one of them out; [grippers] holds a gripper of your own"
        yield InputError("mold.mount", "has its own holes, and so has [mount]", mold.mount, remedy)


def silicones(material: Material, own: Mapping[str, Silicone]) -> Iterator[InputError]:
    """Yield what a lab's own silicones lack, and a material's name that nobody knows."""
    broken = [
        *refusals(lambda: check_own_silicones(own)),
        *refusals(lambda: check_silicone(material.name, own)),
    ]
    yield from broken
    if material.law is not None and not broken:
        meant = silicone_of(material.name, material.given, own)
        yield from refusals(lambda: check_law("material", meant))


def features_on_skin(skin: Base, features: Features) -> Iterator[InputError]:
    """Yield what keeps the skin from being a fan of less than `FAN_LIMIT_DEG` that bears all its features."""
    if skin.width >= 2 * skin.curvature_radius:
        rule = f"must be less than {2 * skin.curvature_radius:g} mm (twice skin.curvature_radius)"
        yield InputError("skin.width", rule, skin.width)
        return  # nothing below has a meaning then
    side = math.asin(skin.width / (2 * skin.curvature_radius))
    if math.degrees(2 * side) >= FAN_LIMIT_DEG:
        widest = 2 * skin.curvature_radius * math.sin(math.radians(FAN_LIMIT_DEG / 2))
        rule = f"the fan from side to side must stay below {FAN_LIMIT_DEG:g} degrees, so below "
        remedy = "make the skin narrower or curvature_radius larger"
        yield InputError("skin.width", f"{rule}{widest:.4g} mm", skin.width, remedy)
    sag = 2 * skin.curvature_radius * math.sin(side / 2) ** 2
    if sag > 0.8 * skin.thickness:
        rule = f"must be above {sag / 0.8:.4g} mm, or too little is left at the sides (the base circle "
        yield InputError("skin.thickness", f"{rule}falls by {sag:.4g} mm)", skin.thickness)
    if isinstance(features, Flat):
        return
    if isinstance(features, Pin):
        yield from _pins_on_skin(skin, features)
        return
    half_root = features.root_width / 2 + features.root_fillet
    furthest, room = max(abs(at.u) for at in places(skin, features)), side * skin.curvature_radius - half_root
    if isinstance(features, Ring):
        most = math.floor(min((room - features.first_radius) / features.spacing, MOST_RIDGES)) + 1
        remedy = "take fewer rings, or a larger skin"
    else:
        most = math.ceil(min(2 * room / features.spacing, MOST_RIDGES))  # infinite where there is no pitch
        remedy = "take fewer ridges, a smaller pitch or a wider skin"
        remedy = remedy if most > 0 else "take a wider skin or a smaller root"
    if (furthest + half_root) / skin.curvature_radius >= side:
        rule = f"at most {max(0, most)} {features.family}s of this pitch and root fit on skin.width"
        yield InputError(f"{features.family}.count", rule, features.count, remedy)
    if isinstance(features, Ring) and half_root > features.first_radius:
        rule = f"must be at least {half_root:.4g} mm, or ring 1 closes over its middle"
        yield InputError("ring.radius", rule, features.first_radius, "enlarge it, or narrow ring.root_width")


def _pins_on_skin(skin: Base, pin: Pin) -> Iterator[InputError]:
    """Yield pins that leave the base or cover each other's feet, and heights for another number of them."""
    try:
        where = places(skin, pin)
    except InputError as broken:
        yield broken
        return
    half_u, half_v = skin.half_arcs
    over = max(max(skin.arm(at.u, at.v) - half_u, abs(at.v) - half_v) for at in where) + pin.foot
    if over > _EDGE:
        remedy = "take fewer pins, a smaller pin.pitch or a larger skin"
        yield InputError("pin.pitch", f"puts pins {over:.4g} mm over the skin's edge", pin.pitch, remedy)
    if pin.pitch < 2 * pin.foot:
        rule = f"must be at least {2 * pin.foot:.4g} mm, or neighbours' feet overlap"
        yield InputError(
            "pin.pitch", rule, pin.pitch, "enlarge it, or take thinner pins or smaller root fillets"
        )
    shells = max(at.shell for at in where) + 1
    if pin.heights is not None and len(pin.heights) not in (len(where), shells):
        rule = f"must be {len(where)} values, one a pin, or {shells}, one a ring of pins from inside out"
        yield InputError("pin.heights", rule, len(pin.heights), "give as many, or pin.height for all")


OUTLINES = {  # that a family needs, and what to do for it
    "ridge": ("rectangle", 'take outline = "rectangle", or [ring]'),
    "ring": ("round", 'give skin.outline = "round"'),
}
_EDGE = 1e-9  # mm, by which a pin's foot may stand over the edge: rounding


def family(skin: Base, features: Features, slot: Slot | None) -> Iterator[InputError]:
    """Yield what a skin of this family can't be: slots without ridges, rings on no disc, a pocket that leaves
    no wall."""
    name = features.family
    if slot is not None and name != "ridge":
        yield InputError("slot", f"needs ridges, and [{name}] has none", remedy="drop [slot] and [film]")
    outline = skin.outline or "rectangle"
    needed, remedy = OUTLINES.get(name, (outline, ""))
    if needed != outline:
        yield InputError("skin.outline", f"must be '{needed}' for {name}s", skin.outline, remedy)
    if skin.round:
        if skin.length != skin.width:
            rule = f"must be skin.width, {skin.width:g} mm, of a round skin"
            yield InputError("skin.length", rule, skin.length, "leave it out")
        rule = "must not be given for a round skin, which curvature_radius curves all round"
        yield from skin.refused_radius_y(rule)
    if features.pocket is not None:
        yield from _pockets(skin, features, features.pocket)


LEAST_POCKET_WALL = 0.3  # mm, assumption: silicone over or beside a pocket that a magnet does not tear


def _pockets(skin: Base, features: Features, pocket: Pocket) -> Iterator[InputError]:
    """Yield pockets that come too near to the face or to each other, or leave the base."""
    where, key = places(skin, features), f"{features.family}.pocket"
    half_u, half_v = skin.half_arcs
    radius, height = pocket.diameter / 2, 0.0
    if isinstance(features, Pin):
        height = min(features.heights or (features.height or 0.0,))
        if radius + abs(pocket.offset) + LEAST_POCKET_WALL > features.tip_diameter / 2:
            height = 0.0  # wider than the pin: it must end below the base
    low = max(_sink(skin, at.u, at.v, radius + abs(pocket.offset)) for at in where)
    most = skin.thickness - low + height - LEAST_POCKET_WALL
    if pocket.depth > most:
        rule = f"must be at most {max(most, 0.0):.4g} mm, to stay {LEAST_POCKET_WALL:g} mm below the face"
        remedy = "make it shallower or narrower, or the skin thicker"
        yield InputError(f"{key}.depth", rule, pocket.depth, remedy)
    spacing = features.pitch or math.inf  # infinite of a single one
    if len(where) > 1 and spacing < pocket.diameter + LEAST_POCKET_WALL:
        rule = f"must be at most {spacing - LEAST_POCKET_WALL:.4g} mm, or the wall to the next is too thin"
        yield InputError(f"{key}.diameter", rule, pocket.diameter, "make it narrower, or the pitch larger")
    over = (
        max(abs(at.u) for at in where) + abs(pocket.offset) + radius - half_u,
        max(abs(at.v) for at in where) + radius - half_v,
    )
    if max(over) > -LEAST_POCKET_WALL:
        rule = f"must leave {LEAST_POCKET_WALL:g} mm to the skin's edge"
        yield InputError(f"{key}.diameter", rule, pocket.diameter, "make it narrower, or the skin larger")


CAP = 0.2  # mm, assumption: least silicone behind a magnet that closes its pocket
MOST_READ = 100_000  # pairs of a sensor and a magnet; a second or two


def magnets(skin: Base, features: Features, sensors: Magnetometer | None) -> Iterator[InputError]:
    """Yield a magnet that its pocket does not hold, and sensors that have nothing to read: those lie under
    the flat back, so that none lies in a magnet."""
    name, pocket = features.family, features.pocket
    magnet = pocket and pocket.magnet
    if pocket and magnet:
        key = f"{name}.pocket.magnet"
        if not pocket.diameter <= magnet.diameter <= pocket.diameter + LEAST_POCKET_WALL:
            rule = f"must be from {pocket.diameter:g} to {pocket.diameter + LEAST_POCKET_WALL:.4g} mm, or "
            rule += f"{name}.pocket.diameter does not grip it"
            yield InputError(f"{key}.diameter", rule, magnet.diameter, "take another magnet or pocket")
        most = pocket.depth - magnet.gap - CAP
        if magnet.gap and most <= 0.0:
            rule = f"must be less than {pocket.depth - CAP:.4g} mm, or {name}.pocket.depth leaves no room"
            yield InputError(f"{key}.gap", rule, magnet.gap, "make it smaller, or the pocket deeper")
        elif magnet.length > most + 1e-9:
            rule = f"must be at most {most:.4g} mm, or {name}.pocket.depth leaves no {CAP:g} mm for a cap"
            yield InputError(f"{key}.length", rule, magnet.length, "take a shorter one, or a deeper pocket")
    if sensors is None:
        return
    if not isinstance(features, Pin) or magnet is None or pocket is None:
        words = "reads magnets in pins, and there are none"
        remedy = "give [pin.pocket.magnet]" if name == "pin" else "leave it out: only pins' magnets are known"
        yield InputError("magnetometer", words, remedy=remedy)
        return
    if pocket.offset:
        rule = "must be 0 beside [magnetometer]: a magnet's way is known on its pin's axis"
        yield InputError("pin.pocket.offset", rule, pocket.offset, "leave it out")
    rule = "must not be given with [magnetometer], whose sensors lie under a flat back"
    yield from skin.refused_radius_y(rule, "leave one of them out")
    many = len(places(skin, features))
    if many * (len(sensors.places) if sensors.places else many) > MOST_READ:
        rule = f"must be at most {MOST_READ} pairs of a sensor and a magnet"
        yield InputError("magnetometer", rule, remedy="take fewer sensors, or a part of the skin")


def _sink(skin: Base, u: float, v: float, reach: float) -> float:
    """By how much the base lies lower than in the skin's middle, mm, `reach` mm further out than (u, v)."""
    arcs = (skin.arm(u, v), skin.curvature_radius), (abs(v), skin.radius_y)
    return math.fsum(2 * r * math.sin((arc + reach) / r / 2) ** 2 for arc, r in arcs if math.isfinite(r))


def revolved(skin: Base) -> Iterator[InputError]:
    """Yield a section too near the axis that it turns about, and a turn of the fan's limit or more."""
    least, longest = skin.thickness / (1 - CORE_SHARE), skin.radius_y * math.radians(FAN_LIMIT_DEG)
    if skin.radius_y < least:
        rule = f"must be at least {least:.4g} mm, or the back at skin.thickness below comes too near its axis"
        yield from skin.refused_radius_y(rule, "make the skin thinner or the radius larger")
    if skin.length >= longest:
        rule = f"the fan from end to end must stay below {FAN_LIMIT_DEG:g} degrees, so below {longest:.4g} mm"
        remedy = "make the skin shorter or curvature_radius_y larger"
        yield InputError("skin.length", rule, skin.length, remedy)


def profile(features: Features) -> Iterator[InputError]:
    """Yield widths, fillets and a crown that make no feature."""
    if isinstance(features, Flat):
        return
    name, (root_key, tip_key) = features.family, features.widths
    root, tip = features.root_width, features.tip_width
    if root >= features.spacing:
        rule = f"must be less than {features.spacing:g} mm ({name}.pitch)"
        yield InputError(f"{name}.{root_key}", rule, root)
    if tip > root:
        rule = f"must be at most {root:g} mm ({name}.{root_key}), or the {name} hooks in its mold"
        yield InputError(f"{name}.{tip_key}", rule, tip)
    for key, radius in (("tip_fillet", features.tip_fillet), ("root_fillet", features.root_fillet)):
        if 0 < radius < SMALLEST_FILLET:
            yield InputError(f"{name}.{key}", f"must be 0 or at least {SMALLEST_FILLET:g} mm", radius)
    heights = features.heights or (features.height or 0.0,)  # levelling makes none lower
    limit = min(*heights, tip / 2)
    if features.crown >= limit and not (name == "pin" and features.crown == tip / 2 < min(heights)):
        lowest = f" of {name} {heights.index(limit) + 1}" if limit in heights and limit < max(heights) else ""
        rule = f"must be less than {limit:g} mm (the smaller of height{lowest} and half {tip_key})"
        yield InputError(f"{name}.crown", rule, features.crown)


def strips(skin: Base, slot: Slot | None, film: Film | None, mold: Mold) -> Iterator[InputError]:
    """Yield a film that finds no room in its slot, and strips that cannot be cast in, which lie straight."""
    if film is not None and slot is None:
        yield InputError("film", "needs a slot to lie in", remedy="add [slot] or drop [film]")
    if film is not None and slot is not None and film.thickness > slot.thickness:
        rule = f"must be at most {slot.thickness:g} mm (slot.thickness)"
        yield InputError("film.thickness", rule, film.thickness)
    if film is not None and slot is not None and 2 * film.margin >= slot.depth:
        rule = f"must be less than {slot.depth / 2:g} mm (half of slot.depth), or no electrode is left"
        remedy = "a deeper slot, or a finer film.cut_tolerance and film.registration"
        yield InputError("film.electrode_margin", rule, film.margin, remedy)
    key, method = "mold.method", mold.method
    if method == "cast-in" and slot is not None and film is None:
        yield InputError(key, "needs a [film] to cast in", method, "add [film], or take 'shim'")
    if method == "cast-in" and math.isfinite(skin.radius_y):
        rule = "needs straight strips, and skin.curvature_radius_y bends them"
        yield InputError(key, rule, method, "drop curvature_radius_y")


def bond(contact: Contact, film: Film | None) -> Iterator[InputError]:
    """Yield a bond of films that are not there."""
    if contact.film == "bonded" and film is None:
        yield InputError("contact.film", "'bonded' needs a [film]", remedy="add [film] or say 'loose'")


def shots(skin: Base, layers: tuple[Shot, ...], own: Mapping[str, Silicone]) -> Iterator[InputError]:
    """Yield a silicone that nobody knows, and faces that meet each other, the back or the skin's own face:
    THINNEST mm of each silicone must be left."""
    below_middle = below_side = 0.0
    for number, shot in enumerate(layers, 1):
        unknown = [*refusals(partial(check_silicone, shot.name, own))]
        yield from (InputError("shot.name", e.rule, e.value, e.remedy) for e in unknown)
        if shot.law is not None and not unknown:
            meant = silicone_of(shot.name, shot.given, own)
            yield from refusals(partial(check_law, "shot", meant))
        middle, side = face_heights(skin, shot)
        key, value = ("thickness", shot.thickness) if shot.depth is None else ("depth", shot.depth)
        for height, below, top, where in (
            (middle, below_middle, skin.thickness, "in the middle"),
            (side, below_side, shoulder(skin), "at the sides"),
        ):
            if not below + THINNEST <= height <= top - THINNEST:
                room = f"from {below + THINNEST:.4g} to {top - THINNEST:.4g} mm above the back {where}"
                rule = f"shot {number}'s face must be {room}, and is at {height:.4g} mm"
                remedy = "give shots from the back to the front, or a thicker skin"
                yield InputError(f"shot.{key}", rule, value, remedy)
                break
        below_middle, below_side = middle, side


THINNEST = 0.05  # mm; assumption: of a silicone between two faces, to be meshed


def shoulder(skin: Base) -> float:
    """Return the base circle's height above the back at the sides, mm."""
    half_turn = math.asin(min(1.0, skin.width / (2 * skin.curvature_radius))) / 2
    return skin.thickness - 2 * skin.curvature_radius * math.sin(half_turn) ** 2


def face_heights(skin: Base, shot: Shot) -> tuple[float, float]:
    """Return how high a shot's face is above the back, mm, in the middle and at the sides; -inf where it does
    not reach them."""
    if shot.depth is None:
        return shot.thickness or 0.0, shot.thickness or 0.0
    radius = skin.curvature_radius - shot.depth
    reach = skin.width / (2 * radius) if radius > 0 else math.inf
    middle = skin.thickness - shot.depth
    return middle, middle - 2 * radius * math.sin(math.asin(reach) / 2) ** 2 if reach < 1 else -math.inf
