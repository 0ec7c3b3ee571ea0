"""A condensed pad under its plate: the gaps to a plate of any shape, and where the plate then is."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from skincad.base.arrays import Array
from skincad.mechanics.bodies.elements import ContactStiffness
from skincad.mechanics.contact.frictionless import Flexibility
from skincad.mechanics.contact.threshold import Ridges
from skincad.mechanics.plate import rise
from skincad.mechanics.problem import Pad


def seen_by_plate(pad: Pad, system: ContactStiffness, flexibility: Flexibility, unit: float) -> Ridges:
    """Return the contact points as the pad's plate sees them; `unit` is the pad's, mm."""
    if pad.plate.shape == "flat":
        return Ridges.of(system, flexibility, pad.top / unit)
    return Ridges.of(system, flexibility, pad.top / unit, lambda x: rise(pad.plate, x * unit) / unit)


def height_above(
    pad: Pad, ridges: Ridges, system: ContactStiffness, approach: float, unit: float
) -> Callable[[Array], Array]:
    """Return the plate's height over x, in units, at an approach; gaps count from the first touch.

    Of a measured part, whose crests are moved and whose mesh is not, as over the ridge that it is closest to.
    """
    x, z = system.nodes.position.T
    first = float((z + ridges.gap - rise(pad.plate, x * unit) / unit).min())
    return lambda at: np.asarray(first - approach + rise(pad.plate, at * unit) / unit)
