"""The ladders in words: what `skincad accuracy` prints for a person."""

from __future__ import annotations

from collections.abc import Iterator

from skincad.ladders.ladder import Ladder
from skincad.outputs.accuracy_job import Accuracy


def accuracy_lines(found: Accuracy) -> list[str]:
    """Return the table of each ladder, what its rungs are held against, and the machine."""
    told, versions = found.machine, found.machine["versions"]
    lines = [line for ladder in found.ladders for line in _ladder_lines(ladder)]
    load = "" if told["load"] is None else f", load {told['load']:g}"
    return [
        *lines,
        f"On {told['processor']}, {told['cores']} cores{load}, Python {told['python']}, "
        + ", ".join(f"{name} {version}" for name, version in versions.items()),
        f"Times are medians of {found.repeats} runs, +- half from the shortest to the longest; what takes "
        f"long runs once. The whole took {found.seconds:.0f} s.",
    ]


def _ladder_lines(ladder: Ladder) -> Iterator[str]:
    """A row a rung; a star marks the rungs that no other beats in both time and the first error."""
    measures = ladder.measures
    models = max((len(r.model) for r in ladder.rungs), default=0)
    settings = max((len(r.setting) for r in ladder.rungs), default=0)
    yield f"{ladder.name}: {ladder.title}"
    heads = "".join(f"{m.name:>15}" for m in measures)
    yield f"  {'model':{models}}  {'setting':{settings}} {'unknowns':>9} {'time, s':>9} {'+-':>8} {heads}"
    best = {measure.name: ladder.best(measure) for measure in measures}
    for rung in ladder.rungs:
        cells = "".join(
            f"{rung.errors[m.name]:>14.2g}{'*' if rung in best[m.name] else ' '}"
            if m.name in rung.errors
            else f"{'':15}"
            for m in measures
        )
        yield (
            f"  {rung.model:{models}}  {rung.setting:{settings}} {rung.unknowns:9d} {rung.seconds:9.3g} "
            f"{rung.spread / 2:8.1g} {cells}".rstrip()
        )
    for m in measures:
        unit = "" if m.unit == "1" else f", {m.unit}"
        yield f"  {m.name}: {m.what}{unit}; against {m.reference} ({m.checked})"
    yield from _matched_lines(ladder)
    for model, law in ladder.laws().items():
        off = f"within a factor of {law.scatter:.2f}"
        yield f"  time of {model}: {law.factor:.2g} s x unknowns^{law.exponent:.2f}, {off}"
    yield from (f"  not {name}: {why}" for name, why in ladder.skipped.items())
    if ladder.lines:
        yield "  * no other rung is both faster and better (of its model, where each aims at its own truth)"
    yield ""


def _matched_lines(ladder: Ladder) -> Iterator[str]:
    """Times of the models at equal errors, by the first measure that compares them; more is in the JSON."""
    measures = [measure for measure in ladder.measures if measure.compares]
    for measure, error, rungs in ((m, *found) for m in measures[:1] for found in ladder.matched(m).items()):
        first, *others = rungs
        more = (f"{r.model} {r.seconds:.2g} s ({r.seconds / first.seconds:.2g} times)" for r in others)
        aim = f"{measure.name} {error:.0e}" + ("" if measure.unit == "1" else f" {measure.unit}")
        yield f"  {aim} takes {first.model} {first.seconds:.2g} s, {', '.join(more)}"
