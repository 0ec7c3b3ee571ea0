"""Crests of a printed mold by its layers; slicers' own layers are read in consumers/test_print_levels.py."""

from __future__ import annotations

import numpy as np
import pytest

import skincad
from skincad.fabrication.printed_heights import come_out
from skincad.inputs.design import Design
from skincad.shape.crests import summits
from skincad.solids.mold import mold
from skincad.solids.shrinkage import shrinkage


def heights(design: Design) -> tuple[float, ...]:
    found = come_out(design, mold(design))
    assert found is not None
    return found


def test_without_layers_crests_come_out_as_designed(yamada: Design) -> None:
    assert heights(yamada) == summits(yamada)


@pytest.mark.parametrize("name", ["lab-bench", "plain-ridges", "nozzle-04"])
def test_heights_are_whole_layers_of_the_mold(name: str) -> None:
    design = skincad.load(name)
    layer = {"nozzle-04": 0.2}.get(name, 0.05)
    layers = np.array(heights(design)) / (1 - shrinkage(design)) / layer
    assert layers == pytest.approx(np.round(layers), abs=1e-9)
    # ledge and groove are each rounded by half a layer at most
    assert np.abs(np.array(heights(design)) - summits(design)).max() <= layer


def test_a_groove_that_is_narrower_at_a_middle_than_slicers_close_ends_a_layer_higher() -> None:
    """With a floor of 9.014 a middle lies just over the bottoms of ridges 4 and 6, where the mesh is open,
    by less than 0.098 mm; consumers/test_print_levels.py slices it. With 9.012 it is wider."""
    wide, narrow = (skincad.load("plain-ridges", [f"mold.floor={floor}"]) for floor in (9.012, 9.014))
    off = np.array(heights(narrow)) - heights(wide)
    # a layer of the mold, less the shrinkage of 0.1 %
    assert off == pytest.approx([0, 0, 0, -0.05, 0, -0.05, 0, 0, 0], abs=1e-4)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("plain-ridges", {"printer": {"sla": {"orientation": "end"}}}),
        ("plain-ridges", {"skin": {"curvature_radius_y": 60.0}}),
        ("steep-fingertip", {"mold": {"split": "auto", "process": "sla"}}),
    ],
)
def test_steps_that_fall_anywhere_are_not_told(name: str, changes: dict[str, dict[str, object]]) -> None:
    design = skincad.load(name).with_(**changes)
    assert come_out(design, mold(design)) is None


def test_each_skin_of_a_gang_comes_out_as_one_alone() -> None:
    design = skincad.load("plain-ridges")
    assert heights(design.with_(mold={"cavities": 2})) == pytest.approx(heights(design), abs=1e-9)


def test_layers_higher_than_the_block_are_not_looked_for_for_ever() -> None:
    """The first middle of a layer over the grooves, 22.5 mm, is over the block, so the search had no end."""
    coarse = ["mold.process=sla", "printer.sla.layer=9.0", "skin.thickness=1.0", "mold.floor=13.55"]
    design = skincad.load("plain-ridges", coarse)
    assert come_out(design, mold(design)) is None
