"""The inspection list's limits, the drawing and the page, against the design."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import pytest

from skincad.fabrication.inspection import inspection, inspection_lines
from skincad.inputs.catalog import load, template_names
from skincad.inputs.design import Design
from skincad.pictures.drawing import PAGE, drawing
from skincad.pictures.page import page
from skincad.solids.mold import mold


def rows(design: Design, drops: tuple[float, ...] = ()) -> dict[str, tuple[float, float, float]]:
    listed = inspection(design, mold(design).part("skin"), drops)
    return {m.what: (m.low, m.nominal, m.high) for m in listed}


def test_crests_may_sink_until_the_margin_is_used_up(yamada: Design) -> None:
    drops = (0.002, *(math.inf,) * 8)
    found = rows(yamada, drops)
    low, nominal, high = found["crest of ridge 1 over the flat back"]
    # by hand: 60.5 mm on an axis leaning by 4 pitches / 60 mm
    assert nominal == pytest.approx(4.0 - 60.0 + 60.5 * math.cos(4.0 / 60.0), abs=1e-9)
    assert nominal - low == pytest.approx(0.002)
    assert high - nominal == pytest.approx(3 * 0.003)  # edm: three standard deviations
    middle = found["crest of ridge 5 over the flat back"]
    assert middle[1] == 4.5
    assert middle[1] - middle[0] == pytest.approx(0.009)  # what the process lets it differ by


def test_the_mass_is_the_skins(yamada: Design) -> None:
    low, nominal, high = rows(yamada)["mass of the skin alone"]
    assert nominal == pytest.approx(mold(yamada).part("skin").volume * 1080e-6)
    assert low < 0.97 * nominal < 1.03 * nominal < high


def test_the_list_is_a_table(yamada: Design) -> None:
    lines = inspection_lines(inspection(yamada, mold(yamada).part("skin")))
    assert sum(line.startswith("| crest of ridge") for line in lines) == 9


@pytest.mark.parametrize("name", template_names())
def test_the_drawing_is_an_svg_within_its_page(name: str) -> None:
    design = load(name)
    root = ET.fromstring(drawing(design, mold(design)))
    text = " ".join(node.text or "" for node in root.iter("{http://www.w3.org/2000/svg}text"))
    for value in (design.skin.width, design.skin.thickness, design.ridge.height, design.skin.length):
        assert f"{value:g}" in text
    for node in root.iter("{http://www.w3.org/2000/svg}polygon"):
        for corner in node.attrib["points"].split():
            x, y = map(float, corner.split(","))
            assert 0 <= x <= PAGE[0]
            assert 0 <= y <= PAGE[1]


def test_the_page_has_tables_and_takes_no_html() -> None:
    text = page("# A\n\n<script>x</script>\n\n| a | b |\n|---|---|\n| 1 | 2 |\n", "<svg/>", "a < b")
    assert "<td>1</td>" in text
    assert "<script>" not in text
    assert "<title>a &lt; b</title>" in text
    assert "<svg/>" in text
