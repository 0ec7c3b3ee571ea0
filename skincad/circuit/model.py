"""What a person writes of a circuit: a strict TOML model, and the network's constants from it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Literal, Self

from pydantic import Field, field_validator, model_validator

from skincad.base.errors import InputError, did_you_mean
from skincad.base.tables import Document, Table, quantity
from skincad.circuit.network import PICO, TOPOLOGIES, Constants, Network, Noise, capacitance, network
from skincad.circuit.rails import rest, sign
from skincad.inputs.catalog import overridden, read_table

UNLIMITED = (-math.inf, math.inf)  # V, without rails
SHORT = 1e-12  # ohm; less is no resistor, and what it conducts is more than a number holds


class FilmCapacitor(Table):
    """A piece of PVDF film with its electrodes; defaults: data sheets of uniaxially drawn film."""

    area: float = quantity("mm2", "of the electrodes", gt=0.0, le=1e5)
    thickness: float = quantity("mm", "of the film", ge=0.004, le=5.0)
    permittivity: float = quantity("1", "relative; PVDF 12 to 13", ge=1.0, le=1e4, default=12.0)
    loss_tangent: float = quantity(
        "1", "dielectric loss; counts in the noise only", ge=0.0, le=1.0, default=0.02
    )
    d31: float = quantity("pC/N", "charge per stress along the draw axis", ge=-1e4, le=1e4, default=23.0)
    d32: float = quantity(
        "pC/N", "charge per stress across the draw axis, in the film's plane", ge=-1e4, le=1e4, default=3.0
    )
    d33: float = quantity("pC/N", "charge per stress through the film", ge=-1e4, le=1e4, default=-33.0)
    draw_axis: Literal["length", "width"] = Field(
        default="length", description="the film was drawn along the strip's length (y) or its width"
    )


class Cable(Table):
    """The lead from film to amplifier."""

    capacitance: float = quantity(
        "F", "of the lead, parallel to the film; a metre of coaxial cable has about 100e-12", ge=0.0, le=1e-6
    )


class Motional(Table):
    """The series R-L-C branch beside the film's static capacitance: its mechanical resonance."""

    resistance: float = quantity("ohm", "of the motional branch", gt=0.0, le=1e12)
    inductance: float = quantity("H", "of the motional branch", gt=0.0, le=1e9)
    capacitance: float = quantity("F", "of the motional branch", gt=0.0, le=1e-3)


class Amplifier(Table):
    """The amplifier behind the film, by the sums in the paper's loop equations."""

    topology: str = Field(default="inverting", description=f"one of {', '.join(TOPOLOGIES)}", max_length=64)
    series_resistance: float = quantity("ohm", "R1 + R2, from film to input", gt=0.0, le=1e12)
    input_resistance: float = quantity("ohm", "Ropi, from input to ground", gt=0.0, le=1e16)
    input_capacitance: float = quantity("F", "Copi, from input to ground", gt=0.0, le=1e-6)
    feedback_resistance: float = quantity("ohm", "R3 + R4, from output to input", gt=0.0, le=1e13)
    output_resistance: float = quantity("ohm", "Ropo, of the output", gt=0.0, le=1e9)
    gain: float = quantity("1", "A, of the open loop", gt=0.0, le=1e12)
    feedback_capacitance: float = quantity(
        "F", "parallel to R3 + R4, in a charge amplifier; 0: none", ge=0.0, le=1e-3, default=0.0
    )
    gain_bandwidth: float = quantity(
        "Hz", "where the open loop's gain has fallen to 1; 0: no limit", ge=0.0, le=1e12, default=0.0
    )
    input_bias_current: float = quantity(
        "A",
        "direct current into each input; the output rests beside the reference by it times the resistance",
        ge=-1e-3,
        le=1e-3,
        default=0.0,
    )
    reference: float = quantity(
        "V",
        "at which the output rests; half of a single supply, 0 of a double one",
        ge=-1e3,
        le=1e3,
        default=0.0,
    )
    rail_low: float | None = quantity(
        "V", "lowest output that the amplifier gives; none: no limit", ge=-1e3, le=1e3, default=None
    )
    rail_high: float | None = quantity(
        "V", "highest output that the amplifier gives; none: no limit", ge=-1e3, le=1e3, default=None
    )

    @field_validator("topology")
    @classmethod
    def _known(cls, topology: str) -> str:
        if topology not in TOPOLOGIES:
            raise InputError("", "no such topology", topology, did_you_mean(topology, TOPOLOGIES))
        return topology

    @model_validator(mode="after")
    def _no_short(self) -> Self:
        for key, value in self:
            if key.endswith("resistance") and value < SHORT:
                raise InputError(key, f"must be at least {SHORT:g} ohm", value)
        return self

    @model_validator(mode="after")
    def _between_rails(self) -> Self:
        low, high = self.rails
        if low >= high:
            rule = f"must be above {low:g} V (rail_low)"
            raise InputError("rail_high", rule, high, "give the output's lowest and highest voltage")
        if not low < self.reference < high:
            rules = {f"above {low:g} V (rail_low)": low, f"below {high:g} V (rail_high)": high}
            rule = " and ".join(words for words, rail in rules.items() if math.isfinite(rail))
            remedy = f"half-way is {(low + high) / 2:g} V" if math.isfinite(high - low) else ""
            raise InputError("reference", f"must be {rule}", self.reference, remedy)
        return self

    @property
    def rails(self) -> tuple[float, float]:
        """The lowest and the highest output, V; infinite where there is no limit."""
        return (
            -math.inf if self.rail_low is None else self.rail_low,
            math.inf if self.rail_high is None else self.rail_high,
        )


class Sweep(Table):
    """The frequency test; its defaults are the paper's."""

    low: float = quantity("Hz", "first frequency", gt=0.0, le=1e9, default=10.0)
    high: float = quantity("Hz", "last frequency", gt=0.0, le=1e9, default=20_000.0)
    points: int = Field(default=400, ge=20, le=1_000_000, description="frequencies, evenly in log f")
    fit_high: float = quantity(
        "Hz", "slopes and cut-off are fitted up to here", gt=0.0, le=1e9, default=8000.0
    )
    offset: float = quantity(
        "dB",
        "added to the measured gain to give the computed one; 166 in the paper",
        ge=-400.0,
        le=400.0,
        default=0.0,
    )

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not 10 * self.low <= self.fit_high <= self.high:
            rule = f"must be from {10 * self.low:g} Hz (10 times low) to {self.high:g} Hz (high)"
            raise InputError("fit_high", rule, self.fit_high, "two slopes need at least a decade")
        return self


class Indenter(Table):
    """The mechanical resonance of indenter and film: a mass on a spring with a damper passes the load on.

    Of the frequency test's rig: it is in the gain by the measured load, and not in use.
    """

    resonance: float = quantity("Hz", "of indenter and film; 9000 in the paper", gt=0.0, le=1e9)
    damping: float = quantity("1", "relative to critical damping", gt=0.0, le=10.0, default=0.5)


class ForceSensor(Table):
    """The rig's force sensor, a mass on a damped spring: above its resonance it reads less than is felt.

    Of the frequency test's rig: it is in the gain by the measured load, and not in use.
    """

    resonance: float = quantity("Hz", "of the sensor with its probe, or of its amplifier", gt=0.0, le=1e9)
    damping: float = quantity("1", "relative to critical damping", gt=0.0, le=10.0)


class Sampling(Table):
    """The recording of the output."""

    rate: float = quantity("Hz", "samples per second; 650 in the paper", gt=0.0, le=1e9)


class Circuit(Document):
    """A film with its amplifier; everything after `amplifier` is optional."""

    film: FilmCapacitor
    cable: Cable = Field(default=Cable(capacitance=0.0), description="none: no lead")
    motional: Motional
    amplifier: Amplifier
    sweep: Sweep = Field(default=Sweep(), description="10 to 20 000 Hz in the paper")
    indenter: Indenter | None = None
    force_sensor: ForceSensor | None = None
    sampling: Sampling | None = None
    noise: Noise = Field(default=Noise(), description="a noiseless amplifier at 293 K")

    @model_validator(mode="after")
    def _charged(self) -> Self:
        if self.film.d33 == 0:
            raise InputError("film.d33", "must not be 0 pC/N: the load would give no charge", 0.0)
        rate, low = self.sampling.rate if self.sampling else None, self.sweep.low
        if rate is not None and rate <= 2 * low:
            raise InputError(
                "sampling.rate", f"must be above {2 * low:g} Hz (twice sweep.low)", rate, "sample faster"
            )
        return self

    @model_validator(mode="after")
    def _rests_between_rails(self) -> Self:
        a = self.amplifier
        if not a.input_bias_current or a.rails == UNLIMITED:
            return self
        at_rest = a.reference + output_offset(a, circuit_network(self))
        if not a.rails[0] < at_rest < a.rails[1]:
            rule = f"must let the output rest between its rails, but it rests at {at_rest:.3g} V"
            remedy = (
                "take a smaller feedback_resistance (of a follower, input_resistance) or another amplifier"
            )
            raise InputError("amplifier.input_bias_current", rule, a.input_bias_current, remedy)
        return self


def load_circuit(source: str | Path, settings: list[str] | tuple[str, ...] = ()) -> Circuit:
    """Return the circuit of a template's name or of a TOML file, settings as of `load_design` on top.

    Raises InputError with key, rule, value, remedy.
    """
    return Circuit(**overridden(read_table(source, "circuits"), settings))


def constants(circuit: Circuit) -> Constants:
    """Return the network's constants in SI: Cpvd is the film's capacitance and the cable's."""
    film, motional = circuit.film, circuit.motional
    return Constants(
        d33=film.d33 * PICO,
        capacitance=capacitance(film.area, film.thickness, film.permittivity) + circuit.cable.capacitance,
        **{f"motional_{key}": value for key, value in motional},
        **{key: value for key, value in circuit.amplifier if key in Constants.__dataclass_fields__},
    )


def circuit_network(circuit: Circuit, c: Constants | None = None) -> Network:
    """Return the elements of a circuit's film and amplifier, with their noise; `c` in place of its constants.

    The lead has no loss.
    """
    film = circuit.film
    loss = capacitance(film.area, film.thickness, film.permittivity) * film.loss_tangent
    return network(c or constants(circuit), circuit.noise, loss, circuit.amplifier.topology)


def output_offset(amplifier: Amplifier, whole: Network) -> float:
    """Return how far the amplifier's own output rests above its reference, V, by its input bias current."""
    return sign(whole) * rest(whole, amplifier.input_bias_current) + 0.0  # no -0.0


def output_swing(amplifier: Amplifier, whole: Network) -> tuple[float, float]:
    """Return how far `vout` can go from rest, V below and above 0; infinite where there is no rail.

    Of an inverting amplifier, whose own output has the other sign, the upper rail is the lower end.
    """
    at_rest = amplifier.reference + output_offset(amplifier, whole)
    low, high = sorted(sign(whole) * (rail - at_rest) for rail in amplifier.rails)
    return low, high
