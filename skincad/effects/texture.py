"""A plate with a profile along x: a wave, or a table or CSV of one period.

A contact point meets the plate where it sits on it, so a point that sticks keeps its height, and one that
slides rises and falls at speed / wavelength. The place is that of the step before: a step late for sliding
points. Range: small strain; slopes so small that forces stay along x and z; a profile no finer than the mesh
of the crests, as the plate meets the mesh's points alone. Reference: the spectrum's peak
(tests/effects/test_texture.py).
"""

from __future__ import annotations

from functools import cached_property
from typing import Annotated, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from skincad.base.arrays import Array
from skincad.base.columns import read_columns
from skincad.base.errors import InputError
from skincad.base.tables import quantity
from skincad.effects.kinds import RELIEF, Share, Step, Term

MOST_POINTS, MOST_ROWS = 1000, 100_000
HIGHEST = 10.0  # mm
COLUMNS = "x_mm", "out_mm"


class Texture(Term):
    """Relief of the plate, the same all along y."""

    asks: ClassVar[frozenset[str]] = frozenset({RELIEF})

    wavelength: float = quantity("mm", "length of a period along x", gt=0.0, le=1e3)
    amplitude: float | None = quantity(
        "mm", "of a sine wave: half of what it is high", gt=0.0, le=HIGHEST, default=None
    )
    table: list[Annotated[list[float], Field(min_length=2, max_length=2)]] | None = Field(
        default=None,
        min_length=2,
        max_length=MOST_POINTS,
        description="one period: pairs of x from 0 to the wavelength, and of how far the plate comes out, mm",
    )

    file: str | None = Field(
        default=None, description=f"a CSV of one period instead of a table: columns {' and '.join(COLUMNS)}"
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if [self.amplitude, self.table, self.file].count(None) != 2:
            rule = "or a table or a file must be given, and one alone"
            raise InputError("amplitude", rule, remedy="give one of them")
        if self.amplitude is None:
            key = "file" if self.table is None else "table"
            x, out = self.period
            if x[0] < 0 or x[-1] > self.wavelength or np.any(np.diff(x) <= 0):
                rule = f"needs x that rise from 0 to at most wavelength, {self.wavelength:g} mm"
                raise InputError(key, rule, float(x[-1]))
            if np.abs(out).max() > HIGHEST:
                raise InputError(key, f"must come out by at most {HIGHEST:g} mm", float(np.abs(out).max()))
        return self

    @cached_property
    def period(self) -> tuple[Array, Array]:
        """Places and how far the plate comes out there `(n,)` mm, of a table or a file. InputError for a file
        that is none."""
        if self.table is not None:
            x, out = np.array(self.table).T
            return x, out
        read = read_columns(self.file or "", COLUMNS)
        if read[COLUMNS[0]].size > MOST_ROWS:
            raise InputError(self.file or "", f"must have at most {MOST_ROWS} rows", read[COLUMNS[0]].size)
        return read[COLUMNS[0]], read[COLUMNS[1]]

    @property
    def rise(self) -> float:
        """From its lowest to its highest level, mm."""
        return 2 * self.amplitude if self.amplitude is not None else float(np.ptp(self.period[1]))

    def depth(self, place: Array) -> Array:
        """Return how far the plate stays behind its foremost level `(m,)` mm at places `(m,)` mm along it."""
        if self.amplitude is not None:
            return np.asarray(self.amplitude * (1 - np.cos(2 * np.pi * place / self.wavelength)))
        x, out = self.period
        return np.asarray(out.max() - np.interp(place, x, out, period=self.wavelength))

    def share(self, step: Step) -> Share:  # noqa: ARG002
        """Return the relief; the same at every step."""
        return Share(relief=self.depth)
