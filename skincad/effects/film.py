"""The PVDF strips in their slots, along their real, straight or tilted, lines: bonded, or loose.

Bonded strips are thin stiff solids in silicone; a membrane line without bending stiffness buckles
(docs/evidence/facts.md#what-a-model-leaves-out).
A loose strip lies in an empty slot and carries nothing, so it feels nothing either, until the slot's walls
meet it; a scene warns where walls meet, for contact within a slot is not in the model. Range: isotropic film.
Without this effect the slots are full of silicone, and the signal is the silicone's stress in the films'
place. Reference: film/stress.py's patches and contour integrals; loose, the linear model on the same pad.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Literal

import numpy as np
from pydantic import Field

from skincad.base.errors import InputError
from skincad.effects.kinds import LeftOutEffect, PadChange, SceneOutline
from skincad.inputs.design import Design
from skincad.mechanics.problem import Pad
from skincad.shape.skin import skin_of

OF_SHEAR, OF_PRESSURE = 0.133, 0.033  # fitted to 30 random scenes
WITHIN, PRESSED = 3.0, 4.0  # the second where nothing is pulled


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

        bonded_pad = pad_of(design.with_(contact={"film": self.bond}))
        return replace(
            pad,
            strips=bonded_pad.strips,
            voids=bonded_pad.voids,
            film_modulus=bonded_pad.film_modulus,
            film_ratio=bonded_pad.film_ratio,
            film_density=bonded_pad.film_density,
        )

    @staticmethod
    def left_out(outline: SceneOutline) -> LeftOutEffect | None:
        """Return by what a ridge bears against the largest signal without the films.

        The stress across a thin stiff strip in incompressible silicone is nearly the silicone's in its place,
        but for its blunt ends, the more so the thicker it is for its depth d, as the root of t / d. Whatever
        the tilt that changes S1 - S2 by a share of the ridge's nominal shear stress and pressure; S1 - S2
        itself depends on the tilt, and is small at some 15 deg. None without a film or a normal force.
        """
        design, path = outline.design, outline.path
        slot = skin_of(design).slot
        if design.film is None or slot is None or outline.ridge_normal <= 0:
            return None
        area = skin_of(design).profile.mean_width * design.skin.length
        shear, pressure = (float(np.abs(part).max()) / area for part in (path.pulled, path.pressed))
        borne = OF_SHEAR * shear + OF_PRESSURE * pressure
        blunt = math.sqrt(design.film.thickness / slot.depth)
        largest = float(np.abs(path.felt).max(initial=0.0)) or shear + pressure
        text = (
            f"films of {design.film.thickness:g} mm, {slot.depth:g} mm deep, in ridges that bear "
            f"{shear:.2g} MPa of shear stress and {pressure:.2g} MPa of pressure"
        )
        return LeftOutEffect(
            "film",
            text,
            blunt * borne / largest,
            calibrated=True,
            within=WITHIN if outline.pulls else PRESSED,
        )
