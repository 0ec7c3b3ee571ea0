"""A drawing sheet as PDF of its size: lines by layer, words as text that can be searched and copied.

A sheet takes 2 ms this way: it is lines, filled triangles and words in Helvetica, one of the fonts that every
reader of PDF has (ISO 32000-1, 9.6.2.2). matplotlib took 0.1 s a sheet, and `make` writes one for each part.
No time is written, so the same sheet has the same bytes.
"""

from __future__ import annotations

import math
import zlib
from collections.abc import Iterator
from pathlib import Path

from skincad.pictures.layers import LAYERS, LINES
from skincad.pictures.marks import CAP, Fill, Ink, Sheet, Words, width
from skincad.pictures.sheet_svg import primitives
from skincad.solids.projection import Arc, Place, Stroke

POINT = 72 / 25.4  # points in a millimetre


def write_sheet_pdf(sheet: Sheet, path: Path) -> None:
    """Write a sheet as PDF."""
    wide, tall = (f"{POINT * size:.3f}" for size in sheet.size)
    content = zlib.compress("\n".join(_content(sheet)).encode("cp1252", "replace"), 9)
    objects = [
        b"<< /Type /Catalog /Pages 2 0 R >>",
        b"<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
        f"<< /Type /Page /Parent 2 0 R /MediaBox [0 0 {wide} {tall}] /Contents 4 0 R "
        "/Resources << /Font << /F 5 0 R >> >> >>".encode(),
        b"<< /Length %d /Filter /FlateDecode >>\nstream\n%b\nendstream" % (len(content), content),
        b"<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica /Encoding /WinAnsiEncoding >>",
        b"<< /Title %b /Creator (skincad) >>" % _string(sheet.title).encode("cp1252", "replace"),
    ]
    path.write_bytes(_file(objects))


def _file(objects: list[bytes]) -> bytes:
    """The objects, numbered from 1, the table of where they begin, and the trailer."""
    written, places = b"%PDF-1.4\n%\xe2\xe3\xcf\xd3\n", []
    for number, body in enumerate(objects, 1):
        places.append(len(written))
        written += b"%d 0 obj\n%b\nendobj\n" % (number, body)
    table = b"".join(b"%010d 00000 n \n" % place for place in places)
    count = len(objects) + 1
    return (
        written
        + b"xref\n0 %d\n0000000000 65535 f \n%b" % (count, table)
        + b"trailer\n<< /Size %d /Root 1 0 R /Info %d 0 R >>\n" % (count, len(objects))
        + b"startxref\n%d\n%%%%EOF\n" % len(written)
    )


def _content(sheet: Sheet) -> Iterator[str]:
    """The page's operators; lengths are scaled to millimetres at once."""
    yield f"{POINT:.6f} 0 0 {POINT:.6f} 0 0 cm 1 J 1 j"
    marks = list(primitives(sheet.marks))
    for name, layer in LAYERS.items():
        layer_marks = [mark for mark in marks if mark.layer == name]
        if not layer_marks:
            continue
        red, green, blue = (int(layer.ink[i : i + 2], 16) / 255 for i in (1, 3, 5))
        dashes = " ".join(f"{abs(length):g}" for length in LINES[layer.line])
        yield f"{red:.3f} {green:.3f} {blue:.3f} RG {red:.3f} {green:.3f} {blue:.3f} rg"
        yield f"{layer.width:g} w [{dashes}] 0 d"
        for mark in layer_marks:
            if isinstance(mark, Ink):
                yield f"{_path(mark.stroke)} S"
            elif isinstance(mark, Fill):
                yield f"{_lines(mark.points)} f"
            else:
                yield _text(mark)


def _lines(points: tuple[Place, ...]) -> str:
    steps = [f"{x:.4f} {y:.4f} {'l' if i else 'm'}" for i, (x, y) in enumerate(points)]
    return " ".join(steps)


def _path(stroke: Stroke) -> str:
    """A stroke; an arc as Bezier curves of a quarter circle at most, within 0.03 % of its radius."""
    if not isinstance(stroke, Arc):
        return _lines(stroke.points)
    count = max(1, math.ceil(stroke.sweep / (math.pi / 2) - 1e-9))
    step = stroke.sweep / count
    handle = 4 / 3 * math.tan(step / 4) * stroke.radius
    x, y = stroke.at(0.0)
    steps = [f"{x:.4f} {y:.4f} m"]
    for i in range(count):
        (a, b), (c, d) = stroke.at(i / count), stroke.at((i + 1) / count)
        start, end = stroke.start + i * step, stroke.start + (i + 1) * step
        p, q = a - handle * math.sin(start), b + handle * math.cos(start)
        r, s = c + handle * math.sin(end), d - handle * math.cos(end)
        steps.append(f"{p:.4f} {q:.4f} {r:.4f} {s:.4f} {c:.4f} {d:.4f} c")
    return " ".join(steps)


def _text(words: Words) -> str:
    back = {"start": 0.0, "middle": 0.5, "end": 1.0}[words.anchor] * width(words.text, words.height)
    way = math.radians(words.turn)
    c, s = math.cos(way), math.sin(way)
    x, y = words.at[0] - back * c, words.at[1] - back * s
    turned = f"{c:.5f} {s:.5f} {-s:.5f} {c:.5f} {x:.4f} {y:.4f} Tm"
    return f"BT /F {words.height / CAP:.4f} Tf {turned} {_string(words.text)} Tj ET"


def _string(text: str) -> str:
    escaped = text.replace("\\", r"\\").replace("(", r"\(").replace(")", r"\)")
    return f"({escaped})"
