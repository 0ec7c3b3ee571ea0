"""A law is an isotropic energy of the stretches; a body adds the volume's part.

In units of the law's shear modulus G at small strain the energy is f(x), of a measure of strain

    x = sum of m_k ((2 / a_k^2) (l1^a_k + l2^a_k + l3^a_k - 3) - (2 / a_k) ln J),   sum of m_k = 1,

with f(0) = 0 and f'(0) = 1. Each power a_k alone has no stress at rest and is e:e there, so any law is
neo-Hooke's at small strain, whatever Poisson's ratio; the power 2 alone with f(x) = x is neo-Hooke. Powers
are Ogden's (Proc. R. Soc. A 326 (1972) 565), in the convention in which G is the sum of the terms' mu; f is
what laws of the first invariant add: 2 x is I1 - 3 where the volume is kept.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import Field, model_validator

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.base.faces import imported
from skincad.base.result import Figure, with_picture
from skincad.base.tables import Table, unit_of

# Stretches of a bar between which a law must pull the more the longer the bar is. Assumption: a ridge's root
# reaches 0.5 where it folds, and castings are stripped at less than 2
SHORTEST, LONGEST = 0.5, 2.0


class Candidate(NamedTuple):
    """How a law is fitted: `make` takes free numbers, `start` `(p,)` are such of a shear modulus of 1 MPa."""

    name: str
    start: tuple[float, ...]
    make: Callable[[Array], Rubber]


class Rubber(Table):
    """A law of rubber elasticity, its constants in MPa or plain numbers."""

    candidates: ClassVar[Callable[[], tuple[Candidate, ...]]]
    kind: str = Field(description="which law")

    @property
    @abstractmethod
    def shear(self) -> float:
        """The shear modulus at small strain, MPa."""

    @property
    def powers(self) -> tuple[tuple[float, float], ...]:
        """Shares m_k and powers a_k of the strain's measure x."""
        return ((1.0, 2.0),)

    def energy(self, x: Any, of: Any) -> Any:  # noqa: ARG002
        """Return f(x) by arithmetic, `of.exp` and `of.log`, as numpy has them, and NGSolve for symbols."""
        return x

    def slopes(self, x: Array) -> tuple[Array, Array]:
        """Return f'(x) and f''(x)."""
        return np.ones_like(x), np.zeros_like(x)

    def young_modulus(self, poisson_ratio: float) -> float:
        """Return Young's modulus at small strain, MPa."""
        return 2 * (1 + poisson_ratio) * self.shear

    def scaled(self, scale: float) -> Self:
        """Return the law with all its moduli times a factor."""
        moduli = {
            key: getattr(self, key) for key in type(self).model_fields if unit_of(type(self), (key,)) == "MPa"
        }
        changed = {
            key: tuple(term * scale for term in value) if isinstance(value, tuple) else value * scale
            for key, value in moduli.items()
        }
        return type(self)(**{**self.model_dump(), **changed})

    def strain_energy(self, stretch: Array) -> Array:
        """Return the energy, mJ/mm3, of an incompressible bar pulled or squeezed to `stretch` `(n,)`; nan
        where the law ends. Ogden 1972, eq. (31)."""
        with np.errstate(all="ignore"):
            energy = self.shear * np.asarray(self.energy(self._measure(stretch), np), dtype=np.float64)
            return np.where(np.isfinite(energy), energy, np.nan)

    def stress(self, stretch: Array) -> Array:
        """Return the nominal stress, MPa, of such a bar: the energy's slope by its stretch. Ogden 1972, eq.
        (37) for the powers."""
        measure = self._measure(stretch)
        with np.errstate(all="ignore"):
            stress = self.shear * self.slopes(measure)[0] * self._pull(stretch)
            return np.where(np.isfinite(self.energy(measure, np)), stress, np.nan)

    def tangent_modulus(self, stretch: Array) -> Array:
        """Return the nominal stress's slope, MPa; at a stretch of 1 it is Young's modulus."""
        measure, pull, steeper = self._measure(stretch), self._pull(stretch), np.zeros_like(stretch)
        for share, power in self.powers:
            half = -power / 2
            steeper += (
                share
                * 2
                / power
                * ((power - 1) * stretch ** (power - 2) - (half - 1) * stretch ** (half - 2))
            )
        with np.errstate(all="ignore"):
            slope, bend = self.slopes(measure)
            modulus = self.shear * (slope * steeper + bend * pull**2)
            return np.where(np.isfinite(self.energy(measure, np)), modulus, np.nan)

    def _measure(self, stretch: Array) -> Array:
        """The measure x of a bar's strain."""
        x = np.zeros_like(stretch)
        for share, power in self.powers:
            x += share * 2 / power**2 * (stretch**power + 2 * stretch ** (-power / 2) - 3)
        return x

    def _pull(self, stretch: Array) -> Array:
        """Its slope by the stretch."""
        pull = np.zeros_like(stretch)
        for share, power in self.powers:
            pull += share * 2 / power * (stretch ** (power - 1) - stretch ** (-power / 2 - 1))
        return pull

    def figure(self) -> Figure:
        """Return the matplotlib figure of stress and tangent modulus against stretch."""
        figure: Figure = imported("skincad.outputs.figures.results:law_figure")(self)
        return figure

    def _repr_html_(self) -> str:
        """The constants and the curve, for a notebook."""
        return with_picture(repr(self), self.figure())

    def own_rules(self) -> None:
        """Raise InputError for constants that do not go together."""

    @model_validator(mode="after")
    def _is_rubber(self) -> Self:
        self.own_rules()
        if not self.shear > 0:
            raise InputError("", "must have a shear modulus above 0 MPa at small strain", self.shear)
        stretch = np.linspace(SHORTEST, LONGEST, 151)
        negative_eigenvalues = np.diff(self.stress(stretch)) <= 0  # not so where the law has ended
        if negative_eigenvalues.any():
            at = float(
                stretch[1:][negative_eigenvalues][np.argmin(np.abs(stretch[1:][negative_eigenvalues] - 1))]
            )
            rule = "must pull a bar the more the longer it is, at stretches of"
            rule = f"{rule} {SHORTEST:g} to {LONGEST:g}; it does not at {at:.3g}"
            raise InputError("", rule, remedy="take constants of a fit")
        return self
