"""The pad's finite length: its ends bulge freely, so it is softer than an endless one.

Range: small strain, quasi-static. What changes is how far ridges go down under normal forces, by ridge, from
a coarse solid (mechanics/ends.py). Left out: shear in three dimensions, how pressure and slip vary along y,
and that near its ends a film is stressed otherwise; a film's stress follows the changed forces as in plane
strain. Reference: the corrected tier's approach and shares (tests/effects/test_free_ends.py).
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from skincad.base.errors import InputError
from skincad.effects.kinds import PadChange
from skincad.inputs.design import Design
from skincad.mechanics.problem import Pad


class FreeEnds(PadChange):
    """Free ends at y = -length / 2 and length / 2."""

    condenses: ClassVar[bool] = True

    def check(self, design: Design) -> None:
        """Raise InputError for a doubly curved skin."""
        if design.skin.curvature_radius_y is not None:
            raise InputError("", "needs a skin that is straight along y", design.skin.curvature_radius_y)

    def changed(self, pad: Pad, design: Design) -> Pad:
        """Return the pad with what its ends add."""
        from skincad.mechanics.tiers.ends import added_compliance

        return replace(pad, ends=tuple(map(tuple, added_compliance(design).tolist())))
