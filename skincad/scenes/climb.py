"""A scene on one mesh after the other, until its differential stress is known as well as asked."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from skincad.base import climbing
from skincad.base.arrays import Array
from skincad.base.climbing import Ascent, overrun, unmet
from skincad.base.errors import InputError, RefusedError
from skincad.scenes.levels import LEVELS, Level, expected
from skincad.scenes.march import INTERRUPTED, March
from skincad.scenes.on_mesh import Marching, march_on, march_thin
from skincad.scenes.refined import ComparisonRuns
from skincad.scenes.scene import Scene

if TYPE_CHECKING:
    from skincad.mechanics.film.stick import PadPiece

_Error = dict[int, float] | None
DEFAULT_TOLERANCE = 0.05  # of the largest differential stress; what is left out changes more (docs/facts.md)


@dataclass(frozen=True, eq=False)
class RefinedRun:
    """The last march that counts, its error MPa by told ridge (None with one mesh), what was not met, and the
    marches that its slips are held against."""

    march: March
    error: dict[int, float] | None
    short: list[str]
    refined: ComparisonRuns = field(default_factory=ComparisonRuns)


def climb(
    on: Marching, tol: float | None, budget: float | None, began: float, seconds: dict[str, float]
) -> RefinedRun:
    """March on one mesh after the other as `simulate` says; `began` is when the budget began to run."""
    wanted, films = tol or DEFAULT_TOLERANCE, bool(on.scene.readout.ridges)
    last: dict[str, float] = {}
    refined = [ComparisonRuns()]

    def marched(level: Level, before: Ascent[Level, March, _Error] | None) -> March:
        two = before is None and budget is None  # two meshes are the least
        last.clear()
        following = LEVELS[1] if two and len(LEVELS) > 1 else None
        march = march_on(level, on, last, following, before is None and films)
        if before is not None:
            refined[0] = replace(refined[0], before=before.found)
        elif films and not (march.failed or march.interrupted):
            after = expected(following, level, last) if following else 0.0
            thin = march_thin(on, march, last, after)
            if thin is not None and thin.interrupted:
                thin, march = (
                    None,
                    replace(march, stopped=INTERRUPTED),
                )  # Ctrl-C ends the climb, not its march
            refined[0] = ComparisonRuns(every=march, thin=thin)
        for stage, more in last.items():
            seconds[stage] = seconds.get(stage, 0.0) + more
        if before is not None and march.interrupted:
            raise KeyboardInterrupt  # a whole march says more than a part
        if before is not None and march.failed and before.error <= wanted:
            raise _StoppedError(f"a finer mesh stopped at {march.stopped}")  # what is there is good enough
        return march

    def price(before: Ascent[Level, March, _Error], following: Level) -> float:
        if before.found.failed or before.found.interrupted:
            return np.inf
        return expected(following, before.rungs[-1], {**last, "mesh": seconds["mesh"]})

    reached = climbing.climb(
        marched,
        LEVELS,
        lambda _, found, before: (None, np.inf) if before is None else _errors(on, before, found),
        wanted if tol is not None or budget is None else 0.0,  # a budget alone asks for the best it buys
        budget,
        began=began,
        price=price,
        ends=(InputError, RefusedError, *((KeyboardInterrupt,) if on.partial else ())),
    )
    march, error, ended, short = reached.found, reached.told, reached.ended, list[str]()
    if isinstance(ended, KeyboardInterrupt):
        march = replace(march, stopped=INTERRUPTED)
    elif ended is not None:
        words = str(ended) if isinstance(ended, _StoppedError) else f"a finer mesh is refused ({ended})"
        short.append(f"{words}; the results are those of the mesh before")
    if films:
        how = "of unknown error" if error is None else f"within {reached.error:.1e} of its largest"
        short += unmet(f"the differential stress is {how}", reached.error, wanted)
    counts = refined[0] if len(reached.rungs) > 1 else replace(refined[0], before=None)
    return RefinedRun(march, error, [*short, *overrun("", reached.spent, budget)], counts)


class _StoppedError(RefusedError):
    """A march that did not reach the end of its history."""


def differential(piece: PadPiece, scene: Scene, march: March) -> dict[int, Array]:
    """Return S1 - S2 across the films `(steps + 1,)` MPa by told ridge."""
    place = {(s.feature, s.side): i for i, s in enumerate(piece.whole.section.slots)}
    films = march.column("films")
    return {r: films[:, place[r, "S1"], 0] - films[:, place[r, "S2"], 0] for r in scene.readout.ridges}


def _errors(on: Marching, before: March, march: March) -> tuple[dict[int, float], float]:
    """Largest change of each told ridge's difference from the mesh before, MPa; the largest relative one."""
    one, other = (differential(on.piece, on.scene, run) for run in (before, march))
    steps = min(before.time.size, march.time.size)
    error = {r: float(np.abs(one[r][:steps] - other[r][:steps]).max()) for r in one}
    largest = max((float(np.abs(v).max()) for v in other.values()), default=0.0)
    return error, max(error.values(), default=0.0) / largest if largest else 0.0
