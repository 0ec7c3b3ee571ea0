"""The pad's finite length: its ends bulge freely, so it is softer than an endless one.

Range: small strain, quasi-static. What changes is how far ridges go down under normal forces, by ridge, from
a coarse solid (mechanics/tiers/ends.py). Left out: shear in three dimensions, how pressure and slip vary
along y, and that near its ends a film is stressed otherwise; a film's stress follows the changed forces as
in plane strain. Reference: the corrected tier's approach and shares (tests/effects/test_free_ends.py).
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import ClassVar

from skincad.base.errors import InputError
from skincad.effects.kinds import PadChange
from skincad.effects.omitted import Omitted, SceneOutline
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

    @staticmethod
    def left_out(outline: SceneOutline) -> Omitted | None:
        """Return by the pad's width against its length, as mechanics/left_out.py has it.

        Press and pull with and without the effect on yamada-2002 (6, 12, 24 mm long; tilted strips),
        lab-bench and cast-in: 1.03 to 5 times the change (0.026 to 0.097); on few ridges, which share the
        force evenly all the same, a hundred times. What the effect itself leaves out is not in it.
        """
        slender = outline.design.skin.width / outline.design.skin.length
        reach = min(math.sqrt(slender), 1.5 * slender)
        return Omitted("free_ends", f"width {slender:.2g} of the length", 0.105 * reach, calibrated=True)
