"""The exam's skins: the templates with films, and random ones: 10 to fit on, 30 to score; 90 more to fit on.

Random skins keep the proportions of templates/designs/yamada-2002 within a factor (assumption) and are drawn
again until design and Winkler verdict take them; they are pressed by what makes all their ridges touch.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

import skincad
from skincad.base import InputError
from skincad.inputs import Design, load_design, template_names

DESIGN, EXAM = "design", "exam"
SETS = (DESIGN, EXAM)
RANDOM = {DESIGN: range(10), EXAM: range(110, 140)}  # numbers; 10 to 19 were scored before
# those of the design set's later batches: templates say little of other skins
MORE = range(20, 50), range(50, 110)
LARGEST = 12  # ridges; gripper-pad's 21 take as long as five others


LATER = {"home-printer"}  # ships since the detector and the bounds were fitted: random scenes stay the same


@dataclass(frozen=True, eq=False)
class Skin:
    """A design, and N at which a scene of it presses."""

    name: str
    design: Design
    force: float


def templates() -> list[Skin]:
    """Return the flat-extruded templates with films and not more ridges than LARGEST; both sets have them."""
    rows = [load_design(name) for name in template_names("designs") if name not in LATER]
    return [
        Skin(d.name, d, d.contact.force)
        for d in rows
        if d.film is not None and d.slot is not None and d.contact and d.ridge.count <= LARGEST
    ]


def skins(kind: str, batch: int = 0) -> list[Skin]:
    """Return a set's skins, templates first, or those of a later batch of its scenes, from 1."""
    if batch:
        return [random_skin(i) for i in MORE[batch - 1]]
    return [*templates(), *(random_skin(i) for i in RANDOM[kind])]


def random_skin(number: int) -> Skin:
    """Return the random skin of a number; the same every time."""
    draw = np.random.default_rng((20, number))
    while True:
        try:
            design = _drawn(draw, f"random-{number}")
            needed = skincad.check(design, model="winkler").all_touch_force.value
            force = float(np.clip(needed * draw.uniform(0.9, 1.6), 0.2, 60.0))
            return Skin(design.name, design, force)
        except InputError:
            continue


def _drawn(draw: np.random.Generator, name: str) -> Design:
    """Return a random design, or raise InputError."""
    pitch = float(np.exp(draw.uniform(np.log(0.9), np.log(4.0))))
    count = int(draw.integers(3, LARGEST + 1))
    part = {
        "height": draw.uniform(0.35, 0.6),
        "root_width": draw.uniform(0.7, 0.82),
        "tip_width": draw.uniform(0.45, 0.6),
        "crown": draw.uniform(0.015, 0.04),
    }
    ridge = {key: pitch * share for key, share in part.items()}
    gap = max(0.05, 0.05 * pitch)
    return load_design(
        "yamada-2002",
        [
            f"name={name!r}".replace("'", '"'),
            f"skin.curvature_radius={np.exp(draw.uniform(np.log(12), np.log(300))):.4g}",
            f"skin.thickness={pitch * draw.uniform(2.5, 6):.4g}",
            f"skin.width={pitch * (count + 2):.4g}",
            f"skin.length={pitch * draw.uniform(8, 20):.4g}",
            f"ridge.count={count}",
            f"ridge.pitch={pitch:.4g}",
            *(f"ridge.{key}={value:.4g}" for key, value in ridge.items()),
            f"ridge.tip_fillet={0.05 * pitch:.4g}",
            f"ridge.root_fillet={0.08 * pitch:.4g}",
            f"ridge.levelling={draw.choice([0.0, 0.0, 0.3, 0.6])}",
            f"slot.thickness={gap:.4g}",
            f"slot.depth={0.25 * pitch:.4g}",
            f"slot.offset={0.16 * pitch:.4g}",
            f"slot.elevation={0.05 * pitch:.4g}",
            f"material.young_modulus={np.exp(draw.uniform(np.log(0.15), np.log(1.5))):.4g}",
        ],
    )
