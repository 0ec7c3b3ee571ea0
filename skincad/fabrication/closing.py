"""Rules of the closed mold as a stack: its cover's bow between the screws, and what its seal takes up."""

from __future__ import annotations

from collections.abc import Iterator

from skincad.fabrication.finding import Finding
from skincad.inputs.design import Design
from skincad.shape.cross_section import section
from skincad.solids.closing import BOW, PLAY, SHEETS, bow, thick_enough
from skincad.solids.layout import STOCK, layout, lid_process, stack
from skincad.solids.shrinkage import poured


def closing_findings(design: Design) -> Iterator[Finding]:
    """Yield a warning where a cover of a given thickness bows by more than `BOW` mm under 10 kPa, and one
    where carrier and keepers may stand so high or low that no seal both lets the cover lie on the cavity's
    walls and holds them down."""
    cast = poured(design)
    place, _ = layout(cast, section(cast))
    modulus = lid_process(design).part_modulus
    measured = bow(place.spans, place.lid, modulus)
    if measured > BOW * (1 + 1e-9):
        remedy = (
            f"mold.cover of {thick_enough(place.spans, modulus, STOCK):g} mm, or a stiffer mold.lid_process"
        )
        yield Finding("cover bow", "cover, under 10 kPa", measured, BOW, "mm", "warning", remedy)
    off, most = stack(cast, place.spans, place.lid), PLAY * SHEETS[-1]
    if place.top > place.back and off > most:
        where, remedy = "carrier and keepers, under the seal", "finer processes, or a thicker mold.cover"
        yield Finding("closing stack", where, off, most, "mm", "warning", remedy)
