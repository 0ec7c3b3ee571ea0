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

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import ClassVar

from skincad.base.tables import quantity
from skincad.effects.kinds import MASS, RATE, Share, Step, Term
from skincad.effects.omitted import Omitted, SceneOutline
from skincad.inputs.material import silicone
from skincad.shape.crests import full_height

PER_RAMP = 0.4  # measured 0.16 to 0.82 on ramps of 0.5 to 5 ms, plates of 0.1 and 0.4 of the skin's mass


class Inertia(Term):
    """Masses of skin and plate; the plate's is the scene's plate.mass."""

    asks: ClassVar[frozenset[str]] = frozenset({MASS})

    spectral_radius: float = quantity(
        "1", "share of the highest modes that a step keeps; 1 damps nothing", ge=0.0, le=1.0, default=0.8
    )

    def share(self, step: Step) -> Share:  # noqa: ARG002
        """Return how the highest modes are damped; the same at every step."""
        return Share(damped=self.spectral_radius)

    def remarks(self, asked: frozenset[str]) -> Iterator[str]:
        """Warn of masses that nothing damps."""
        if RATE not in asked:
            yield "nothing damps the masses: points that slide may flutter; add [effects.viscosity]"

    @staticmethod
    def left_out(outline: SceneOutline) -> Omitted | None:
        """Return by each ramp's share of its load, and its length against the slowest mode of the pad.

        That is the shear wave's quarter length, f = sqrt(G / rho) / (4 h): a bonded layer, free above. A
        ramp of t leaves a vibration of at most 1 / (pi f t) of its height. Clough and Penzien, Dynamics of
        Structures, sec. 5.3. PER_RAMP is for plates up to half the skin's mass; heavier ones lower the mode:
        it is a floor.
        """
        from skincad.mechanics.dynamics.reference import shear_frequency

        design, stuff = outline.design, silicone(outline.design)
        shear = stuff.young_modulus.value / (2 * (1 + stuff.poisson_ratio))
        mode = shear_frequency(shear, stuff.density, full_height(design))
        changes = []
        for loads in filter(None, outline.loads):
            largest = max(map(abs, loads))
            for (start, before), (end, after) in pairwise(zip(outline.time_s, loads, strict=True)):
                if after != before and start < outline.end:
                    slow = math.pi * mode * (end - start)
                    changes.append((abs(after - before) / largest * min(1.0, 1 / slow), end - start))
        if not changes:
            return None
        change, ramp = max(changes)
        text = f"a ramp of {ramp:.3g} s, slowest mode about {mode:.3g} Hz"
        return Omitted("inertia", text, PER_RAMP * change, calibrated=True)
