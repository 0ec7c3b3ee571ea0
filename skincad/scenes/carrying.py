"""The object on a finger: its mass on the skin's friction, step by step.

Velocity Verlet for the object, whose place in a step comes from its acceleration; then the contact is solved
at that place. The skin has no mass. It is a compliance: that of small strain, or that about an equilibrium at
finite strain (`PressedSkin`); and it relaxes as a whole, u + tau u' = C f. References: a block on springs in
closed form, finite strain in chosen steps (tests/scenes).
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.base.errors import RefusedError
from skincad.base.machine import one_blas_thread
from skincad.effects.chosen_steps import ChosenPad
from skincad.effects.kinds import FRICTIONLESS, Share, Step
from skincad.effects.small_strain import CondensedPad
from skincad.effects.viscosity import Viscosity
from skincad.mechanics.contact.frictional import solve_contact
from skincad.mechanics.contact.state import Compliance, ContactState, Drive, FrictionCoefficients, at_rest
from skincad.mechanics.dynamics.ringing import RETARDATION
from skincad.mechanics.problem import ContactError
from skincad.scenes.grip import FINGERS
from skincad.scenes.march import LEVELS, Level
from skincad.scenes.plan import CHOSEN
from skincad.scenes.runs import MarchSetup, meshed_pad, piece_for
from skincad.scenes.scene import Scene

TONNE = 1e-6  # of a gram
STABLE = 0.5  # of an explicit step's limit by 4: dt^2 times the object's swing, and its damping
MOST_PARTS = 64  # of a step
DEEPEST = 6  # halvings of a step whose contact does not settle
PRESSED = "film", "friction", "free_ends"  # effects that a skin at finite strain is pressed with
PRESSES = 4  # steps to each grip at finite strain; more are chosen where points move far


@dataclass(frozen=True, eq=False)
class Carried:
    """The object on a finger: the skin's `contact`, its points' displacement `moved` `(2 m,)` mm, the strips'
    stresses `films` `(strips, 3)` MPa; the object's `travel` mm, `speed` mm/s, `acceleration` mm/s2, and how
    far all of it has slid on the skin, `slide` mm, to +x."""

    contact: ContactState
    moved: Array
    films: Array
    travel: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    slide: float = 0.0

    @property
    def pull(self) -> float:
        """The skin's force on the object against its load, N."""
        return float(self.contact.tangential.sum())


@dataclass(frozen=True, eq=False)
class Carrier:
    """A finger's skin and the object on it: the contact points' `ridge` and the `skin` as the object sees it,
    the strips' stresses `films` `(strips, 3)` MPa without forces and `strips` `(strips, 3, 2 m)` per N, what
    is carried at `start`; `mass` tonne, friction's `cone`, the skin's relaxation `tau` s."""

    ridge: Index
    skin: Compliance
    films: Array
    strips: Array
    start: Carried
    unknowns: int
    mass: float
    cone: FrictionCoefficients
    tau: float
    scaled: dict[float, Compliance] = field(default_factory=dict, init=False)  # a copy's skin may differ

    def parts(self, step: float) -> int:
        """Return in how many parts a step of so many s is stable."""
        m = self.skin.gap.size
        sticks = np.linalg.solve(self.skin.compliance[:m, :m], np.ones(m))
        swing = float(sticks.sum()) / self.mass  # its square, 1/s2
        count = next((n for n in range(1, MOST_PARTS + 1) if self._stiff(swing, step / n) <= STABLE), None)
        if count is None:
            short = f"{step / MOST_PARTS:.2g} s"
            raise RefusedError(
                f"the object is too light for this skin: steps would be below {short}; raise grip.mass"
            )
        return count

    def _stiff(self, swing: float, step: float) -> float:
        return swing * step * (step + 2 * self.tau)

    def through(self, state: Carried, step: float, drives: list[list[float]]) -> Carried:
        """Return the state after `step` s, in whose equal parts grip and load (N) go from pair to pair.

        Raises ContactError for a part that does not converge."""
        for start, end in pairwise(drives):
            state = self._halved(state, step / (len(drives) - 1), start, end, DEEPEST)
        return state

    def _halved(
        self, state: Carried, step: float, start: list[float], end: list[float], deepest: int
    ) -> Carried:
        try:
            return self._one(state, step, *end)
        except ContactError:
            if not deepest:
                raise
        middle = [(a + b) / 2 for a, b in zip(start, end, strict=True)]
        first = self._halved(state, step / 2, start, middle, deepest - 1)
        return self._halved(first, step / 2, middle, end, deepest - 1)

    def _one(self, state: Carried, step: float, grip: float, load: float) -> Carried:
        keeps = self.tau / (self.tau + step)
        if step not in self.scaled:
            whole = (1 - keeps) * self.skin.compliance, (1 - keeps) * self.skin.free
            tag = np.float64(keeps).tobytes()
            self.scaled[step] = replace(self.skin, compliance=whole[0], free=whole[1], tag=tag)
        at_once = self.scaled[step]
        skin = replace(at_once, free=at_once.free + keeps * state.moved)
        travel = state.travel + step * (state.speed + step * state.acceleration / 2)
        contact = solve_contact(skin, state.contact, Drive(grip, travel=travel), self.cone)
        force = contact.force
        moved = skin.compliance @ force + skin.free
        films = (1 - keeps) * (self.films + self.strips @ force) + keeps * state.films
        acceleration = (load - float(contact.tangential.sum())) / self.mass
        speed = state.speed + step * (state.acceleration + acceleration) / 2
        touches = contact.touches
        slid = contact.slipped[touches]
        slide = state.slide
        if slid.size and bool((contact.slips | ~touches).all()):
            # the points lag behind the plate
            slide -= float(slid[np.argmin(np.abs(slid))])
        return Carried(contact, moved, films, travel, speed, acceleration, slide)


def carrier(scene: Scene, on: MarchSetup, level: Level) -> Carrier:
    """Return the scene's skin in small strain on a mesh, with half of the object; nothing touches yet."""
    assert on.piece is not None
    mesh = meshed_pad(on.piece, level, on.meshes)
    pad = scene.law.marched(on.piece, mesh, level.order, bool(scene.readout.ridges), ())
    assert isinstance(pad, CondensedPad)
    whole, still = pad.pad, np.zeros((pad.pad.strips.shape[0], 3))
    start = Carried(at_rest(whole.gap.size), np.zeros(2 * whole.gap.size), still)
    return _carrier(scene, whole.ridge, pad.skin, still, whole.strips, start, whole.unknowns)


def _carrier(
    scene: Scene,
    ridge: Index,
    skin: Compliance,
    films: Array,
    strips: Array,
    start: Carried,
    unknowns: int,
) -> Carrier:
    """A skin with the scene's object, friction and relaxation."""
    assert scene.grip is not None
    relaxing = [part for part in scene.parts.values() if isinstance(part, Viscosity)]
    tau = relaxing[0].retardation_time if relaxing else None
    mass, cone = TONNE * scene.grip.mass / FINGERS, scene.cone or FRICTIONLESS
    whole = mass, cone, RETARDATION if tau is None else tau
    return Carrier(ridge, skin, films, strips, start, unknowns, *whole)


class PressedSkin:
    """A scene's skin at finite strain, pressed harder and harder; on the coarsest mesh."""

    def __init__(self, scene: Scene) -> None:
        assert scene.grip is not None
        self.scene, self.share = scene, Share(scene.cone or FRICTIONLESS)
        finite = Scene(
            name=scene.name,
            skin=scene.design,
            history=scene.grip.plan(),  # type: ignore[arg-type]
            effects={**{name: scene.effects[name] for name in PRESSED if name in scene.effects}, **CHOSEN},
            readout={"ridges": scene.readout.ridges},  # type: ignore[arg-type]
        )
        piece, films = piece_for(finite, {}), bool(scene.readout.ridges)
        assert piece is not None
        mesh = meshed_pad(piece, LEVELS[0], {})
        pad = finite.law.marched(piece, mesh, LEVELS[0].order, films, ())
        assert isinstance(pad, ChosenPad)
        self.pad, self.state, self.grip = pad, pad.start(), 0.0

    @one_blas_thread()
    def at(self, grip: float) -> Carrier:
        """Return the skin as it is about its equilibrium under a grip, N, larger than the last. Raises
        ContactError where there is none nearby."""
        for part in np.linspace(self.grip, grip, PRESSES + 1)[1:].tolist():
            drives = Drive(self.grip, travel=0.0), Drive(part, travel=0.0)
            self.state, self.grip = self.pad.advanced(self.state, Step(0.0, 1.0, *drives), self.share), part
        self.state = self.pad.chosen(self.state, Drive(grip, travel=0.0), self.share)
        tangent = self.state.tangent
        if tangent.cut:
            raise ContactError(tangent.cut)
        films = tangent.films - tangent.per_force @ tangent.force
        start = Carried(tangent.state.contact, tangent.place, tangent.films)
        pad, unknowns = self.pad.pad, self.pad.discretisation.unknowns
        return _carrier(self.scene, pad.ridge, tangent.skin, films, tangent.per_force, start, unknowns)
