"""The drawing: each dimension is as long as it says, at the figure's own scale, and drawn beside it."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import cache
from itertools import chain, combinations

import numpy as np
import pytest

import skincad
from skincad.fabrication import Job, manifold
from skincad.inputs import Design
from skincad.outputs import PAGE
from skincad.outputs.drawing.overview import drawing
from skincad.shape import section
from skincad.solids import ClosedMold, Part
from tests.designs import KINDS, three_ridges

SVG = "{http://www.w3.org/2000/svg}"
NAMES = ("yamada-2002", "plain-ridges", "steep-fingertip", "bent")
DIGITS = 2e-3  # page mm; the file has three decimals
Ends = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Page:
    """What is on a page: lines by their ends, texts by their place, outlines `(n, 2)` and boxes by kind."""

    design: Design
    closed: ClosedMold
    lines: list[Ends]
    texts: dict[str, tuple[float, float, str]]
    outlines: dict[str, list[np.ndarray]]

    def dimension(self, words: str) -> Ends:
        """The line that a text stands at, found by its place: over its middle, or beside it."""
        x, y, anchor = self.texts[words]
        boxes = []
        for (x0, y0), (x1, y1) in self.lines:
            over = abs((x0 + x1) / 2 - x) < DIGITS and y0 == y1 and abs(y0 - y - 0.9) < DIGITS
            offset = x - x0 if anchor == "start" else x0 - x
            beside = x0 == x1 and abs(offset - 1.2) < DIGITS and abs((y0 + y1) / 2 + 1 - y) < DIGITS
            if over or beside:
                boxes.append(((x0, y0), (x1, y1)))
        (line,) = boxes
        return line

    def scale(self, begin: str) -> float:
        (words,) = (text for text in self.texts if text.startswith(begin))
        match = re.search(r"scale (\S+) : 1", words)
        assert match
        return float(match[1])


def wide_skin() -> Design:
    """Wider by far than it is high, its middle between two ridges."""
    return skincad.load("plain-ridges", ["skin.width=60", "skin.curvature_radius=500", "ridge.count=10"])


@cache
def page(name: str) -> Page:
    designs = {"bent": three_ridges, "wide": wide_skin}
    design = designs[name]() if name in designs else skincad.load(name)
    closed = Job(design).closed
    root = ET.fromstring(drawing(design, closed))
    lines = [
        ((float(n.attrib["x1"]), float(n.attrib["y1"])), (float(n.attrib["x2"]), float(n.attrib["y2"])))
        for n in root.iter(f"{SVG}line")
    ]
    texts = {
        n.text or "": (float(n.attrib["x"]), float(n.attrib["y"]), n.attrib["text-anchor"])
        for n in root.iter(f"{SVG}text")
    }
    outlines: dict[str, list[np.ndarray]] = {}
    for n in root.iter(f"{SVG}polygon"):
        points = [tuple(map(float, pair.split(","))) for pair in n.attrib["points"].split()]
        outlines.setdefault(n.attrib["class"], []).append(np.array(points))
    for n in root.iter(f"{SVG}rect"):
        x, y, wide, high = (float(n.attrib[key]) for key in ("x", "y", "width", "height"))
        outlines.setdefault(n.attrib["class"], []).append(np.array([[x, y], [x + wide, y + high]]))
    return Page(design, closed, lines, texts, outlines)


def drawn_as_told(page: Page, words: str, value: float, scale: float, figure: np.ndarray) -> Ends:
    """A dimension's line is as long as the value, has extension lines and ticks, and lies off its figure."""
    (x0, y0), (x1, y1) = page.dimension(words)
    assert math.hypot(x1 - x0, y1 - y0) == pytest.approx(
        scale * value, rel=5e-3, abs=DIGITS
    )  # scale: 3 digits
    for x, y in ((x0, y0), (x1, y1)):
        tick = np.array([[x - 0.8, y + 0.8], [x + 0.8, y - 0.8]])
        assert any(np.abs(tick - line).max() < 1.5 * DIGITS for line in page.lines)
        extended = [line for line in page.lines if line[1] == (x, y) and line[0] not in ((x0, y0), (x1, y1))]
        assert extended
        assert all((a == x) == (y0 == y1) and (b == y) == (x0 == x1) for (a, b), _ in extended)
    low, high = figure.min(axis=0), figure.max(axis=0)
    assert not low[1] <= y0 <= high[1] if y0 == y1 else not low[0] <= x0 <= high[0]
    return (x0, y0), (x1, y1)


@pytest.mark.parametrize("name", NAMES)
def test_the_sections_dimensions_span_what_they_measure(name: str) -> None:
    seen = page(name)
    skin, shape, scale = seen.design.skin, section(seen.design), seen.scale("section")
    figure = seen.outlines["skin"][0]
    (left, top), (right, base) = figure.min(axis=0), figure.max(axis=0)
    assert right - left == pytest.approx(scale * skin.width, rel=5e-3)
    assert base - top == pytest.approx(scale * shape.top, rel=5e-3)
    (x0, y0), (x1, _) = drawn_as_told(seen, f"{skin.width:g}", skin.width, scale, figure)
    assert (x0, x1) == pytest.approx((left, right), abs=DIGITS)
    assert y0 > base  # under the back
    (x0, y0), (_, y1) = drawn_as_told(seen, f"{shape.top:.4g} to the crest", shape.top, scale, figure)
    assert (y0, y1) == pytest.approx((base, top), abs=0.02)  # chords of 1 um, enlarged
    assert x0 > right
    (x0, y0), (_, y1) = drawn_as_told(seen, f"{skin.thickness:g}", skin.thickness, scale, figure)
    assert y0 == pytest.approx(base, abs=DIGITS)
    assert y1 < y0
    assert x0 < left
    assert any(
        f"R {skin.curvature_radius:g}, {seen.design.ridge.count} ridges" in text for text in seen.texts
    )
    assert any("along y" in text for text in seen.texts) == (skin.curvature_radius_y is not None)
    assert len(seen.outlines.get("slot", [])) == len(shape.slots) + (2 if shape.slots else 0)


@pytest.mark.parametrize("name", NAMES)
def test_the_ridges_dimensions_span_what_they_measure(name: str) -> None:
    seen = page(name)
    ridge, scale = seen.design.ridge, seen.scale("ridge")
    figure = seen.outlines["skin"][1]
    crest = figure[:, 1].min()
    ends = drawn_as_told(seen, f"root {ridge.root_width:g}", ridge.root_width, scale, figure)
    assert ends[0][1] > figure[:, 1].max()
    middle = (figure[:, 0].min() + figure[:, 0].max()) / 2  # it is drawn upright
    assert ends[0][0] + ends[1][0] == pytest.approx(2 * middle, abs=0.02)
    words = f"tip {ridge.tip_width:g}, crown {ridge.crown:g}"
    ends = drawn_as_told(seen, words, ridge.tip_width, scale, figure)
    assert ends[0][1] < crest
    assert ends[0][0] + ends[1][0] == pytest.approx(2 * middle, abs=0.02)
    (x0, y0), (_, y1) = drawn_as_told(seen, f"{ridge.height:g}", ridge.height, scale, figure)
    assert y1 == pytest.approx(crest, abs=0.1)  # chords of 1 um, far enlarged
    assert y1 < y0
    assert x0 > figure[:, 0].max()
    assert figure[:, 1].max() - crest == pytest.approx(1.8 * ridge.height * scale, rel=0.02)  # and some base
    for slot in seen.outlines.get("slot", [])[len(section(seen.design).slots) :]:
        assert (slot.min(axis=0) >= figure.min(axis=0)).all()
        assert (slot.max(axis=0) <= figure.max(axis=0)).all()


def extent(parts: list[Part]) -> np.ndarray:
    """Lowest and highest corner of parts, `(2, 3)` mm."""
    boxes = np.array([manifold(part, 1e-3).bounding_box() for part in parts]).reshape(-1, 2, 3)
    return np.array([boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)])


@pytest.mark.parametrize("name", NAMES[:-1])
def test_the_mold_from_above_has_its_outer_size(name: str) -> None:
    seen = page(name)
    scale = seen.scale("closed mold from above")
    size = np.ptp(extent([part for part in seen.closed.parts if part.made == "made"]), axis=0)
    assert any(f"height {size[2]:.4g}" in text for text in seen.texts)
    wide = drawn_as_told(seen, f"{size[0]:.4g}", size[0], scale, np.vstack(seen.outlines["mold"]))
    long = drawn_as_told(seen, f"{size[1]:.4g}", size[1], scale, np.vstack(seen.outlines["mold"]))
    (left, _), (right, _) = wide
    (_, bottom), (_, top) = long
    corners = [(left, bottom), (right, bottom), (right, top), (left, top)]
    frame = [{corners[i], corners[(i + 1) % 4]} for i in range(4)]  # round all parts
    assert all(any(side == set(line) for line in seen.lines) for side in frame)
    for (x0, y0), (x1, y1) in seen.outlines["hole"]:
        assert wide[0][0] < x0 < x1 < wide[1][0]
        assert long[1][1] < y0 < y1 < long[0][1]
    carrier = np.ptp(extent([seen.closed.part("carrier")]), axis=0)
    assert np.ptp(seen.outlines["hole"][-1], axis=0) == pytest.approx(scale * carrier[:2], rel=5e-3)


def test_the_bent_mold_from_the_side_has_its_outer_size() -> None:
    seen = page("bent")
    scale = seen.scale("closed mold from the side")
    shown = [
        p for p in seen.closed.parts if p.name in ("cavity", "carrier", "skin", "cover") or "end-" in p.name
    ]
    low, high = extent([part for part in shown if "pin" not in part.name])
    figure = np.vstack([*seen.outlines["mold"], seen.outlines["skin"][-1]])
    assert np.ptp(figure, axis=0) == pytest.approx(scale * (high - low)[1:], rel=0.02)
    # end plates are drawn before their tops are cut level, so it may be a little higher
    assert any("ends lean by 13.8 degrees" in text for text in seen.texts)


@pytest.mark.parametrize("name", [*KINDS, "bent"])
def test_all_lines_outlines_and_words_are_on_the_page(name: str) -> None:
    seen = page(name)
    points = np.vstack([*(np.array(line) for line in seen.lines), *chain(*seen.outlines.values())])
    assert (points >= 0).all()
    assert (points <= PAGE).all()
    for words, place in seen.texts.items():
        (left, _), (right, _) = words_box(words, place)
        assert left > 0
        assert right < PAGE[0]
        assert 2.8 < place[1] < PAGE[1]


def words_box(words: str, place: tuple[float, float, str]) -> np.ndarray:
    """Lowest and highest corner of a text, `(2, 2)`: letters are half as wide as high, about."""
    x, y, anchor = place
    long = 0.5 * 2.8 * len(words)
    left = {"start": x, "middle": x - long / 2, "end": x - long}[anchor]
    return np.array([[left, y - 2.0], [left + long, y]])


def apart(one: np.ndarray, other: np.ndarray) -> bool:
    return bool((one[1] <= other[0]).any() or (other[1] <= one[0]).any())


@pytest.mark.parametrize("name", [*NAMES, "wide"])
def test_views_and_words_lie_apart_each_caption_under_its_view(name: str) -> None:
    seen = page(name)
    kinds = seen.outlines
    views = [kinds["skin"][0], kinds["skin"][1], np.vstack([*kinds["mold"], *kinds.get("hole", [])])]
    boxes = [np.array([points.min(axis=0), points.max(axis=0)]) for points in views]
    assert all(apart(one, other) for one, other in combinations(boxes, 2))
    words = {text: words_box(text, place) for text, place in seen.texts.items()}
    assert all(apart(one, other) for one, other in combinations(words.values(), 2))
    assert all(apart(box, text) for box in boxes for text in words.values())
    ridges = seen.design.ridge.count
    for begin, box in zip(("section", f"ridge {math.ceil(ridges / 2)}", "closed mold"), boxes, strict=True):
        (caption,) = (text for text in words if text.startswith(begin))
        assert seen.texts[caption][0] == pytest.approx(box[:, 0].mean(), abs=0.02)  # chords, enlarged
        assert 0 < seen.texts[caption][1] - box[1, 1] < 35
    size = np.ptp(boxes[0], axis=0)
    assert size == pytest.approx([120.0, 45.0], abs=0.02) or (size <= (120.02, 45.02)).all()
    assert (size >= (119.9, 44.9)).any()  # as large as the page has room
    view_size = np.ptp(boxes[1], axis=0)
    assert view_size[0] == pytest.approx(38.0, abs=0.02) or view_size[1] == pytest.approx(
        24.0 * 1.2, rel=0.03
    )
    root = seen.design.ridge.root_width * seen.scale("ridge")
    assert view_size[0] > 1.2 * root  # some of the base on either side
    assert (view_size <= (38.02, 29.5)).all()


@pytest.mark.parametrize("name", NAMES)
def test_the_mold_lies_about_the_middle_of_the_pages_lower_right(name: str) -> None:
    """A mold from the side reaches up and down by different lengths from its own z = 0."""
    kinds = page(name).outlines
    figure = np.vstack([*kinds["mold"], *kinds.get("hole", [])])
    (left, top), (right, bottom) = figure.min(axis=0), figure.max(axis=0)
    assert ((left + right) / 2, (top + bottom) / 2) == pytest.approx((142.0, 105.0), abs=0.01)
    assert right - left == pytest.approx(50.0, abs=0.1) or bottom - top == pytest.approx(36.0, abs=0.1)
