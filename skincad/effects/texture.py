"""A plate with a profile along x: a wave, or a table of one period.

A contact point meets the plate where it sits on it, so a point that sticks keeps its height, and one that
slides rises and falls at speed / wavelength. The place is that of the step before: a step late for sliding
points. Range: small strain; slopes so small that forces stay along x and z; a profile no finer than the mesh
of the crests, as the plate meets the mesh's points alone. Reference: the spectrum's peak
(tests/effects/test_texture.py).
"""

from __future__ import annotations

from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.tables import quantity
from skincad.effects.kinds import RELIEF, Share, Step, Term

MOST_POINTS = 1000


class Texture(Term):
    """Relief of the plate, the same all along y."""

    asks: ClassVar[frozenset[str]] = frozenset({RELIEF})

    wavelength: float = quantity("mm", "length of a period along x", gt=0.0, le=1e3)
    amplitude: float | None = quantity(
        "mm", "of a sine wave: half of what it is high; not with a table", gt=0.0, le=10.0, default=None
    )
    table: list[Annotated[list[float], Field(min_length=2, max_length=2)]] | None = Field(
        default=None,
        min_length=2,
        max_length=MOST_POINTS,
        description="one period: pairs of x from 0 to the wavelength, and of how far the plate comes out, mm",
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if (self.amplitude is None) == (self.table is None):
            raise InputError("amplitude", "or a table must be given, and not both", remedy="give one of them")
        places = [pair[0] for pair in self.table or []]
        if places and (places[0] < 0 or places[-1] > self.wavelength or np.any(np.diff(places) <= 0)):
            rule = f"needs x that rise from 0 to at most wavelength, {self.wavelength:g} mm"
            raise InputError("table", rule, places[-1])
        return self

    @property
    def rise(self) -> float:
        """From its lowest to its highest level, mm."""
        return (
            2 * (self.amplitude or 0.0) if self.table is None else float(np.ptp(np.array(self.table)[:, 1]))
        )

    def depth(self, place: Array) -> Array:
        """Return how far the plate stays behind its foremost level `(m,)` mm at places `(m,)` mm along it."""
        if self.table is None:
            return np.asarray((self.amplitude or 0.0) * (1 - np.cos(2 * np.pi * place / self.wavelength)))
        x, out = np.array(self.table).T
        return np.asarray(out.max() - np.interp(place, x, out, period=self.wavelength))

    def share(self, step: Step) -> Share:  # noqa: ARG002
        """Return the relief; the same at every step."""
        return Share(relief=self.depth)
