"""A flat skin: the base alone, which touches with its whole face."""

from __future__ import annotations

from skincad.inputs.design import Design
from skincad.shape.curves import Point
from skincad.shape.feature import Feature, Frame, Placed


def place(design: Design) -> tuple[Placed, ...]:
    """Return the face as the one feature of the skin, of no height, as wide as the skin."""
    width = design.skin.width
    face = Feature(
        family="flat",
        outline=(),
        height=0.0,
        root_width=width,
        tip_width=width,
        crown=0.0,
        root_fillet=0.0,
        tip_fillet=0.0,
    )
    top = Frame(Point(0.0, design.skin.thickness), Point(1.0, 0.0), Point(0.0, 1.0))
    return (Placed(face, top, 1, 0.0, (), design.skin.area / width),)


def without_fillets(design: Design) -> Design:
    """Return the design, which has none."""
    return design
