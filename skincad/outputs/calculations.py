"""The closed forms behind a verdict, of casting, and of a film strip with its amplifier: formula and number.

Each result comes from the function that the program itself uses; tests hold it against its formula, which is
Python's arithmetic, and the numbers that are printed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from statistics import median
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from skincad.circuit.model import Circuit, constants
from skincad.circuit.network import PICO, capacitance, charge, electrode
from skincad.fabrication.job import Job
from skincad.fabrication.papers import macro
from skincad.fabrication.pouring import DEAD_VOLUME, pours
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.models import winkler
from skincad.mechanics.models.winkler import compliances
from skincad.mechanics.problem import Request
from skincad.mechanics.validity import limits, plane_modulus
from skincad.outputs.pages import rounded
from skincad.shape.curves import area
from skincad.shape.skin import skin_of
from skincad.solids.plan import PartRole

if TYPE_CHECKING:
    from skincad.circuit.bode import CircuitGain
    from skincad.scenes.simulation import Simulation

MM3 = 1e-3  # cm3
EPSILON_0 = 8.8541878128e-3  # pF/mm; source: CODATA 2018, as scipy.constants.epsilon_0
KILO, GIGA = 1e3, 1e9


SIGNS = {  # of the symbols and functions that are no letters of ours
    "E1": "E\u2032",
    "delta": "δ",
    "epsilon": "ε",
    "nu": "\u03bd",
    "phi": "φ",
    "pi": "π",
    "rho": "\u03c1",
    "sigma": "\u03c3",
    "sqrt": "√",
    "sum": "∑",
}


@dataclass(frozen=True)
class Quantity:
    """A number in its unit, or one of each ridge, as `symbol` in a formula: `c_r` has an index."""

    symbol: str
    meaning: str
    value: float | tuple[float, ...]
    unit: str

    def __str__(self) -> str:
        """The number with its unit; of what each ridge has, the unit."""
        number = "" if isinstance(self.value, tuple) else rounded(self.value)
        return f"{number} {'' if self.unit == '1' else self.unit}".strip()


@dataclass(frozen=True)
class Calculation:
    """A result by a formula of what is given; `source` is author, year and place."""

    title: str
    result: Quantity
    formula: str
    given: tuple[Quantity, ...]
    source: str
    remark: str = ""

    @property
    def numbers(self) -> dict[str, str]:
        """What is put in for symbols, as printed; not what differs from ridge to ridge."""
        given = ((term.symbol, term.value) for term in self.given)
        return {symbol: rounded(value) for symbol, value in given if not isinstance(value, tuple)}

    @staticmethod
    def signs(formula: str, numbers: Mapping[str, str] = MappingProxyType({})) -> str:
        """Return a formula as HTML, with numbers in the place of some symbols."""

        def sign(match: re.Match[str]) -> str:
            letter, _, index = match[0].partition("_")
            number = numbers.get(match[0], "")
            symbol = SIGNS.get(letter, letter) + (f"<sub>{index}</sub>" if index else "")
            return f"({number})" if number.startswith("−") else number or symbol  # noqa: RUF001

        powers = re.sub(r"\*\*(\d)", r"<sup>\1</sup>", re.sub(r"[A-Za-z]\w*", sign, formula))
        return powers.replace("*", "·").replace("-", "−")  # noqa: RUF001


def contact_calculations(design: Design, share: float | None = None) -> list[Calculation]:
    """Return the foundation's verdict, step by step; `share` N is the force on the most loaded ridge by the
    verdict's model, for its strain."""
    skin, depths, gaps = skin_of(design), winkler.crest_depths(design), winkler.crest_gaps(design)
    facts: dict[str, Any] = {
        "compliances": compliances(design),
        "depths": depths,
        "first": int(np.argmin(depths)),
        "gaps": gaps,
        "median_height": median(skin.heights),
        "plane_modulus": plane_modulus(design),
        "plate_rises": winkler.plate_rises(design),
        "ridge_stiffness": winkler.ridge_stiffness(design),
        "share": share,
        "strain": None if share is None else limits(design).strain(share),
        "verdict": None,
    }
    if skin.body == "straight":
        verdict = winkler.answer(design, Request(design.contact.force))
        facts |= {
            "verdict": verdict,
            "all_touch_force": winkler.all_touch_force(design),
            "stiffnesses": np.broadcast_to(winkler.stiffnesses(design), gaps.shape),
            "touching": np.array([(ridge.value or 0.0) > 0 for ridge in verdict.ridge_force]),
        }
    material = silicone(design)
    return _steps("contact", design, skin, material, int(np.argmax(depths)), silicone=material.name, **facts)


def _steps(name: str, *values: Any, silicone: str = "", **facts: Any) -> list[Calculation]:
    """The steps of a macro of templates/pages/calculations.txt, each of the quantities above it. The name of
    a silicone, which may be any text, takes its place once the text is in cells."""
    terms, steps = dict[str, Quantity](), list[Calculation]()
    for line in macro("pages/calculations.txt", name, *values, **facts).splitlines():
        first, *cells = (cell.replace("{silicone}", silicone) for cell in line.split(" | "))
        if first.startswith("* "):
            result, _, formula = cells[0].partition(" = ")
            symbols = dict.fromkeys(re.findall(r"[A-Za-z]\w*", formula))
            given = tuple(terms[symbol] for symbol in symbols if symbol in terms)
            steps.append(Calculation(first[2:], terms[result], formula, given, *cells[1:]))
        else:
            meaning, number, unit = cells
            each = number.startswith("[")
            value = tuple(map(float, number.strip("[]").split())) if each else float(number)
            terms[first] = Quantity(first, meaning, value, unit)
    return steps


def casting_calculations(job: Job) -> list[Calculation]:
    """Return the cavity's volume by the shrinkage, and the silicone to weigh."""
    steps, layers = list[Calculation](), pours(job)
    if job.bone is None and not (job.bent and job.skin.slot is not None):  # no one formula has them
        slots = math.fsum(area(slot.loop()) for slot in job.section.slots) * job.design.skin.length
        steps += _steps(
            "cavity",
            volume=MM3 * job.skin_part.volume,
            shrinkage=job.shrinkage,
            # their depth follows the shrinkage, as a slot's length does
            pockets=MM3 * math.fsum(cut.volume for cut in job.skin_part.cuts),
            slots=MM3 * slots,
            cavity_volume=MM3 * job.closed.first(PartRole.SKIN).volume,
        )
    for layer in layers:
        whose = "the layer of {silicone}" if len(layers) > 1 else "the mold"
        steps += _steps("mass", layer, whose, silicone=layer.silicone.name, left=DEAD_VOLUME, MM3=MM3)
    return steps


def strip_calculations(design: Design) -> list[Calculation]:
    """Return a strip's electrode and its charge by the stress through it; none without films."""
    film, slot = design.film, skin_of(design).slot
    if film is None or slot is None:
        return []
    inside, coefficients = electrode(design), (film.d31, film.d32, film.d33)
    unit_charge = charge(1.0, 0.0, 0.0, area=inside, coefficients=coefficients)
    return _steps("strip", design, slot, film, inside=inside, charge=float(unit_charge) / PICO)


def scene_calculations(
    simulation: Simulation, amplifier: Circuit, circuit_gain: CircuitGain
) -> list[Calculation]:
    """Return a strip's charge where the scene's differential stress is largest, its capacitance with the
    lead, and what the ideal amplifier makes of 1 N on the film, by the network's own beside it.

    `amplifier` is the circuit fitted to the skin, `circuit_gain` its gain.
    """
    film = amplifier.film
    static_capacitance = capacitance(film.area, film.thickness, film.permittivity) / PICO
    plates = _steps("capacitance", film, static_capacitance=static_capacitance, EPSILON_0=EPSILON_0)
    return [*_largest_charge(simulation, amplifier), *plates, _ideal(amplifier, circuit_gain)]


def _largest_charge(simulation: Simulation, amplifier: Circuit) -> list[Calculation]:
    """The charge of the monitored strip at the step of the largest differential stress of all."""
    from skincad.effects.piezo import strip_charges

    design, film = simulation.scene.design, simulation.scene.design.film
    if not simulation.raw or film is None:
        return []
    ridge = max(simulation.raw, key=lambda r: float(np.abs(simulation.raw[r]).max()))
    step = int(np.argmax(np.abs(simulation.raw[ridge])))
    stress = np.array([simulation.march.readings[step].films])
    strip = 2 * (ridge - 1)
    charges = strip_charges(amplifier, design, stress)[0]
    through, transverse, along = (float(value) for value in stress[0, strip])
    drawn, other = (along, transverse) if amplifier.film.draw_axis == "length" else (transverse, along)
    facts: dict[str, Any] = {"drawn": drawn, "other": other, "through": through, "ridge": ridge, "step": step}
    facts |= {"charge": float(charges[strip]) / PICO, "inside": electrode(design)}
    return _steps("largest_charge", film, **facts)


def _ideal(amplifier: Circuit, circuit_gain: CircuitGain) -> Calculation:
    """What an ideal amplifier makes of 1 N on the film at the mid-band, against the network's own gain."""
    c = constants(amplifier)
    frequency, decibels = circuit_gain.mid_band
    turn, charge_by_1_N = 2 * math.pi * frequency * c.feedback_resistance, abs(c.d33)
    if amplifier.amplifier.topology == "follower":
        value = charge_by_1_N / (c.capacitance + c.input_capacitance)
    elif not c.feedback_capacitance:
        value = turn * charge_by_1_N
    else:
        value = turn * charge_by_1_N / math.sqrt(1 + (turn * c.feedback_capacitance) ** 2)
    facts: dict[str, Any] = {"frequency": frequency, "network": 10 ** (decibels / 20), "value": value}
    facts |= {"charge_by_1_N": charge_by_1_N, "PICO": PICO, "KILO": KILO, "GIGA": GIGA}
    (step,) = _steps("ideal", amplifier.amplifier, c, **facts)
    return replace(step, given=tuple(sorted(step.given, key=lambda term: term.symbol != "d")))
