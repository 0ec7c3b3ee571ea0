"""Masses of skin and plate, by the generalised-alpha method.

The plate is a rigid body: the history's forces act on it, and the skin feels them less what moves its mass.
It may leave the skin, and gross slip does not end the march. Range: small strain; steps well below the
periods 2 pi / w that are to be seen, which they lengthen by about (w dt)^2 / 12. The contact points bear no
mass, so that they neither bounce nor chatter, and impacts leave order 2. Points that slide on and on flutter
where nothing viscous damps them, the more the smaller the steps; as Coulomb sliding of an elastic body is ill
posed (Renardy, J. Elasticity 27 (1992) 281), that is no surprise, but no other method was tried. So name
[effects.viscosity] too (docs/evidence/scenes.md#masses). Chung and Hulbert, J. Appl. Mech. 60 (1993) 371.
Reference cases: a clamped layer's frequency, an oscillator with friction, a plate that strikes a bar
(tests/mechanics/dynamics/test_steps.py).

What leaving them out changes is told from a march without masses. The skin is a spring along x and one
downwards. The first is the march's largest pull over the plate's travel. The second is a tenth of the largest
normal force over the approach there: a skin is soft where contact begins, and there the plate gathers speed.
FREE_TOP of the skin's mass goes with the plate, which gives a bonded layer its slowest mode. A driven plate
does not ring along: the layer below it does, held on both faces, and meets each change of speed with
sqrt(stiffness mass) N per mm/s, of which 2 / pi is its first mode's. Friction only limits the pull. Compared
with marches with masses in bench/left_out.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from skincad.base.arrays import Array
from skincad.base.tables import quantity
from skincad.effects.kinds import MASS, RATE, LeftOutEffect, PlatePath, SceneOutline, Share, Step, Term
from skincad.mechanics.dynamics.ringing import FREE_TOP, Ringer, ringer, skin_mass

CALIBRATED = 1.4  # of a plate that forces move; fitted: ridges also slip and share the load again
WITHIN, ROUGHLY = 4.0, 7.0  # the second where nothing is pulled, or the plate is driven
TONNE = 1e-6  # of a gram
FIRST_MODE = 2 / math.pi  # of a sawtooth from 1 to -1
FIRST_CONTACT_SHARE = 0.1  # of the largest normal force
SAMPLES_PER_CORNER = 65  # at two periods of ringing after each corner
TINY = 1e-300


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
        """Return by how much a plate as heavy as the skin would ring after the history's corners. Lighter
        plates change about as much, heavier ones more.

        None where no load changes.
        """
        path, (down, pull) = outline.path, outline.loads
        mass, corners = skin_mass(outline.design), np.array(outline.time_s)
        ringing = plate_ringing(path, corners, (np.array(down), np.array(pull)), outline.driven, mass)
        if ringing is None:
            return None
        change = ringing.signals(path, path.per_force(), outline.friction)
        text = f"a plate of {mass:.2g} g, as heavy as the skin, would swing in {1e3 * ringing.period:.2g} ms"
        estimate = (1.0 if outline.driven else CALIBRATED) * change / float(np.abs(path.signal).max())
        within = WITHIN if outline.pulls and not outline.driven else ROUGHLY
        return LeftOutEffect("inertia", text, estimate, calibrated=True, within=within)


@dataclass(frozen=True, eq=False)
class PlateRinging:
    """At `time` `(k,)` s what masses add to the plate's `normal` force and `pull`, N `(k,)`; `period` s is
    that of the slowest ringing."""

    time: Array
    normal: Array
    pull: Array
    period: float

    def signals(self, path: PlatePath, per_force: Array, friction: float) -> float:
        """Return the largest change of a ridge's signal, in the signal's unit.

        `path` is without masses, `per_force` `(2, ridges)` the signal per N of a ridge's normal force and
        pull. The plate cannot pull the skin up, and pulls along by no more than `friction` times the normal
        force. The ridges share both as they do the normal force; what they pull each other besides goes with
        that.
        """
        loads = (path.pressed.sum(axis=1), path.pulled.sum(axis=1))
        bears, pulls = (np.interp(self.time, path.time, of) for of in loads)
        normal = np.maximum(bears + self.normal, 0.0)
        more = np.clip(pulls + self.pull, -friction * normal, friction * normal) - pulls
        grown = normal / np.maximum(bears, TINY) - 1
        change = 0.0
        for ridge, (down, tangential) in enumerate(per_force.T):
            parts = (path.pressed[:, ridge], path.pulled[:, ridge])
            push, pull = (np.interp(self.time, path.time, of) for of in parts)
            share = push / np.maximum(bears, TINY)
            remainder = pull - share * pulls
            moved = (down * push + tangential * remainder) * grown + tangential * share * more
            change = max(change, float(np.abs(moved)[bears > 0].max(initial=0.0)))
        return change


def plate_ringing(
    path: PlatePath, corners: Array, loads: tuple[Array, Array], driven: bool, mass: float
) -> PlateRinging | None:
    """Return how a plate of `mass` g rings on a skin of the same mass under a history of straight lines.

    `path` is that of a march without masses. `loads` `(n,)` at `corners` `(n,)` s are the normal force N and
    the pull, N, or of a plate that is `driven` its travel, mm. None if no load that the march reached
    changes.
    """
    skin = plate = TONNE * mass
    swinging = plate + FREE_TOP * skin
    down, along = _stiffness_down(path), _stiffness_along(path)
    parts: list[tuple[int, Ringer, float]] = []
    if down and np.any(loads[0]):
        parts.append((0, ringer(down, swinging), plate / swinging))
    if along and np.any(loads[1]) and driven:
        layer = ringer(math.pi**2 * along, skin)
        parts.append((1, layer, -FIRST_MODE * math.sqrt(along * skin) * layer.frequency))
    elif along and np.any(loads[1]):
        parts.append((1, ringer(along, swinging), plate / swinging))
    if not parts:
        return None
    period, end = max(ring.period for _, ring, _ in parts), float(path.time[-1])
    starts = corners[corners < end]
    lasts = np.minimum(np.diff(starts, append=end), 2 * period)
    times = starts[:, None] + lasts[:, None] * np.linspace(0, 1, SAMPLES_PER_CORNER)
    felt = np.zeros((2, *times.shape))
    for which, ring, share in parts:
        felt[which] += share * ring.rings(corners, loads[which], times)
    return PlateRinging(times.ravel(), felt[0].ravel(), felt[1].ravel(), period)


def _stiffness_down(path: PlatePath) -> float | None:
    """N/mm of a plate that begins to press; None without a normal force."""
    normal = path.pressed.sum(axis=1)
    largest = float(normal.max())
    if largest <= 0:
        return None
    at = int(np.argmax(normal >= FIRST_CONTACT_SHARE * largest))
    return float(normal[at] / path.approach[at]) if path.approach[at] > 0 else None


def _stiffness_along(path: PlatePath) -> float | None:
    """N/mm of the largest pull; None without one."""
    pull = path.pulled.sum(axis=1)
    at = int(np.argmax(np.abs(pull)))
    stiffness = float(pull[at] / path.travel[at]) if path.travel[at] else 0.0
    return stiffness if stiffness > 0 else None
