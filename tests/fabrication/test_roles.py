"""What a part or a bore is, its role says: no name, radius or place is asked."""

import json
from collections.abc import Iterator
from dataclasses import replace

import pytest

import skincad
from skincad.fabrication import (
    Job,
    casting_sheet,
    design_findings,
    filling_findings,
    interference,
    laid_on_end,
    poured_volume,
)
from skincad.inputs import Design
from skincad.outputs import explosion_offset
from skincad.outputs.drawing.overview import drawing
from skincad.solids import TAP_RADIUS, ClosedMold, CutRole, bores
from skincad.solids.mold import mold
from tests.bent_skin import three_ridges

OTHER = "x-"
PRINTED = ['mold.process="fdm"', 'mold.lid_process="fdm"', "mold.clearance=0.2"]


def renamed(closed: ClosedMold) -> ClosedMold:
    """The mold with every part called something else."""
    steps = tuple(step._replace(parts=tuple(OTHER + name for name in step.parts)) for step in closed.opening)
    return ClosedMold(tuple(replace(part, name=OTHER + part.name) for part in closed.parts), steps)


def mold_texts(design: Design, closed: ClosedMold) -> Iterator[str]:
    """Everything that is said of a mold, as text."""
    findings = [*design_findings(Job(design, closed)), *filling_findings(Job(design, closed))]
    yield from (json.dumps(finding.as_json()) for finding in findings)
    yield f"{poured_volume(Job(design, closed))} {closed.length}"
    yield casting_sheet(Job(design, closed), findings, "Passes.", True)
    yield drawing(design, closed)
    for part in closed.parts:
        offset = explosion_offset(part, closed)
        yield f"{part.name} {part.made} {part.colour} {laid_on_end(Job(design), part)} {offset}"


@pytest.mark.parametrize(
    ("name", "settings"),
    [
        ("lab-bench", ["ridge.count=3"]),
        ("cast-in", ["ridge.count=3", 'mold.pour="open"']),
        ("plain-ridges", PRINTED),
        ("yamada-2002", ["ridge.count=3", "mold.cavities=2", *PRINTED]),
        ("steep-fingertip", []),
    ],
)
def test_a_mold_whose_parts_have_other_names_is_judged_and_told_alike(name: str, settings: list[str]) -> None:
    design = skincad.load(name, settings)
    closed = mold(design)
    other = "\n".join(mold_texts(design, renamed(closed)))
    assert other != "\n".join(mold_texts(design, closed))  # the names are there
    assert other.replace(OTHER, "") == "\n".join(mold_texts(design, closed))


def test_a_doubly_curved_mold_too() -> None:
    design = three_ridges()
    closed = mold(design)
    assert "\n".join(mold_texts(design, renamed(closed))).replace(OTHER, "") == "\n".join(
        mold_texts(design, closed)
    )


def test_what_is_free_to_bend_is_known_by_its_role() -> None:
    """A skin that its cavity holds by its ridges is pulled out of it, which its undercut is judged for."""
    closed = renamed(mold(skincad.load("steep-fingertip", ['mold.split="none"'])))
    assert interference(closed, 2e-3) == []


def test_a_pin_hole_as_wide_as_a_thread_is_no_thread() -> None:
    loose = skincad.load("plain-ridges", ["mold.clearance=0.25", 'mold.process="fdm"'])
    closed = mold(loose)
    assert {bore.radius for bore in bores(closed.part("end-b"), CutRole.END_PIN)} == {TAP_RADIUS}
    text = casting_sheet(Job(loose, closed), [], "Passes.", True)
    assert (
        "M3 bolts, ISO 4762: 4 M3 x 25 through both end plates, with nuts, 4 of them sunk in end plate b"
        in text
    )


def test_a_cut_without_a_role_is_none_of_a_mold() -> None:
    for closed in (mold(skincad.load("steep-fingertip")), mold(three_ridges())):
        assert {cut.role for part in closed.parts for cut in part.cuts} <= set(CutRole)
