"""A board's footprint for the contacts of a skin's strips, as KiCad reads it: a pin header of two rows.

Each strip is a column, its pads' crimps plug on the two pins: KiCad's format because a laboratory orders such
a board from a file, and KiCad, which others import, costs nothing. As seen from the skin: pins stick out
towards it, the front's row (+) is upper, ridges are below.
"""

from __future__ import annotations

from pathlib import Path

from skincad.fabrication.electrodes import PITCH
from skincad.fabrication.fan_out import fan_out
from skincad.inputs.design import Design

FORMAT = 20211014  # source: KiCad 6, file formats, footprint libraries; later ones read it
PIN, DRILL = 1.7, 1.0  # mm, source: KiCad's own pin headers of 2.54 mm, for pins 0.64 square
ROOM = 1.8  # mm, source: the same, of the courtyard beyond a pin's centre
TEXT = 0.8  # mm, assumption: the smallest letters that boards' makers print
NAME = "strip-board"


def write_strip_board(design: Design, path: Path) -> None:
    """Write the footprint of one skin's contacts as .kicad_mod, mm, y down: pads are named by ridge, slot and
    face, as "3S1+" is the front of ridge 3's S1."""
    path.write_text(strip_board(design), encoding="utf-8")


def strip_board(design: Design) -> str:
    """Return the footprint's text. Raises ValueError without film."""
    fan, film = fan_out(design), design.film
    if fan is None or film is None:
        raise ValueError("a design without film has no contacts")
    strips = fan.strips if film.wiring_side == "b" else fan.strips[::-1]  # seen from the skin
    middle, row = (len(strips) - 1) / 2, PITCH / 2
    places = [(f"{s.ridge}{s.side}", PITCH * (i - middle)) for i, s in enumerate(strips)]
    side, high = PITCH * middle + ROOM, row + ROOM
    description = (
        f"Strips of {design.name}, revision {design.revision}: seen from the skin, pins towards it, + above"
    )
    rows = [
        f'(footprint "{NAME}" (version {FORMAT}) (generator skincad)',
        '  (layer "F.Cu")',
        f'  (descr "{description}")',
        "  (attr through_hole)",
        _text("reference", "J**", (0.0, -high - 4.5), "F.SilkS"),
        _text("value", NAME, (0.0, high + 1.5), "F.Fab"),
        _text("user", "+", (-side - 1.0, -row), "F.SilkS"),
        _text("user", "-", (-side - 1.0, row), "F.SilkS"),
        f'  (fp_rect (start {-side:.4f} {-high:.4f}) (end {side:.4f} {high:.4f}) (layer "F.CrtYd")'
        " (width 0.05) (fill none))",
    ]
    for label, x in places:
        rows.append(_text("user", label, (x, -high - 1.5), "F.SilkS", 90))
        rows += [_pad(f"{label}{sign}", (x, y)) for sign, y in (("+", -row), ("-", row))]
    return "\n".join([*rows, ")"]) + "\n"


def _text(kind: str, text: str, at: tuple[float, float], layer: str, turn: int = 0) -> str:
    size = f"(effects (font (size {TEXT:g} {TEXT:g}) (thickness 0.12)))"
    turned = f" {turn}" if turn else ""
    return f'  (fp_text {kind} "{text}" (at {at[0]:.4f} {at[1]:.4f}{turned}) (layer "{layer}") {size})'


def _pad(name: str, at: tuple[float, float]) -> str:
    return (
        f'  (pad "{name}" thru_hole circle (at {at[0]:.4f} {at[1]:.4f}) (size {PIN:g} {PIN:g}) '
        f'(drill {DRILL:g}) (layers "*.Cu" "*.Mask"))'
    )
