"""The constants that a topology makes its elements of, in SI.

Source: Yamada et al. 2002, equations (1) to (9) and Figs 5 and 6: the film is a current source beside its
static capacitance and a series R-L-C (motional) branch.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

from skincad.base.errors import InputError

MAY_BE_0 = ("feedback_capacitance", "gain_bandwidth")  # what the paper's network has not


@dataclass(frozen=True)
class NoiseSources:
    """Temperature, K; amplifier's input noise, V/sqrt(Hz) and A/sqrt(Hz); the film's own part of Cpvd, F."""

    temperature: float = 293.0
    voltage_density: float = 0.0
    current_density: float = 0.0
    loss_tangent: float = 0.0
    film_capacitance: float = 0.0


@dataclass(frozen=True)
class Constants:
    """The constants of a film and its amplifier, each finite and above 0; `d33` may have either sign, not 0.

    `capacitance` is the paper's Cpvd with the cable's in parallel; `feedback_capacitance` may be 0,
    none, and `gain_bandwidth` 0, no limit. Raises InputError for any other value.
    """

    d33: float  # C/N
    capacitance: float  # F, Cpvd
    motional_resistance: float  # ohm
    motional_inductance: float  # H
    motional_capacitance: float  # F
    series_resistance: float  # ohm, R1 + R2
    input_resistance: float  # ohm, Ropi
    input_capacitance: float  # F, Copi
    feedback_resistance: float  # ohm, R3 + R4
    output_resistance: float  # ohm, Ropo
    gain: float  # A
    feedback_capacitance: float = 0.0  # F, beside R3 + R4; none in the paper
    gain_bandwidth: float = 0.0  # Hz, of A, one pole; none in the paper

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not math.isfinite(value):
                raise InputError(name, "must be a finite number", value)
            valid, rule = value > 0, "be above 0"
            if name in MAY_BE_0:
                valid, rule = value >= 0, "not be below 0"
            elif name == "d33":
                valid, rule = value != 0, "not be 0"
            if not valid:
                raise InputError(name, f"must {rule}", value)

    def as_json(self) -> dict[str, float]:
        """Return the constants by name, the unit as suffix."""
        units = {"d33": "_C_per_N", "resistance": "_ohm", "capacitance": "_F", "inductance": "_H", "gain": ""}
        units["bandwidth"] = "_Hz"
        return {name + units[name.rpartition("_")[2]]: value for name, value in asdict(self).items()}
