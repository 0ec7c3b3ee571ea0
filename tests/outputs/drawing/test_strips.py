"""The strips' cutting pattern as another library reads its DXF: both faces have metal in the skin alone."""

from __future__ import annotations

import math
from collections import defaultdict
from itertools import islice
from pathlib import Path

import dxf_parser
import pytest
import shapely
from shapely.affinity import translate

import skincad
from bench.campaign.random_designs import drawn
from skincad.fabrication import Job, electrode_findings
from skincad.inputs import Design, template_names
from skincad.outputs.drawing.flat import write_strips_dxf
from skincad.shape import section
from skincad.solids import scaled_for_shrinkage
from tests.conftest import Made

FILMS = [name for name in template_names() if skincad.load(name).film]
ROUND = 1e-9  # mm2, sixteen digits of places below 100 mm: a sliver of 1e-14 mm along a lead of 100


def read(design: Design, folder: Path) -> dict[str, list[shapely.Polygon]]:
    """The closed outlines by layer, one strip after the other; a rounded corner as its chord."""
    write_strips_dxf(Job(design), folder / "strips.dxf")
    drawing = dxf_parser.parse((folder / "strips.dxf").read_text(encoding="utf-8"))
    layers = defaultdict(list)
    for entity in (e for e in drawing["entities"] if e["type"] == "LWPOLYLINE"):
        if len(entity["vertices"]) > 2:  # a hole is two half circles
            layers[entity["layer"]].append(shapely.Polygon([(v["x"], v["y"]) for v in entity["vertices"]]))
    return layers


def skins(design: Design) -> list[shapely.Polygon]:
    """What of each strip's row lies in the skin: its length, or its arc, as it is poured."""
    whole, radius = scaled_for_shrinkage(design) if design.mold.method == "cast-in" else design, 1e99
    radius = design.skin.curvature_radius_y or radius
    halves = [
        whole.skin.length / 2 * (1 + (slot.centre.z - design.skin.thickness) / radius)
        for slot in section(whole).slots
    ]
    return [shapely.box(-half, -1e4, half, 1e4) for half in halves]


def check(design: Design, folder: Path) -> None:
    """Overlap outside the skin is none, even with both faces off by the registration; and each has a pad."""
    layers, film = read(design, folder), design.film
    assert film is not None
    assert len(layers["FRONT"]) == len(layers["BACK"]) == len(layers["CUT"]) == 2 * design.ridge.count
    off = 0.0 if any(f.rule == "lead width" for f in electrode_findings(Job(design))) else film.registration
    rows = zip(layers["CUT"], layers["FRONT"], layers["BACK"], skins(design), strict=True)
    for cut, front, back, skin in rows:
        assert front.is_valid
        assert back.is_valid
        assert front.intersection(back).difference(skin).area < ROUND
        assert front.difference(cut).area < ROUND
        assert back.difference(cut).area < ROUND
        moved = translate(front, 0.0, -off), translate(back, 0.0, off)
        assert moved[0].intersection(moved[1]).difference(skin).area < ROUND
        # a pad each, 1.5 mm wide at least, and beside it bare film on the other face
        for metal, other in ((front, back), (back, front)):
            pad = (
                metal.difference(skin.buffer(Job(design).lead))
                .buffer(-0.749)
                .buffer(0.749, join_style="mitre")
            )
            assert pad.area >= 4.5 - ROUND
            assert pad.distance(other) > 0.0


@pytest.mark.parametrize("side", ["a", "b"])
@pytest.mark.parametrize("name", FILMS)
def test_both_faces_have_metal_in_the_skin_alone(name: str, side: str, tmp_path: Path) -> None:
    check(skincad.load(name, [f'film.wiring_side="{side}"']), tmp_path)


def test_a_doubly_curved_skins_strips_too(tmp_path: Path) -> None:
    check(skincad.load("yamada-2002", ["skin.curvature_radius_y=200"]), tmp_path)


@pytest.mark.slow
def test_sixty_random_designs_strips_too(tmp_path: Path) -> None:
    designs = (drawn(seed).design for seed in range(1000))
    with_film = list(islice((design for design in designs if design.film), 60))
    assert len(with_film) == 60
    for design in with_film:
        check(design, tmp_path)


def test_the_layers_say_what_is_cut_kept_and_marked(made: Made) -> None:
    drawing = dxf_parser.parse((made.folder / "film/strips.dxf").read_text(encoding="utf-8"))
    colours = {name: row["colorIndex"] for name, row in drawing["tables"]["layer"]["layers"].items()}
    assert {name: colours[name] for name in ("CUT", "FRONT", "BACK", "ENGRAVE", "MARK", "DIMENSIONS")} == {
        "CUT": 1,
        "ENGRAVE": 2,
        "FRONT": 3,
        "BACK": 4,
        "MARK": 5,
        "DIMENSIONS": 6,
    }


@pytest.mark.parametrize("name", FILMS)
def test_number_and_sign_are_on_what_is_not_cut_off(name: str, tmp_path: Path) -> None:
    """And off the leads, which an engraved mark could cut; a letter is at most 0.8 of its height wide."""
    layers = read(skincad.load(name), tmp_path)
    drawing = dxf_parser.parse((tmp_path / "strips.dxf").read_text(encoding="utf-8"))
    texts = [e for e in drawing["entities"] if e["type"] == "TEXT" and e["layer"] == "ENGRAVE"]
    cuts = [e for e in drawing["entities"] if e["type"] == "LINE" and e["layer"] == "MARK"]
    words = [t for t in texts if t["text"] == "+" or t["text"].endswith(("S1", "S2"))]
    assert len(words) == len(texts) == 2 * len(layers["CUT"])  # nothing else is engraved
    ends = {line["vertices"][0]["x"] for line in cuts}
    for word in words:
        x, y = word["startPoint"]["x"], word["startPoint"]["y"]
        box = shapely.box(x, y, x + 0.8 * len(word["text"]) * word["textHeight"], y + word["textHeight"])
        assert any(tab.contains(box) for tab in layers["CUT"])
        assert not any(box.intersects(metal) for metal in (*layers["FRONT"], *layers["BACK"]))
        assert max(end for end in ends if end < 0) < x  # the leads are at end b
        assert box.bounds[2] < min((end for end in ends if end > 0), default=math.inf)
