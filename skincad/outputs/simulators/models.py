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

from collections.abc import Iterable
from xml.sax.saxutils import escape

import numpy as np

from skincad.fabrication.papers import macro
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
    skin = skin_of(design)
    of_features = {"ridge": (skin.pitch, design.skin.length), "pin": (skin.pitch, skin.pitch)}
    across, along = of_features.get(skin.family, (design.skin.width, design.skin.length))
    size = np.array([across, along, max(*skin.heights, 0.1 * design.skin.thickness)]) * M
    tips = crests(design).poses[:, :, 3]
    bodies = []
    for weight, (name, members) in zip(links.ridges, feature_bodies(design).items(), strict=True):
        low, high = tips[[*members]].min(axis=0), tips[[*members]].max(axis=0)
        middle = numbers(np.append((low + high)[:2] / 2, high[2]) * M)
        half = numbers(size + np.append((high - low)[:2] / 2, 0.0) * M)
        bodies.append({"name": name, "weight": weight, "middle": middle, "half": half})
    armature, damping = slide_damping(springs)
    facts = {
        "armature": armature,
        "damping": damping,
        "friction": friction(design),
        "tendons": _tendons(springs),
    }
    constants = {"STEP": STEP, "IMPEDANCE": IMPEDANCE, "M": M, "inertial": body_inertial}
    return macro("simulators/mujoco.xml", "skin", design.name, links, bodies, **facts, **constants)


def scene_xml(design: Design, springs: Springs) -> str:
    """Return a scene: the skin, fixed, and a flat plate that presses along -z and pulls along +x."""
    top = max(place[2, 3] for place in crests(design).poses) * M
    half = np.array([design.skin.width, design.skin.length, 2.0]) * M
    force, approach = springs.verdict.force, float(springs.verdict.approach) * M
    friction_force, mass = friction(design) * force, force / GRAVITY
    down = springs.flexibility @ springs.body_force * M
    at = numbers([*down, approach, 0.0])
    keys = [
        ("press", numbers([0.0] * (down.size + 2)), 0.0),
        ("pull", at, STICKS * friction_force),
        ("slide", at, SLIDES * friction_force),
    ]
    facts = {
        "place": numbers([0.0, 0.0, top + half[2]]),
        "drag": max((SLIDES - 1) * friction_force, LEAST_DRAG * force) / (SPEED * approach),
        "mass": mass,
        "inertia": numbers([mass * float(half @ half) / 3] * 3),
        "half": numbers(half),
    }
    constants = {"STICKS": STICKS, "SLIDES": SLIDES, "numbers": numbers}
    return macro("simulators/mujoco.xml", "scene", design.name, force, keys, **facts, **constants)


def body_inertial(weight: Weight) -> str:
    """Return a body's `inertial` element, in the design's axes."""
    i = weight.inertia * KG_M2
    full = numbers([i[0, 0], i[1, 1], i[2, 2], i[0, 1], i[0, 2], i[1, 2]])
    at = f'pos="{numbers(weight.centre * M)}" mass="{numbers([weight.mass * KG])}"'
    return f'<inertial {at} fullinertia="{full}"/>'


def _tendons(springs: Springs) -> list[tuple[float, list[tuple[int, float]]]]:
    """The springs: of row r of the Cholesky factor the stiffness r_ii^2, its coefficients over r_ii."""
    tendons = []
    for i, row in enumerate(springs.rows):
        lead = float(row[i])
        used = np.flatnonzero(np.abs(row) > SMALL * abs(lead)).tolist()
        tendons.append((lead * lead * N_PER_M, [(j, float(row[j]) / lead) for j in used]))
    return tendons


def skin_urdf(design: Design, links: Links, prefix: str = "") -> str:
    """Return the skin on its carrier: root link `carrier`, in the design's frame. Names of meshes begin with
    `prefix`."""

    def inertia(weight: Weight) -> str:
        values = numbers((weight.inertia * KG_M2)[np.triu_indices(3)]).split()
        axes = zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), values, strict=True)
        return " ".join(f'{axis}="{value}"' for axis, value in axes)

    bodies = list(zip(feature_bodies(design), links.ridges, strict=False))  # none where none are asked
    facts = {"KG": KG, "M": M, "numbers": numbers, "inertia": inertia, "escape": escape}
    return macro("simulators/skin.urdf", "skin", design.name, links, bodies, prefix, **facts)


def numbers(values: Iterable[float]) -> str:
    """Return numbers as words apart by a space, to DIGITS digits of the largest."""
    all_of_them = [float(value) for value in values]
    least = 10.0**-DIGITS * max(map(abs, all_of_them), default=0.0)
    return " ".join(f"{0.0 if abs(value) < least else value:.{DIGITS}g}" for value in all_of_them)


def exactly(values: Iterable[float]) -> str:
    """Return numbers as words apart by a space, each the shortest that reads back as the same double."""
    return " ".join(repr(float(value) + 0.0) for value in values)
