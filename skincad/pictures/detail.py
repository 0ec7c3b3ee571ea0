"""The enlarged detail of a sheet: one ridge's groove of a cavity, or a comb's slits, from the front view."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import shapely

from skincad.base.arrays import Array
from skincad.fabrication.bore_table import number
from skincad.fabrication.drawn_features import Groove, Slit
from skincad.fabrication.part_drawing import PartDrawing
from skincad.pictures.marks import Box, Ink, Mark, Words, aligned, rectangle
from skincad.pictures.sheet_bores import ViewPlacement
from skincad.solids.projection import Arc, Place, Polyline, Stroke

MARGIN = (10.0, 10.0)  # mm of paper beside and over it, for dimensions and caption
WINDOW_FACTOR = (1.3, 1.4)  # assumption: a window's size by that of what it shows
MIN_WINDOW = (42.0, 34.0)  # mm of paper, assumption: width and height of a window, at least
SLACK = 1.05  # the shown extent may exceed the window by this factor: it has margins of its own
SCALES = (200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0)  # source: ISO 5455
LETTER, SIZE = "W", 2.0
CHORD = 0.01  # mm of paper, of arcs that are cut at the window


class Focus(NamedTuple):
    """What a detail shows: its middle in the front view and its extent, mm, and what is dimensioned: two
    points, the line's distance from them (to the left of the way), all mm, and words."""

    middle: Place
    extent: tuple[float, float]
    sizes: tuple[tuple[Place, Place, float, str], ...]


def detail_size(drawing: PartDrawing, window: tuple[float, float]) -> tuple[float, float]:
    """Return width and height of the detail with its dimensions in a window of at most this size, mm; 0 where
    there is none."""
    focus = _focus(drawing)
    if focus is None:
        return 0.0, 0.0
    _, (wide, tall) = _scale_and_window(focus, window)
    return wide + 2 * MARGIN[0], tall + 2 * MARGIN[1]


def _focus(drawing: PartDrawing) -> Focus | None:
    if drawing.slits:
        return _slit_focus(drawing.slits)
    return _groove_focus(drawing.grooves) if drawing.grooves else None


def _scale_and_window(focus: Focus, max_size: tuple[float, float]) -> tuple[float, tuple[float, float]]:
    """The largest standard scale at which a window of at most this size shows it, and the window, mm."""
    fits = SLACK * min(w / e for w, e in zip(max_size, focus.extent, strict=True))
    scale = next((s for s in SCALES if s <= fits), SCALES[-1])
    wide, tall = (
        min(room, max(least, by * scale * e))
        for room, least, by, e in zip(max_size, MIN_WINDOW, WINDOW_FACTOR, focus.extent, strict=True)
    )
    return scale, (wide, tall)


def detail_marks(
    drawing: PartDrawing, front: ViewPlacement, corner: Place, max_size: tuple[float, float]
) -> list[Mark]:
    """Return the detail in a window of at most this size, mm, the lower left corner of all there, and where
    it is in the front view, which lies so."""
    focus = _focus(drawing)
    if focus is None:
        return []
    scale, size = _scale_and_window(focus, max_size)
    left, low = corner[0] + MARGIN[0], corner[1] + MARGIN[1]
    middle = left + size[0] / 2, low + size[1] / 2
    place = ViewPlacement((middle[0] - scale * focus.middle[0], middle[1] - scale * focus.middle[1]), scale)
    window = left, low, left + size[0], low + size[1]
    marks: list[Mark] = [rectangle(window, "CENTRE")]
    marks += [Ink(s, "OUTLINE") for s in _profile_in_window(drawing, place, window)]
    for a, b, out, words in focus.sizes:
        marks.append(aligned((place.at(a), place.at(b)), scale * out, scale, words, SIZE))
    caption = f"detail {LETTER} ({scale:g}:1)"
    marks.append(Words(caption, (middle[0], corner[1] + 3.5), 2.5, "TEXT", "middle"))
    return [*marks, *_window_mark(focus.middle, front, [length / scale for length in size])]


def _window_mark(middle: Place, front: ViewPlacement, size: list[float]) -> list[Mark]:
    """The window's rectangle in the front view, with its letter."""
    x, y = front.at(middle)
    w, h = (length / 2 * front.scale for length in size)
    return [
        rectangle((x - w, y - h, x + w, y + h), "DIMENSIONS"),
        Words(LETTER, (x + w + 0.5, y + h + 0.3), 1.8, "DIMENSIONS"),
    ]


def _slit_focus(slits: tuple[Slit, ...]) -> Focus:
    """The slits of the ridge in the middle: width and depth, and how far apart."""
    ridges = sorted({slit.ridge for slit in slits})
    middle = ridges[len(ridges) // 2]
    ridge_slits = sorted((slit for slit in slits if slit.ridge == middle), key=lambda slit: slit.at)
    first, last = ridge_slits[0], ridge_slits[-1]
    mouths = [_along(slit.at, slit.out, slit.depth) for slit in ridge_slits]
    points = [slit.at for slit in ridge_slits] + mouths
    x, y = zip(*points, strict=True)
    u, v = last.out
    half_width = v * last.width / 2, -u * last.width / 2
    corners = [(last.at[0] + s * half_width[0], last.at[1] + s * half_width[1]) for s in (-1, 1)]
    foot = first.at[0] - first.out[1] * first.width / 2, first.at[1] + first.out[0] * first.width / 2
    sizes = [
        (corners[0], corners[1], -0.35 * last.depth, number(last.width)),
        (foot, _along(foot, first.out, first.depth), 0.5 * first.depth, number(first.depth)),
    ]
    if len(ridge_slits) > 1:
        spacing = number(math.dist(mouths[0], mouths[-1]))
        sizes.append((mouths[0], mouths[-1], 0.4 * first.depth, spacing))
    size = max(x) - min(x) + 2.2 * first.depth, (max(y) - min(y)) * 2.2
    return Focus(((max(x) + min(x)) / 2, (max(y) + min(y)) / 2), size, tuple(sizes))


def _groove_focus(grooves: tuple[Groove, ...]) -> Focus:
    """The groove in the middle: depth, and widths at root and tip before fillets."""
    groove = grooves[len(grooves) // 2]
    lean, h = math.radians(groove.lean), groove.height
    up, sideways = (math.sin(lean), math.cos(lean)), (math.cos(lean), -math.sin(lean))
    mouth = _along(groove.bottom, up, h)
    root = [_along(mouth, sideways, s * groove.root / 2) for s in (-1, 1)]
    tip = [_along(groove.bottom, sideways, s * groove.tip / 2) for s in (-1, 1)]
    sizes = (
        (root[0], root[1], 0.35 * h, f"root {number(groove.root)}"),
        (tip[0], tip[1], -0.3 * h, f"tip {number(groove.tip)}"),
        (_along(groove.bottom, sideways, 0.0), mouth, 0.5 * groove.root + 0.4 * h, number(h)),
    )
    middle = _along(groove.bottom, up, h / 2)
    return Focus(middle, (1.6 * groove.root, 1.9 * h), sizes)


def _along(point: Place, way: Place, far: float) -> Place:
    return point[0] + far * way[0], point[1] + far * way[1]


def _profile_in_window(drawing: PartDrawing, place: ViewPlacement, window: Box) -> list[Stroke]:
    """What of the profile lies in the window, on paper."""
    frame, strokes = shapely.box(*window), list[Stroke]()
    for stroke in drawing.profile:
        on_paper = place.stroke(stroke)
        (left, low), (right, high) = on_paper.box()
        if left > window[2] or right < window[0] or low > window[3] or high < window[1]:
            continue
        points = np.array(on_paper.points) if isinstance(on_paper, Polyline) else _chords(on_paper)
        cut = shapely.LineString(points).intersection(frame)
        for one in getattr(cut, "geoms", [cut]):
            if one.geom_type == "LineString" and not one.is_empty:
                strokes.append(Polyline(tuple((float(x), float(y)) for x, y in one.coords)))
    return strokes


def _chords(arc: Arc) -> Array:
    count = math.ceil(arc.sweep / (2 * math.acos(1 - min(0.5, CHORD / arc.radius)))) + 1
    return np.array([arc.at(i / count) for i in range(count + 1)])
