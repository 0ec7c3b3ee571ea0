"""The PVDF strips in their slots, along their real, straight or tilted, lines: bonded, or loose.

Bonded strips are thin stiff solids in silicone; a membrane line without bending stiffness buckles
(docs/facts.md#what-a-model-leaves-out).
A loose strip lies in an empty slot and carries nothing, so it feels nothing either, until the slot's walls
meet it; a scene warns where walls meet, for contact within a slot is not in the model. Range: isotropic film.
Without this effect the slots are full of silicone, and what is told is the silicone's stress in the films'
place. Reference: film/stress.py's patches and contour integrals; loose, the linear tier on the same pad.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal

from pydantic import Field

from skincad.base.errors import InputError
from skincad.effects.kinds import PadChange
from skincad.inputs.design import Design
from skincad.mechanics.problem import Pad


class FilmStrips(PadChange):
    """PVDF strips in the slots."""

    bond: Literal["bonded", "loose"] = Field(
        default="bonded", description="bonded: silicone fills the slot's rest; loose: the slot is empty"
    )

    @property
    def feels(self) -> bool:
        """Whether the strips bear stress."""
        return self.bond == "bonded"

    def check(self, design: Design) -> None:
        """Raise InputError for a skin without films."""
        if design.film is None:
            raise InputError("", "needs a skin with a [film]", design.name, "take a skin with slots and film")

    def changed(self, pad: Pad, design: Design) -> Pad:
        """Return the pad with the design's strips, or with empty slots."""
        from skincad.mechanics.problem import pad_of

        own = pad_of(design.with_(contact={"film": self.bond}))
        return replace(
            pad,
            strips=own.strips,
            voids=own.voids,
            film_modulus=own.film_modulus,
            film_ratio=own.film_ratio,
            film_density=own.film_density,
        )
