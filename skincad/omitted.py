"""What a scene leaves out, and about how much that would change: cheap indicators from numbers at hand."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from skincad.catalog import silicone
from skincad.march import March
from skincad.scene import Scene

PER_STRAIN = 0.9  # change of a ridge's share by strain: mechanics/left_out.py, under normal force alone
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
    known = {"finite_strain": _finite_strain, "inertia": _inertia, "film": _film}
    entries = [
        entry for name, look in known.items() if name not in scene.effects for entry in look(scene, found)
    ]
    return sorted(entries, key=lambda entry: -entry.change)


def _finite_strain(scene: Scene, found: March) -> Iterator[Omitted]:
    """By the pad's nominal shear and squeeze: travel and approach by its height."""
    design = scene.design
    height = design.skin.thickness + design.ridge.height
    travel, approach = np.abs(found.column("travel")).max(), np.abs(found.column("approach")).max()
    strain = float(max(travel, approach)) / height
    yield Omitted("finite_strain", f"nominal strain {strain:.2g}", min(1.0, PER_STRAIN * strain))


def _inertia(scene: Scene, found: March) -> Iterator[Omitted]:
    """By the shortest ramp against the slowest mode of the pad.

    That is the shear wave's quarter length, f = sqrt(G / rho) / (4 h): a bonded layer, free above. A ramp of
    t leaves a vibration of at most 1 / (pi f t) of its height. Clough and Penzien,
    Dynamics of Structures, sec. 5.3.
    """
    stuff, design, history = silicone(scene.design.material), scene.design, scene.history
    shear = 1e6 * stuff.young_modulus.value / (2 * (1 + stuff.poisson_ratio))
    height = 1e-3 * (design.skin.thickness + design.ridge.height)
    mode = math.sqrt(shear / stuff.density) / (4 * height)
    across = history.tangential_force_N or history.displacement_mm or []
    loads = zip(history.time_s, history.normal_force_N, across, strict=True)
    ramps = [b[0] - a[0] for a, b in pairwise(loads) if a[1:] != b[1:] and a[0] < found.time[-1]]
    if ramps:
        text = f"fastest ramp {min(ramps):.3g} s, slowest mode about {mode:.3g} Hz"
        yield Omitted("inertia", text, min(1.0, 1 / (math.pi * mode * min(ramps))))


def _film(scene: Scene, found: March) -> Iterator[Omitted]:  # noqa: ARG001
    """By the film's stiffness across a ridge against the silicone's: E t of both strips by E w."""
    design = scene.design
    if design.film is not None:
        soft = silicone(design.material).young_modulus.value * design.ridge.root_width
        ratio = 2 * design.film.young_modulus * design.film.thickness / soft
        text = f"films' stiffness {ratio:.2g} of the ridge's"
        yield Omitted("film", text, ratio / (1 + ratio))
