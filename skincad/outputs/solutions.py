"""What solving says: the values that give what is wanted, or how near any came."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.outputs.delivery import picture, text
from skincad.outputs.designcopy import write_copy
from skincad.studies.asking import short
from skincad.studies.knobs import Knob
from skincad.studies.measures import worded
from skincad.studies.solution import Solution, Solved
from skincad.studies.subject import owner

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "solve"
MOST_SHOWN = 5  # solutions, in words


def lines(found: Solution) -> list[str]:
    """Return what `solve` prints."""
    count, model = len(found.evaluations), found.question.tier
    tried = f"{count} evaluation{'s' if count != 1 else ''}" + (f" by {model}" if model else "")
    refused = [each.refused for each in found.evaluations if each.refused]
    return [
        *(_solution_lines(found) if found.solutions else [_none(found)]),
        f"  tried          {tried}, {found.seconds:.3g} s",
        *([f"  refused        {len(refused)}; the first: {refused[0]}"] if refused else []),
        *(f"  note           {note}" for note in found.notes),
    ]


def _solution_lines(found: Solution) -> list[str]:
    first, *others = found.solutions
    # choices alone are told where the wish lies within the error, not only where it is met
    gives = "may give" if all(knob.choices or knob.whole for knob in found.knobs) else "gives"
    told = [f"{found.name}: {_values(found, first)} {gives} {_wishes(found)}."]
    for each in (first, *others[: MOST_SHOWN - 1]):
        if each is not first:
            told.append(f"  also           {_values(found, each)}")
        told += [f"  reached        {worded(key, value)}" for key, value in each.reached.items()]
        for key, (low, high) in each.interval.items():
            knob = next(knob for knob in found.knobs if knob.key == key)
            ends = f"{short(low)} to {short(high)}{_unit(knob)}"
            told.append(f"  may be         {key} anywhere from {ends}, since the result has that error")
        told += [
            f"  nearest        {key} = {name}" for key, name in each.nearest.items() if key not in each.values
        ]
    if len(others) >= MOST_SHOWN:
        told.append(f"  and            {len(others) + 1 - MOST_SHOWN} more")
    return told


def _values(found: Solution, solved: Solved) -> str:
    units = {knob.key: _unit(knob) for knob in found.knobs}
    return ", ".join(f"{key} {short(value)}{units[key]}" for key, value in solved.values.items())


def _unit(knob: Knob) -> str:
    return f" {knob.unit}" if knob.unit else ""


def _none(found: Solution) -> str:
    ranges, count = ", ".join(_range(knob) for knob in found.knobs), len(found.evaluations)
    told = f"{found.name}: no {ranges} gives {_wishes(found)}"
    if not found.complete:
        many = f"{count} evaluation{'s' if count != 1 else ''}"
        told = f"{found.name}: none found in {many} of {ranges} that gives {_wishes(found)}"
    if found.closest is None:
        return f"{told}."
    reached = ", ".join(worded(key, value) for key, value in found.closest.reached.items())
    return f"{told}. The nearest is {reached}, at {_values(found, found.closest)}."


def _wishes(found: Solution) -> str:
    return ", ".join(worded(key, wanted) for key, wanted in found.target.items())


def _range(knob: Knob) -> str:
    if knob.choices:
        many = len(knob.choices) > MOST_SHOWN
        return f"{knob.key} among {len(knob.choices) if many else ' and '.join(map(str, knob.choices))}"
    return f"{knob.key} from {knob.low:g} to {knob.high:g}{_unit(knob)}"


def manifest(found: Solution) -> dict[str, Any]:
    """Return what the manifest says of the result."""
    return {"name": found.name, "target": dict(found.target)}


def figures(found: Solution) -> dict[str, Callable[[], Picture]]:
    """Return the result against the one number that is varied; nothing for several."""
    if len(found.knobs) != 1 or found.knobs[0].choices:
        return {}
    from skincad.pictures.study_figures import solution_figure

    return {"solve.png": partial(solution_figure, found)}


def files(found: Solution) -> dict[str, Writer]:
    """Return the writers of the first solution's design, and of the figure."""
    designs = {"solved.toml": text(found.solved.to_toml)} if found.solutions else {}
    return {**designs, **{name: picture(draw) for name, draw in figures(found).items()}}


def write_solution(found: Solution, path: Path, source: str) -> None:
    """Write the first solution as a copy of the file it began from, its comments kept.

    Raises InputError for a file that is there already or cannot be written.
    """
    values = found.solutions[0].values
    said = {key: f"solved for {_wishes(found)}" for key in values if not key.rpartition(".")[2].isdigit()}
    if any(owner(found.subject, key)[0] is not found.subject for key in values):
        said = {}  # a skin's or a circuit's own tables come in place of its name
    write_copy(path, source, found.solved, said)
