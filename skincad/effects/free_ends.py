"""The pad's finite length: its ends bulge freely, so it is softer than an endless one.

Range: small strain, quasi-static. What changes is how far ridges go down under normal forces, by ridge, from
a coarse solid (mechanics/models/corrected.py). Left out: shear in three dimensions, how pressure and slip
vary along y, and that near its ends a film is stressed otherwise; a film's stress follows the changed forces
as in plane strain. Reference: the corrected model's approach and shares (tests/effects/test_free_ends.py).

By how much free ends move normal force from ridge to ridge, in closed form, for what is left out. A pad
modelled as endless along y carries nu times its stress in that direction. Free ends release it over about the
base's thickness T from either end. So ridge i sinks by A_ij more per N on ridge j. A_ij scales with nu^2 / E
times T over the length L, and decays with the distance of the ridges over T:

    A_ij = reach nu^2 T / (E L^2) exp(-fall |x_i - x_j| / T).

Bonded strips run along y and hold the ridges there, so that less than half is left. The four constants were
read off the corrected model's solids of six random pads (three and five ridges, T 0.32 to 0.9 of the width,
1.2 to 3 times as long as wide): the middle ridge to 15 % with strips, to 25 % without.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.effects.kinds import LeftOutEffect, PadChange, SceneOutline
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.models.winkler import ridge_stiffness
from skincad.mechanics.problem import Pad
from skincad.mechanics.validity import base_softness
from skincad.shape.skin import skin_of

BONDED_STRIPS, NO_BONDED_STRIPS = (1.36, 1.2), (3.2, 1.5)  # (reach, fall)
SLIPPING = 6  # assumption, of 1, 3 and 6 the one nearest to 29 random scenes
CALIBRATED = 1.5  # by the same: Winkler's springs know nothing of their neighbours, which yield with them
WITHIN, ROUGHLY = 2.5, 10.0  # the second where nothing is pulled, or the change is less than SMALL
SMALL, LEAST = 0.01, 0.001
TINY = 1e-12  # N


class FreeEnds(PadChange):
    """Free ends at y = -length / 2 and length / 2."""

    condenses: ClassVar[bool] = True

    def check(self, design: Design) -> None:
        """Raise InputError for a doubly curved skin."""
        if skin_of(design).body == "bent":
            raise InputError("", "needs a skin that is straight along y", design.skin.radius_y)

    def changed(self, pad: Pad, design: Design) -> Pad:
        """Return the pad with what its ends add."""
        from skincad.mechanics.models.corrected import added_compliance

        return replace(pad, ends=tuple(map(tuple, added_compliance(design).tolist())))

    @staticmethod
    def left_out(outline: SceneOutline) -> LeftOutEffect | None:
        """Return by what the ends move from ridge to ridge (`force_changes`).

        A ridge's signal follows its normal force as it has in the march; and where all of it slips, its pull
        too, which friction bounds then. As points begin to slip the pull follows by the share of them to the
        power of SLIPPING. Below LEAST the two are not separated. None without a normal force.
        """
        path = outline.path
        if outline.ridge_normal <= 0:
            return None
        shift, (down, pull) = np.abs(force_changes(outline.design, path.pressed)), path.per_force()
        friction = path.pulled / np.maximum(path.pressed, TINY)
        change = shift * np.abs(down + pull * path.slips**SLIPPING * friction)
        slender = outline.design.skin.width / outline.design.skin.length
        part = float(shift.max()) / outline.ridge_normal
        text = f"width {slender:.2g} of the length, and {part:.1%} of a ridge's normal force goes elsewhere"
        if skin_of(outline.design).bare:
            text = f"width {slender:.2g} of the length: a face sinks deeper, and slips as if it did not"
        estimate = max(CALIBRATED * float(change.max() / np.abs(path.signal).max()), LEAST)
        within = WITHIN if outline.pulls and estimate > SMALL else ROUGHLY
        return LeftOutEffect("free_ends", text, estimate, calibrated=True, within=within)


def end_compliance(design: Design) -> Array:
    """Return the extra sinking of ridge i, mm, per N on ridge j `(ridges, ridges)`."""
    material, skin = silicone(design), design.skin
    at = np.arange(skin_of(design).count) * skin_of(design).pitch
    distance = np.abs(at[:, None] - at) / skin.thickness
    reach, fall = BONDED_STRIPS if design.film_state == "bonded" else NO_BONDED_STRIPS
    ends = (
        reach * material.poisson_ratio**2 * skin.thickness * base_softness(design)
        / (material.young_modulus.value * skin.length**2)
    )  # fmt: skip
    return np.asarray(ends * np.exp(-fall * distance))


def force_changes(design: Design, forces: Array) -> Array:
    """Return the changes of normal forces `forces` `(n, ridges)` N by free ends; they sum to 0 at each step.

    Each touching ridge is the Winkler model's spring. It carries less by its stiffness times the extra
    sinking beyond the mean of the touching ridges."""
    touching = forces > 0
    sunk = forces @ end_compliance(design)
    mean = (sunk * touching).sum(axis=1) / np.maximum(touching.sum(axis=1), 1)
    return np.asarray(np.where(touching, ridge_stiffness(design) * (mean[:, None] - sunk), 0.0))
