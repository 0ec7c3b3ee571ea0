"""The links of a skin: its solids in the design's frame, their masses and inertias, and their surfaces.

Carrier and skin weigh what their STEP files hold times a density; what fills the slots is a link of its own,
so that neither differs from its file. Left out: leads outside the skin, screws, and the silicone in the
carrier's holes.

A simulator's contact wants convex pieces: each ridge, the base under them and the carrier are the convex
hulls of their meshes. A hull fills a ridge's root fillets; crests, which touch, are convex themselves.

Of more than MOST_BODIES pins neighbours are one body: the plan is halved, and its halves are halved, until
there are that many. A group's hull fills what is between its pins, and touches a plate with the highest.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import trimesh

from skincad.base.arrays import Array, Index
from skincad.fabrication.meshes import mesh, upright
from skincad.inputs.design import Design
from skincad.inputs.material import layers, silicone
from skincad.mechanics.problem import PVDF_DENSITY
from skincad.shape.curves import Loop, Point, Segment
from skincad.shape.skin import Section, section, skin_of
from skincad.solids.layout import lid_process
from skincad.solids.mold import mold
from skincad.solids.pins import pins
from skincad.solids.plan import Body, Part, PartRole, Prism, RevolvedBody, TurnedBody
from skincad.solids.shots import room
from skincad.solids.skin import along_skin, skin_part

MOST_BODIES = 64  # features
G_PER_MM3 = 1e-6  # of 1 kg/m3
TO_DESIGN = np.diag([1.0, -1.0, -1.0])  # the mold's frame turned about x, ridges up
CHORD = 1e-3  # of the pitch: visual
CONTACT_CHORD = 1e-4  # of the pitch, what touches: crests 0.1 um off, where the approach is 100 um
GROUP_CHORD = 3e-4  # the same of groups, whose hulls have many crests
MOST_FACES = 150_000  # of a mesh that is seen; MuJoCo reads 200,000


@dataclass(frozen=True, eq=False)
class Weight:
    """A rigid body's `mass` g, `centre` `(3,)` mm and `inertia` `(3, 3)` g mm2 about it, in the design's
    frame."""

    mass: float
    centre: Array
    inertia: Array

    def turned(self, turn: Array) -> Weight:
        """Return the weight in a frame turned about the same origin."""
        return Weight(self.mass, turn @ self.centre, turn @ self.inertia @ turn.T)


def combine(weights: Iterable[Weight]) -> Weight:
    """Return bodies as one; of a negative mass what is taken away (Steiner's theorem)."""
    bodies = list(weights)
    mass = float(sum(body.mass for body in bodies))
    centre = np.asarray(sum(body.mass * body.centre for body in bodies)) / mass
    inertia = np.zeros((3, 3))
    for body in bodies:
        away = body.centre - centre
        inertia += body.inertia + body.mass * (away @ away * np.eye(3) - np.outer(away, away))
    return Weight(mass, centre, inertia)


def without(whole: Weight, parts: Iterable[Weight]) -> Weight:
    """Return what is left of a body when parts of it are bodies of their own."""
    return combine([whole, *(Weight(-part.mass, part.centre, -part.inertia) for part in parts)])


@dataclass(frozen=True)
class Links:
    """What a skin's simulated links weigh: the `carrier`, the whole `skin`, of that each of the bodies of its
    `ridges` above the base, and the `filling` of its slots, None where they are empty or there are none."""

    carrier: Weight
    skin: Weight
    ridges: tuple[Weight, ...]
    filling: Weight | None

    @property
    def base(self) -> Weight:
        """The skin without its ridges."""
        return without(self.skin, self.ridges)

    @property
    def mass(self) -> float:
        """Mass of all links, g."""
        return self.carrier.mass + self.skin.mass + (self.filling.mass if self.filling else 0.0)


def links(design: Design, *, bodies: bool = True) -> Links:
    """Return the weight of each link, without `bodies` none of its ridges'. Raises InputError where the
    design has no carrier that can be made.
    """
    density = silicone(design).density * G_PER_MM3
    carrier = _weight(carrier_part(design), 1e3 * lid_process(design).density * G_PER_MM3)
    features = [_weight(part, density) for part in (ridge_parts(design) if bodies else ())]
    members = feature_bodies(design).values() if bodies else ()
    ridges = tuple(
        combine(features[i] for i in group) if len(group) > 1 else features[group[0]] for group in members
    )
    skin = _weight(skin_part(design), density)
    skin = combine([skin, *_layers(design)]) if design.shot else skin
    return Links(carrier.turned(TO_DESIGN), skin, ridges, _filling(design, density))


def _layers(design: Design) -> Iterator[Weight]:
    """What layers behind the skin's own silicone weigh more than the one in front of each, as if that filled
    all behind its face."""
    densities = [*(stuff.density for stuff in layers(design)), silicone(design).density]
    for number, (own, front) in enumerate(pairwise(densities), 1):
        yield _weight(room(design, number), (own - front) * G_PER_MM3)


def carrier_part(design: Design) -> Part:
    """Return the carrier, or the bone in its place, as it lies in a mold of one skin, in the mold's frame:
    `TO_DESIGN` turns it."""
    closed = mold(design.with_(mold={"cavities": 1}))
    return closed.first(PartRole.BONE if closed.of(PartRole.BONE) else PartRole.CARRIER)


def _slab(shape: Section) -> Loop:
    """The face of a skin without features, with a tenth of what is under its edges."""
    face = tuple(s for s in shape.outline if s.feature == 1)
    right, left = face[0].start, face[-1].end
    corners = [left, Point(left.x, 0.9 * left.z), Point(right.x, 0.9 * right.z), right]
    return (*face, *(Segment(a, b) for a, b in pairwise(corners)))


def _closed(outline: Iterable[Segment]) -> Loop:
    segments = tuple(outline)
    return (*segments, Segment(segments[-1].end, segments[0].start, 0.0, "base"))


def feature_bodies(design: Design) -> dict[str, tuple[int, ...]]:
    """Return the simulated bodies: by name the features, from 0, that move as one. Up to MOST_BODIES features
    are bodies of their own; of more, neighbours are grouped."""
    skin = skin_of(design)
    if skin.count <= MOST_BODIES:
        return {f"{skin.family}-{i + 1}": (i,) for i in range(skin.count)}
    plan = np.array([placed.foot[:2] for placed in skin.placed])
    groups = [np.arange(skin.count)]
    while 2 * len(groups) <= MOST_BODIES:
        groups = [half for group in groups for half in _halves(group, plan)]
    return {f"{skin.family}s-{i}": tuple(map(int, group)) for i, group in enumerate(groups, 1)}


def _halves(group: Index, plan: Array) -> list[Index]:
    """A group cut across its longer side."""
    side = int(np.argmax(np.ptp(plan[group], axis=0)))
    ordered = group[np.argsort(plan[group, side], kind="stable")]
    return [np.sort(half) for half in np.array_split(ordered, 2)]


def ridge_parts(design: Design) -> list[Part]:
    """Return each ridge above the base, or each pin; slots are not taken off it, they are of the base."""
    skin, shape = skin_of(design), section(design)
    bodies: list[Body] = [replace(pin, buried=0.0) for pin in pins(design, shape)]
    if not bodies:
        loops = [_closed(p.outline) if p.feature.outline else _slab(shape) for p in skin.placed]
        bodies = [along_skin(design, loop, ()) for loop in loops]
    return [Part(f"{skin.family}-{i}", PartRole.SKIN, body) for i, body in enumerate(bodies, 1)]


def touching(design: Design) -> list[tuple[Prism | RevolvedBody | TurnedBody, list[Segment]]]:
    """Return what of each feature may meet a plate: a body, and of its own loop the feature's segments."""
    part = skin_part(design)
    if part.adds:
        return [(pin, [s for s in pin.outline if s.touches]) for pin in pins(design, section(design))]
    body = along_skin(design, section(design).outline, ())
    numbers = range(1, skin_of(design).count + 1)
    return [(body, [s for s in body.outline if s.touches and s.feature == number]) for number in numbers]


def base_loop(design: Design) -> Loop:
    """Return the skin's outline with each ridge cut off by the chord between its feet, mm."""
    segments: list[Segment] = []
    for segment in section(design).outline:
        if segment.feature is None:
            segments.append(segment)
        elif segments[-1].kind == "flank" and segments[-1].feature == segment.feature:
            segments[-1] = replace(segments[-1], end=segment.end)
        else:
            segments.append(Segment(segment.start, segment.end, 0.0, "flank", segment.feature))
    return tuple(segments)


def _weight(part: Part, density: float) -> Weight:
    """Weight of a solid of a density in g/mm3, from the CAD kernel's moments."""
    from skincad.solids.occ import moments, solid, volume

    shape = solid(part)
    centre, inertia = moments(part, shape)
    return Weight(density * volume(part, shape), centre, density * inertia)


def _filling(design: Design, density: float) -> Weight | None:
    """Film strips, and the silicone round them, in all slots."""
    film, slots, state = design.film, section(design).slots, design.film_state
    strip = PVDF_DENSITY * G_PER_MM3
    weights = []
    for slot in slots:
        name = f"slot-{slot.feature}-{slot.side}"
        if state != "loose":
            weights.append(_weight(Part(name, PartRole.STRIP, along_skin(design, slot.loop(), ())), density))
        if film and state != "ignored":
            more = strip - (density if state == "bonded" else 0.0)
            loop = slot.loop(film.thickness)
            weights.append(_weight(Part(name, PartRole.STRIP, along_skin(design, loop, ())), more))
    return combine(weights) if weights else None


def visual(design: Design) -> dict[str, trimesh.Trimesh]:
    """Return skin and carrier, within CHORD of a pitch of their solids; coarser where they have too many
    faces."""
    chord = CHORD * skin_of(design).pitch
    return {"skin": _seen(skin_part(design), chord), "carrier": upright(_seen(carrier_part(design), chord))}


def _seen(part: Part, chord: float) -> trimesh.Trimesh:
    shape = mesh(part, chord)
    while len(shape.faces) > MOST_FACES:
        chord *= 2
        shape = mesh(part, chord)
    return shape


def contact_chord(design: Design) -> float:
    """Return how far the bodies that touch are from their solids, of the pitch."""
    return CONTACT_CHORD if skin_of(design).count <= MOST_BODIES else GROUP_CHORD


def collision(design: Design) -> dict[str, trimesh.Trimesh]:
    """Return the convex hulls of each body of ridges, the base and the carrier; ridges within
    `contact_chord`."""
    skin = skin_of(design)
    chord, fine = CHORD * skin.pitch, contact_chord(design) * skin.pitch
    base = Part("base-hull", PartRole.SKIN, along_skin(design, base_loop(design), ()))
    shapes = [mesh(part, fine) for part in ridge_parts(design)]
    hulls = {
        name: trimesh.util.concatenate([shapes[i] for i in members]).convex_hull
        for name, members in feature_bodies(design).items()
    }
    hulls["base-hull"] = mesh(base, chord).convex_hull
    hulls["carrier-hull"] = upright(mesh(carrier_part(design), chord)).convex_hull
    return hulls


def obj(shape: trimesh.Trimesh, name: str) -> str:
    """Return a mesh as OBJ, mm, in the design's frame."""
    return str(trimesh.exchange.obj.export_obj(shape, header=f"{name}, mm, z out of the skin", digits=9))


def glb(shapes: dict[str, trimesh.Trimesh]) -> bytes:
    """Return meshes as GLB: metres and y up, as glTF wants it, so the skin's z is y and its y is -z."""
    scene = trimesh.Scene()
    for name, shape in shapes.items():
        placed = shape.copy()
        placed.vertices = 1e-3 * placed.vertices[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
        scene.add_geometry(placed, node_name=name, geom_name=name)
    return bytes(scene.export(file_type="glb"))
