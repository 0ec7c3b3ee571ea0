"""What tests of fabrication share."""

from __future__ import annotations

from skincad.inputs import Design


def by(design: Design, process: str) -> Design:
    """The design with cavity and end plates by one process."""
    return design.with_(mold={"process": process, "end_plate_process": None})
