"""What a scene leaves out, and about how much that would change: cheap indicators from numbers at hand."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skincad.inputs.catalog import silicone
from skincad.mechanics.dynamics.reference import shear_frequency
from skincad.scenes.march import March
from skincad.scenes.scene import Scene

# largest change by strain, measured: 3.6 to 8.8 in 14 scenes marched both ways, 3 to 9 ridges, 0.007 to 0.44
# N a ridge, friction 0.2 and 0.5, films bonded and none; tests/effects/test_finite_strain.py repeats two
PER_STRAIN = 5.0
PER_RAMP = 0.4  # measured 0.16 to 0.82 on ramps of 0.5 to 5 ms, plates of 0.1 and 0.4 of the skin's mass
MATTERS = 0.1  # relative; a larger change is warned of


@dataclass(frozen=True)
class Omitted:
    """An effect left out, what points to it, and the relative change of the differential stress that it may
    bring; `calibrated` says whether that was held against a run with the effect."""

    effect: str
    indicator: str
    change: float
    calibrated: bool = False

    def as_json(self) -> dict[str, Any]:
        """Return the entry under the contract's keys."""
        return {
            "effect": self.effect,
            "indicator": self.indicator,
            "estimated_change": self.change,
            "calibrated": self.calibrated,
        }

    @property
    def warning(self) -> str:
        """What a scene that leaves it out is warned of."""
        how = "" if self.calibrated else ", an uncalibrated estimate"
        return f"{self.effect} is left out: {self.indicator}; it may change signals by {self.change:.0%}{how}"


def omitted(scene: Scene, found: March) -> list[Omitted]:
    """Return the effects that the scene leaves out, the one that matters most first."""
    known = {"finite_strain": _finite_strain, "inertia": _inertia, "film": _film, "free_ends": _free_ends}
    entries = [
        entry for name, look in known.items() if name not in scene.effects for entry in look(scene, found)
    ]
    return sorted(entries, key=lambda entry: -entry.change)


def _finite_strain(scene: Scene, found: March) -> Iterator[Omitted]:
    """By the pad's nominal shear and squeeze, which counts twice: travel and approach by its height.

    The squeeze counts twice as the normal force may add to a ridge's bending by its lean: a reading of the
    runs, not proven.
    """
    design = scene.design
    height = design.skin.thickness + design.ridge.height
    travel, approach = np.abs(found.column("travel")).max(), np.abs(found.column("approach")).max()
    strain = float(travel + 2 * approach) / height
    yield Omitted("finite_strain", f"nominal strain {strain:.2g}", min(1.0, PER_STRAIN * strain), True)


def _inertia(scene: Scene, found: March) -> Iterator[Omitted]:
    """By each ramp's share of its load, and its length against the slowest mode of the pad.

    That is the shear wave's quarter length, f = sqrt(G / rho) / (4 h): a bonded layer, free above. A ramp of
    t leaves a vibration of at most 1 / (pi f t) of its height. Clough and Penzien, Dynamics of Structures,
    sec. 5.3. PER_RAMP is for plates up to half the skin's mass; heavier ones lower the mode: it is a floor.
    """
    stuff, design, history = silicone(scene.design.material), scene.design, scene.history
    shear = stuff.young_modulus.value / (2 * (1 + stuff.poisson_ratio))
    mode = shear_frequency(shear, stuff.density, design.skin.thickness + design.ridge.height)
    across = history.tangential_force_N or history.displacement_mm or []
    changes = []
    for loads in (history.normal_force_N, across):
        largest = max(map(abs, loads), default=0.0)
        for (start, before), (end, after) in pairwise(zip(history.time_s, loads, strict=True)):
            if after != before and start < found.time[-1]:
                slow = math.pi * mode * (end - start)
                changes.append((abs(after - before) / largest * min(1.0, 1 / slow), end - start))
    if changes:
        change, ramp = max(changes)
        text = f"a ramp of {ramp:.3g} s, slowest mode about {mode:.3g} Hz"
        yield Omitted("inertia", text, PER_RAMP * change, True)


def _film(scene: Scene, found: March) -> Iterator[Omitted]:  # noqa: ARG001
    """By how slender and how tilted the strips are, as far as they are stiffer than the ridge, E t by E w.

    The stress across a thin strip is nearly the silicone's in its place; a tilted one bears load along it.
    Press and pull on five designs with strips along the ridge's axis: 1.1 to 8 times the change with the film
    (0.017 to 0.20); yamada-2002 tilted by 20 and 45 degrees: 1.05 and 2.2 times (1.28 and 0.62).
    """
    design = scene.design
    if design.film is not None and design.slot is not None:
        soft = silicone(design.material).young_modulus.value * design.ridge.root_width
        ratio = 2 * design.film.young_modulus * design.film.thickness / soft
        blunt = 1.3 * design.film.thickness / design.slot.depth
        leaning = 1.2 * min(
            1.0, abs(math.sin(2 * math.radians(design.slot.tilt))) / math.sin(math.radians(40))
        )
        text = f"films' stiffness {ratio:.2g} of the ridge's, tilt {design.slot.tilt:g} deg"
        yield Omitted("film", text, (blunt + leaning) * ratio / (1 + ratio), calibrated=True)


def _free_ends(scene: Scene, found: March) -> Iterator[Omitted]:  # noqa: ARG001
    """By the pad's width against its length, as mechanics/left_out.py has it.

    Press and pull with and without the effect on yamada-2002 (6, 12, 24 mm long; tilted strips), lab-bench
    and cast-in: 1.03 to 5 times the change (0.026 to 0.097); on few ridges, which share the force evenly all
    the same, a hundred times. What the effect itself leaves out is not in it.
    """
    slender = scene.design.skin.width / scene.design.skin.length
    reach = min(math.sqrt(slender), 1.5 * slender)
    text = f"width {slender:.2g} of the length"
    yield Omitted("free_ends", text, 0.105 * reach, calibrated=True)
