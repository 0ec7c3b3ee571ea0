"""The kinds of effects, what they see of a scene, and how one that is left out says what it would change.

What an effect says of a scene that leaves it out: an indicator, from numbers at hand. What it says is the
change of the differential stress S1 - S2 that naming the effect brings: of any ridge and at any time of the
march the largest one, relative to the largest S1 - S2 of any ridge without the effect. Where a scene tells no
film's stress, the ridges' pulls stand for it, and without a pull their normal forces. bench/left_out.py
holds each against marches with and without its effect.

A law makes the pad that a march advances (exactly one); a pad change alters it before it is meshed; a term
adds its share to every step; a reader looks at accepted states. Effects are frozen and keep no state: what a
step leaves behind is that pad's own state, which the march replaces only when a step has converged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from skincad.base.arrays import Array, Index, Mask
from skincad.base.result import Record, item
from skincad.base.tables import Table
from skincad.inputs.design import Design
from skincad.mechanics.contact.state import ContactState, Drive, FrictionCoefficients, Swing
from skincad.mechanics.problem import Pad
from skincad.mechanics.validity import Limits
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.mechanics.bodies.mesh import PadPiece


FAINT = 0.1
TINY = 1e-300


@dataclass(frozen=True)
class LeftOutEffect(Record):
    """An effect left out, and the relative change of the differential stress that it may bring."""

    effect: str = item(meaning="its name")
    indicator: str = item(meaning="what points to it")
    change: float = item(meaning="relative, that it may bring", key="estimated_change")
    calibrated: bool = item(meaning="whether that was held against runs with the effect", default=False)
    within: float | None = item(
        meaning="factor, to either side, that held 90 % of random scenes which no constant saw", default=None
    )

    @property
    def warning(self) -> str:
        """What a scene that leaves it out is warned of."""
        may = f"leaving it out may change signals by {self.change:.0%}, {self.certainty}"
        return f"{self.effect} is left out: {self.indicator}; {may}"

    @property
    def certainty(self) -> str:
        """How far the change is to be trusted."""
        if self.within is not None:
            return f"to a factor of {self.within:g}"
        return "calibrated" if self.calibrated else "an uncalibrated estimate"


@dataclass(frozen=True, eq=False)
class PlatePath:
    """What a march found: at `time` `(n,)` s the plate's `approach` and `travel` `(n,)` mm; of the ridges,
    `(n, ridges)`, the normal force `pressed` and the pull `pulled`, N, to +x, the share of their touching
    points that `slips`, and S1 - S2 `felt`, MPa, with no ridges where no film is read; and what of them
    touches, its `area` `(n, ridges)` mm2."""

    time: Array
    approach: Array
    travel: Array
    pressed: Array
    pulled: Array
    slips: Array
    felt: Array
    area: Array

    @property
    def signal(self) -> Array:
        """S1 - S2, or what stands for it `(n, ridges)`."""
        for part in (self.felt, self.pulled):
            if np.abs(part).max(initial=0.0) > 0:
                return part
        return self.pressed

    def per_force(self) -> Array:
        """Return how much a ridge's signal rises with its normal force and its pull, `(2, ridges)` in the
        signal's unit per N: with the pull as it does in all ridges and steps together, with the normal force
        as what is left does in all of the ridge's steps. A ridge that bears less than FAINT of what the most
        loaded one bears feels its neighbours more than that: nothing goes with its own normal force then."""
        signal, pulled, normal = self.signal, self.pulled, self.pressed
        per_pull = float((signal * pulled).sum() / max((pulled**2).sum(), TINY))
        rest = ((signal - per_pull * pulled) * normal).sum(axis=0)
        down = rest / np.maximum((normal**2).sum(axis=0), TINY)
        borne = normal.max(axis=0)
        return np.array([np.where(borne > FAINT * borne.max(), down, 0.0), np.full_like(down, per_pull)])


@dataclass(frozen=True, eq=False)
class SceneOutline:
    """What an indicator looks at: the skin; the history's points, `time_s` and `loads` at them (normal force
    N, and tangential force N or, where the plate is `driven`, displacement mm); the `path` of the march; and
    the coefficient of static `friction`, at small pressures where it depends on pressure, 0 without any."""

    design: Design
    time_s: tuple[float, ...]
    loads: tuple[tuple[float, ...], ...]
    path: PlatePath
    driven: bool = False
    friction: float = 0.0

    @property
    def pulls(self) -> bool:
        """Whether the history moves or pulls the plate along."""
        return any(self.loads[1])

    @property
    def ridge_normal(self) -> float:
        """The largest normal force on a ridge, N."""
        return float(self.path.pressed.max(initial=0.0))


# What a term may ask of the law: inertia, history-dependent stress, a plate that is not flat
MASS, RATE, RELIEF = "mass", "rate", "relief"
MOVING = frozenset({MASS, RATE})  # of these what a quasi-static pad does not know


@dataclass(frozen=True)
class Step:
    """From time `start` to `end`, s, the plate, of `mass` g, goes from `before` to `after`."""

    start: float
    end: float
    before: Drive
    after: Drive
    mass: float = 0.0


@dataclass(frozen=True)
class Share:
    """What a term adds to a step, or all of its terms together: friction's `cone`; `damped`, for masses, what
    is left of the highest modes after a step; `rate` s, the viscous part's stress per strain rate by the
    elastic one's per strain; `relaxing`, pairs of what a modulus is larger at first, relative to the slow
    one, and the time, s, in which it relaxes; `swing`, what masses add at the contact points of a pad that
    has none; and `relief`, how far the plate stays behind its foremost level at places along it, mm.
    """

    cone: FrictionCoefficients | None = None
    damped: float | None = None
    rate: float = 0.0
    relaxing: tuple[tuple[float, float], ...] = ()
    swing: Swing | None = None
    relief: Callable[[Array], Array] | None = None

    def __add__(self, other: Share) -> Share:
        """Return what two terms add together; of what one of them alone can add, the first's."""
        return Share(
            cone=self.cone or other.cone,
            damped=other.damped if self.damped is None else self.damped,
            rate=self.rate + other.rate,
            relaxing=self.relaxing + other.relaxing,
            swing=self.swing or other.swing,
            relief=self.relief or other.relief,
        )


FRICTIONLESS = FrictionCoefficients(0.0, 0.0)


def share_of(terms: Iterable[Term], step: Step) -> Share:
    """Return what all terms of a scene add to a step."""
    return sum((term.share(step) for term in terms), Share())


class Drift(NamedTuple):
    """Error of a pad that is linear between chosen steps: of each ridge's `forces` `(2, ridges)` N, along x
    and z, and of the strips' stresses `films` `(strips, 3)` MPa. `chosen` says whether the step is a chosen
    one, `cut` why no later one could be, or ''."""

    forces: Array
    films: Array
    chosen: bool = False
    cut: str = ""


@dataclass(frozen=True)
class Observables:
    """The observables of an accepted state.

    `normal`, `tangential` N and `approach`, `travel` mm of the plate; `touches`, `slips` `(m,)` by contact
    point; `films` `(strips, 3)` MPa, across, along and lengthwise; `elastic` mJ stored and `dissipated` mJ
    in the step; `residual` relative. With masses `kinetic` mJ, of viscous parts `viscous` mJ dissipated in
    the step; `work` mJ is what drives the plate did in the step, None where the plate's forces tell it.
    `drift` is given by a pad that is linear between chosen steps; `fold` says where the surface folds; `tips`
    `(pins, 3)` N are the plate's forces on pins along x, y and z, None of other features; `magnets` gives
    what finite strain adds to how pins' magnets go under such forces.
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
    kinetic: float = 0.0
    viscous: float = 0.0
    work: float | None = None
    drift: Drift | None = None
    fold: str | None = None
    tips: Array | None = None
    magnets: Callable[[Array], Array] | None = None

    @classmethod
    def of(cls, contact: ContactState, films: Array, elastic: float, dissipated: float, **more: Any) -> Self:
        """Return the observables of a contact and of what goes with it; `more` by its name."""
        normal, tangential = float(contact.normal.sum()), float(contact.tangential.sum())
        plate = normal, tangential, contact.approach, contact.travel
        return cls(
            *plate, contact.touches, contact.slips, films, elastic, dissipated, contact.residual, **more
        )


class Discretisation(NamedTuple):
    """Of each contact point of a pad its `ridge` `(m,)` and the `area` `(m,)` that it stands for, mm2,
    undeformed; and the number of the pad's free `unknowns`."""

    ridge: Index
    area: Array
    unknowns: int


class MarchedPad(Protocol):
    """A meshed pad that is advanced through a scene. Its states are its own and never changed; each has its
    `contact`, a ContactState."""

    @property
    def discretisation(self) -> Discretisation:
        """Its contact points and unknowns."""

    def start(self) -> Any:
        """The unloaded state."""

    def advanced(self, state: Any, step: Step, share: Share) -> Any:
        """Return the converged state at the step's end; `share` is what all terms add to it.

        Raises GrossSlip, whose `last` is the last state there is, or ContactError.
        """

    def reading(self, before: Any, state: Any) -> Observables:
        """Return the observables of a state that a step led to from `before`."""

    def fault(self, state: Any) -> str | None:
        """Return what of the skin would collide unseen in a state, or None; None too where `advanced` says so
        itself."""


class Effect(Table):
    """A table `[effects.<name>]` of a scene; `needs` names the effects that it cannot be without."""

    needs: ClassVar[tuple[str, ...]] = ()

    def check(self, design: Design) -> None:
        """Raise InputError, its key within the effect's own table, where the skin lacks what it needs."""

    @staticmethod
    def left_out(outline: SceneOutline) -> LeftOutEffect | None:  # noqa: ARG004
        """Return what leaving the effect out may change, or None where it cannot matter.

        Only those of INDICATORS are asked.
        """
        return None


class Law(Effect):
    """Stress from strain; `gives` names what its pads know of what terms ask, `halves` says whether the
    half of a mirror-symmetric pad is enough of a mesh, `condenses` whether its quasi-static pads are known
    by the compliance of its contact points: then the plate may turn, and a pad may have `ends`."""

    halves: ClassVar[bool] = True
    condenses: ClassVar[bool] = False
    gives: ClassVar[frozenset[str]] = frozenset()

    @property
    def swings(self) -> bool:
        """Whether its quasi-static pads take what slow modes add at their contact points (modal.py)."""
        return False

    def limits(self, design: Design) -> Limits:
        """Return where the law's range ends; any law's does where the skin is pressed flat."""
        return Limits(skin_of(design).height)

    def marched(
        self, piece: PadPiece, mesh: object, order: int, films: bool, terms: Sequence[Term]
    ) -> MarchedPad:
        """Return a meshed pad to be marched; `films` asks for the stresses in its strips.

        Only what the terms ask is built.
        """
        raise NotImplementedError


class PadChange(Effect):
    """Alters the pad, as by a region with its own stiffness; `condenses`: whether it needs a pad that
    does."""

    condenses: ClassVar[bool] = False

    @property
    def feels(self) -> bool:
        """Whether films bear stress with it."""
        return True

    def changed(self, pad: Pad, design: Design) -> Pad:
        """Return the altered pad."""
        raise NotImplementedError


class Term(Effect):
    """Adds forces, and their tangent, to a step; `asks` names what it needs of the law beyond its stress:
    MASS, RATE, RELIEF."""

    asks: ClassVar[frozenset[str]] = frozenset()

    @property
    def rise(self) -> float:
        """How far the plate's face is from plane, mm."""
        return 0.0

    def remarks(self, needs: frozenset[str]) -> Iterator[str]:  # noqa: ARG002
        """Yield what to warn of, given all that the scene's terms ask."""
        yield from ()

    def afterwards(self, path: PlatePath) -> Iterator[str]:  # noqa: ARG002
        """Yield what to warn of once a march is known."""
        yield from ()

    def share(self, step: Step) -> Share:
        """Return what it adds; pure."""
        raise NotImplementedError


@dataclass(frozen=True)
class ReaderContext:
    """What a reader reads of: the skin, the monitored ridges, and the signals' bandwidth, Hz."""

    design: Design
    ridges: tuple[int, ...]
    bandwidth: float


class Reader(Effect):
    """Looks at what the march has accepted."""

    def read(self, watched: ReaderContext, time: Array, readings: Sequence[Observables]) -> Mapping[str, Any]:
        """Return keys for the result's JSON from the accepted readings at `time` s.

        `warnings` are added to the result's. `<name>_<unit>` of ridge, of signal, with a number a step, also
        become columns of the table.
        """
        raise NotImplementedError

    def other_noises(self, watched: ReaderContext, time: Array) -> Iterator[Array]:  # noqa: ARG002
        """Yield `(steps + 1, ridges, 2)` V that, added to `output_V`, make its noise that of another seed;
        none where nothing read has noise."""
        yield from ()
