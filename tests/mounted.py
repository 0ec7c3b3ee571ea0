"""A mount that fits each template's carrier, and a doubly curved one's, for all tests of mounts."""

from __future__ import annotations

from typing import Any

import skincad
from skincad.inputs import Design
from tests.bent_skin import bent
from tests.families import RIDGED

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
