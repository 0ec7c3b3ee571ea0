"""The PVDF strips as thin stiff solids bonded in their slots, along their real, straight or tilted, lines.

Range: small strain, isotropic film. Without this effect the slots are full of silicone, and what is told is
the silicone's stress in the films' place. A strip is meshed as a solid: a membrane line without bending
stiffness buckles (FACTS.md). Reference: film/stress.py's patches and contour integrals.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from skincad.design import Design
from skincad.effects.kinds import Body
from skincad.errors import InputError
from skincad.mechanics.problem import Pad


class Film(Body):
    """PVDF strips in the slots."""

    bond: Literal["bonded"] = Field(default="bonded", description="the slot's rest is filled with silicone")

    def check(self, design: Design) -> None:
        """Raise InputError for a skin without films."""
        if design.film is None:
            raise InputError("", "needs a skin with a [film]", design.name, "take a skin with slots and film")

    def changed(self, pad: Pad, design: Design) -> Pad:  # noqa: ARG002
        """Return the design's pad with its strips."""
        from skincad.mechanics.film.stress import filled_pad

        return filled_pad(design.with_(contact={"film": "bonded"}))[0]
