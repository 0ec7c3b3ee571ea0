"""One small design of each family but ridges, for tests that are the same for all."""

from __future__ import annotations

import skincad
from skincad.inputs import Design, read_table, template_names

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


RIDGED = [name for name in template_names() if "ridge" in read_table(name, "designs")]
