"""Pins in a scene: the reduced model of pins with friction at each tip (mechanics/contact/tips.py).

Range: quasi-static, Coulomb's friction with one coefficient; a flat tip is pressed all over. In small strain
a tip sways by less than SWAYS of its pin's height. At finite strain each pin is a body of its own
(mechanics/models/pin_body.py) on a base in small strain. Its equilibria are found at the corners of a square
of normal forces and sways around it, where a step leads out of the last one: that step is a chosen one. In
between they are interpolated, and the error of that is the drift. A pin that leans is bent as an upright one.
A tip is one point: parts of its contact slip before all of it does, which makes Mindlin's compliance up to
half larger. What that changes is the error that a mesh has elsewhere. References: pins that don't feel each
other, in closed form, and solid pins in three dimensions (tests/effects/test_pin_pad.py, bench/pins.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.effects.kinds import (
    FRICTIONLESS,
    Discretisation,
    Drift,
    LeftOutEffect,
    Observables,
    PlatePath,
    Share,
    Step,
)
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.contact.frictional import in_halves, joined
from skincad.mechanics.contact.state import Drive, GrossSlip
from skincad.mechanics.contact.tips import SWAY, TINY, Tips, TipState, advance, unloaded
from skincad.mechanics.models import reduced
from skincad.mechanics.models.pin_body import MIXED, BentPins, bent_pins
from skincad.mechanics.problem import ContactError
from skincad.mechanics.validity import crown_radius, limits
from skincad.shape.skin import skin_of

# Of a pin's height; a cantilever is 13 % stiffer then: Bisshopp and Drucker, Q. Appl. Math. 3 (1945) 272
SWAYS = 0.5
STIFFENS = 0.6  # that, by the square of what it sways
# By its strain, how much stiffer a pressed pin bends, of its first stiffness: a neo-Hookean column that is
# shorter, thicker, and of another tangent modulus by 4, (1 - e) (1 + 2 e) / (1 - e)^3, its root by less: the
# median of 19 random pins at finite strain, and what 90 % of them are off (mechanics/models/test_pin_body)
FIRMER = 3.5
STRAINED = 2.0
STICKING, SLIDING = 1.0, 1.5  # of Mindlin's compliance: where all of a contact sticks, and where all slips
UPRIGHT = 1e-4  # rad, of pins that lean by nothing
MOST = 600  # pins: of more the dense equations take over 1 s a step
DEEPEST = 4  # halvings of a step
MOST_SQUARES = 200  # rounds of a step from square to square; the hardest of four loads took 33


@dataclass(frozen=True, eq=False)
class PinPad:
    """Pins to be marched; its states are `TipState`. `height` `(n,)` mm; a pull times its `lever` `(n,)` mm
    is the moment on a flat tip, 0 of others; `area` `(n,)` mm2 of the tips."""

    tips: Tips
    height: Array
    lever: Array
    area: Array

    @property
    def discretisation(self) -> Discretisation:
        """The tips, each by its pin's number, and the unknowns."""
        count = self.height.size
        return Discretisation(np.arange(1, count + 1), self.area, 3 * count + 2)

    def start(self) -> TipState:
        """The unloaded state."""
        return unloaded(self.tips)

    def advanced(self, state: TipState, step: Step, share: Share) -> TipState:
        """Return the converged state at the step's end."""
        coefficient = (share.cone or FRICTIONLESS).static

        def solved(before: TipState, _start: Drive, end: Drive, _share: float) -> TipState:
            after = advance(self.tips, before, end, coefficient)
            pull, normal = np.hypot(after.tangential, after.sideways), np.maximum(after.normal, 0.0)
            sways = self.sways(pull, after.normal)
            if sways.max() > SWAYS and not self.tips.bend:
                pin, most = int(sways.argmax()) + 1, f"{SWAYS:.0%} of its height"
                raise ContactError(f"pin {pin} sways by more than {most}: the model's range ends there")
            # at finite strain the normal force acts beside the foot
            bends = pull + normal * sways if self.tips.bend else pull
            lifted = bends * self.lever > normal * self.kern
            if lifted.any():
                pin = int(lifted.argmax()) + 1
                raise ContactError(f"pin {pin}'s flat tip lifts at one side: the model's range ends there")
            return after

        return in_halves(solved, state, step.before, step.after, joined, DEEPEST)

    @property
    def kern(self) -> float:
        """How far from the middle of a flat tip a force may act that presses all of it, mm."""
        return math.sqrt(float(self.area[0]) / math.pi) / 4

    def sways(self, pull: Array, normal: Array) -> Array:
        """Return how far tips go under pulls and normal forces `(..., n)` N, of the pins' heights."""
        gives = self.tips.compliance.diagonal()[: self.height.size] + self.tips.own(normal)
        bent = self.tips.bending(normal, pull).way if self.tips.bend else 0.0
        return np.asarray((pull * gives + bent) / self.height)

    def reading(self, before: TipState, state: TipState) -> Observables:  # noqa: ARG002
        """Return the observables of a state."""
        tips = np.column_stack([state.tangential, state.sideways, -state.normal])
        return Observables.of(state, np.zeros((0, 3)), state.elastic, state.dissipated, tips=tips)

    def fault(self, state: TipState) -> str | None:  # noqa: ARG002
        """None: pins have no mesh that could collide."""
        return None


class BentState(NamedTuple):
    """A state at finite strain: the `contact`, the squares that the `pins` are in, and whether the step to it
    is a `chosen` one."""

    contact: TipState
    pins: BentPins
    chosen: bool


@dataclass(frozen=True, eq=False)
class BentPad:
    """Pins to be marched at finite strain: the `pad` in small strain, and its `unloaded` pins."""

    pad: PinPad
    unloaded: BentPins

    @property
    def discretisation(self) -> Discretisation:
        """That of the pad in small strain."""
        return self.pad.discretisation

    def start(self) -> BentState:
        """The unloaded state."""
        return BentState(self.pad.start(), self.unloaded, chosen=True)

    def advanced(self, state: BentState, step: Step, share: Share) -> BentState:
        """Return the converged state at the step's end, by way of squares next to those before."""
        pins, limit = state.pins, None
        for _ in range(MOST_SQUARES):
            pad = replace(self.pad, tips=replace(self.pad.tips, bend=pins.bending))
            try:
                contact = pad.advanced(state.contact, step, share)
            except GrossSlip as slip:
                contact, limit = slip.last, slip
            except ContactError:  # as where pins are far beyond their squares, or tip over
                before = state.contact.normal
                loads = before * step.after.normal / max(before.sum(), TINY), 0 * before
                if (further := pins.followed(*loads)) is None:
                    self._stands(pins, *loads)
                    raise
                pins = further
                continue
            loads = contact.normal, np.hypot(contact.tangential, contact.sideways)
            if (further := pins.followed(*loads)) is None:
                break
            pins, limit = further, None
        else:
            raise ContactError(f"pins do not settle at finite strain within {MOST_SQUARES} rounds")
        self._stands(pins, *loads)
        after = BentState(contact, pins, chosen=pins is not state.pins)
        if limit:
            limit.last = after
            raise limit
        return after

    @staticmethod
    def _stands(pins: BentPins, normal: Array, pull: Array) -> None:
        """Raise ContactError for a pin that tips over under these forces `(n,)` N."""
        if (over := pins.tips_over(normal, pull)).any():
            pin = int(over.argmax())
            words = f"under {normal[pin]:.2g} N and a pull of {pull[pin]:.2g} N"
            raise ContactError(f"pin {pin + 1} tips over {words}")

    def reading(self, before: BentState, state: BentState) -> Observables:
        """Return the observables of a state."""
        contact, (pull, sinking) = state.contact, state.pins.off
        borne = np.array([np.hypot(contact.tangential, contact.sideways), contact.normal])
        off = np.array([pull, sinking / state.pins.sinks]) + MIXED * borne
        drift = Drift(np.where(contact.touches, off, 0.0), np.zeros((0, 3)), state.chosen)
        small = self.pad.reading(before.contact, state.contact)
        return replace(small, drift=drift, magnets=state.pins.magnets)

    def fault(self, state: BentState) -> str | None:  # noqa: ARG002
        """None, as of the pad in small strain."""
        return None


def pin_pad(design: Design, creep: float = STICKING) -> PinPad:
    """Return a design's pins to be marched; `creep` as in `Tips`. Raises InputError for too many."""
    pad = _sticking(design)
    return replace(pad, tips=replace(pad.tips, creep=creep))


def bent_pad(design: Design, creep: float = STICKING) -> BentPad:
    """Return a design's pins to be marched at finite strain, as `pin_pad`."""
    pad = pin_pad(design, creep)
    small = replace(pad.tips, soften=np.zeros_like(pad.tips.soften))
    return BentPad(replace(pad, tips=small), bent_pins(reduced.pin_cells(design), pad.height))


@lru_cache(maxsize=2)
def _sticking(design: Design) -> PinPad:
    skin, n = skin_of(design), skin_of(design).count
    if n > MOST:
        raise InputError(
            "skin", f"must have at most {MOST} pins in a scene", n, "take fewer, or a part of it"
        )
    cells, model = reduced.pin_cells(design), reduced.pin_model(design)
    compliance, height = reduced.tip_compliance(design, cells), np.array(skin.heights)
    pressed = np.arange(2 * n, 3 * n)
    compliance[pressed, pressed] -= cells.stiffest.axial
    young, poisson = silicone(design).young_modulus.value, silicone(design).poisson_ratio
    radius, across = crown_radius(design), cells.across
    flat, turn = not math.isfinite(radius), across[:, 0, 1] / across[:, 0, 0]
    crown, gives = 0.0 if flat else radius, compliance.diagonal()[:n]
    softer, back = gives * SWAY / height, crown * (across[:, 1, 1] - turn * across[:, 0, 1])
    return PinPad(
        tips=Tips(
            gap=model.gap,
            curve=model.alone,
            compliance=compliance,
            wide=float(np.cbrt(0.75 * radius * (1 - poisson**2) / young)),
            shear=(2 - poisson) * (1 + poisson) / (4 * young),
            soften=np.array([softer - FIRMER / limits(design).squeeze, gives * crown * turn**2, back]),
            pressed=partial(reduced.pressed, model),
        ),
        height=height,
        lever=np.abs(across[:, 0, 1] / across[:, 1, 1]) if flat else np.zeros(n),
        area=np.full(n, math.pi * skin.profile.tip_width**2 / 4),
    )


def left_out(design: Design, path: PlatePath, *, bent: bool = False) -> list[LeftOutEffect]:
    """Return what a march of pins leaves out: the base's edges and what else the reduced model misses, and
    finite strain; where it has that, `bent`, what pins that lean miss of it, bent as upright ones. A part of
    the normal force pulls at these, and finite strain changes that as much as a pull."""
    pad, ends = pin_pad(design), limits(design)
    if bent:  # small strain may have ended
        pad = replace(pad, tips=replace(pad.tips, soften=np.zeros_like(pad.tips.soften)))
    pulled, pressed = np.abs(path.pulled), path.pressed
    sways = float(pad.sways(pulled, pressed).max(initial=0.0))
    strain = ends.strain(float(pressed.max(initial=0.0)))
    left = STRAINED * strain / float(1 - pad.tips.sway(pressed).max(initial=0.0))  # of what stiffness it has
    edges = LeftOutEffect(
        "free_ends", "of the base, whose sides bulge", reduced.further(design) * reduced.PIN_ERRORS.share
    )
    change, words = STIFFENS * sways**2 + left, f"pins sway by {sways:.2g} of their height"
    if not bent:
        return [edges, LeftOutEffect("finite_strain", f"{words}, and are strained by {strain:.2g}", change)]
    lean = float(np.abs(skin_of(design).leans).max())
    if lean < UPRIGHT:
        return [edges]
    change *= min(1.0, math.sin(lean) * float(pressed.max()) / max(float(pulled.max()), TINY))
    words += f", and lean by up to {math.degrees(lean):.2g} degrees"
    return [edges, LeftOutEffect("finite_strain", words, change)]
