"""Dimensions of what is drawn flat and at full size: the skin's section, and the strips' cutting pattern.

Their marks are laid out on paper that is `scale` times as large, so that words and arrows suit the part.
"""

from __future__ import annotations

import math

from skincad.fabrication.bore_table import number
from skincad.fabrication.pattern import StripPattern
from skincad.fabrication.seal_pattern import SealPattern
from skincad.inputs.design import Design
from skincad.pictures.marks import Dimension, Words, aligned, diameter, linear
from skincad.shape.curves import Loop
from skincad.shape.skin import section, skin_of
from skincad.solids.projection import Place
from skincad.solids.shrinkage import shrinkage

SIZE = 2.0  # mm of paper, height of capitals
SECTION_WIDTH = 110.0  # mm of paper
ROOM_BESIDE, ROOM_OVER = 10.0, 14.0  # mm of paper, beside and over a section


def section_margin(design: Design) -> tuple[float, float]:
    """Return the room beside and over a section that its dimensions have, mm."""
    beside = design.skin.width * ROOM_BESIDE / SECTION_WIDTH
    over = design.skin.width * ROOM_OVER / SECTION_WIDTH
    return max(1.0, beside), max(1.0, over)


def section_dimensions(design: Design) -> tuple[list[Dimension], float]:
    """Return the section's dimensions, within its margin, and their paper's scale: width and thickness,
    height to the crest, pitch, and a ridge's height, root and tip before fillets."""
    skin, scale, top = design.skin, SECTION_WIDTH / design.skin.width, section(design).top
    half = skin.width / 2

    def on_paper(x: float, z: float) -> Place:
        return scale * x, scale * z

    rows = [
        linear((on_paper(-half, 0.0), on_paper(half, 0.0)), -6.0, True, scale, number(skin.width), SIZE),
        linear(
            (on_paper(-half, 0.0), on_paper(-half, skin.thickness)),
            -scale * half - 4.0,
            False,
            scale,
            number(skin.thickness),
            SIZE,
        ),
        linear(
            (on_paper(half, 0.0), on_paper(half, top)), scale * half + 5.0, False, scale, number(top), SIZE
        ),
    ]
    return [*rows, *_ridge(design, scale)], scale


def section_notes(design: Design) -> list[str]:
    """Return the notes under the section: it is the cured skin; a mold is cut by other files."""
    larger = 1 / (1 - shrinkage(design))
    by = f"{larger:.6g} times as large, for the silicone's shrinkage" if larger > 1 else "as large"
    bent = design.skin.curvature_radius_y is not None
    return [
        "The skin as it shall be, cured: not for cutting."
        + (" Section in its middle, y = 0." if bent else ""),
        f"The mold is {by}: cut it by the DXF of its own parts, layer CUT.",
    ]


def seal_dimensions(pattern: SealPattern) -> tuple[list[Dimension], float]:
    """Return the dimensions of a seal, over it and at its right, and their paper's scale: it suits 2 mm
    letters for any seal."""
    (left, low), (right, high) = pattern.box
    rows = [
        linear(((left, high), (right, high)), high + 6.0, True, 1.0, number(right - left), SIZE),
        linear(((right, low), (right, high)), right + 8.0, False, 1.0, number(high - low), SIZE),
    ]
    return rows, 1.0


def _ridge(design: Design, scale: float) -> list[Dimension]:
    """Root and tip of the middle ridge, the pitch from the one before it, as a chord between crests, and the
    height of the first ridge, beside which there is room."""
    skin = skin_of(design)
    profile, middle = skin.profile, (skin.count + 1) // 2

    def on_paper(number_: int, t: float, n: float) -> Place:
        point = skin.placed[number_ - 1].frame.at(t, n)
        return scale * point.x, scale * point.z

    high, first = skin.heights[middle - 1], skin.heights[0]
    root, tip = profile.root_width / 2, profile.tip_width / 2
    rows = [
        aligned(
            (on_paper(middle, -root, 0.0), on_paper(middle, root, 0.0)),
            -3.2,
            scale,
            f"root {number(2 * root)}",
            SIZE,
        ),
        aligned(
            (on_paper(middle, -tip, high), on_paper(middle, tip, high)),
            2.8,
            scale,
            f"tip {number(2 * tip)}",
            SIZE,
        ),
        aligned(
            (on_paper(1, 0.0, 0.0), on_paper(1, 0.0, first)), scale * root + 3.0, scale, number(first), SIZE
        ),
    ]
    if middle > 1:
        ends = on_paper(middle - 1, 0.0, skin.heights[middle - 2]), on_paper(middle, 0.0, high)
        words = f"{number(math.dist(*ends) / scale)} (pitch {number(skin.pitch)})"
        rows.append(aligned(ends, 6.6, scale, words, SIZE))
    return rows


def strip_dimensions(strips: list[StripPattern]) -> tuple[list[Dimension], float]:
    """Return the dimensions of the uppermost strip, over it and at its ends, and their paper's scale: lengths
    where both faces have metal, of the leads up to their pads, what is cut off and all; width of strip and
    tab; pitch of the pads; a tab's hole."""
    scale, strip = 2.5, strips[-1]
    left, low, right, high = (scale * v for v in _extent(strip.cut))
    rows = []

    def over(a: float, b: float, level: int, words: str) -> None:
        (a, b), top = sorted((a, b)), high + 6.0 + 6.0 * level
        label = f"{words} {number((b - a) / scale)}".strip()
        rows.append(linear(((a, high), (b, high)), top, True, scale, label, SIZE))

    sensed, pad, other = ([scale * v for v in _extent(o)] for o in (strip.overlap, *strip.pads))
    cuts = [scale * line.start.x for line in strip.cut_off]
    wired_a = cuts[0] > 0  # what is cut off is at the other end
    over(sensed[0], sensed[2], 0, "both faces")
    over(*((pad[2], sensed[0]) if wired_a else (sensed[2], pad[0])), 1, "leads")
    over(cuts[0], right if wired_a else left, 2, "cut off")
    over(left, right, 3, "")
    centres = [((p[0] + p[2]) / 2, (p[1] + p[3]) / 2) for p in (other, pad)]
    line_x = left - 6.0 if wired_a else right + 6.0
    words = f"pads {number((centres[1][1] - centres[0][1]) / scale)}"
    rows.append(linear((centres[0], centres[1]), line_x, False, scale, words, SIZE))
    line = strip.cut_off[0]
    x, (_, z0), (_, z1) = cuts[0] + 5.0, *(tuple(scale * v for v in point) for point in line)
    wide = abs(z1 - z0)
    rows.append(linear(((x, z0), (x, z1)), x, False, scale, number(wide / scale), SIZE))
    if high - low > wide + 1e-9:
        words = number((high - low) / scale)
        rows.append(linear(((right, low), (right, high)), right + 16.0, False, scale, words, SIZE))
    for hole in strip.holes[:1]:
        a, b, c, d = (scale * v for v in _extent(hole))
        text = f"{len(strip.holes)}x Ø{number((c - a) / scale)}"
        label = Words(text, (c + 1.0, high + 1.0), SIZE, "DIMENSIONS")
        rows.append(diameter(((a + c) / 2, (b + d) / 2), (c - a) / 2, math.radians(45), scale, label))
    return rows, scale


def _extent(outline: Loop) -> tuple[float, float, float, float]:
    x, z = zip(*(s.start for s in outline), strict=True)
    return min(x), min(z), max(x), max(z)
