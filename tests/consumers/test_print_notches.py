"""A comb's notches in a resin slicer's pictures let their shims in, wherever the rule says so."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from skincad.base import Array, Mask
from skincad.fabrication import Job, design_findings, laid, mesh, print_chord
from skincad.inputs import Design, processes
from skincad.outputs import write_stl
from skincad.shape import polygon
from skincad.solids import PartRole
from skincad.solids.mold import mold
from tests.consumers import prusaslicer
from tests.consumers.print_levels import resin_layers
from tests.templates import of_one_printer

pytestmark = [pytest.mark.skipif(bool(prusaslicer.missing()), reason=prusaslicer.missing()), pytest.mark.slow]
FINE = 0.004  # mm, of the points that a shim's section is looked at; a pixel is ten times that


def section_points(corners: Array) -> Array:
    """Points `(n, 2)` all over a shim's section, mm, its corners `(4, 2)` in order."""
    a, b, c = corners[0], corners[1], corners[3]
    along, rows = (max(2, round(np.linalg.norm(v - a) / FINE)) for v in (b, c))
    u, v = np.meshgrid(np.linspace(0.0, 1.0, along), np.linspace(0.0, 1.0, rows))
    return np.asarray(a + u.reshape(-1, 1) * (b - a) + v.reshape(-1, 1) * (c - a))


def goes_in(lit: Mask, points: Array, pixel: float, play: float) -> bool:
    """Whether the section is free of lit pixels somewhere: moved along x by at most `play` mm, and by a pixel
    up or down, as the notch's bottom comes out."""
    middle = np.array(lit.shape)[::-1] / 2
    for up in np.linspace(-pixel, pixel, 9):
        for shift in np.arange(-play, play + FINE / 2, FINE):
            at = np.floor((points + np.array([shift, up])) / pixel + middle).astype(int)
            if not lit[at[:, 1], at[:, 0]].any():
                return True
    return False


def shims_that_go_in(design: Design, folder: Path) -> tuple[int, int]:
    """How many of the shims, and of how many, by the middle layer of end a's comb, laid on its face."""
    process, closed = processes(design.printer)[design.mold.process], mold(design)
    comb = next(part for part in closed.of(PartRole.COMB) if part.end == "a")
    shape = mesh(comb, print_chord(design))
    write_stl(laid(shape, True, comb), folder / "comb.stl")
    layers = list(resin_layers(folder / "comb.stl", process.layer, process.pixel, folder))
    lit = layers[len(layers) // 2]
    low, high = shape.bounds
    centre = np.array([low[0] + high[0], low[2] + high[2]]) / 2
    shims = [
        section_points(polygon(shim.body.outline, FINE)[:4] - centre) for shim in closed.of(PartRole.SHIM)
    ]
    passing = []
    for picture in (lit, lit[::-1]):  # a picture's rows may run up or down: one way there are no notches
        play = design.mold.slit_clearance + process.pixel
        passing.append(sum(goes_in(picture, points, process.pixel, play) for points in shims))
    return max(passing), len(shims)


@pytest.mark.parametrize(
    ("changes", "all_go_in"),
    [
        ([], True),
        (["printer.sla.pixel=0.04725"], True),
        (["printer.sla.pixel=0.035"], True),
        (["mold.slit_clearance=0.01"], False),
        (["mold.slit_clearance=0.01", "printer.sla.pixel=0.04725"], False),
    ],
)
def test_where_no_finding_says_otherwise_every_shim_goes_in(
    changes: list[str], all_go_in: bool, tmp_path: Path
) -> None:
    design = of_one_printer("lab-bench", changes)
    warned = any(finding.rule == "notch" for finding in design_findings(Job(design)))
    count, of = shims_that_go_in(design, tmp_path)
    assert of == 18
    assert (count == of) == all_go_in
    assert warned != all_go_in
