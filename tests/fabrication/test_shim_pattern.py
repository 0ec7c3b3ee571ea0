"""The shims' cutting pattern against the solids that lie in the mold, and as DXF."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import dxf_parser
import pytest
import shapely

import skincad
from skincad.fabrication import Job, shim_patterns
from skincad.outputs import write_shims_dxf
from skincad.shape import area, polygon
from skincad.solids import PartRole
from skincad.solids.mold import mold
from tests.bent_skin import three_ridges
from tests.templates import SHIPPED


def test_arcs_laid_flat_have_the_area_of_the_shims_in_the_mold() -> None:
    """A shim is a part of a cone of even thickness, so its volume is the flat area times that."""
    design = three_ridges()
    closed = mold(design)
    assert design.slot is not None
    flat = [area(shim.cut) * design.slot.thickness for shim in shim_patterns(Job(design, closed))]
    assert flat == pytest.approx([part.volume for part in closed.of(PartRole.SHIM)], rel=1e-12)


@pytest.mark.parametrize("name", SHIPPED)
def test_bars_are_the_shims_of_one_skin_in_whole_millimetres(name: str) -> None:
    design = skincad.load(name)
    closed = mold(design)
    patterns, parts = shim_patterns(Job(design, closed)), closed.of(PartRole.SHIM)
    assert len(patterns) * design.mold.cavities == len(parts)
    for shim, part in zip(patterns, parts, strict=False):
        assert design.slot is not None
        long = area(shim.cut) / design.slot.depth
        assert long == pytest.approx(round(long), abs=1e-9)
        true = part.volume / design.slot.depth / design.slot.thickness
        assert true - 1e-9 <= long < true + 1
        assert shim.thinned is None  # the end plates come off before the film is drawn in


@pytest.mark.parametrize("name", ["yamada-2002", "bent"])
def test_no_shim_lies_on_another_and_a_thin_tail_is_marked(name: str, tmp_path: Path) -> None:
    design = three_ridges() if name == "bent" else skincad.load(name)
    closed = mold(design)
    shims = shim_patterns(Job(design, closed))
    shapes = [shapely.Polygon(polygon(shim.cut, 1e-4)) for shim in shims]
    assert all(a.distance(b) > 1.0 for a, b in pairwise(shapes))
    for shim, shape in zip(shims, shapes, strict=True):
        if shim.thinned:
            a, b = shim.thinned
            assert math.dist(a, b) == pytest.approx(design.slot.depth)  # type: ignore[union-attr]
            assert shapely.LineString([a, b]).distance(shape) < 1e-3
    write_shims_dxf(Job(design, closed), tmp_path / "shims.dxf")
    read = dxf_parser.parse((tmp_path / "shims.dxf").read_text(encoding="utf-8"))
    kinds = [e["type"] for e in read["entities"] if e["layer"] == "CUT"]
    assert kinds == ["LWPOLYLINE"] * len(shims)
    texts = [(e["layer"], e["text"]) for e in read["entities"] if e["type"] == "TEXT"]
    assert [text for layer, text in texts if layer == "ENGRAVE"] == [shim.label for shim in shims]
    assert "kerf not compensated" in next(text for layer, text in texts if layer == "TEXT")


def test_strips_that_are_cast_in_have_no_shims() -> None:
    design = skincad.load("cast-in")
    assert shim_patterns(Job(design)) == []
