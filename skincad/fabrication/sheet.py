"""The casting sheet: from made parts to a cast skin. Its words are templates/papers/casting-sheet.md."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from skincad.base.version import __version__
from skincad.fabrication import (
    day_plan,
    part_drawing,
    parts_list,
    printing,
)
from skincad.fabrication.estimates import ProcessEstimate
from skincad.fabrication.inspection import Inspection, inspection_lines
from skincad.fabrication.job import Job
from skincad.fabrication.papers import paper
from skincad.fabrication.rules import Finding, counted
from skincad.inputs.catalog import display_name
from skincad.solids import fasteners as threads
from skincad.solids.lids import core_hole, core_proud
from skincad.solids.mold import Move
from skincad.solids.plan import END_PLATES, PartRole

FIRST = "trial"  # the step that is numbered 0
OPENS = "cure"  # the step after which the mold is opened


class SheetStep(NamedTuple):
    """A step of the sheet: its name, its words, which parts leave the mold in it, "" for none, and, where the
    mold is opened, by which moves."""

    name: str
    words: str
    leaves: str
    moves: tuple[Move, ...] = ()


def casting_sheet(
    job: Job,
    findings: list[Finding],
    verdict: str,
    passed: bool,
    inspected: Inspection | None = None,
    estimates: tuple[ProcessEstimate, ...] = (),
) -> str:
    """Return the sheet as Markdown. `verdict` is the contact check's, `passed` that of the whole job,
    `inspected` what to measure on the skin, `estimates` what each process takes."""
    return _sheet(job, findings, verdict, passed, inspected, estimates)[0]


def sheet_steps(job: Job) -> dict[str, str]:
    """Return the words of each step by its name, in order."""
    return {step.name: step.words for step in _sheet(job)[1]}


def opening_steps(job: Job) -> list[SheetStep]:
    """Return the steps by which a cured skin comes out of its mold, in order; together they make each move of
    `closed.opening` once."""
    by: dict[str, list[Move]] = {}
    for move in job.closed.opening:
        role = job.closed.part(move.parts[0]).role
        known = {PartRole.SHIM: "shims", PartRole.COVER: "lid", **dict.fromkeys(END_PLATES, "ends")}
        by.setdefault(known.get(role, "skin"), []).append(move)
    steps = _sheet(job)[1]
    begin = [step.name for step in steps].index(OPENS) + 1
    return [step._replace(moves=tuple(by.get(step.leaves, []))) for step in steps[begin:]]


def _sheet(
    job: Job,
    findings: list[Finding] | None = None,
    verdict: str = "",
    passed: bool = True,
    inspected: Inspection | None = None,
    estimates: tuple[ProcessEstimate, ...] = (),
) -> tuple[str, list[SheetStep]]:
    """The sheet and its steps, which the text numbers as it comes to them."""
    steps: list[SheetStep] = []

    def step(name: str, leaves: str = "", *, caller: Callable[[], str]) -> str:
        words = " ".join(caller().split())
        steps.append(SheetStep(name, words, leaves))
        number = len(steps) - (steps[0].name == FIRST)
        return f"{number}. {words}\n"

    text = paper(
        "casting-sheet.md",
        **parts_list.facts(job),
        title=display_name(job.design),
        step=step,
        day=day_plan,
        drawing=part_drawing,
        torque=min(threads.torque(job.process(part)) for part in job.closed.made),
        proud=core_proud(job.place),
        core_hole=core_hole(job.design) if job.design.features.pocket else 0.0,
        printing=printing,
        passed=passed,
        counted=counted(findings or []),
        verdict=verdict,
        version=__version__,
        findings=findings or [],
        estimates=estimates,
        inspection=inspection_lines(inspected) if inspected else [],
    )
    return text, steps
