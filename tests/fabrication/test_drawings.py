"""What shop drawings and cutting patterns say of parts; whole drawings are in tests/golden."""

from __future__ import annotations

import math
from itertools import pairwise
from pathlib import Path

import dxf_parser
import pytest
import shapely

import skincad
from skincad.fabrication import Job, shim_patterns
from skincad.fabrication.part_drawing import notes, surface_words, what_matters
from skincad.inputs import processes
from skincad.outputs import write_shims_dxf
from skincad.shape import area, polygon
from skincad.solids import PartRole
from skincad.solids.mold import mold
from tests.bent_skin import three_ridges
from tests.templates import SHIPPED, of_one_printer


def test_nothing_is_cut_of_a_print_or_with_no_room_for_a_wire() -> None:
    printed, narrow = of_one_printer("lab-bench"), skincad.load("yamada-2002", ["ridge.tip_fillet=0.01"])
    for design, part in ((printed, "end-a-comb"), (narrow, "cavity")):
        assert not any("trim cuts" in row for row in notes(Job(design), mold(design).part(part)))


def test_slits_and_seat_are_told_as_they_come_out() -> None:
    """Growth of 0.002 on a comb's walls, and on both parts that slide: 0.005 and mold.clearance less that."""
    design = skincad.load("yamada-2002")
    grown = design.with_(printer={"edm": {"growth": 0.002}})
    comb, carrier = mold(grown).part("end-a-comb"), mold(grown).part("carrier")
    assert any("Slits: 0.003 a side" in row for row in what_matters(Job(grown), comb, None))
    assert any(
        "(0.005 as drawn, less growth and coat)" in row for row in what_matters(Job(grown), comb, None)
    )
    left = f"Length and width: {design.mold.clearance - 0.004:.4g} a side to its seat"
    assert any(row.startswith(left) for row in what_matters(Job(grown), carrier, None))
    assert not any("as drawn" in row for row in what_matters(Job(design), comb, None))
    tight = design.with_(printer={"edm": {"growth": 0.003}})  # leaves 0.002, and ± 0.003 is the process
    assert any("does not keep that gap" in row for row in what_matters(Job(tight), comb, None))


@pytest.mark.parametrize("name", ["fdm", "sla", "cnc", "edm"])
def test_each_process_says_how_rough_its_faces_are(name: str) -> None:
    design = skincad.load("plain-ridges", [f"mold.process={name}"])
    part = mold(design).part("cavity")
    rough = processes()[name].roughness
    assert rough > 0
    cut = not processes()[name].layer  # the general one; faces on the silicone have the process's own
    assert surface_words(Job(design), part) == ("Ra 1.6" if cut else f"Ra {rough:g}")
    accurate = what_matters(Job(design), part, None)[0]
    assert (f", Ra {rough:g}: seat, trough, grooves" in accurate) == cut
    unsaid = design.with_(printer={name: {"roughness": 0.0}})
    assert surface_words(Job(unsaid), part) == ""


def test_arcs_laid_flat_have_the_area_of_the_shims_in_the_mold() -> None:
    """A shim is a part of a cone of even thickness, so its volume is the flat area times that."""
    design = three_ridges()
    closed = mold(design)
    flat = [area(shim.cut) * design.slot.thickness for shim in shim_patterns(Job(design, closed))]
    assert flat == pytest.approx([part.volume for part in closed.of(PartRole.SHIM)], rel=1e-12)


@pytest.mark.parametrize("name", SHIPPED)
def test_bars_are_the_shims_of_one_skin_in_whole_millimetres(name: str) -> None:
    design = skincad.load(name)
    closed = mold(design)
    patterns, parts = shim_patterns(Job(design, closed)), closed.of(PartRole.SHIM)
    assert len(patterns) * design.mold.cavities == len(parts)
    for shim, part in zip(patterns, parts, strict=False):
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
            assert math.dist(a, b) == pytest.approx(design.slot.depth)
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
