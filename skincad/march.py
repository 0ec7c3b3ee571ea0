"""The march through a scene's history. It names no effect.

The state is replaced only when a step has converged. A march that cannot go on stops with what it has and
says where and why.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skincad.effects.kinds import Model, Reading, Step, Term
from skincad.mechanics.grip import Drive, GrossSlip
from skincad.mechanics.problem import ContactError

Array = NDArray[np.float64]
GROSS_SLIP, INTERRUPTED = "gross slip", "interrupted"


@dataclass(frozen=True, eq=False)
class March:
    """The accepted readings, entry 0 the unloaded start, at `time` `(steps + 1,)` s.

    `stopped` says why the march ended early, None at its end; `failed` whether that was a step that did not
    converge. `ridge` `(m,)` of the contact points; `seconds` of the march. `states` are the model's own of
    the steps that were to be kept, and the last; `model` is what it advanced.
    """

    time: Array
    readings: tuple[Reading, ...]
    ridge: NDArray[np.int64]
    unknowns: int
    stopped: str | None
    failed: bool
    seconds: float
    states: Mapping[int, Any] = field(default_factory=dict)
    model: Model | None = None

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""
        return self.stopped == INTERRUPTED

    def column(self, name: str) -> Array:
        """Return a field of the readings, stacked along steps."""
        return np.array([getattr(reading, name) for reading in self.readings])


def march(
    model: Model,
    times: Array,
    drives: Sequence[Drive],
    terms: Sequence[Term],
    tick: Callable[[int], None] | None = None,
    keep: Collection[int] = (),
    mass: float = 0.0,
) -> March:
    """Return the march of a model through `drives` at `times` `(steps + 1,)` s; `tick` is told each step.

    The plate's `mass`, g, counts where a term asks for masses. States of the steps in `keep` are kept. Gross
    slip ends it, for a plate driven by force has no equilibrium then; its entry is the state that just slips.
    A step that does not converge ends it, and so does Ctrl-C.
    """
    began = perf_counter()
    state = model.start()
    readings = [model.reading(state, state)]
    states = {0: state} if 0 in keep else {}
    stopped, failed = None, False
    try:
        for i in range(1, len(drives)):
            step = Step(float(times[i - 1]), float(times[i]), drives[i - 1], drives[i], mass)
            try:
                after = model.advanced(state, step, [term.share(step) for term in terms])
            except GrossSlip as end:
                readings.append(model.reading(state, end.last))
                state = end.last
                stopped = GROSS_SLIP
                break
            except ContactError as failure:
                stopped, failed = f"step {i}, t = {times[i]:.6g} s: {failure}", True
                break
            readings.append(model.reading(state, after))
            state = after
            if i in keep:
                states[i] = state
            if tick:
                tick(i)
    except KeyboardInterrupt:
        stopped = INTERRUPTED
    spent = perf_counter() - began
    states[len(readings) - 1] = state
    done = np.asarray(times[: len(readings)])
    return March(done, tuple(readings), model.ridge, model.unknowns, stopped, failed, spent, states, model)
