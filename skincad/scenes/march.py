"""Time steps of a scene.

The state is replaced only when a step has converged and lies within the law's limits. A march that cannot go
on stops with what it has and says where and why.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from math import inf
from time import perf_counter
from typing import Any

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.base.interrupt import safe_point
from skincad.effects.kinds import MarchedPad, Observables, Step, Term, share_of
from skincad.mechanics.contact.state import ContactState, Drive, GrossSlip
from skincad.mechanics.problem import ContactError
from skincad.mechanics.validity import Limits
from skincad.scenes.scene import Scene


@dataclass(frozen=True)
class Level:
    """A mesh and an order; `size` is its unknowns in units of the first level's.

    Sizes were measured on yamada-2002-slip: 22 700, 39 600, 56 500 and 105 000 unknowns; with masses, where
    the inside is not condensed, the second has 2.2.
    """

    fineness: float
    order: int
    size: float = 1.0


LEVELS = (Level(0.5, 2, 1.0), Level(0.5, 3, 1.75), Level(0.5, 4, 2.5), Level(1.0, 4, 4.6))
# s ~ size^EXPONENT of condensation and march. Measured (ladder slip and seven scenes): 1.1 to 1.5 from level
# to level, so within a factor of 1.3 from one to the next
EXPONENT = 1.35


def expected(level: Level, last: Level, spent: Mapping[str, float]) -> float:
    """Return the seconds that a level will take, by the stages' seconds of the last; its mesh is made again
    if it is finer, else shared."""
    growth = level.size / last.size
    mesh = spent["mesh"] * growth if level.fineness != last.fineness else 0.0
    return mesh + float(growth**EXPONENT) * (spent["condense"] + spent["march"])


GROSS_SLIP, INTERRUPTED = "gross slip", "interrupted"
ENDLESS = Limits(inf)
WINDOW = 200  # steps; to look for collisions takes as long as some 20 quasi-static ones


@dataclass(frozen=True, eq=False)
class March:
    """The accepted readings, entry 0 the unloaded start, at `time` `(steps + 1,)` s.

    `stopped` says why the march ended early, None at its end; `failed` whether that was a step that did not
    converge or left the model's range. `ridge` `(m,)` of the contact points, and the `area` `(m,)` mm2 that
    each stands for; `seconds` by stage. `loads`
    `(steps + 1, 3, ridges)` are the normal and tangential force on each ridge, N, and what of it touches,
    mm2. `states` are the pad's own of the steps that were to be kept, and the last; `pad` is what it
    advanced. Neither states nor pad are in a pickle or a copy: they hold the FE library's own objects.
    """

    time: Array
    readings: tuple[Observables, ...]
    ridge: Index
    unknowns: int
    stopped: str | None
    failed: bool
    seconds: dict[str, float]
    loads: Array
    states: Mapping[int, Any] = field(default_factory=dict)
    pad: MarchedPad | None = None
    area: Array = field(default_factory=lambda: np.zeros(0))

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "states": {}, "pad": None}

    @property
    def interrupted(self) -> bool:
        """Whether Ctrl-C ended it."""
        return self.stopped == INTERRUPTED

    def column(self, name: str) -> Array:
        """Return a field of the readings, stacked along steps."""
        return np.array([getattr(reading, name) for reading in self.readings])

    @property
    def slip_share(self) -> Array:
        """The share of the touching area that slips `(steps + 1,)`, 0 where nothing touches."""
        touching, slipping = (self.column(name) @ self.area for name in ("touches", "slips"))
        return np.asarray(slipping / np.maximum(touching, np.finfo(float).tiny))


def march(
    pad: MarchedPad,
    times: Array,
    drives: Sequence[Drive],
    terms: Sequence[Term],
    tick: Callable[[int], None] | None = None,
    keep: Collection[int] = (),
    mass: float = 0.0,
    limits: Limits = ENDLESS,
    partial: bool = False,
) -> March:
    """Return the march of a pad through `drives` at `times` `(steps + 1,)` s; `tick` is told each step.

    The plate's `mass`, g, counts where a term asks for masses. States of the steps in `keep` are kept. Gross
    slip ends it, for a plate driven by force has no equilibrium then; its entry is the state that just slips.
    A step that does not converge or goes beyond `limits` ends it, and so does what collides unseen: that is
    looked for every WINDOW steps and at the end. Where it is found the march goes back to where it last
    looked, and on from there looking at each step. Ctrl-C ends it where what is done by then is wanted
    (`partial`), and raises KeyboardInterrupt otherwise.
    """
    began, path = perf_counter(), _Path(pad, limits, keep)
    stopped, failed = None, False
    try:
        while (i := len(path.readings)) < len(drives) and stopped is None:
            safe_point()
            step = Step(float(times[i - 1]), float(times[i]), drives[i - 1], drives[i], mass)
            wrong = ""
            try:
                after = pad.advanced(path.state, step, share_of(terms, step))
                wrong = path.refused(after)
            except GrossSlip as end:
                stopped, wrong = GROSS_SLIP, path.refused(end.last)
            except ContactError as failure:
                wrong = str(failure)
            if path.due(bool(wrong or stopped) or i + 1 == len(drives)) and (
                contact_note := path.collision()
            ):
                again = not path.careful
                path.back()
                if again:
                    stopped = None
                    continue
                wrong = contact_note
            if wrong:
                stopped, failed = f"step {i}, t = {times[i]:.6g} s: {wrong}", True
            elif tick and not stopped:
                tick(i)
    except KeyboardInterrupt:
        if not partial:
            raise
        stopped = INTERRUPTED
        if path.collision():
            path.back()
    times_done, states = np.asarray(times[: len(path.readings)]), path.states
    spent, loads = perf_counter() - began, np.array(path.loads)
    return March(
        time=times_done,
        readings=tuple(path.readings),
        ridge=pad.discretisation.ridge,
        unknowns=pad.discretisation.unknowns,
        stopped=stopped,
        failed=failed,
        seconds={"march": spent},
        loads=loads,
        states=states,
        pad=pad,
        area=pad.discretisation.area,
    )


class _Path:
    """What a march has accepted, and of it what nobody has looked at for collisions.

    They are looked for in the states in which a ridge is pressed harder, or pulled harder to one side, than
    in any before: what is loaded less in all three ways is taken to be as sound as those.
    """

    def __init__(self, pad: MarchedPad, limits: Limits, keep: Collection[int]) -> None:
        self.pad, self.limits, self.keep = pad, limits, keep
        ridge, self.area, _ = pad.discretisation
        count = 1 + int(ridge.max())
        self.thrice = np.concatenate([ridge, count + ridge, 2 * count + ridge])
        self.state = pad.start()
        self.readings = [pad.reading(self.state, self.state)]
        self.loads = [self._of_ridges(self.state.contact)]
        self.kept = {0: self.state} if 0 in keep else {}
        self.careful = False
        self.hardest, self.unseen = [0.0] * 3, dict[int, Any]()
        self.sound = 0, self.state, self.hardest.copy()

    @property
    def states(self) -> dict[int, Any]:
        """Those to keep, and the last."""
        return {**self.kept, len(self.readings) - 1: self.state}

    def refused(self, state: Any) -> str:
        """Accept a state, or return why it is beyond the limits."""
        contact = state.contact
        of_ridges = self._of_ridges(contact)
        down, tangential = self.limits.on_first(of_ridges[:2])
        loads = tuple(map(float, (down.max(), tangential.max(), -tangential.min())))
        wrong = self.limits.crushed_reason(contact.approach) or self.limits.overload_reason(
            loads[0], max(loads[1:])
        )
        if wrong:
            return wrong
        self.readings.append(self.pad.reading(self.state, state))
        self.loads.append(of_ridges)
        self.state = state
        if len(self.readings) - 1 in self.keep:
            self.kept[len(self.readings) - 1] = state
        for i, load in enumerate(loads):
            if load > self.hardest[i]:
                self.hardest[i], self.unseen[i] = load, state
        return ""

    def _of_ridges(self, contact: ContactState) -> Array:
        """Normal and tangential force, and what touches, `(3, ridges)`."""
        sums = np.concatenate([contact.normal, contact.tangential, self.area * contact.touches])
        return np.asarray(np.bincount(self.thrice, sums), dtype=float).reshape(3, -1)[:, 1:]

    def due(self, ends: bool) -> bool:
        """Whether to look for collisions now."""
        return ends or self.careful or len(self.readings) > self.sound[0] + WINDOW

    def collision(self) -> str | None:
        """Return what collides in a state that nobody has looked at; without any, all is sound so far."""
        for state in {id(state): state for state in self.unseen.values()}.values():
            if wrong := self.pad.fault(state):
                return wrong
        self.unseen = {}
        self.sound = len(self.readings) - 1, self.state, self.hardest.copy()
        return None

    def back(self) -> None:
        """Return to where all was sound, and be careful from there on."""
        step, self.state, hardest = self.sound
        self.careful, self.unseen, self.hardest = True, {}, hardest.copy()
        del self.readings[step + 1 :], self.loads[step + 1 :]
        self.kept = {at: state for at, state in self.kept.items() if at <= step}


def frames(scene: Scene) -> list[int]:
    """Return the steps of an animation, evenly over the history's time."""
    even = scene.history.even
    count = min(scene.readout.frames, even.size)
    places = np.unique(np.linspace(0, even.size - 1, count).round().astype(int))
    return list(map(int, even[places]))
