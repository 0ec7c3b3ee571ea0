"""What is drawn flat at full size, as DXF and SVG: the section, and patterns of strips, shims and seal.

Their dimensions are laid out on paper that is `scale` times as large, so that words and arrows suit the part.
The board for the strips' contacts is here too, as KiCad's footprint of a pin header of two rows: each strip
is a column, its pads' crimps plug on the two pins. KiCad's format because a laboratory orders such a board
from a file, and KiCad, which others import, costs nothing. As seen from the skin: pins stick out towards it,
the front's row (+) is upper, ridges are below.
"""

from __future__ import annotations

import base64
import math
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from skincad.fabrication.drawn_features import number
from skincad.fabrication.electrodes import fan_out
from skincad.fabrication.job import Job
from skincad.fabrication.papers import macro
from skincad.fabrication.patterns import (
    StripPattern,
    pattern_notes,
    pattern_words,
    seal_pattern,
    shim_patterns,
    strip_patterns,
)
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.outputs.drawing.formats import sheet_svg, write_dxf
from skincad.outputs.drawing.marks import (
    Contour,
    Dimension,
    Mark,
    Sheet,
    Words,
    aligned,
    diameter,
    line,
    linear,
)
from skincad.shape.curves import Loop
from skincad.shape.skin import drawn_section, skin_of, summit
from skincad.solids.inserts import PITCH
from skincad.solids.projection import Place
from skincad.solids.shrinkage import shrinkage

if TYPE_CHECKING:
    from skincad.solids.mold import ClosedMold


SIZE = 2.0  # mm of paper, height of capitals
SECTION_WIDTH = 110.0  # mm of paper
ROOM_BESIDE, ROOM_OVER = 10.0, 14.0  # mm of paper, beside and over a section
NOTES_Z, SEAL_NOTES_GAP = -14.0, 6.0  # mm of paper: notes' first line, below z = 0, and below a seal
STRIPS = 2.5  # paper by strip
OTHER_FONT = 1.2  # assumption: letters of a font in Arial's place, by Arial's width
STRIPS_ROOM = 20.0, 32.5  # mm of paper, beside and over the strips, for their dimensions
FOOTPRINT_ROOM = 1.8  # mm, source: the same, of the courtyard beyond a pin's centre


def write_section_dxf(design: Design, path: Path) -> None:
    """Write the skin's own section with true arcs (polyline bulges) as DXF, mm: layers OUTLINE and SLOTS,
    DIMENSIONS, and TEXT, which says that a mold is not cut by it."""
    sheet = _section(design, "OUTLINE")
    notes = pattern_words("section", design=design, larger=1 / (1 - shrinkage(design)))
    written = _note_words(notes, (-SECTION_WIDTH / 2, NOTES_Z), SIZE)
    write_dxf(path, [*sheet.marks, *written], sheet.scale, notes)


def section_html(design: Design) -> str:
    """Return what a notebook shows of a design: its name, its sizes, and its section."""
    skin = skin_of(design)
    size = f"{design.skin.across} x {summit(design):.4g} mm"
    words = f"{design.name}: {skin.counted} on {size}, of {silicone(design).name}"
    data = base64.b64encode(section_svg(design).encode()).decode()
    picture = f'<img style="width:100%;max-width:760px" src="data:image/svg+xml;base64,{data}">'
    return f"<p><b>{escape(words)}</b></p>{picture}"


def section_svg(design: Design) -> str:
    """Return the section with true arcs as SVG, mm, z up."""
    sheet = _section(design, "SKIN")
    return sheet_svg(sheet, 1 / sheet.scale)


def _section(design: Design, layer: str) -> Sheet:
    """The section, its outline on this layer, with its dimensions: width and thickness, height to the crest,
    pitch, and a ridge's height, root and tip before fillets."""
    skin, shape = design.skin, drawn_section(design)
    scale = SECTION_WIDTH / skin.width
    half, thick, top = scale * skin.width / 2, scale * skin.thickness, scale * shape.top
    beside, over = max(scale, ROOM_BESIDE), max(scale, ROOM_OVER)
    marks: tuple[Mark, ...] = (
        Contour(shape.outline, layer),
        *(Contour(slot.loop(), "SLOTS") for slot in shape.slots),
        linear(((-half, 0.0), (half, 0.0)), -6.0, True, scale, number(skin.width)),
        linear(((-half, 0.0), (-half, thick)), -half - 4.0, False, scale, number(skin.thickness)),
        linear(((half, 0.0), (half, top)), half + 5.0, False, scale, number(shape.top)),
        *_ridge(design, scale),
    )
    size = 2 * (half + beside), top + over + beside
    return Sheet(f"{design.name}: section", size, scale, marks, corner=(-half - beside, -beside))


def _ridge(design: Design, scale: float) -> list[Dimension]:
    """Root and tip of the middle ridge, the pitch from the one before it, as a chord between crests, and the
    height of the first ridge, beside which there is room."""
    skin = skin_of(design)
    profile, middle = skin.profile, (skin.count + 1) // 2

    def on_paper(number_: int, t: float, n: float) -> Place:
        point = skin.placed[number_ - 1].frame.at(t, n)
        return scale * point.x, scale * point.z

    def across(half: float, height: float, out: float, words: str) -> Dimension:
        ends = on_paper(middle, -half, height), on_paper(middle, half, height)
        return aligned(ends, out, scale, f"{words} {number(2 * half)}")

    high, first = skin.heights[middle - 1], skin.heights[0]
    root, upright = profile.root_width / 2, (on_paper(1, 0.0, 0.0), on_paper(1, 0.0, first))
    rows = [
        across(root, 0.0, -3.2, "root"),
        across(profile.tip_width / 2, high, 2.8, "tip"),
        aligned(upright, scale * root + 3.0, scale, number(first)),
    ]
    if middle > 1:
        ends = on_paper(middle - 1, 0.0, skin.heights[middle - 2]), on_paper(middle, 0.0, high)
        words = f"{number(math.dist(*ends) / scale)} (pitch {number(skin.pitch)})"
        rows.append(aligned(ends, 6.6, scale, words))
    return rows


def _strip_dimensions(strip: StripPattern, scale: float) -> list[Dimension]:
    """The dimensions of a strip, over it and at its ends: lengths where both faces have metal, of the leads
    up to their pads, what is cut off and all; width of strip and tab; pitch of the pads; a tab's hole."""
    left, low, right, high = (scale * v for v in _extent(strip.cut))
    rows = []

    def over(a: float, b: float, level: int, words: str) -> None:
        (a, b), top = sorted((a, b)), high + 6.0 + 6.0 * level
        label = f"{words} {number((b - a) / scale)}".strip()
        rows.append(linear(((a, high), (b, high)), top, True, scale, label))

    sensed, pad, other = ([scale * v for v in _extent(o)] for o in (strip.overlap, *strip.pads))
    cuts = [scale * start.x for start, _ in strip.cut_off]
    wired_a = cuts[0] > 0  # what is cut off is at the other end
    over(sensed[0], sensed[2], 0, "both faces")
    over(*((pad[2], sensed[0]) if wired_a else (sensed[2], pad[0])), 1, "leads")
    over(cuts[0], right if wired_a else left, 2, "cut off")
    over(left, right, 3, "")
    centres = [((p[0] + p[2]) / 2, (p[1] + p[3]) / 2) for p in (other, pad)]
    line_x = left - 6.0 if wired_a else right + 6.0
    words = f"pads {number((centres[1][1] - centres[0][1]) / scale)}"
    rows.append(linear((centres[0], centres[1]), line_x, False, scale, words))
    x, (z0, z1) = cuts[0] + 5.0, (scale * end.z for end in strip.cut_off[0])
    wide = abs(z1 - z0)
    rows.append(linear(((x, z0), (x, z1)), x, False, scale, number(wide / scale)))
    if high - low > wide + 1e-9:
        words = number((high - low) / scale)
        rows.append(linear(((right, low), (right, high)), right + 16.0, False, scale, words))
    for hole in strip.holes[:1]:
        a, b, c, d = (scale * v for v in _extent(hole))
        text = f"{len(strip.holes)}x Ø{number((c - a) / scale)}"
        label = Words(text, (c + 1.0, high + 1.0), SIZE, "DIMENSIONS")
        rows.append(diameter(((a + c) / 2, (b + d) / 2), (c - a) / 2, math.radians(45), scale, label))
    return rows


def _extent(outline: Loop) -> tuple[float, float, float, float]:
    x, z = zip(*(s.start for s in outline), strict=True)
    return min(x), min(z), max(x), max(z)


def _note_words(notes: list[str], at: tuple[float, float], height: float) -> list[Words]:
    """Notes below each other from the place of the first one on, mm of paper."""
    return [Words(text, (at[0], at[1] - 2 * height * i), height, "TEXT") for i, text in enumerate(notes)]


def write_strips_dxf(job: Job, path: Path) -> None:
    """Write the cutting pattern of the film strips as DXF, mm: CUT (outlines and holes), FRONT and BACK
    (metal of either face), ENGRAVE (ridge and side, + sign), MARK (where a strip is cut off later); TEXT and
    DIMENSIONS, to be switched off."""
    sheet = _strips(job)
    write_dxf(path, sheet.marks, sheet.scale, sheet.notes)


def strips_svg(job: Job) -> str:
    """Return the same cutting pattern as SVG, mm; where both faces have metal, both colours lie over each
    other."""
    return sheet_svg(_strips(job), 1 / STRIPS)


def _strips(job: Job) -> Sheet:
    strips, notes = strip_patterns(job), pattern_notes(job)
    marks: list[Mark] = []
    for strip in strips:
        marks += [Contour(outline, "CUT") for outline in (strip.cut, *strip.holes)]
        marks += [Contour(strip.front, "FRONT"), Contour(strip.back, "BACK")]
    for a, b in (ends for strip in strips for ends in strip.cut_off):
        marks.append(line((STRIPS * a.x, STRIPS * a.z), (STRIPS * b.x, STRIPS * b.z), "MARK"))
    begin = min(s.start.x for strip in strips for s in strip.cut)
    texts = [(strip.label, *strip.label_at, "ENGRAVE") for strip in strips]
    texts += [("+", *strip.plus_at, "ENGRAVE") for strip in strips]
    texts += [(note, begin, -2.0 - 2 * i, "TEXT") for i, note in enumerate(notes)]
    words = [Words(text, (STRIPS * x, STRIPS * z), STRIPS, layer) for text, x, z, layer in texts]
    ends = STRIPS * np.array([_extent(strip.cut) for strip in strips])
    boxes = np.array([mark.box() for mark in words])
    wide = boxes[:, 0] + OTHER_FONT * (boxes[:, 2] - boxes[:, 0])
    beside, over = STRIPS_ROOM
    low, high = boxes[:, 1].min(), ends[:, 3].max() + over
    left, right = ends[:, 0].min() - beside, max(ends[:, 2].max() + beside, wide.max())
    title, size = f"{job.design.name}: film strips", (right - left, high - low)
    drawn = (*marks, *words, *_strip_dimensions(strips[-1], STRIPS))
    return Sheet(title, size, STRIPS, drawn, notes=tuple(notes), corner=(left, low))


def write_shims_dxf(job: Job, path: Path) -> None:
    """Write the cutting pattern of one skin's shims as DXF, mm: CUT, ENGRAVE (ridge and slot, beside each),
    MARK (where a tail is thinned, at +x) and TEXT."""
    shims, notes = shim_patterns(job), pattern_words("shims", job=job)
    marks: list[Mark] = [Contour(shim.cut, "CUT") for shim in shims]
    marks += [Words(shim.label, shim.label_at, 1.0, "ENGRAVE") for shim in shims]
    marks += [line(*shim.thinned, "MARK") for shim in shims if shim.thinned]
    low = min(s.start.z for shim in shims for s in shim.cut)
    marks += _note_words(notes, (min(shim.label_at.x for shim in shims), low - 3.0), 1.0)
    write_dxf(path, marks, notes=notes)


def write_seal_dxf(closed: ClosedMold, path: Path) -> None:
    """Write the cutting pattern of the foam under the cover as DXF, mm, seen from above, end b up: CUT
    (outline and holes), TEXT and DIMENSIONS over it and at its right."""
    loops, notes = seal_pattern(closed)
    left, low, right, high = _extent(loops[0])
    marks: list[Mark] = [
        *(Contour(loop, "CUT") for loop in loops),
        linear(((left, high), (right, high)), high + 6.0, True, 1.0, number(right - left)),
        linear(((right, low), (right, high)), right + 8.0, False, 1.0, number(high - low)),
        *_note_words(notes, (left, low - SEAL_NOTES_GAP), SIZE),
    ]
    write_dxf(path, marks, notes=notes)


def strip_board(job: Job) -> str:
    """Return the footprint of one skin's contacts as .kicad_mod, mm, y down: pads are named by ridge, slot
    and face, as "3S1+" is the front of ridge 3's S1. Raises ValueError without film."""
    design = job.design
    fan, film = fan_out(job), design.film
    if fan is None or film is None:
        raise ValueError("a design without film has no contacts")
    strips = fan.strips if film.wiring_side == "b" else fan.strips[::-1]  # seen from the skin
    middle, row = (len(strips) - 1) / 2, PITCH / 2
    places = [(f"{s.feature}{s.side}", PITCH * (i - middle)) for i, s in enumerate(strips)]
    side, high = PITCH * middle + FOOTPRINT_ROOM, row + FOOTPRINT_ROOM
    facts: dict[str, Any] = {"design": design, "side": side, "high": high, "row": row, "places": places}
    return macro("papers/strip-board.kicad_mod", "board", **facts)
