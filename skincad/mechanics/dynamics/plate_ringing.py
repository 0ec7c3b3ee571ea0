"""How a plate with mass rings on a skin, and what of it the ridges feel, from a march without masses.

The skin is a spring along and one down: the march's largest pull over how far it moved the plate, and how far
the plate came by a tenth of the largest normal force, for where contact begins a skin is soft and that is
where the plate gathers speed. FREE_TOP of the skin's mass goes with the plate, which gives a bonded layer its
slowest mode. A driven plate does not ring along: the layer below it does, held on both faces, and meets each
change of speed with sqrt(stiffness mass) N per mm/s, of which 2 / pi is its first mode's.

Range: small strain; of what friction does, that the plate pulls no harder than it holds. Against marches with
masses: bench/table_left_out.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.dynamics.ringing import LOOKS, Ringer, ringer
from skincad.mechanics.validity import mean_width

TONNE = 1e-6  # of a gram
FREE_TOP = 4 / math.pi**2  # of a layer's mass, at its top, gives its quarter wave: sqrt(G / rho) / (4 h)
FIRST_MODE = 2 / math.pi  # of a sawtooth from 1 to -1
SOFT = 0.1  # of the largest normal force
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class MasslessMarch:
    """A march without masses: at `time` `(n,)` s the forces `normal` and `pull`, N, and the plate's
    `approach` and `travel`, mm, `(n,)` each."""

    time: Array
    normal: Array
    pull: Array
    approach: Array
    travel: Array

    def down(self) -> float | None:
        """Return N/mm of a plate that begins to press; None without a normal force."""
        largest = float(self.normal.max())
        if largest <= 0:
            return None
        at = int(np.argmax(self.normal >= SOFT * largest))
        return float(self.normal[at] / self.approach[at]) if self.approach[at] > 0 else None

    def along(self) -> float | None:
        """Return N/mm of the largest pull; None without one."""
        at = int(np.argmax(np.abs(self.pull)))
        stiffness = float(self.pull[at] / self.travel[at]) if self.travel[at] else 0.0
        return stiffness if stiffness > 0 else None


@dataclass(frozen=True, eq=False)
class Rung:
    """At `time` `(k,)` s what masses add to the plate's `normal` force and `pull`, N `(k,)`, on `springs`;
    `period` s is that of the slowest ringing."""

    springs: MasslessMarch
    time: Array
    normal: Array
    pull: Array
    period: float

    def signals(self, pressed: Array, pulled: Array, per_force: Array, friction: float) -> float:
        """Return the largest change of a ridge's signal, in the signal's unit.

        `pressed` and `pulled` `(n, ridges)` N are what the ridges bear without masses, `per_force`
        `(2, ridges)` what of the signal goes with either. The plate cannot pull the skin up, and pulls along
        by no more than `friction` times the normal force. The ridges share both as they do the normal force;
        what they pull each other besides goes with that.
        """
        steps = self.springs.time
        bears, pulls = (np.interp(self.time, steps, of) for of in (self.springs.normal, self.springs.pull))
        normal = np.maximum(bears + self.normal, 0.0)
        more = np.clip(pulls + self.pull, -friction * normal, friction * normal) - pulls
        grown = normal / np.maximum(bears, TINY) - 1
        change = 0.0
        for ridge, (down, across) in enumerate(per_force.T):
            own, pull = (np.interp(self.time, steps, of[:, ridge]) for of in (pressed, pulled))
            share = own / np.maximum(bears, TINY)
            among = pull - share * pulls
            moved = (down * own + across * among) * grown + across * share * more
            change = max(change, float(np.abs(moved)[bears > 0].max(initial=0.0)))
        return change


def rung(
    springs: MasslessMarch, corners: Array, loads: tuple[Array, Array], driven: bool, mass: float
) -> Rung | None:
    """Return how a plate of `mass` g rings on a skin of the same mass under a history of straight lines.

    `loads` `(n,)` at `corners` `(n,)` s are the normal force N and the pull, N, or of a plate that is
    `driven` its travel, mm. None where nothing that the march reached changes.
    """
    skin = plate = TONNE * mass
    swinging = plate + FREE_TOP * skin
    end = float(springs.time[-1])
    reached = corners < end
    down, along = springs.down(), springs.along()
    parts: list[tuple[int, Ringer, float]] = []
    if down and np.any(loads[0]):
        parts.append((0, ringer(down, swinging), plate / swinging))
    if along and np.any(loads[1]) and driven:
        held = ringer(math.pi**2 * along, skin)
        parts.append((1, held, -FIRST_MODE * math.sqrt(along * skin) * held.frequency))
    elif along and np.any(loads[1]):
        parts.append((1, ringer(along, swinging), plate / swinging))
    if not parts:
        return None
    period = max(ring.period for _, ring, _ in parts)
    begun = corners[reached]
    lasts = np.minimum(np.diff(begun, append=end), 2 * period)
    times = begun[:, None] + lasts[:, None] * np.linspace(0, 1, LOOKS)
    felt = np.zeros((2, *times.shape))
    for which, ring, share in parts:
        felt[which] += share * ring.rings(corners, loads[which], times)
    return Rung(springs, times.ravel(), felt[0].ravel(), felt[1].ravel(), period)


def skin_mass(design: Design) -> float:
    """Return what a skin weighs, taken as a flat block and straight-flanked ridges, g."""
    skin = design.skin
    area = skin.width * skin.thickness + sum(design.heights) * mean_width(design)
    return 1e-6 * silicone(design).density * area * skin.length
