"""The Winkler tier: each ridge a spring of its own, in closed form.

It ranks designs in microseconds. It leaves out that ridges push each other down through the common
base, so against plane strain F9 comes out 25 to 35 % low (FACTS.md), more on thick skins.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from skincad.catalog import silicone
from skincad.design import Design
from skincad.mechanics.plate import rise
from skincad.mechanics.problem import Answer, Request
from skincad.quantities import Estimate
from skincad.stopwatch import Progress

Array = NDArray[np.float64]

# Half-widths against the linear tier, measured over the variants of tests/mechanics/test_winkler.py
THRESHOLD_ERROR = 0.8  # of F9: 25 to 35 % low at usual sizes, 43 % at twice the thickness
APPROACH_ERROR = 0.3  # of the approach
SHARE_ERROR = 0.5  # of the mean share


def ridge_stiffness(design: Design) -> float:
    """Return one ridge's stiffness, N/mm: its part of the base and the ridge itself in series.

    k = L / (n T / (E' W) + h / (E' w)) with E' = E / (1 - nu^2), w the ridge's mean width.
    Johnson, Contact Mechanics, 1985, sec. 4.3 (elastic foundation).
    """
    skin, ridge, stuff = design.skin, design.ridge, silicone(design.material)
    plane = stuff.young_modulus.value / (1 - stuff.poisson_ratio**2)
    base = ridge.count * skin.thickness / (plane * skin.width)
    return skin.length / (base + 2 * ridge.height / (plane * (ridge.root_width + ridge.tip_width)))


def crest_gaps(design: Design) -> Array:
    """Return how far each crest is from the plate when the first one touches, `(ridges,)` mm."""
    radius = design.skin.curvature_radius + design.ridge.height
    lean = np.array([design.lean(i + 1) for i in range(design.ridge.count)])
    gap = 2 * radius * np.sin(lean / 2) ** 2 + rise(design.contact.plate, radius * np.sin(lean))
    return np.asarray(gap - gap.min())


def answer(design: Design, request: Request, progress: Progress | None = None) -> Answer:
    """Return the Winkler verdict on a design; the error is the model's, whatever the tolerance asked."""
    started, force = perf_counter(), request.force
    if progress:
        progress("winkler tier: closed form")
    stiffness, gaps = ridge_stiffness(design), crest_gaps(design)
    threshold = stiffness * float((gaps.max() - gaps).sum())
    order = np.sort(gaps)
    carried = stiffness * (order * np.arange(1, order.size + 1) - np.cumsum(order))
    count = int(np.searchsorted(carried, force, side="left"))
    approach = (force / stiffness + float(order[:count].sum())) / count
    shares = stiffness * np.maximum(approach - gaps, 0.0)
    error = SHARE_ERROR * force / gaps.size
    return Answer(
        int(np.count_nonzero(shares > 0)),
        Estimate(threshold, THRESHOLD_ERROR * threshold, "N"),
        Estimate(approach, APPROACH_ERROR * approach, "mm"),
        tuple(Estimate(float(f), error, "N") for f in shares),
        gaps.size,
        abs(float(shares.sum()) / force - 1),
        {"contact": perf_counter() - started},
        ("winkler tier: ridges are taken as independent springs, slots and film are left out",),
    )
