"""A scene on one mesh after the other, until its differential stress is known as well as asked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial as bound
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.scenes.levels import LEVELS, expected
from skincad.scenes.march import INTERRUPTED, March
from skincad.scenes.on_mesh import Marching, march_on
from skincad.scenes.scene import Scene

if TYPE_CHECKING:
    from skincad.mechanics.film.stick import PadPiece

DEFAULT_TOLERANCE = 0.05  # of the largest differential stress; what is left out changes more (docs/facts.md)


@dataclass(frozen=True, eq=False)
class Climbed:
    """The last march that counts, its error MPa by told ridge (None with one mesh), and what was not met."""

    march: March
    error: dict[int, float] | None
    short: list[str]


def climb(
    on: Marching, tol: float | None, budget: float | None, began: float, seconds: dict[str, float]
) -> Climbed:
    """March on one mesh after the other as `simulate` says; `began` is when the budget began to run."""
    wanted, films = tol or DEFAULT_TOLERANCE, bool(on.scene.readout.ridges)
    before: March | None = None
    error: dict[int, float] | None = None
    reached, met = np.inf, False
    short: list[str] = []
    for level, following in zip(LEVELS, (*LEVELS[1:], None), strict=True):
        stages: dict[str, float] = {}
        rest = following if before is None and budget is None else None  # two meshes are the least
        found = _or_before(bound(march_on, level, on, stages, rest), before, met, on.partial, short)
        for stage, more in stages.items():
            seconds[stage] = seconds.get(stage, 0.0) + more
        if before is not None and found.readings is before.readings:
            break
        if before is not None:
            error, reached = _errors(on, before, found)
            met = reached <= wanted
        enough = met and (tol is not None or budget is None)  # a budget alone asks for the best it buys
        if enough or found.failed or found.interrupted or following is None:
            break
        if not films and before is not None:
            break
        price = expected(following, level, {**stages, "mesh": seconds["mesh"]})
        if budget is not None and perf_counter() - began + price > budget:
            break
        before = found
    if films and not met:
        how = "of unknown error" if error is None else f"within {reached:.1e} of its largest"
        short.append(f"the differential stress is {how}: the tolerance {wanted:.1e} is not met")
    if budget is not None and (late := perf_counter() - began) > budget:
        short.append(f"took {late:.2g} s, more than the budget of {budget:g} s")
    return Climbed(found, error, short)


def _or_before(
    run: Callable[[], March], before: March | None, met: bool, partial: bool, short: list[str]
) -> March:
    """Return the march on the next mesh, or that `before` where it says more; `short` gets why."""
    try:
        found = run()
    except KeyboardInterrupt:
        if not partial or before is None:
            raise
        return replace(before, stopped=INTERRUPTED)
    except (InputError, RefusedError) as refusal:
        if before is None:
            raise
        short.append(f"a finer mesh is refused ({refusal}); the results are those of the mesh before")
        return before
    if found.interrupted and before is not None:
        return replace(before, stopped=INTERRUPTED)  # a whole march says more than a part
    if found.failed and met and before is not None:  # only a budget climbs on from what is good enough
        short.append(f"a finer mesh stopped at {found.stopped}; the results are those of the mesh before")
        return before
    return found


def differential(piece: PadPiece, scene: Scene, found: March) -> dict[int, Array]:
    """Return S1 - S2 across the films `(steps + 1,)` MPa by told ridge."""
    place = {(s.ridge, s.side): i for i, s in enumerate(piece.whole.section.slots)}
    films = found.column("films")
    return {r: films[:, place[r, "S1"], 0] - films[:, place[r, "S2"], 0] for r in scene.readout.ridges}


def _errors(on: Marching, before: March, found: March) -> tuple[dict[int, float], float]:
    """Largest change of each told ridge's difference from the mesh before, MPa; the largest relative one."""
    one, other = (differential(on.piece, on.scene, each) for each in (before, found))
    steps = min(before.time.size, found.time.size)
    error = {r: float(np.abs(one[r][:steps] - other[r][:steps]).max()) for r in one}
    largest = max((float(np.abs(v).max()) for v in other.values()), default=0.0)
    return error, max(error.values(), default=0.0) / largest if largest else 0.0
