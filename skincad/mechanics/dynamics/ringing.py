"""How fast pad and plate ring, and what the ringing changes.

Under a load f(t) of straight lines, x'' + 2 z w x' + w^2 x = w^2 f, x follows f, less what damping makes it
lag, and rings: a corner, where the slope changes by s, adds x'' = s w^2 / w_d exp(-z w t) sin(w_d t) with
w_d = w sqrt(1 - z^2). Clough and Penzien, Dynamics of Structures, sec. 5.3 and 6.1. Reference: the equation
of motion integrated in time (tests/mechanics/dynamics/test_ringing.py).

Ringing of a plate with mass on a skin, and its effect on the ridges, from a run without masses. The skin is a
spring along x and one downwards. The first is the run's largest pull over the plate's travel. The second is a
tenth of the largest normal force over the approach there: a skin is soft where contact begins, and there the
plate gathers speed. FREE_TOP of the skin's mass goes with the plate, which gives a bonded layer its slowest
mode. A driven plate does not ring along: the layer below it does, held on both faces, and meets each change
of speed with sqrt(stiffness mass) N per mm/s, of which 2 / pi is its first mode's.

Range: small strain. Friction only limits the pull. Compared with runs with masses in
bench/left_out.py.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.silicone import Silicone
from skincad.mechanics.validity import mean_width, through_base
from skincad.shape.skin import skin_of


def shear_frequency(shear: float, density: float, height: float) -> float:
    """Return the lowest frequency, Hz, of a layer bonded below and free above, sqrt(G / rho) / (4 h).

    `shear` MPa, `density` kg/m3, `height` mm.
    """
    return math.sqrt(shear / (1e-12 * density)) / (4 * height)


def layer_period(design: Design) -> float:
    """Return the slowest period of a skin as a layer of its thickness and of its mean height, s; ridges
    count with the share of the base that they cover, layers with the time in which a wave runs through."""
    skin, own = skin_of(design), silicone(design)
    ridges = float(np.mean(skin.heights)) * mean_width(design) / skin.pitch

    def part(thickness: float, stuff: Silicone) -> float:
        shear = stuff.young_modulus.value / (2 * (1 + stuff.poisson_ratio))
        return 1 / shear_frequency(shear, stuff.density, thickness)

    return part(ridges, own) + sum(part(*layer) for layer in through_base(design))


RETARDATION = 2.4e-5  # s; assumption, docs/evidence/facts.md#friction-and-motion
MOST_DAMPED = 0.99  # of critical damping; beyond it nothing rings
SAMPLES_PER_CORNER = 65  # at two periods of ringing after each corner


@dataclass(frozen=True)
class Ringer:
    """An angular frequency w, 1/s, and its damping z, relative to the critical one, below 1."""

    frequency: float
    damping: float

    @property
    def period(self) -> float:
        """Time from one swing to the next, s."""
        return 2 * math.pi / (self.frequency * math.sqrt(1 - self.damping**2))

    def rings(self, corners: Array, values: Array, times: Array) -> Array:
        """Return -x'' / w^2, how far x is from a load less its lag, at `times` `(m, k)` s.

        The load is `values` `(n,)` at `corners` `(n,)` s, m at most n, straight in between and constant after
        the last, x at rest until the first. Times of row i follow corner i, and the next one follows them. In
        the unit of `values`.
        """
        slopes = np.diff(values) / np.diff(corners)
        turns = np.diff(slopes, prepend=0.0, append=0.0)[: len(times)]
        swing = self.frequency * complex(-self.damping, math.sqrt(1 - self.damping**2))
        states, now, last = np.zeros(len(times), dtype=complex), 0j, corners[0]
        for i, turn in enumerate(turns):
            now = now * np.exp(swing * (corners[i] - last)) - turn / swing.imag
            states[i], last = now, corners[i]
        return np.asarray((states[:, None] * np.exp(swing * (times - corners[: len(times), None]))).imag)


def ringer(stiffness: float, mass: float) -> Ringer:
    """Return how `mass`, tonne, swings on a spring of silicone, `stiffness` N/mm, damped by the assumed
    retardation time."""
    frequency = math.sqrt(stiffness / mass)
    return Ringer(frequency, min(frequency * RETARDATION / 2, MOST_DAMPED))


TONNE = 1e-6  # of a gram
FREE_TOP = 4 / math.pi**2  # of a layer's mass, at its top, gives its quarter wave: sqrt(G / rho) / (4 h)
FIRST_MODE = 2 / math.pi  # of a sawtooth from 1 to -1
FIRST_CONTACT_SHARE = 0.1  # of the largest normal force
TINY = 1e-300


@dataclass(frozen=True, eq=False)
class MasslessRun:
    """A run without masses: at `time` `(n,)` s the forces `normal` and `pull`, N, and the plate's
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
        at = int(np.argmax(self.normal >= FIRST_CONTACT_SHARE * largest))
        return float(self.normal[at] / self.approach[at]) if self.approach[at] > 0 else None

    def along(self) -> float | None:
        """Return N/mm of the largest pull; None without one."""
        at = int(np.argmax(np.abs(self.pull)))
        stiffness = float(self.pull[at] / self.travel[at]) if self.travel[at] else 0.0
        return stiffness if stiffness > 0 else None


@dataclass(frozen=True, eq=False)
class PlateRinging:
    """At `time` `(k,)` s what masses add to the plate's `normal` force and `pull`, N `(k,)`, on `springs`;
    `period` s is that of the slowest ringing."""

    springs: MasslessRun
    time: Array
    normal: Array
    pull: Array
    period: float

    def signals(self, ridge_normal: Array, ridge_pull: Array, per_force: Array, friction: float) -> float:
        """Return the largest change of a ridge's signal, in the signal's unit.

        `ridge_normal` and `ridge_pull` `(n, ridges)` N are the ridges' forces without masses, `per_force`
        `(2, ridges)` the signal per N of either. The plate cannot pull the skin up, and pulls along
        by no more than `friction` times the normal force. The ridges share both as they do the normal force;
        what they pull each other besides goes with that.
        """
        steps = self.springs.time
        bears, pulls = (np.interp(self.time, steps, of) for of in (self.springs.normal, self.springs.pull))
        normal = np.maximum(bears + self.normal, 0.0)
        more = np.clip(pulls + self.pull, -friction * normal, friction * normal) - pulls
        grown = normal / np.maximum(bears, TINY) - 1
        change = 0.0
        for ridge, (down, tangential) in enumerate(per_force.T):
            push, pull = (np.interp(self.time, steps, of[:, ridge]) for of in (ridge_normal, ridge_pull))
            share = push / np.maximum(bears, TINY)
            remainder = pull - share * pulls
            moved = (down * push + tangential * remainder) * grown + tangential * share * more
            change = max(change, float(np.abs(moved)[bears > 0].max(initial=0.0)))
        return change


def plate_ringing(
    springs: MasslessRun, corners: Array, loads: tuple[Array, Array], driven: bool, mass: float
) -> PlateRinging | None:
    """Return how a plate of `mass` g rings on a skin of the same mass under a history of straight lines.

    `loads` `(n,)` at `corners` `(n,)` s are the normal force N and the pull, N, or of a plate that is
    `driven` its travel, mm. None if no load that the run reached changes.
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
        layer = ringer(math.pi**2 * along, skin)
        parts.append((1, layer, -FIRST_MODE * math.sqrt(along * skin) * layer.frequency))
    elif along and np.any(loads[1]):
        parts.append((1, ringer(along, swinging), plate / swinging))
    if not parts:
        return None
    period = max(ring.period for _, ring, _ in parts)
    starts = corners[reached]
    lasts = np.minimum(np.diff(starts, append=end), 2 * period)
    times = starts[:, None] + lasts[:, None] * np.linspace(0, 1, SAMPLES_PER_CORNER)
    felt = np.zeros((2, *times.shape))
    for which, ring, share in parts:
        felt[which] += share * ring.rings(corners, loads[which], times)
    return PlateRinging(springs, times.ravel(), felt[0].ravel(), felt[1].ravel(), period)


def skin_mass(design: Design) -> float:
    """Return the mass of a skin, g, taken as a flat block with straight-flanked ridges."""
    skin = design.skin
    area = skin.width * skin.thickness + sum(skin_of(design).heights) * mean_width(design)
    return 1e-6 * silicone(design).density * area * skin.length
