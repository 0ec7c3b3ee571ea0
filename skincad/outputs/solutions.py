"""Output of `solve`: the values that reach the target, or the nearest ones."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.outputs.delivery import picture, text
from skincad.outputs.designcopy import write_copy
from skincad.studies.query import short, worded
from skincad.studies.solving import Solution, SolutionPoint
from skincad.studies.subject import DesignVariable, owner

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "solve"
MAX_SHOWN = 5  # solutions, in words


def lines(solution: Solution) -> list[str]:
    """Return what `solve` prints."""
    count, model = len(solution.evaluations), solution.question.tier
    effort = f"{count} evaluation{'s' if count != 1 else ''}" + (f" by {model}" if model else "")
    refused = [evaluation.refused for evaluation in solution.evaluations if evaluation.refused]
    return [
        *(_solution_lines(solution) if solution.solutions else [_none(solution)]),
        f"  tried          {effort}, {solution.seconds:.3g} s",
        *([f"  refused        {len(refused)}; the first: {refused[0]}"] if refused else []),
        *(f"  note           {note}" for note in solution.notes),
    ]


def _solution_lines(solution: Solution) -> list[str]:
    first, *others = solution.solutions
    # with choices alone, a solution only has the target within its error
    gives = "may give" if all(knob.choices or knob.whole for knob in solution.knobs) else "gives"
    rows = [f"{solution.name}: {_values(solution, first)} {gives} {_targets(solution)}."]
    for candidate in (first, *others[: MAX_SHOWN - 1]):
        if candidate is not first:
            rows.append(f"  also           {_values(solution, candidate)}")
        rows += [f"  reached        {worded(key, value)}" for key, value in candidate.reached.items()]
        for key, (low, high) in candidate.interval.items():
            knob = next(knob for knob in solution.knobs if knob.key == key)
            ends = f"{short(low)} to {short(high)}{_unit(knob)}"
            rows.append(f"  may be         {key} anywhere from {ends}, since the result has that error")
        rows += [
            f"  nearest        {key} = {name}"
            for key, name in candidate.nearest.items()
            if key not in candidate.values
        ]
    if len(others) >= MAX_SHOWN:
        rows.append(f"  and            {len(others) + 1 - MAX_SHOWN} more")
    return rows


def _values(solution: Solution, solved: SolutionPoint) -> str:
    units = {knob.key: _unit(knob) for knob in solution.knobs}
    return ", ".join(f"{key} {short(value)}{units[key]}" for key, value in solved.values.items())


def _unit(knob: DesignVariable) -> str:
    return f" {knob.unit}" if knob.unit else ""


def _none(solution: Solution) -> str:
    ranges, count = ", ".join(_range(knob) for knob in solution.knobs), len(solution.evaluations)
    sentence = f"{solution.name}: no {ranges} gives {_targets(solution)}"
    if not solution.complete:
        many = f"{count} evaluation{'s' if count != 1 else ''}"
        sentence = f"{solution.name}: none found in {many} of {ranges} that gives {_targets(solution)}"
    if solution.closest is None:
        return f"{sentence}."
    reached = ", ".join(worded(key, value) for key, value in solution.closest.reached.items())
    return f"{sentence}. The nearest is {reached}, at {_values(solution, solution.closest)}."


def _targets(solution: Solution) -> str:
    return ", ".join(worded(key, wanted) for key, wanted in solution.target.items())


def _range(knob: DesignVariable) -> str:
    if knob.choices:
        many = len(knob.choices) > MAX_SHOWN
        return f"{knob.key} among {len(knob.choices) if many else ' and '.join(map(str, knob.choices))}"
    return f"{knob.key} from {knob.low:g} to {knob.high:g}{_unit(knob)}"


def manifest(solution: Solution) -> dict[str, Any]:
    """Return what the manifest says of the result."""
    return {"name": solution.name, "target": dict(solution.target)}


def figures(solution: Solution) -> dict[str, Callable[[], Picture]]:
    """Return the result against the one number that is varied; nothing for several."""
    if len(solution.knobs) != 1 or solution.knobs[0].choices:
        return {}
    from skincad.pictures.study_figures import solution_figure

    return {"solve.png": partial(solution_figure, solution)}


def files(solution: Solution) -> dict[str, Writer]:
    """Return the writers of the first solution's design, and of the figure."""
    designs = {"solved.toml": text(solution.solved.to_toml)} if solution.solutions else {}
    return {**designs, **{name: picture(draw) for name, draw in figures(solution).items()}}


def write_solution(solution: Solution, path: Path, source: str) -> None:
    """Write the first solution as a copy of the file it began from, its comments kept.

    Raises InputError for a file that is there already or cannot be written.
    """
    values = solution.solutions[0].values
    comments = {
        key: f"solved for {_targets(solution)}" for key in values if not key.rpartition(".")[2].isdigit()
    }
    if any(owner(solution.subject, key)[0] is not solution.subject for key in values):
        comments = {}  # a skin's or a circuit's own tables come in place of its name
    write_copy(path, source, solution.solved, comments)
