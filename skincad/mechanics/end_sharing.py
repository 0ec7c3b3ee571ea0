"""By how much a pad's free ends move normal force from ridge to ridge, in closed form.

A pad modelled as endless along y carries nu times its stress in that direction. Free ends release it over
about the base's thickness T from either end. So ridge i sinks by A_ij more per N on ridge j. A_ij scales with
nu^2 / E times T over the length L, and decays with the distance of the ridges over T:

    A_ij = reach nu^2 T / (E L^2) exp(-fall |x_i - x_j| / T).

Bonded strips run along y and hold the ridges there, so that less than half is left. The four constants were
read off mechanics/tiers/ends.py's solids of six random pads, three and five ridges, T 0.32 to 0.9 of the
width, 1.2 to 3 times as long as wide: the middle ridge to 15 % with strips, to 25 % without.
"""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.tiers.winkler import ridge_stiffness
from skincad.shape.skin import skin_of

BONDED_STRIPS, NO_BONDED_STRIPS = (1.36, 1.2), (3.2, 1.5)  # (reach, fall)


def end_compliance(design: Design) -> Array:
    """Return the extra sinking of ridge i, mm, per N on ridge j `(ridges, ridges)`."""
    material, skin = silicone(design), design.skin
    at = np.arange(skin_of(design).count) * skin_of(design).pitch
    distance = np.abs(at[:, None] - at) / skin.thickness
    reach, fall = BONDED_STRIPS if design.film_state == "bonded" else NO_BONDED_STRIPS
    ends = (
        reach * material.poisson_ratio**2 * skin.thickness / (material.young_modulus.value * skin.length**2)
    )
    return np.asarray(ends * np.exp(-fall * distance))


def force_changes(design: Design, forces: Array) -> Array:
    """Return the changes of normal forces `forces` `(n, ridges)` N by free ends; they sum to 0 at each step.

    Each touching ridge is the Winkler tier's spring. It carries less by its stiffness times the extra sinking
    beyond the mean of the touching ridges.
    """
    touching = forces > 0
    sunk = forces @ end_compliance(design)
    mean = (sunk * touching).sum(axis=1) / np.maximum(touching.sum(axis=1), 1)
    return np.asarray(np.where(touching, ridge_stiffness(design) * (mean[:, None] - sunk), 0.0))
