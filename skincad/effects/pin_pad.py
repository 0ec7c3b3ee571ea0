"""Pins in a scene: the reduced model of pins with friction at each tip (mechanics/contact/tips.py).

Range: small strain, quasi-static, Coulomb's friction with one coefficient; a tip sways by less than SWAYS of
its pin's height, and a flat one is pressed all over. A tip is one point: parts of its contact slip before all
of it does, which makes Mindlin's compliance up to half larger. What that changes is the error that a mesh has
elsewhere. References: pins that don't feel each other, in closed form, and solid pins in three dimensions
(tests/effects/test_pin_pad.py, bench/pins.py).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache, partial

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.effects.kinds import (
    FRICTIONLESS,
    Discretisation,
    LeftOutEffect,
    Observables,
    PlatePath,
    Share,
    Step,
)
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.contact.frictional import in_halves, joined
from skincad.mechanics.contact.state import Drive
from skincad.mechanics.contact.tips import SWAY, Tips, TipState, advance, unloaded
from skincad.mechanics.models import reduced
from skincad.mechanics.problem import ContactError
from skincad.mechanics.validity import crown_radius, limits
from skincad.shape.skin import skin_of

# Of a pin's height; a cantilever is 13 % stiffer then: Bisshopp and Drucker, Q. Appl. Math. 3 (1945) 272
SWAYS = 0.5
STIFFENS = 0.6  # that, by the square of what it sways
# By its strain, how much stiffer a pressed pin bends: a neo-Hookean column that is shorter, thicker, and of
# another tangent modulus, (1 - e) (1 + 2 e) / (1 - e)^3 to first order
FIRMER = 4.0
STRAINED = 2.0  # what is left of that, by its strain; assumption: 1.5 on the pin of the tests
STICKING, SLIDING = 1.0, 1.5  # of Mindlin's compliance: where all of a contact sticks, and where all slips
MOST = 600  # pins: of more the dense equations take over 1 s a step
DEEPEST = 4  # halvings of a step


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
            sways = self.sways(np.hypot(after.tangential, after.sideways), after.normal)
            if sways.max() > SWAYS:
                pin, most = int(sways.argmax()) + 1, f"{SWAYS:.0%} of its height"
                raise ContactError(f"pin {pin} sways by more than {most}: the model's range ends there")
            lifted = (
                np.hypot(after.tangential, after.sideways) * self.lever
                > np.maximum(after.normal, 0.0) * self.kern
            )
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
        return np.asarray(pull * gives / self.height)

    def reading(self, before: TipState, state: TipState) -> Observables:  # noqa: ARG002
        """Return the observables of a state."""
        return Observables.of(state, np.zeros((0, 3)), state.elastic, state.dissipated)

    def fault(self, state: TipState) -> str | None:  # noqa: ARG002
        """None: pins have no mesh that could collide."""
        return None


def pin_pad(design: Design, creep: float = STICKING) -> PinPad:
    """Return a design's pins to be marched; `creep` as in `Tips`. Raises InputError for too many."""
    pad = _sticking(design)
    return replace(pad, tips=replace(pad.tips, creep=creep))


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
    return PinPad(
        tips=Tips(
            gap=model.gap,
            curve=model.alone,
            compliance=compliance,
            wide=float(np.cbrt(0.75 * radius * (1 - poisson**2) / young)),
            shear=(2 - poisson) * (1 + poisson) / (4 * young),
            soften=compliance.diagonal()[:n] * (SWAY / height - (0.0 if flat else radius) * turn**2)
            - FIRMER / limits(design).squeeze,
            pressed=partial(reduced.pressed, model),
        ),
        height=height,
        lever=np.abs(across[:, 0, 1] / across[:, 1, 1]) if flat else np.zeros(n),
        area=np.full(n, math.pi * skin.profile.tip_width**2 / 4),
    )


def left_out(design: Design, path: PlatePath) -> list[LeftOutEffect]:
    """Return what a march of pins leaves out: the base's edges and what else the reduced model misses, and
    finite strain."""
    pad, ends = pin_pad(design), limits(design)
    sways = float(pad.sways(np.abs(path.pulled), path.pressed).max(initial=0.0))
    strain = ends.strain(float(path.pressed.max(initial=0.0)))
    edges = reduced.further(design) * reduced.PIN_ERRORS.share
    words = f"pins sway by {sways:.2g} of their height, and are strained by {strain:.2g}"
    return [
        LeftOutEffect("free_ends", "of the base, whose sides bulge", edges),
        LeftOutEffect("finite_strain", words, STIFFENS * sways**2 + STRAINED * strain),
    ]
