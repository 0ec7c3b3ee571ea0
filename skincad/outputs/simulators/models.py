"""The skin as a MuJoCo model (MJCF) with a scene: a plate presses and pulls it; and as URDF. m, kg, N, s.

Each ridge, or group of pins, is a body on a slide along z, held by springs that are tendons over several of
them (springs.py), so that stiffness is in N/m and stays what it is whatever touches: the softness of MuJoCo's
own contact follows the masses that meet, and is a few percent of the springs' here. Slides carry armature and
damping by which stiff springs on milligrams stand at MuJoCo's usual step: numbers of the method, not of the
silicone. Sideways a ridge is rigid. Source: MuJoCo documentation, Computation: Constraint model; XML
reference: tendon, joint.

URDF has the same links, all fixed, for it knows no springs. Source: the URDF XML specification
(wiki.ros.org/urdf/XML); meshes are named beside the file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from xml.sax.saxutils import escape

import numpy as np

from skincad.inputs.design import Design
from skincad.outputs.simulators.links import Links, Weight, feature_bodies
from skincad.outputs.simulators.springs import Springs
from skincad.outputs.simulators.taxels import crests
from skincad.shape.skin import skin_of

STEP = 0.002  # s; MuJoCo's own default
FRICTION = 1.0  # where contact.friction is not given; paper: about 4 N of weight at a static friction of 1.0
GRAVITY = 9.81  # m/s2; the plate has the mass whose weight its force is, but no weight of its own
IMPEDANCE = 0.97  # of a contact: above 0.99 it rattles on springs as stiff, at 0.9 it gives way by 3 %
LEAST_DRAG = 0.01  # of the force, at that speed: without friction the plate would drift off
SPEED = 2.0  # approaches a second, at which key "slide" ends: MuJoCo's cone lifts a plate that slides faster
STICKS, SLIDES = 0.5, 1.2  # of what friction holds: the pulls of the keyframes
SMALL = 1e-9  # of the largest; smaller coefficients of a spring are left out
KG, KG_M2, M = 1e-3, 1e-9, 1e-3  # of a g, a g mm2, a mm
N_PER_M = 1e3  # of a N/mm
DIGITS = 12  # of a number; what is smaller by more than that than the largest beside it is rounding


def slide_damping(springs: Springs) -> tuple[float, float]:
    """Return a slide's armature, kg, and damping, N s/m: the stiffest combination of ridges moves by half a
    radian and half of its critical damping in a step. Measured on four skins: with as much damping and half
    of the armature a pressed plate rattles, for MuJoCo solves contact without damping and integrates with it.
    """
    stiffest = float(np.linalg.eigvalsh(springs.stiffness).max()) * N_PER_M
    return 4 * stiffest * STEP**2, 2 * stiffest * STEP


def friction(design: Design) -> float:
    """Return the coefficient of friction of the ridges."""
    return FRICTION if design.contact.friction is None else design.contact.friction


def skin_xml(design: Design, links: Links, springs: Springs) -> str:
    """Return the skin on its carrier as a model of its own, to be loaded, included or attached."""
    return "\n".join(
        [
            f'<mujoco model="{design.name}">',
            "  <!-- m, kg, N, s; frame: x across the ridges, z out of the skin, its back at z = 0.",
            "       What was simplified and where it holds: package.md -->",
            '  <compiler inertiafromgeom="auto"/>',  # other bodies of a robot that includes it keep their own
            '  <option integrator="implicitfast" cone="elliptic" impratio="10" noslip_iterations="3"/>',
            *_defaults(design, springs),
            *_assets(design),
            "  <worldbody>",
            '    <body name="carrier">',
            body_inertial(links.carrier, 6),
            '      <geom class="visual" mesh="carrier"/>',
            '      <geom class="collision" name="carrier" mesh="carrier-hull"/>',
            '      <body name="skin">',
            body_inertial(links.base, 8),
            '        <geom class="visual" mesh="skin"/>',
            '        <geom class="collision" name="skin" mesh="base-hull"/>',
            *_filling(links),
            *_ridges(design, links),
            "      </body>",
            "    </body>",
            "  </worldbody>",
            *_tendons(springs, [*feature_bodies(design)]),
            *_sensors(design),
            "</mujoco>",
            "",
        ]
    )


def scene_xml(design: Design, springs: Springs) -> str:
    """Return a scene: the skin, fixed, and a flat plate that presses along -z and pulls along +x."""
    top = max(place[2, 3] for place in crests(design).poses) * M
    half = np.array([design.skin.width, design.skin.length, 2.0]) * M
    force, friction_force = springs.verdict.force, friction(design) * springs.verdict.force
    down = springs.flexibility @ springs.body_force * M
    mass = force / GRAVITY
    drag = max((SLIDES - 1) * friction_force, LEAST_DRAG * force) / (
        SPEED * float(springs.verdict.approach) * M
    )
    inertia = numbers([mass * float(half @ half) / 3] * 3)
    at = numbers([*down, float(springs.verdict.approach) * M, 0.0])
    start = numbers([0.0] * (down.size + 2))
    keys = [
        ("press", start, 0.0),
        ("pull", at, STICKS * friction_force),
        ("slide", at, SLIDES * friction_force),
    ]
    return "\n".join(
        [
            f'<mujoco model="{design.name}-scene">',
            '  <include file="skin.xml"/>',
            "  <!-- key press: from the first touch, the plate presses; joint plate-z is the approach.",
            f"       pull: pressed, pulled by {STICKS:g} of what friction holds; slide: by {SLIDES:g} -->",
            "  <worldbody>",
            '    <light pos="0 -0.05 0.1" dir="0 0.4 -1"/>',
            f'    <body name="plate" pos="{numbers([0.0, 0.0, top + half[2]])}" gravcomp="1">',
            '      <joint name="plate-z" type="slide" axis="0 0 -1"/>',
            f'      <joint name="plate-x" type="slide" axis="1 0 0" damping="{drag!r}"/>',
            f'      <inertial pos="0 0 0" mass="{mass!r}" diaginertia="{inertia}"/>',
            f'      <geom name="plate" type="box" size="{numbers(half)}" rgba="0.6 0.7 0.8 0.3"/>',
            "    </body>",
            "  </worldbody>",
            "  <actuator>",
            '    <motor name="press" joint="plate-z"/>',
            '    <motor name="pull" joint="plate-x"/>',
            "  </actuator>",
            "  <keyframe>",
            *(
                f'    <key name="{name}" qpos="{q}" ctrl="{numbers([force, pull])}"/>'
                for name, q, pull in keys
            ),
            "  </keyframe>",
            "</mujoco>",
            "",
        ]
    )


def _defaults(design: Design, springs: Springs) -> Iterator[str]:
    armature, damping = slide_damping(springs)
    yield "  <default>"
    yield '    <default class="visual">'
    yield '      <geom type="mesh" contype="0" conaffinity="0" group="2" rgba="0.93 0.72 0.62 1"/>'
    yield "    </default>"
    yield '    <default class="collision">'  # the skin's own parts don't touch each other, all else does
    yield '      <geom type="mesh" contype="2" conaffinity="1" group="3"/>'
    yield '      <default class="ridge">'
    yield (
        f'        <geom priority="1" condim="3" friction="{friction(design):g} 0.005 0.0001"'
        f' solref="{2 * STEP:g} 1" solimp="{IMPEDANCE:g} {IMPEDANCE:g} 0.001"/>'
    )
    yield f'        <joint type="slide" axis="0 0 -1" armature="{armature!r}" damping="{damping!r}"/>'
    yield '        <site type="box" group="4" rgba="0.9 0.2 0.2 0.3"/>'
    yield "      </default>"
    yield "    </default>"
    yield "  </default>"


def _assets(design: Design) -> Iterator[str]:
    names = ["carrier", "carrier-hull", "skin", "base-hull", *feature_bodies(design)]
    yield "  <asset>"
    yield from (f'    <mesh name="{name}" file="{name}.stl" scale="{M:g} {M:g} {M:g}"/>' for name in names)
    yield "  </asset>"


def body_inertial(weight: Weight, indent: int) -> str:
    """Return a body's `inertial` element, in the design's axes."""
    i = weight.inertia * KG_M2
    full = numbers([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]])
    at = f'pos="{numbers(weight.centre * M)}" mass="{numbers([weight.mass * KG])}"'
    return f'{" " * indent}<inertial {at} fullinertia="{full}"/>'


def _filling(links: Links) -> Iterator[str]:
    if links.filling:
        yield '        <body name="filling">'
        yield body_inertial(links.filling, 10)
        yield "        </body>"


def _ridges(design: Design, links: Links) -> Iterator[str]:
    skin = skin_of(design)
    along = skin.pitch if skin.symmetry == "revolved" else design.skin.length
    across = skin.pitch if skin.symmetry in ("extruded", "revolved") else design.skin.width
    size = np.array([across, along, max(*skin.heights, 0.1 * design.skin.thickness)]) * M
    tips = crests(design).poses[:, :, 3]
    for weight, (name, members) in zip(links.ridges, feature_bodies(design).items(), strict=True):
        low, high = tips[[*members]].min(axis=0), tips[[*members]].max(axis=0)
        middle = numbers(np.append((low + high)[:2] / 2, high[2]) * M)
        half = numbers(size + np.append((high - low)[:2] / 2, 0.0) * M)
        yield f'        <body name="{name}">'
        yield body_inertial(weight, 10)
        yield f'          <joint class="ridge" name="{name}"/>'
        yield f'          <geom class="ridge" name="{name}" mesh="{name}"/>'
        yield f'          <site class="ridge" name="{name}" pos="{middle}" size="{half}"/>'
        yield "        </body>"


def _tendons(springs: Springs, names: list[str]) -> Iterator[str]:
    """The springs: of row r of the Cholesky factor the stiffness r_ii^2, its coefficients over r_ii."""
    yield "  <tendon>"
    for i, row in enumerate(springs.rows, 1):
        lead = float(row[i - 1])
        yield f'    <fixed name="spring-{i}" stiffness="{lead * lead * N_PER_M!r}" springlength="0">'
        for j in map(int, np.flatnonzero(np.abs(row) > SMALL * abs(lead))):
            yield f'      <joint joint="{names[j]}" coef="{float(row[j]) / lead!r}"/>'
        yield "    </fixed>"
    yield "  </tendon>"


def _sensors(design: Design) -> Iterator[str]:
    """Normal force by touch, and the force in the design's axes, of the ridge on what touches it."""
    yield "  <sensor>"
    for kind in ("touch", "force"):
        for i, name in enumerate(feature_bodies(design), 1):
            yield f'    <{kind} name="{kind}-{i}" site="{name}"/>'
    yield "  </sensor>"


def skin_urdf(design: Design, links: Links, prefix: str = "") -> str:
    """Return the skin on its carrier: root link `carrier`, in the design's frame. Names of meshes begin with
    `prefix`."""
    lines = ['<?xml version="1.0"?>', f'<robot name="{design.name}">']
    lines += _urdf_link("carrier", links.carrier, f"{prefix}carrier", f"{prefix}carrier-hull")
    base = _urdf_link("skin", links.base, f"{prefix}skin", f"{prefix}base-hull")
    lines += [*base, *_urdf_joint("carrier", "skin")]
    if links.filling:
        lines += [*_urdf_link("filling", links.filling), *_urdf_joint("skin", "filling")]
    for name, weight in zip(feature_bodies(design), links.ridges, strict=False):  # none where none are asked
        lines += [*_urdf_link(name, weight, None, f"{prefix}{name}"), *_urdf_joint("skin", name)]
    return "\n".join([*lines, "</robot>", ""])


def _urdf_link(
    name: str, weight: Weight, visual: str | None = None, collision: str | None = None
) -> Iterator[str]:
    i = weight.inertia * KG_M2
    axes = {"ixx": i[0, 0], "ixy": i[0, 1], "ixz": i[0, 2], "iyy": i[1, 1], "iyz": i[1, 2], "izz": i[2, 2]}
    yield f'  <link name="{name}">'
    yield "    <inertial>"
    yield f'      <origin xyz="{numbers(weight.centre * M)}" rpy="0 0 0"/>'
    yield f'      <mass value="{numbers([weight.mass * KG])}"/>'
    words = zip(axes, numbers(axes.values()).split(), strict=True)
    yield "      <inertia " + " ".join(f'{axis}="{value}"' for axis, value in words) + "/>"
    yield "    </inertial>"
    for kind, mesh in (("visual", visual), ("collision", collision)):
        if mesh:
            yield f"    <{kind}>"
            yield '      <origin xyz="0 0 0" rpy="0 0 0"/>'
            name = f'filename="{escape(mesh)}.stl" scale="{M:g} {M:g} {M:g}"'
            yield f"      <geometry><mesh {name}/></geometry>"
            yield f"    </{kind}>"
    yield "  </link>"


def _urdf_joint(parent: str, child: str) -> Iterator[str]:
    yield f'  <joint name="{parent}-{child}" type="fixed">'
    yield '    <origin xyz="0 0 0" rpy="0 0 0"/>'
    yield f'    <parent link="{parent}"/>'
    yield f'    <child link="{child}"/>'
    yield "  </joint>"


def numbers(values: Iterable[float]) -> str:
    """Return numbers as words apart by a space, to DIGITS digits of the largest."""
    all_of_them = [float(value) for value in values]
    least = 10.0**-DIGITS * max(map(abs, all_of_them), default=0.0)
    return " ".join(f"{0.0 if abs(value) < least else value:.{DIGITS}g}" for value in all_of_them)


def exactly(values: Iterable[float]) -> str:
    """Return numbers as words apart by a space, each the shortest that reads back as the same double."""
    return " ".join(repr(float(value) + 0.0) for value in values)
