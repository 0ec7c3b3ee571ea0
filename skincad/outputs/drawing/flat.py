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
from typing import TYPE_CHECKING

from skincad.fabrication.drawn_features import number
from skincad.fabrication.electrodes import fan_out
from skincad.fabrication.job import Job
from skincad.fabrication.patterns import (
    SealPattern,
    StripPattern,
    pattern_notes,
    seal_pattern,
    shim_notes,
    shim_patterns,
    strip_patterns,
)
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.outputs.drawing.formats import primitives, svg_row, svg_style, write_dxf
from skincad.outputs.drawing.marks import Dimension, Mark, Words, aligned, diameter, line, linear
from skincad.shape.curves import Loop, Point
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
MARGIN_ABOVE, MARGIN_BESIDE = 13.0, 5.0  # mm over and beside the strips, for their dimensions
FOOTPRINT_FORMAT = 20211014  # source: KiCad 6, file formats, footprint libraries; later ones read it
PIN, DRILL = 1.7, 1.0  # mm, source: KiCad's own pin headers of 2.54 mm, for pins 0.64 square
FOOTPRINT_ROOM = 1.8  # mm, source: the same, of the courtyard beyond a pin's centre
FOOTPRINT_TEXT = 0.8  # mm, assumption: the smallest letters that boards' makers print
FOOTPRINT = "strip-board"


def section_margin(design: Design) -> tuple[float, float]:
    """Return the room beside and over a section that its dimensions have, mm."""
    beside = design.skin.width * ROOM_BESIDE / SECTION_WIDTH
    over = design.skin.width * ROOM_OVER / SECTION_WIDTH
    return max(1.0, beside), max(1.0, over)


def section_dimensions(design: Design) -> tuple[list[Dimension], float]:
    """Return the section's dimensions, within its margin, and their paper's scale: width and thickness,
    height to the crest, pitch, and a ridge's height, root and tip before fillets."""
    skin, scale, top = design.skin, SECTION_WIDTH / design.skin.width, drawn_section(design).top
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


def write_section_dxf(design: Design, path: Path) -> None:
    """Write the skin's own section with true arcs (polyline bulges) as DXF, mm: layers OUTLINE and SLOTS,
    DIMENSIONS, and TEXT, which says that a mold is not cut by it."""
    shape = drawn_section(design)
    rows = [("OUTLINE", shape.outline), *(("SLOTS", s.loop()) for s in shape.slots)]
    dimensions, scale = section_dimensions(design)
    notes = section_notes(design)
    write_dxf(
        path, [*dimensions, *_note_words(notes, (-SECTION_WIDTH / 2, NOTES_Z), SIZE)], scale, rows, notes
    )


def _note_words(notes: list[str], at: tuple[float, float], height: float) -> list[Words]:
    """Notes below each other from the place of the first one on, mm of paper."""
    return [Words(text, (at[0], at[1] - 2 * height * i), height, "TEXT") for i, text in enumerate(notes)]


def write_strips_dxf(job: Job, path: Path) -> None:
    """Write the cutting pattern of the film strips as DXF, mm: CUT (outlines and holes), FRONT and BACK
    (metal of either face), ENGRAVE (ridge and side, + sign), MARK (where a strip is cut off later); TEXT and
    DIMENSIONS, to be switched off."""
    strips = strip_patterns(job)
    rows = [row for strip in strips for row in _strip_rows(strip)]
    dimensions, scale = strip_dimensions(strips)

    def on_paper(point: Point) -> tuple[float, float]:
        return scale * point.x, scale * point.z

    marks: list[Mark] = [line(on_paper(a), on_paper(b), "MARK") for strip in strips for a, b in strip.cut_off]
    notes = pattern_notes(job)
    for text, x, z in _strip_texts(job, strips):
        marks.append(Words(text, on_paper(Point(x, z)), scale, "TEXT" if text in notes else "ENGRAVE"))
    write_dxf(path, [*marks, *dimensions], scale, rows, notes)


def _strip_rows(strip: StripPattern) -> list[tuple[str, Loop]]:
    cuts = [("CUT", outline) for outline in (strip.cut, *strip.holes)]
    return [*cuts, ("FRONT", strip.front), ("BACK", strip.back)]


def _strip_texts(job: Job, strips: list[StripPattern]) -> list[tuple[str, float, float]]:
    """What is written on the pattern: text, x and z of its left foot, mm."""
    texts = [(strip.label, *strip.label_at) for strip in strips]
    texts += [("+", *strip.plus_at) for strip in strips]
    left = min(s.start.x for strip in strips for s in strip.cut)
    return [*texts, *((text, left, -2.0 - 2 * i) for i, text in enumerate(pattern_notes(job)))]


def write_shims_dxf(job: Job, path: Path) -> None:
    """Write the cutting pattern of one skin's shims as DXF, mm: CUT, ENGRAVE (ridge and slot, beside each),
    MARK (where a tail is thinned, at +x) and TEXT."""
    shims, notes = shim_patterns(job), shim_notes(job)
    marks: list[Mark] = [Words(shim.label, shim.label_at, 1.0, "ENGRAVE") for shim in shims]
    marks += [line(*shim.thinned, "MARK") for shim in shims if shim.thinned]
    low = min(s.start.z for shim in shims for s in shim.cut)
    marks += _note_words(notes, (min(shim.label_at.x for shim in shims), low - 3.0), 1.0)
    write_dxf(path, marks, loops=[("CUT", shim.cut) for shim in shims], notes=notes)


def write_seal_dxf(closed: ClosedMold, path: Path) -> None:
    """Write the cutting pattern of the foam under the cover as DXF, mm, seen from above, end b up: CUT
    (outline and holes), TEXT and DIMENSIONS."""
    pattern = seal_pattern(closed)
    dimensions, scale = seal_dimensions(pattern)
    (left, low), _ = pattern.box
    notes = pattern.notes
    note_words = _note_words(notes, (scale * left, scale * low - SEAL_NOTES_GAP), SIZE)
    write_dxf(path, [*dimensions, *note_words], scale, [("CUT", loop) for loop in pattern.loops], notes)


def write_strips_svg(job: Job, path: Path) -> None:
    """Write the same cutting pattern as SVG, mm: classes cut, front, back and mark; where both faces
    have metal, both colours lie over each other."""
    strips = strip_patterns(job)
    texts = _strip_texts(job, strips)
    corners = [s.start for strip in strips for s in strip.cut]
    left, foot = min(x for _, x, _ in texts) - MARGIN_BESIDE, min(z for _, _, z in texts) - 1
    right, top = max(p.x for p in corners) + 8, max(p.z for p in corners) + MARGIN_ABOVE
    right = max(right, left + 0.6 * max(len(text) for text, _, _ in texts))
    outlines = [(layer.lower(), loop) for strip in strips for layer, loop in _strip_rows(strip)]
    shapes = [f'  <path class="{name}" d="{_svg_path(outline)}"/>' for name, outline in outlines]
    shapes += [
        f'  <path class="mark" d="M{a.x:.9g} {-a.z:.9g} L{b.x:.9g} {-b.z:.9g}"/>'
        for strip in strips
        for a, b in strip.cut_off
    ]
    shapes += [f'  <text x="{x:.9g}" y="{-z:.9g}">{text}</text>' for text, x, z in texts]
    shapes.append(_dimensions(*strip_dimensions(strips)))
    style = (
        "path{fill:none;stroke:#333;stroke-width:.03}"
        ".front{fill:#d08020;fill-opacity:.5}.back{fill:#2080c0;fill-opacity:.5}"
        ".mark{stroke:#c00}text{font:1px sans-serif}"
    )
    path.write_text(_svg((left, -top, right - left, top - foot), style, shapes), encoding="utf-8")


def write_section_svg(design: Design, path: Path) -> None:
    """Write the section with true arcs as SVG, mm, z up."""
    path.write_text(_section_svg(design), encoding="utf-8")


def section_html(design: Design) -> str:
    """Return what a notebook shows of a design: its name, its sizes, and its section."""
    skin = skin_of(design)
    size = f"{design.skin.across} x {summit(design):.4g} mm"
    words = f"{design.name}: {skin.counted} on {size}, of {silicone(design).name}"
    data = base64.b64encode(_section_svg(design).encode()).decode()
    picture = f'<img style="width:100%;max-width:760px" src="data:image/svg+xml;base64,{data}">'
    return f"<p><b>{escape(words)}</b></p>{picture}"


def _section_svg(design: Design) -> str:
    shape = drawn_section(design)
    half, top, (margin, over) = design.skin.width / 2, shape.top, section_margin(design)
    box = (-half - margin, -top - over, 2 * (half + margin), top + over + margin)
    curves = [
        f'  <path class="{name}" d="{_svg_path(outline)}"/>'
        for name, outline in [("outline", shape.outline), *(("slot", s.loop()) for s in shape.slots)]
    ]
    style = "path{stroke:#333;stroke-width:.02}.outline{fill:#eebfa6}.slot{fill:#fff}"
    return _svg(box, style, [*curves, _dimensions(*section_dimensions(design))])


def _dimensions(marks: list[Dimension], scale: float) -> str:
    """Dimensions as a group of an SVG of the part's own millimetres, z up."""
    rows = "\n".join(svg_row(mark, 0.0) for mark in primitives(marks))
    return (
        f'  <g class="dimensions" transform="scale({1 / scale:g})" {svg_style("DIMENSIONS")}>\n{rows}\n  </g>'
    )


def _svg(box: tuple[float, float, float, float], style: str, shapes: list[str]) -> str:
    """`box`: left, top (downward), width and height, mm."""
    body = "\n".join(shapes)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{box[2]:.6g}mm" height="{box[3]:.6g}mm" '
        f'viewBox="{box[0]:.6g} {box[1]:.6g} {box[2]:.6g} {box[3]:.6g}">\n'
        f"  <style>{style}</style>\n{body}\n</svg>\n"
    )


def _svg_path(outline: Loop) -> str:
    start = outline[0].start
    steps = [f"M{start.x:.9g} {-start.z:.9g}"]
    for segment in outline:
        end = f"{segment.end.x:.9g} {-segment.end.z:.9g}"
        if segment.bulge == 0.0 or not math.isfinite(segment.radius):
            steps.append(f"L{end}")
        else:
            large_arc, clockwise = int(abs(segment.sweep) > math.pi), int(segment.bulge < 0)
            steps.append(f"A{segment.radius:.9g} {segment.radius:.9g} 0 {large_arc} {clockwise} {end}")
    return " ".join([*steps, "Z"])


def write_strip_board(job: Job, path: Path) -> None:
    """Write the footprint of one skin's contacts as .kicad_mod, mm, y down: pads are named by ridge, slot and
    face, as "3S1+" is the front of ridge 3's S1."""
    path.write_text(strip_board(job), encoding="utf-8")


def strip_board(job: Job) -> str:
    """Return the footprint's text. Raises ValueError without film."""
    design = job.design
    fan, film = fan_out(job), design.film
    if fan is None or film is None:
        raise ValueError("a design without film has no contacts")
    strips = fan.strips if film.wiring_side == "b" else fan.strips[::-1]  # seen from the skin
    middle, row = (len(strips) - 1) / 2, PITCH / 2
    places = [(f"{s.feature}{s.side}", PITCH * (i - middle)) for i, s in enumerate(strips)]
    side, high = PITCH * middle + FOOTPRINT_ROOM, row + FOOTPRINT_ROOM
    description = (
        f"Strips of {design.name}, revision {design.revision}: seen from the skin, pins towards it, + above"
    )
    rows = [
        f'(footprint "{FOOTPRINT}" (version {FOOTPRINT_FORMAT}) (generator skincad)',
        '  (layer "F.Cu")',
        f'  (descr "{description}")',
        "  (attr through_hole)",
        _footprint_text("reference", "J**", (0.0, -high - 4.5), "F.SilkS"),
        _footprint_text("value", FOOTPRINT, (0.0, high + 1.5), "F.Fab"),
        _footprint_text("user", "+", (-side - 1.0, -row), "F.SilkS"),
        _footprint_text("user", "-", (-side - 1.0, row), "F.SilkS"),
        f'  (fp_rect (start {-side:.4f} {-high:.4f}) (end {side:.4f} {high:.4f}) (layer "F.CrtYd")'
        " (width 0.05) (fill none))",
    ]
    for label, x in places:
        rows.append(_footprint_text("user", label, (x, -high - 1.5), "F.SilkS", 90))
        rows += [
            f'  (pad "{label}{sign}" thru_hole circle (at {x:.4f} {y:.4f}) (size {PIN:g} {PIN:g}) '
            f'(drill {DRILL:g}) (layers "*.Cu" "*.Mask"))'
            for sign, y in (("+", -row), ("-", row))
        ]
    return "\n".join([*rows, ")"]) + "\n"


def _footprint_text(kind: str, text: str, at: tuple[float, float], layer: str, turn: int = 0) -> str:
    size = f"(effects (font (size {FOOTPRINT_TEXT:g} {FOOTPRINT_TEXT:g}) (thickness 0.12)))"
    turned = f" {turn}" if turn else ""
    return f'  (fp_text {kind} "{text}" (at {at[0]:.4f} {at[1]:.4f}{turned}) (layer "{layer}") {size})'
