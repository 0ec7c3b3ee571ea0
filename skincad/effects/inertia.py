"""Masses of skin and plate, by the generalised-alpha method.

The plate is a rigid body: the history's forces act on it, and the skin feels them less what moves its mass.
It may leave the skin, and gross slip does not end the march. Range: small strain; steps well below the
periods 2 pi / w that are to be seen, which they lengthen by about (w dt)^2 / 12. The contact points bear no
mass, so that they neither bounce nor chatter, and impacts leave order 2. Points that slide on and on flutter
where nothing viscous damps them, the more the smaller the steps; as Coulomb sliding of an elastic body is ill
posed (Renardy, J. Elasticity 27 (1992) 281), that is no surprise, but no other method was tried. So name
[effects.viscosity] too. With it a pad of three ridges that is
dragged at 0.8 m/s keeps its energy to 3e-4 of the work at 2e-5 s and to 1e-5 at 2e-6 s; without it to 5e-3 at
1e-5 s and 2e-2 at 5e-6 s. Chung and Hulbert, J. Appl. Mech. 60 (1993) 371. Reference cases: a clamped layer's
frequency, an oscillator with friction, a plate that strikes a bar (tests/mechanics/dynamics/test_steps.py).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import ClassVar

import numpy as np

from skincad.base.tables import quantity
from skincad.effects.kinds import MASS, RATE, LeftOutEffect, SceneOutline, Share, Step, Term

CALIBRATED = (
    1.4  # of a plate that forces move; fitted to 46 random scenes: ridges also slip and share the load again
)
WITHIN, ROUGHLY = 4.0, 7.0  # the second where nothing is pulled, or the plate is driven


class Inertia(Term):
    """Masses of skin and plate; the plate's is the scene's plate.mass."""

    asks: ClassVar[frozenset[str]] = frozenset({MASS})

    spectral_radius: float = quantity(
        "1", "share of the highest modes that a step keeps; 1 damps nothing", ge=0.0, le=1.0, default=0.8
    )

    def share(self, step: Step) -> Share:  # noqa: ARG002
        """Return how the highest modes are damped; the same at every step."""
        return Share(damped=self.spectral_radius)

    def remarks(self, needs: frozenset[str]) -> Iterator[str]:
        """Warn of masses that nothing damps."""
        if RATE not in needs:
            yield "nothing damps the masses: points that slide may flutter; add [effects.viscosity]"

    @staticmethod
    def left_out(outline: SceneOutline) -> LeftOutEffect | None:
        """Return by how much a plate as heavy as the skin would ring after the history's corners
        (mechanics/dynamics/ringing.py). Lighter plates change about as much, heavier ones more.

        None where no load changes.
        """
        from skincad.mechanics.dynamics.ringing import MasslessRun, plate_ringing, skin_mass

        path, (down, pull) = outline.path, outline.loads
        mass = skin_mass(outline.design)
        springs = MasslessRun(
            path.time, path.pressed.sum(axis=1), path.pulled.sum(axis=1), path.approach, path.travel
        )
        corners = np.array(outline.time_s)
        ringing = plate_ringing(springs, corners, (np.array(down), np.array(pull)), outline.driven, mass)
        if ringing is None:
            return None
        change = ringing.signals(path.pressed, path.pulled, path.per_force(), outline.friction)
        text = f"a plate of {mass:.2g} g, as heavy as the skin, would swing in {1e3 * ringing.period:.2g} ms"
        estimate = (1.0 if outline.driven else CALIBRATED) * change / float(np.abs(path.signal).max())
        within = WITHIN if outline.pulls and not outline.driven else ROUGHLY
        return LeftOutEffect("inertia", text, estimate, calibrated=True, within=within)
