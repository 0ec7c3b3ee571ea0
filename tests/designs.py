"""Designs that many tests are about: templates by tier, small ones of each family, bent and mounted skins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

import skincad
from skincad.inputs import Design, read_table, template_names
from tests.small_scene import last_of_each

RIDGED = [name for name in template_names() if "ridge" in read_table(name, "designs")]
# The small one of each family and of each way to cast; all others are evidence, a subject each.
FAST = {"yamada-2002", "plain-ridges", "cast-in", "pillars-9", "rings-5", "flat-magnet"}


def template(name: str, *values: Any, tier: str = "fast") -> Any:
    """Return a test's parameter, of this tier, or evidence where a small template shows as much."""
    mark = pytest.mark.evidence(subject=name)
    marks = [mark] if name not in FAST else [pytest.mark.slow] if tier == "slow" else []
    return pytest.param(name, *values, marks=marks)


KINDS = [template(name) for name in RIDGED]
SHIPPED = [template(name) for name in template_names()]

# combs by the machine that prints the rest, which does not hold their notches
ONE_PRINTER = {
    "lab-bench": ["mold.end_plate_process=sla", "mold.slit_clearance=0.028"],
    "nozzle-04": ["mold.end_plate_process=fdm", "mold.slit_clearance=0.1"],
}


def of_one_printer(name: str, settings: Sequence[str] = ()) -> Design:
    """A template whose combs come from the machine that prints the rest."""
    given = {setting.partition("=")[0] for setting in settings}
    kept = [one for one in ONE_PRINTER.get(name, ()) if one.partition("=")[0] not in given]
    return skincad.load_design(name, [*kept, *settings])


_SKIN = {"thickness": 4.0, "width": 20.0, "length": 20.0}
_REST = {"material": {"name": "dragon-skin-20"}, "mold": {"process": "sla"}, "contact": {"force": 4.0}}


def pillars() -> Design:
    """Nine free pillars on a flat skin, the middle one higher."""
    pin = {"pitch": 5.0, "columns": 3, "rows": 3, "heights": [6.0, 5.5], "root_diameter": 3.0}
    pin |= {"tip_diameter": 3.0, "crown": 1.5, "root_fillet": 0.3}
    return skincad.Design(name="pillars", skin={"curvature_radius": 1e8, **_SKIN}, pin=pin, **_REST)


def dome() -> Design:
    """37 pins in rings on a doubly curved skin."""
    skin = {**_SKIN, "curvature_radius": 30.0, "curvature_radius_y": 40.0}
    pin = {"pattern": "polar", "pitch": 1.3, "rings": 3, "height": 0.7, "root_diameter": 0.9}
    pin |= {"tip_diameter": 0.55, "crown": 0.08, "root_fillet": 0.08}
    return skincad.Design(name="dome", skin=skin, pin=pin, **_REST)


def round_nibs() -> Design:
    """A disc full of fine pins."""
    skin = {"outline": "round", "curvature_radius": 60.0, "thickness": 4.0, "width": 14.0}
    pin = {"pattern": "hex", "pitch": 1.2, "margin": 0.4, "height": 0.4, "root_diameter": 0.8}
    pin |= {"tip_diameter": 0.5, "crown": 0.08}
    return skincad.Design(name="round-nibs", skin=skin, pin=pin, **_REST)


def rings() -> Design:
    """Three rings on a disc."""
    skin = {"outline": "round", "curvature_radius": 80.0, "thickness": 4.0, "width": 16.0}
    ring = {"count": 3, "pitch": 2.0, "height": 1.0, "root_width": 1.5, "tip_width": 1.0, "crown": 0.08}
    ring |= {"tip_fillet": 0.1, "root_fillet": 0.15}
    return skincad.Design(name="rings", skin=skin, ring=ring, **_REST)


def flat() -> Design:
    """A slightly curved pad over four pockets."""
    skin = {**_SKIN, "curvature_radius": 60.0}
    table = {"columns": 2, "rows": 2, "pitch": 8.0, "pocket": {"diameter": 2.1, "depth": 2.0}}
    return skincad.Design(name="flat", skin=skin, flat=table, **_REST)


OF_FAMILIES = {"pillars": pillars, "dome": dome, "round-nibs": round_nibs, "rings": rings, "flat": flat}


def bent(name: str, radius: float, *settings: str) -> Design:
    """A template's skin, bent along y to a radius in mm."""
    return skincad.load(name, last_of_each(f"skin.curvature_radius_y={radius}", *settings))


def three_ridges() -> Design:
    """Three ridges with their six shims, 12 mm long; its ends lean by 14 degrees."""
    return bent("yamada-2002", 25.0, "ridge.count=3")


PLAIN = {"mold": {"carrier": "plain"}}  # no holes, where half of them would be in the way
IN_LINE = {"thread": "M2", "pattern": "rectangle", "pitch_x": 8.0}
MOUNTS: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "cast-in": ({"thread": "M2", "diameter": 8.0, "fiducials": 3}, {}),
    "fingertip-soft": ({"thread": "M3", "pattern": "rectangle", "pitch_x": 9.0, "pitch_y": 5.0}, {}),
    "gripper-pad": ({"thread": "M4", "diameter": 20.0, "pin": 3.0, "fiducials": 4}, {}),
    "home-printer": ({"thread": "M3", "pattern": "rectangle", "pitch_x": 14.0, "pitch_y": 14.0}, {}),
    "lab-bench": ({"thread": "M3", "pattern": "rectangle", "pitch_x": 14.0, "pitch_y": 8.0}, {}),
    "milled-pad": ({"thread": "M3", "diameter": 20.0, "pin": 2.0, "fiducials": 4}, {}),
    "nozzle-04": ({"thread": "M4", "diameter": 31.5, "pin": 2.5, "fiducials": 4}, {}),
    "plain-ridges": ({"thread": "M2", "diameter": 7.0, "count": 2, "angle": 0.0}, PLAIN),
    "steep-fingertip": ({"thread": "M2", "pattern": "rectangle", "pitch_y": 5.0}, PLAIN),
    "yamada-2002": ({**IN_LINE, "fiducials": 3}, {}),
    "yamada-2002-tilted": ({"thread": "M2.5", "pattern": "rectangle", "pitch_x": 9.0, "pin": 1.0}, {}),
    "bent": ({"thread": "M2", "pattern": "rectangle", "pitch_x": 8.0, "fiducials": 3}, {}),
}
NAMES = (*RIDGED, "bent")


def mounted_design(name: str) -> Design:
    """A template with a mount that fits it, or `bent`, a skin that is curved along y too."""
    mount, more = MOUNTS[name]
    design = bent("yamada-2002", 60.0, "skin.length=20.0") if name == "bent" else skincad.load(name)
    return design.with_(mount=mount, **more)
