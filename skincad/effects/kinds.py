"""What an effect is: its own table of a scene, of one of four kinds.

A law makes the model that a march advances (exactly one); a body changes the pad before it is meshed; a term
adds its share to every step; a readout looks at accepted states. Effects are frozen and keep no state: what a
step leaves behind is the model's own state, which the march replaces only when a step has converged.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from skincad.design import Design
from skincad.mechanics.grip import Cone, Drive
from skincad.mechanics.problem import Pad
from skincad.tables import Table

if TYPE_CHECKING:
    from skincad.mechanics.film.stick import Part

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class Step:
    """From time `start` to `end`, s, the plate goes from `before` to `after`."""

    start: float
    end: float
    before: Drive
    after: Drive


@dataclass(frozen=True)
class Share:
    """What a term adds to a step: friction's `cone`, and `more` for a law that knows what to do with it."""

    cone: Cone | None = None
    more: Mapping[str, Any] | None = None


@dataclass(frozen=True)
class Reading:
    """What is told of an accepted state.

    `normal`, `tangential` N and `approach`, `travel` mm of the plate; `touches`, `slips` `(m,)` by contact
    point; `films` `(strips, 3)` MPa, across, along and lengthwise; `elastic` mJ stored and `dissipated` mJ
    in the step; `residual` relative.
    """

    normal: float
    tangential: float
    approach: float
    travel: float
    touches: Mask
    slips: Mask
    films: Array
    elastic: float
    dissipated: float
    residual: float


class Model(Protocol):
    """A meshed pad that is advanced through a scene; its states are its own and never changed."""

    @property
    def ridge(self) -> NDArray[np.int64]:
        """Ridge of each contact point `(m,)`."""

    @property
    def unknowns(self) -> int:
        """Number of free unknowns."""

    def start(self) -> Any:
        """The unloaded state."""

    def advanced(self, state: Any, step: Step, shares: Sequence[Share]) -> Any:
        """Return the converged state at the step's end.

        Raises GrossSlip, whose `last` is the last state there is, or ContactError.
        """

    def reading(self, before: Any, state: Any) -> Reading:
        """Return what is told of a state that a step led to from `before`."""


class Effect(Table):
    """A table `[effects.<name>]` of a scene."""

    def check(self, design: Design) -> None:
        """Raise InputError, its key within the effect's own table, where the skin lacks what it needs."""


class Law(Effect):
    """Stress from strain."""

    def model(self, part: Part, mesh: object, order: int, films: bool) -> Model:
        """Return the model of a meshed pad; `films` asks for the stresses in its strips."""
        raise NotImplementedError


class Body(Effect):
    """A region of the section with its own stiffness."""

    def changed(self, pad: Pad, design: Design) -> Pad:
        """Return the pad with this body in it."""
        raise NotImplementedError


class Term(Effect):
    """Adds forces, and their tangent, to a step."""

    def share(self, step: Step) -> Share:
        """Return what it adds; pure."""
        raise NotImplementedError


class Readout(Effect):
    """Looks at what the march has accepted."""

    def read(self, time: Array, readings: Sequence[Reading]) -> Mapping[str, Any]:
        """Return keys for the result's JSON from the accepted readings at `time` s."""
        raise NotImplementedError
