"""How long the ladders still take: what each stage is expected to cost, at this machine's speed so far."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from time import perf_counter

from skincad.base.stopwatch import Progress

PRIOR = 2.0  # s that were as expected before anything is measured: one short stage says little of a machine


class Countdown:
    """A Progress that adds to each stage the seconds left to the end of all.

    `prices` are s by stage in the order in which they come; a stage that is left out is passed over, one that
    is not known costs nothing. Expected times are scaled by those of the stages done.
    """

    def __init__(
        self, prices: Mapping[str, float], progress: Progress, now: Callable[[], float] = perf_counter
    ) -> None:
        self._stages, self._prices = list(prices), list(prices.values())
        self._progress, self._now = progress, now
        self._at: int | None = None
        self._began = self._spent = self._done = 0.0

    def __call__(self, stage: str, left: float | None = None, /) -> None:
        """Tell the stage and the seconds from its begin to the end of all."""
        now = self._now()
        if self._at is not None:
            self._spent += now - self._began
            self._done += self._prices[self._at]
        self._at, self._began = (self._stages.index(stage) if stage in self._stages else None), now
        if self._at is None:
            self._progress(stage, left)
            return
        slower = (PRIOR + self._spent) / (PRIOR + self._done)
        self._progress(stage, slower * math.fsum(self._prices[self._at :]))
