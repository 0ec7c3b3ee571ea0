"""The designs that ship, side by side: size, smallest detail, how they are made, and at what force all touch.

The forces are computed once, by `python -m bench.gallery`, and ship in templates/gallery.toml with the
revision of the design that they belong to.
"""

from __future__ import annotations

import tomllib
from functools import cache
from typing import Any

from skincad.base.estimate import Estimate
from skincad.fabrication.papers import paper
from skincad.inputs.catalog import Kind, load_design, template_names, template_text
from skincad.inputs.design import Design
from skincad.inputs.shipped import templates_folder
from skincad.shape.skin import skin_of


@cache
def forces() -> dict[str, dict[str, Any]]:
    """Return, by design, its revision, all-touch force and error, N, and the model that gave them."""
    return tomllib.loads((templates_folder() / "gallery.toml").read_text("utf-8"))


def purpose(name: str, kind: Kind = "designs") -> str:
    """Return what a template is for, its file's first line."""
    return template_text(name, kind).splitlines()[0].lstrip("# ")


def smallest_detail(design: Design) -> tuple[float, str]:
    """Return the narrowest groove, tooth or slot of a mold, mm, and which it is."""
    skin, pocket = skin_of(design), design.features.pocket
    if skin.bare:
        return (pocket.diameter, "pocket") if pocket else (skin.base.width, "skin")
    details = [skin.groove(), *([tooth] if (tooth := skin.tooth()) else [])]
    widths = [(detail.width, detail.where) for detail in details]
    if design.core_thickness:
        widths.append((design.core_thickness, "slot" if design.mold.method == "shim" else "film"))
    return min(widths)


def force_of(design: Design) -> Estimate:
    """Return a shipped design's all-touch force, without value where none is known."""
    row = forces().get(design.name, {})
    if row.get("revision") != design.revision or "all_touch_force" not in row:
        return Estimate(None, None, "N")
    return Estimate(row["all_touch_force"], row["error"], "N")


def entries() -> dict[str, dict[str, Any]]:
    """Return each design's row as plain data."""
    return {name: _entry(load_design(name)) for name in template_names("designs")}


def _entry(design: Design) -> dict[str, Any]:
    detail, where = smallest_detail(design)
    return {
        "about": purpose(design.name),
        "family": design.features.family,
        "count": design.count,
        "features": skin_of(design).counted,
        "size": design.skin.across,
        "size_mm": [design.skin.width, design.skin.length],
        "smallest_detail_mm": detail,
        "smallest_detail": where,
        "process": design.mold.process,
        "end_plate_process": design.mold.end_plate_process or design.mold.process,
        "silicone": design.material.name,
        "force_N": design.contact.force,
        "all_touch_force_N": force_of(design).as_json(),
    }


def page() -> str:
    """Return the gallery as a page of the docs, whose pictures lie beside it."""
    rows = [(name, entry, force_of(load_design(name))) for name, entry in entries().items()]
    return paper("gallery.md", entries=rows)
