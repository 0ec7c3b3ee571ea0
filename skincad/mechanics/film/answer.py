"""What is told of the film strips' stress."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from skincad.base.estimate import Estimate
from skincad.base.result import Result
from skincad.mechanics.film.ridge_field import RidgeField


@dataclass(frozen=True)
class FilmStress:
    """Mean stresses in the strips of ridges 1, 2, ... in MPa, tension positive, each with its error.

    `s1`, `s2`: across the film (its d33 sees that); `differential`: s1 - s2; `along1`, `along2`: along the
    film in the section; `lengthwise1`, `lengthwise2`: along y, the ridge. `force` and `tangential` N,
    `ridge_force` and `ridge_tangential` the plate's on each ridge (N; compression and +x positive).
    `needed_friction`: what full stick asks of each ridge, |tangential| / normal force, its value None where
    the pull takes the normal force away. Errors are those of discretisation. `fault` says what of the skin
    would go through itself, "" where nothing does; where its flanks are to the plate is not looked at.
    """

    name: str
    force: float
    tangential: float
    ridges: int
    film: str
    s1: tuple[Estimate, ...]
    s2: tuple[Estimate, ...]
    differential: tuple[Estimate, ...]
    along1: tuple[Estimate, ...]
    along2: tuple[Estimate, ...]
    lengthwise1: tuple[Estimate, ...]
    lengthwise2: tuple[Estimate, ...]
    ridge_force: tuple[Estimate, ...]
    ridge_tangential: tuple[Estimate, ...]
    needed_friction: tuple[Estimate, ...]
    unknowns: int
    residual: float
    seconds: dict[str, float]
    warnings: tuple[str, ...]
    fields: tuple[RidgeField, ...] = ()
    fault: str = ""

    def lean_share(self, ridge: int) -> Estimate:
        """Return |S1 - S2| / |S1| of a ridge, from 1; under the normal force alone it is the lean's doing."""
        one, between = self.s1[ridge - 1], self.differential[ridge - 1]
        if not one.value or between.value is None:
            return Estimate(None, None, "1")
        share = abs(between.value / one.value)
        return Estimate(share, ((between.error or 0.0) + share * (one.error or 0.0)) / abs(one.value), "1")

    def as_json(self) -> dict[str, Any]:
        """Return the object of `--json`; the unit is the key's suffix."""

        def pair(one: Sequence[Estimate], other: Sequence[Estimate]) -> dict[str, Any]:
            return {"S1": [e.as_json() for e in one], "S2": [e.as_json() for e in other]}

        return {
            "name": self.name,
            "force_N": self.force,
            "tangential_force_N": self.tangential,
            "ridges": self.ridges,
            "film": self.film,
            "film_stress_MPa": pair(self.s1, self.s2),
            "differential_stress_MPa": [e.as_json() for e in self.differential],
            "stress_along_film_MPa": pair(self.along1, self.along2),
            "stress_lengthwise_MPa": pair(self.lengthwise1, self.lengthwise2),
            "ridge_force_N": [e.as_json() for e in self.ridge_force],
            "ridge_tangential_force_N": [e.as_json() for e in self.ridge_tangential],
            "needed_friction": [e.as_json() for e in self.needed_friction],
            "unknowns": self.unknowns,
            "residual": self.residual,
            "seconds": dict(self.seconds),
            "warnings": list(self.warnings),
        }


@dataclass(frozen=True, repr=False)
class FilmStresses(Result):
    """The films' stress under the normal force alone, and under it and a tangential force."""

    shown_by = "skincad.outputs.checks:FILM_STRESS"
    name: str
    states: tuple[FilmStress, FilmStress]

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is to be known of either."""
        return tuple(dict.fromkeys(note for state in self.states for note in state.warnings))

    def as_json(self) -> dict[str, Any]:
        """Return both states."""
        return {"name": self.name, "film_stress": [state.as_json() for state in self.states]}
