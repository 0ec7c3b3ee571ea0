"""Where the models of small strain end: ridges crushed or buckled, a plate too steep."""

from __future__ import annotations

import math

from skincad.catalog import silicone
from skincad.design import Design
from skincad.errors import InputError
from skincad.mechanics.plate import steepest
from skincad.mechanics.problem import Answer

STEEPEST = 0.35  # slope of the plate; half its square, 6 %, is what vertical contact leaves out
LARGEST_STRAIN = 0.3  # nominal strain of a ridge where all touch, beyond which there is no verdict
SMALL_STRAIN = 0.1  # nominal strain of a ridge up to which small strain is meant
STUB = 2.0  # heights in widths up to which a ridge is no column


def plane_modulus(design: Design) -> float:
    """Return E / (1 - nu^2) of a design's silicone, MPa."""
    stuff = silicone(design.material)
    return stuff.young_modulus.value / (1 - stuff.poisson_ratio**2)


def ridge_strain(design: Design, found: Answer) -> float:
    """Return the nominal strain of the most loaded ridge: force over E' times its mean width and length."""
    width = (design.ridge.root_width + design.ridge.tip_width) / 2
    largest = max(f.value or 0.0 for f in found.ridge_force)
    return largest / (plane_modulus(design) * width * design.skin.length)


def buckling_force(design: Design) -> float:
    """Return the force, N, at which a slender ridge buckles: a column clamped at its root, free at its tip.

    pi^2 E' I / (4 h^2) with I = L w^3 / 12, w the mean width; a stub no higher than `STUB` widths gives way
    otherwise, infinite. Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., sec. 2.2.
    """
    ridge = design.ridge
    width = (ridge.root_width + ridge.tip_width) / 2
    if ridge.height <= STUB * width:
        return math.inf
    inertia = design.skin.length * width**3 / 12
    return math.pi**2 * plane_modulus(design) * inertia / (4 * ridge.height**2)


def beyond_small_strain(design: Design, force: float, found: Answer) -> str:
    """Why the verdict lies beyond the model's range, or "": judged where all ridges begin to touch."""
    threshold = found.all_touch_force.value
    at = 1.0 if threshold is None else min(1.0, threshold / force)
    strain = ridge_strain(design, found) * at
    if strain > LARGEST_STRAIN:
        return f"the ridges' nominal strain is {strain:.2g}, the model's range ends at {LARGEST_STRAIN:g}"
    largest, critical = max(f.value or 0.0 for f in found.ridge_force) * at, buckling_force(design)
    if largest > critical:
        return f"a ridge buckles at {critical:.3g} N and would carry {largest:.3g} N"
    return ""


def strain_warnings(design: Design, found: Answer) -> tuple[str, ...]:
    """Return a warning where the nominal strain is no small one."""
    strain = ridge_strain(design, found)
    if strain <= SMALL_STRAIN:
        return ()
    return (f"nominal ridge strain {strain:.2g} is beyond the small-strain range ({SMALL_STRAIN:g})",)


def slope_warnings(design: Design) -> tuple[str, ...]:
    """Say what a shaped plate's slopes leave out; raise InputError where they are too steep."""
    plate = design.contact.plate
    slope = steepest(plate, design.skin.width / 2)
    if slope > STEEPEST:
        raise InputError(
            "contact.plate",
            f"must not slope by more than {STEEPEST:g} within the skin (contact is taken as vertical)",
            slope,
            "take a larger radius",
        )
    if slope == 0.0:
        return ()
    return (f"contact is taken as vertical: at the plate's slopes up to {slope:.2g}, {slope**2 / 2:.1%} off",)
