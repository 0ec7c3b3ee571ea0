"""The drawing: each dimension is as long as it says, at the figure's own scale, and drawn beside it."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cache
from itertools import chain, combinations, pairwise

import numpy as np
import pytest

import skincad
from skincad.fabrication import Job, manifold
from skincad.inputs import Design
from skincad.outputs import PAGE
from skincad.outputs.drawing.marks import Dimension, Fill, Ink, Words
from skincad.outputs.drawing.overview import overview
from skincad.shape import section
from skincad.solids import Arc, ClosedMold, Part
from tests.designs import KINDS, three_ridges

NAMES = ("yamada-2002", "plain-ridges", "steep-fingertip", "bent")
DIGITS = 1e-6  # page mm; places are rounded to as many decimals
KIND = {"SKIN": "skin", "SLOTS": "slot", "MOLD": "mold", "OPENING": "hole"}
Place = tuple[float, float]
Ends = tuple[Place, Place]


@dataclass(frozen=True)
class Page:
    """What is on a page, mm from its upper left corner: lines by their ends, texts by their boxes, lowest and
    highest corner, outlines `(n, 2)` by kind; and dimensions, as they lie on the sheet."""

    design: Design
    closed: ClosedMold
    lines: list[Ends]
    texts: dict[str, np.ndarray]
    outlines: dict[str, list[np.ndarray]]
    dimensions: dict[str, Dimension]

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
    lines, outlines = list[Ends](), dict[str, list[np.ndarray]]()
    texts, dimensions = dict[str, np.ndarray](), dict[str, Dimension]()
    for mark in overview(design, closed).marks:
        if isinstance(mark, Dimension):
            dimensions[mark.words.text] = mark
        for part in (*mark.drawn, mark.words) if isinstance(mark, Dimension) else (mark,):
            if isinstance(part, Words):
                left, low, right, high = part.box()
                texts[part.text] = np.array([down((left, high)), down((right, low))])
            elif isinstance(part, Ink) and not isinstance(part.stroke, Arc):
                points = [down(point) for point in part.stroke.points]
                if part.layer in KIND:
                    outlines.setdefault(KIND[part.layer], []).append(np.array(points))
                else:
                    lines += pairwise(points)
    return Page(design, closed, lines, texts, outlines, dimensions)


def down(place: Place) -> Place:
    """A place of the sheet from its upper left corner, mm."""
    return round(float(place[0]), 6), round(float(PAGE[1] - place[1]), 6)


def drawn_as_told(page: Page, words: str, value: float, scale: float, figure: np.ndarray) -> Ends:
    """A dimension's line is as long as the value, has arrows and extension lines, and lies off its figure."""
    dimension = page.dimensions[words]
    assert dimension.measured == pytest.approx(value, rel=1e-6)
    (x0, y0), (x1, y1) = (down(arrow.points[0]) for arrow in dimension.drawn if isinstance(arrow, Fill))
    assert math.hypot(x1 - x0, y1 - y0) == pytest.approx(
        scale * value, rel=5e-3, abs=DIGITS
    )  # scale: 3 digits
    level = y0 == y1
    own = [mark.stroke for mark in dimension.drawn if isinstance(mark, Ink)]
    extensions = [[down(point) for point in stroke.points] for stroke in own[:-1]]  # then its line
    assert len(extensions) == 2
    for (x, y), ((a, b), (c, d)) in zip(((x0, y0), (x1, y1)), extensions, strict=True):
        assert (a, c) == pytest.approx((x, x)) if level else (b, d) == pytest.approx((y, y))
        assert math.dist((x, y), (c, d)) == pytest.approx(1.2, abs=1e-5)  # beyond the arrow
        assert math.dist((a, b), (c, d)) > 1.2
    low, high = figure.min(axis=0), figure.max(axis=0)
    assert not low[1] <= y0 <= high[1] if level else not low[0] <= x0 <= high[0]
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
    for (x0, y0), (x1, y1) in ((hole.min(axis=0), hole.max(axis=0)) for hole in seen.outlines["hole"]):
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
    for (left, top), (right, bottom) in seen.texts.values():
        assert 0 < left < right < PAGE[0]
        assert 0 < top < bottom < PAGE[1]


def apart(one: np.ndarray, other: np.ndarray) -> bool:
    return bool((one[1] <= other[0]).any() or (other[1] <= one[0]).any())


@pytest.mark.parametrize("name", [*NAMES, "wide"])
def test_views_and_words_lie_apart_each_caption_under_its_view(name: str) -> None:
    seen = page(name)
    kinds = seen.outlines
    views = [kinds["skin"][0], kinds["skin"][1], np.vstack([*kinds["mold"], *kinds.get("hole", [])])]
    boxes = [np.array([points.min(axis=0), points.max(axis=0)]) for points in views]
    assert all(apart(one, other) for one, other in combinations(boxes, 2))
    words = seen.texts
    assert all(apart(one, other) for one, other in combinations(words.values(), 2))
    assert all(apart(box, text) for box in boxes for text in words.values())
    ridges = seen.design.ridge.count
    for begin, box in zip(("section", f"ridge {math.ceil(ridges / 2)}", "closed mold"), boxes, strict=True):
        (caption,) = (text for text in words if text.startswith(begin))
        assert words[caption][:, 0].mean() == pytest.approx(box[:, 0].mean(), abs=0.02)  # chords, enlarged
        assert 0 < words[caption][1, 1] - box[1, 1] < 35
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
