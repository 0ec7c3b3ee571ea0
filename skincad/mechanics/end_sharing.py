"""By how much a pad's free ends move normal force from ridge to ridge, in closed form.

A pad held as endless along y bears nu times its stress in that direction. Free ends take it off, over about
the base's thickness T from either end, so ridge i goes down by A_ij more per N on ridge j: as nu^2 / E times
T over the length L, and the less the farther apart they are, for the base spreads a load over T:

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

HELD, BARE = (1.36, 1.2), (3.2, 1.5)  # reach and fall with bonded strips and without


def softened(design: Design) -> Array:
    """Return by how much more ridge i goes down, mm, per N on ridge j `(ridges, ridges)`."""
    stuff, skin = silicone(design), design.skin
    at = np.arange(design.ridge.count) * design.ridge.spacing
    apart = np.abs(at[:, None] - at) / skin.thickness
    reach, fall = HELD if design.film_state == "bonded" else BARE
    ends = reach * stuff.poisson_ratio**2 * skin.thickness / (stuff.young_modulus.value * skin.length**2)
    return np.asarray(ends * np.exp(-fall * apart))


def moved(design: Design, pressed: Array) -> Array:
    """Return by how much free ends change normal forces `pressed` `(n, ridges)` N, in all 0 at each step.

    Each touching ridge is the Winkler tier's spring: what the ends make it sink more than the mean of those
    that touch, it bears less.
    """
    touching = pressed > 0
    sunk = pressed @ softened(design)
    mean = (sunk * touching).sum(axis=1) / np.maximum(touching.sum(axis=1), 1)
    return np.asarray(np.where(touching, ridge_stiffness(design) * (mean[:, None] - sunk), 0.0))
