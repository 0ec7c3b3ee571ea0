"""Crests of a printed mold by its layers; slicers' own layers are read in consumers/test_print_levels.py."""

from __future__ import annotations

import numpy as np
import pytest

import skincad
from skincad.fabrication import Job, design_findings, printed_crests, snapped_to_layers, uncertain_ridges
from skincad.fabrication.inspection import inspection
from skincad.inputs import Design, processes
from skincad.shape import skin_of
from skincad.solids.mold import mold
from skincad.solids.shrinkage import shrinkage


def heights(design: Design) -> tuple[float, ...]:
    crests = printed_crests(Job(design))
    assert crests is not None
    return crests


def test_without_layers_crests_come_out_as_designed(yamada: Design) -> None:
    assert heights(yamada) == skin_of(yamada).crests


@pytest.mark.parametrize("name", ["lab-bench", "plain-ridges", "nozzle-04"])
def test_heights_are_whole_layers_of_the_mold(name: str) -> None:
    design = skincad.load(name)
    layer = {"nozzle-04": 0.2}.get(name, 0.05)
    layers = np.array(heights(design)) / (1 - shrinkage(design)) / layer
    assert layers == pytest.approx(np.round(layers), abs=1e-9)
    # ledge and groove are each rounded by half a layer at most
    assert np.abs(np.array(heights(design)) - skin_of(design).crests).max() <= layer


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
    assert printed_crests(Job(design)) is None


@pytest.mark.parametrize(("floor", "found"), [(9.0, (2, 8)), (9.012, (4, 6)), (9.03, ())])
def test_a_groove_that_ends_at_a_layers_middle_is_told(floor: float, found: tuple[int, ...]) -> None:
    """A floor of 9 mm has a middle 2.4 um beside the bottoms of ridges 2 and 8, 9.012 at those of 4 and 6."""
    design = skincad.load("plain-ridges", [f"mold.floor={floor}"])
    closed = mold(design)
    assert uncertain_ridges(Job(design, closed)) == found
    notes = [f for f in design_findings(Job(design, closed)) if f.rule == "crest layer"]
    assert [f.severity for f in notes] == ["note"] * bool(found)
    text = " ".join(inspection(Job(design, closed)).said)
    assert ("may come out a layer" in text) == bool(found)


def test_within_a_pixel_a_ridge_that_leans_is_higher_or_lower() -> None:
    """Of 0.05 mm by tan 0.05, 2.5 um, which 2 um of rounding alone leave out at ridges 2 and 8."""
    design = skincad.load("plain-ridges", ["mold.floor=9.0"])
    fine = design.with_(printer={"sla": {"pixel": 0.001}})
    assert uncertain_ridges(Job(design)) == (2, 8)
    assert uncertain_ridges(Job(fine)) == ()


def test_a_ledge_at_a_layers_middle_leaves_all_crests_open() -> None:
    design = skincad.load("plain-ridges", ["mold.floor=9.0"])
    ledge = -min(s.start.z for s in mold(design).part("cavity").body.outline)
    floor = 9.0 + 0.05 * (np.ceil(ledge / 0.05 - 0.5) + 0.5) - ledge
    moved = skincad.load("plain-ridges", [f"mold.floor={floor:.6f}"])
    assert uncertain_ridges(Job(moved)) == tuple(range(1, 10))


@pytest.mark.parametrize("name", ["lab-bench", "plain-ridges", "nozzle-04"])
def test_heights_and_a_floor_put_each_crest_at_a_layers_end(name: str) -> None:
    design = skincad.load(name)
    heights_and_floor = snapped_to_layers(Job(design))
    assert heights_and_floor is not None
    tall, floor = heights_and_floor
    layer = processes(design.printer)[design.mold.process].layer
    snapped = skincad.load(name, [f"ridge.heights={list(tall)}", f"mold.floor={floor}"])
    closed = mold(snapped)
    # mm: heights are told to 0.1 um, along axes that lean
    assert heights(snapped) == pytest.approx(skin_of(snapped).crests, abs=2e-4)
    assert np.abs(np.array(skin_of(snapped).crests) - skin_of(design).crests).max() <= 0.501 * layer
    assert uncertain_ridges(Job(snapped, closed)) == ()
    assert snapped_to_layers(Job(snapped, closed)) is None
    assert f"`mold.floor = {floor:g}`" in " ".join(inspection(Job(design)).said)


def test_each_skin_of_a_gang_comes_out_as_one_alone() -> None:
    design = skincad.load("plain-ridges")
    assert heights(design.with_(mold={"cavities": 2})) == pytest.approx(heights(design), abs=1e-9)


def test_layers_higher_than_the_block_are_not_looked_for_for_ever() -> None:
    """The first middle of a layer over the grooves, 22.5 mm, is over the block, so the search had no end."""
    coarse = ["mold.process=sla", "printer.sla.layer=9.0", "skin.thickness=1.0", "mold.floor=13.55"]
    design = skincad.load("plain-ridges", coarse)
    assert printed_crests(Job(design)) is None
