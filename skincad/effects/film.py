"""The PVDF strips in their slots, along their real, straight or tilted, lines: bonded, or loose.

Bonded strips are thin stiff solids in silicone; a membrane line without bending stiffness buckles
(docs/facts.md#what-a-model-leaves-out).
A loose strip lies in an empty slot and carries nothing, so it feels nothing either, until the slot's walls
meet it; a scene warns where walls meet, for contact within a slot is not in the model. Range: isotropic film.
Without this effect the slots are full of silicone, and what is told is the silicone's stress in the films'
place. Reference: film/stress.py's patches and contour integrals; loose, the linear tier on the same pad.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

from pydantic import Field

from skincad.base.errors import InputError
from skincad.effects.kinds import PadChange
from skincad.effects.omitted import Omitted, SceneOutline
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
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

    @staticmethod
    def left_out(outline: SceneOutline) -> Omitted | None:
        """Return by how slender and how tilted the strips are, as far as they are stiffer than the ridge.

        That is by E t against E w. The stress across a thin strip is nearly the silicone's in its place; a
        tilted one bears load along it. Press and pull on five designs with strips along the ridge's axis: 1.1
        to 8 times the change with the film (0.017 to 0.20); yamada-2002 tilted by 20 and 45 degrees: 1.05 and
        2.2 times (1.28 and 0.62).
        """
        design = outline.design
        if design.film is None or design.slot is None:
            return None
        soft = silicone(design).young_modulus.value * design.ridge.root_width
        ratio = 2 * design.film.young_modulus * design.film.thickness / soft
        blunt = 1.3 * design.film.thickness / design.slot.depth
        tilt = abs(math.sin(2 * math.radians(design.slot.tilt)))
        leaning = 1.2 * min(1.0, tilt / math.sin(math.radians(40)))
        text = f"the films' stiffness is {ratio:.2g} of the ridge's, tilt {design.slot.tilt:g} deg"
        return Omitted("film", text, (blunt + leaning) * ratio / (1 + ratio), calibrated=True)
