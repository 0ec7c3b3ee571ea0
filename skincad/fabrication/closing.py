"""Rules of the closed mold as a stack: its cover's bow between the screws, and what its seal takes up."""

from __future__ import annotations

from collections.abc import Iterator

from skincad.fabrication.fasteners import end_screws
from skincad.fabrication.finding import Finding
from skincad.inputs.design import Design
from skincad.shape.skin import section
from skincad.solids.fasteners import WASHER, run_out_room
from skincad.solids.layout import (
    MOST_BOW,
    SEAL_PLAY,
    SHEETS,
    STOCK,
    bow,
    cavity_process,
    layout,
    lid_process,
    stack_error,
    thick_enough,
)
from skincad.solids.mold import ClosedMold, mold
from skincad.solids.plan import CutRole, PartRole, bores
from skincad.solids.shrinkage import scaled_for_shrinkage


def closing_findings(design: Design, closed: ClosedMold | None = None) -> Iterator[Finding]:
    """Yield the warnings `cover bow` and `closing stack`, and the note `thread run-out`.

    A cover of a given thickness bows by more than `MOST_BOW` mm under 10 kPa. Carrier and keepers may stand
    so high or low that no seal both lets the cover lie on the cavity's walls and holds them down. A doubly
    curved mold may have too narrow a top for a seal, or too little thread. `closed` saves its planning.
    """
    cast = scaled_for_shrinkage(design)
    place, _ = layout(cast, section(cast))
    modulus = lid_process(design).part_modulus
    measured = bow(place.spans, place.lid, modulus)
    if measured > MOST_BOW * (1 + 1e-9):
        remedy = (
            f"mold.cover of {thick_enough(place.spans, modulus, STOCK):g} mm, or a stiffer mold.lid_process"
        )
        yield Finding("cover bow", "cover, under 10 kPa", measured, MOST_BOW, "mm", "warning", remedy)
    off, most, where = (
        stack_error(cast, place.spans, place.lid),
        SEAL_PLAY * SHEETS[-1],
        "carrier and keepers, under the ",
    )
    bent = design.skin.curvature_radius_y is not None
    closed = (closed or mold(design)) if bent else closed
    if closed and bent and not closed.of(PartRole.SEAL):
        remedy = "lap the carrier's top until the cover lies on the cavity, or make the skin longer, or its "
        remedy += "curvature_radius_y larger, so that the narrow top has room for a seal"
        yield Finding("closing stack", where + "cover, without a seal", off, 0.0, "mm", "warning", remedy)
    elif off > most:
        remedy = "finer processes, or a thicker mold.cover"
        yield Finding("closing stack", where + "seal", off, most, "mm", "warning", remedy)
    if closed and bent:
        yield from _run_outs(design, closed)


def _run_outs(design: Design, closed: ClosedMold) -> Iterator[Finding]:
    """A note where the holes of both ends meet before a tap's lead has room: no screw is short enough."""
    screws, process = end_screws(design, closed), cavity_process(design)
    deep = min(bore.length for bore in bores(closed.first(PartRole.CAVITY), CutRole.END_THREAD))
    left = deep + design.mold.end_plate + screws.washers * WASHER - screws.length
    if screws.bottoming and left < run_out_room(process) - 1e-9:
        remedy = "finish these threads by a bottoming tap, as the casting sheet says, or make the skin longer"
        where = "screws of the end plates, from tip to the hole's end"
        yield Finding("thread run-out", where, left, run_out_room(process), "mm", "note", remedy)
