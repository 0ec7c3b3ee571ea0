"""The pad's finite length: its ends bulge freely, so it is softer than an endless one.

Range: small strain, quasi-static. What changes is how far ridges go down under normal forces, by ridge, from
a coarse solid (mechanics/models/corrected.py). Left out: shear in three dimensions, how pressure and slip
vary along y, and that near its ends a film is stressed otherwise; a film's stress follows the changed forces
as in plane strain. Reference: the corrected model's approach and shares (tests/effects/test_free_ends.py).
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

import numpy as np

from skincad.base.errors import InputError
from skincad.effects.kinds import LeftOutEffect, PadChange, SceneOutline
from skincad.inputs.design import Design
from skincad.mechanics.problem import Pad

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
        if design.skin.curvature_radius_y is not None:
            raise InputError("", "needs a skin that is straight along y", design.skin.curvature_radius_y)

    def changed(self, pad: Pad, design: Design) -> Pad:
        """Return the pad with what its ends add."""
        from skincad.mechanics.models.corrected import added_compliance

        return replace(pad, ends=tuple(map(tuple, added_compliance(design).tolist())))

    @staticmethod
    def left_out(outline: SceneOutline) -> LeftOutEffect | None:
        """Return by what the ends move from ridge to ridge (mechanics/left_out.py).

        A ridge's signal follows its normal force as it has in the march; and where all of it slips, its pull
        too, which friction bounds then. As points begin to slip the pull follows by the share of them to the
        power of SLIPPING. Below LEAST the two are not separated. None without a normal force.
        """
        from skincad.mechanics.left_out import force_changes

        path = outline.path
        if outline.ridge_normal <= 0:
            return None
        shift, (down, pull) = np.abs(force_changes(outline.design, path.pressed)), path.per_force()
        friction = path.pulled / np.maximum(path.pressed, TINY)
        change = shift * np.abs(down + pull * path.slips**SLIPPING * friction)
        slender = outline.design.skin.width / outline.design.skin.length
        part = float(shift.max()) / outline.ridge_normal
        text = f"width {slender:.2g} of the length, and {part:.1%} of a ridge's normal force goes elsewhere"
        estimate = max(CALIBRATED * float(change.max() / np.abs(path.signal).max()), LEAST)
        within = WITHIN if outline.pulls and estimate > SMALL else ROUGHLY
        return LeftOutEffect("free_ends", text, estimate, calibrated=True, within=within)
