"""The closed forms behind a verdict, of casting, and of a film strip with its amplifier: formula and number.

Each result comes from the function that the program itself uses; tests hold it against its formula, which is
Python's arithmetic, and the numbers that are printed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import median
from types import MappingProxyType
from typing import TYPE_CHECKING

import numpy as np

from skincad.base.arrays import Mask
from skincad.circuit.model import Circuit, constants
from skincad.circuit.network import PICO, capacitance, charge, electrode
from skincad.fabrication.job import Job
from skincad.fabrication.pouring import DEAD_VOLUME, LayerPour, pours
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

PLANE_STRAIN = "plane strain: Johnson, Contact Mechanics, 1985, ch. 2"
FOUNDATION = "elastic foundation: Johnson, Contact Mechanics, 1985, sec. 4.3"
ON_A_CIRCLE = "geometry of the base circle"
PIEZO = "IEEE Std 176-1987: D₃ = d₃₁T₁ + d₃₂T₂ + d₃₃T₃"
PLATES = "parallel plates, stray field left out"
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
    skin, depths, terms = skin_of(design), winkler.crest_depths(design), _contact_terms(design)
    which = f"{int(np.argmax(depths)) + 1}"
    lean, gap = "m * p / R", "2 * (R + h_l) * sin(phi / 2)**2"
    gap += " + z_p" if design.contact.plate.shape != "flat" else ""
    gap += " + (h_m - h_l)" if skin.uneven else ""
    gap += " - d_f" if depths.min() else ""
    stiffness = "Stiffness of a ridge on its foundation", "k", "E1 * L / (c_b + c_r)"
    series = "Base and ridge are two springs in series."
    steps = [
        _step("Modulus in plane strain", "E1", "E / (1 - nu**2)", terms, PLANE_STRAIN),
        _step("A ridge's part of the base", "c_b", "n * T / W", terms, FOUNDATION),
        _step("The ridge itself", "c_r", "2 * h / (b_r + b_t)", terms, FOUNDATION),
        _step(*stiffness, terms, FOUNDATION, series),
        _step(f"Lean of ridge {which}, the last to touch", "phi", lean, terms, ON_A_CIRCLE),
        _step(f"Approach needed until ridge {which} touches", "g", gap, terms, ON_A_CIRCLE),
    ]
    if skin.count == 1:
        del steps[-2]
    if design.skin.curvature_radius_y is None:
        steps += _force_steps(design, terms)
    if share is not None:
        terms |= _table(
            Quantity("P_m", "force on it, by the verdict's model", share, "N"),
            Quantity("epsilon", "nominal strain", limits(design).strain(share), "1"),
        )
        title, formula = "Nominal strain of the most loaded ridge", "2 * P_m / (E1 * L * (b_r + b_t))"
        finite = "Small strain holds up to about 0.1; beyond it a model of finite strain is needed."
        steps.append(_step(title, "epsilon", formula, terms, "force over modulus and mean area", finite))
    return steps


def _force_steps(design: Design, terms: dict[str, Quantity]) -> list[Calculation]:
    """The force from which on all ridges touch, and the approach under the asked one."""
    force, gaps = design.contact.force, winkler.crest_gaps(design)
    verdict = winkler.answer(design, Request(force))
    error, approach_error = (e.error or 0.0 for e in (verdict.all_touch_force, verdict.approach))
    touching = np.array([(ridge.value or 0.0) > 0 for ridge in verdict.ridge_force])
    which = "all ridges" if touching.all() else f"the {touching.sum()} ridges"
    terms = terms | _table(
        Quantity("F", "all-touch force", winkler.all_touch_force(design), "N"),
        Quantity("P", "contact.force", force, "N"),
        Quantity("delta", "approach after the first touch", verdict.approach.value or 0.0, "mm"),
    )
    return [
        _step(
            "Force from which on all ridges touch",
            "F",
            "sum(k_i * (g - g_i))",
            terms | _springs(design, np.full(gaps.shape, True)),
            FOUNDATION,
            f"As a model it is known to ± {error:.2g} N: ridges are independent springs here; their common "
            "base, slots and films are left out.",
        ),
        _step(
            f"Approach at {force:g} N",
            "delta",
            "(P + sum(k_i * g_i)) / sum(k_i)",
            terms | _springs(design, touching),
            FOUNDATION,
            f"Summed over {which} that touch. As a model it is known to ± {approach_error:.2g} mm.",
        ),
    ]


def _table(*quantities: Quantity) -> dict[str, Quantity]:
    return {quantity.symbol: quantity for quantity in quantities}


def _step(
    title: str, result: str, formula: str, terms: Mapping[str, Quantity], source: str, remark: str = ""
) -> Calculation:
    """A step whose result and quantities are among these terms."""
    symbols = dict.fromkeys(re.findall(r"[A-Za-z]\w*", formula))
    given = tuple(terms[symbol] for symbol in symbols if symbol in terms)
    return Calculation(title, terms[result], formula, given, source, remark)


def _contact_terms(design: Design) -> dict[str, Quantity]:
    """The quantities of all contact steps but forces and approaches."""
    skin, material, profile = skin_of(design), silicone(design), skin_of(design).profile
    depths, (base, column) = winkler.crest_depths(design), compliances(design)
    last, first = int(np.argmax(depths)), int(np.argmin(depths))
    which, gap = f"ridge {last + 1}", float(winkler.crest_gaps(design)[last])
    return _table(
        Quantity("E", f"Young's modulus of {material.name}", material.young_modulus.value, "MPa"),
        Quantity("nu", "Poisson's ratio", material.poisson_ratio, "1"),
        Quantity("E1", "plane-strain modulus", plane_modulus(design), "MPa"),
        Quantity("n", "ridges", skin.count, "1"),
        Quantity("T", "skin.thickness", skin.base.thickness, "mm"),
        Quantity("W", "skin.width", skin.base.width, "mm"),
        Quantity("L", "skin.length", design.skin.length, "mm"),
        Quantity("R", "skin.curvature_radius", design.skin.curvature_radius, "mm"),
        Quantity("h", "ridge height, the median one", median(skin.heights), "mm"),
        Quantity("b_r", "ridge.root_width", profile.root_width, "mm"),
        Quantity("b_t", "ridge.tip_width", profile.tip_width, "mm"),
        Quantity("c_b", "compliance of the base under a ridge", base, "1"),
        Quantity("c_r", "compliance of the ridge, of median height", column, "1"),
        Quantity("k", "stiffness of a ridge", winkler.ridge_stiffness(design), "N/mm"),
        Quantity("m", "pitches from the middle", abs(last - (skin.count - 1) / 2), "1"),
        Quantity("p", "ridge.pitch", skin.pitch, "mm"),
        Quantity("phi", f"lean of {which}", abs(skin.lean(last + 1)), "rad"),
        Quantity("h_l", f"height of {which}", skin.heights[last], "mm"),
        Quantity("h_m", "height of the highest ridge", max(skin.heights), "mm"),
        Quantity("z_p", f"rise of the plate over {which}", float(winkler.plate_rises(design)[last]), "mm"),
        Quantity("d_f", f"the same of ridge {first + 1}, the first", float(depths[first]), "mm"),
        Quantity("g", f"gap of {which} when the first one touches", gap, "mm"),
    )


def _springs(design: Design, chosen: Mask) -> dict[str, Quantity]:
    stiff, gaps = winkler.stiffnesses(design), winkler.crest_gaps(design)
    return _table(
        Quantity("k_i", "stiffness of each ridge", tuple(np.broadcast_to(stiff, gaps.shape)[chosen]), "N/mm"),
        Quantity("g_i", "gap of each ridge", tuple(gaps[chosen]), "mm"),
    )


def casting_calculations(job: Job) -> list[Calculation]:
    """Return the cavity's volume by the shrinkage, and the silicone to weigh."""
    other = job.bone is not None or (job.bent and job.skin.slot is not None)  # no one formula has them
    cavity, layers = [] if other else [_cavity(job)], pours(job)
    return [*cavity, *(step for layer in layers for step in _mass(layer, len(layers) > 1))]


def _cavity(job: Job) -> Calculation:
    slots = math.fsum(area(slot.loop()) for slot in job.section.slots) * job.design.skin.length
    pockets = math.fsum(cut.volume for cut in job.skin_part.cuts)
    words = "slots in it, which shims keep as they are"
    if pockets:  # their depth follows the shrinkage, as a slot's length does
        words = "pockets in it, which core pins keep as wide as they are"
    terms = _table(
        Quantity("V", "skin as designed", MM3 * job.skin_part.volume, "cm³"),
        Quantity("s", "linear shrinkage", job.shrinkage, "1"),
        Quantity("V_s", words, MM3 * (pockets or slots), "cm³"),
        Quantity("V_c", "skin in the mold", MM3 * job.closed.first(PartRole.SKIN).volume, "cm³"),
    )
    formula = "(V + V_s) / (1 - s)**3 - V_s / (1 - s)" if pockets or slots else "V / (1 - s)**3"
    title, source = "Cavity that cures to the skin", "the same shrinkage in all directions"
    return _step(title, "V_c", formula, terms, source)


def _mass(layer: LayerPour, one_of_several: bool) -> list[Calculation]:
    material, whose = layer.silicone, f"the layer of {layer.silicone.name}" if one_of_several else "the mold"
    a, b = material.mix or (1.0, 0.0)
    terms = _table(
        Quantity("rho", f"density of {material.name}", material.density * 1e-3, "g/cm³"),
        Quantity("V_p", "skin, gate, vents, reservoir, bleeds", MM3 * layer.filled, "cm³"),
        Quantity("m", f"silicone that {whose} takes", layer.mass, "g"),
        Quantity("m_0", "stays in cup and syringe", DEAD_VOLUME, "g"),
        Quantity("m_t", "silicone to mix", layer.batch, "g"),
        Quantity("a", "parts of A", a, "1"),
        Quantity("b", "parts of B", b, "1"),
        Quantity("m_A", "component A to weigh", (layer.mass + DEAD_VOLUME) * a / (a + b), "g"),
    )
    steps = [
        _step(f"Silicone that {whose} takes", "m", "rho * V_p", terms, "mass is density times volume"),
        _step("Silicone to mix", "m_t", "m + m_0", terms, "assumption of the casting sheet"),
    ]
    if material.mix:
        steps.append(_step("Component A", "m_A", "m_t * a / (a + b)", terms, "mix by mass, data sheet"))
    return steps


def strip_calculations(design: Design) -> list[Calculation]:
    """Return a strip's electrode and its charge by the stress through it; none without films."""
    film, slot = design.film, skin_of(design).slot
    if film is None or slot is None:
        return []
    inside, coefficients = electrode(design), (film.d31, film.d32, film.d33)
    unit_charge = charge(1.0, 0.0, 0.0, area=inside, coefficients=coefficients)
    terms = _table(
        Quantity("L", "skin.length", design.skin.length, "mm"),
        Quantity("b", "slot.depth", slot.depth, "mm"),
        Quantity("e", "bare margin of the film", film.margin, "mm"),
        Quantity("A", "electrode in the skin, of one strip", inside, "mm²"),
        Quantity("d_33", "film.d33", film.d33, "pC/N"),
        Quantity("sigma", "stress through the film, tension positive", 1.0, "MPa"),
        Quantity("Q", "charge", float(unit_charge) / PICO, "pC"),
    )
    return [
        _step("Electrode of a strip", "A", "(L - 2 * e) * (b - 2 * e)", terms, "the cutting pattern"),
        _step("Charge of a strip by 1 MPa through it", "Q", "A * d_33 * sigma", terms, PIEZO),
    ]


def scene_calculations(
    simulation: Simulation, amplifier: Circuit, circuit_gain: CircuitGain
) -> list[Calculation]:
    """Return a strip's charge where the scene's differential stress is largest, its capacitance with the
    lead, and what the ideal amplifier makes of 1 N on the film, by the network's own beside it.

    `amplifier` is the circuit fitted to the skin, `circuit_gain` its gain.
    """
    charge = _largest_charge(simulation, amplifier)
    return [*([charge] if charge else []), _capacitance(amplifier), _ideal(amplifier, circuit_gain)]


def _largest_charge(simulation: Simulation, amplifier: Circuit) -> Calculation | None:
    """The charge of the monitored strip at the step of the largest differential stress of all."""
    from skincad.effects.piezo import strip_charges

    design, film = simulation.scene.design, simulation.scene.design.film
    if not simulation.raw or film is None:
        return None
    ridge = max(simulation.raw, key=lambda r: float(np.abs(simulation.raw[r]).max()))
    step = int(np.argmax(np.abs(simulation.raw[ridge])))
    stress = np.array([simulation.march.readings[step].films])
    strip = 2 * (ridge - 1)
    charges = strip_charges(amplifier, design, stress)[0]
    through, transverse, along = (float(value) for value in stress[0, strip])
    drawn, other = (along, transverse) if amplifier.film.draw_axis == "length" else (transverse, along)
    terms = _table(
        Quantity("Q", "charge", float(charges[strip]) / PICO, "pC"),
        Quantity("A", "electrode in the skin", electrode(design), "mm²"),
        Quantity("d_31", "film.d31", film.d31, "pC/N"),
        Quantity("T_1", "stress along the draw axis", drawn, "MPa"),
        Quantity("d_32", "film.d32", film.d32, "pC/N"),
        Quantity("T_2", "stress across it, in the film", other, "MPa"),
        Quantity("d_33", "film.d33", film.d33, "pC/N"),
        Quantity("T_3", "stress through the film", through, "MPa"),
    )
    title = f"Charge of S1 in ridge {ridge} at step {step}, where the differential stress is largest"
    formula = "A * (d_31 * T_1 + d_32 * T_2 + d_33 * T_3)"
    return _step(
        title, "Q", formula, terms, PIEZO, "Stresses are those of the scene's run, before the low-pass."
    )


def _capacitance(amplifier: Circuit) -> Calculation:
    film = amplifier.film
    static_capacitance = capacitance(film.area, film.thickness, film.permittivity)
    terms = _table(
        Quantity("C", "static capacitance", static_capacitance / PICO, "pF"),
        Quantity("epsilon_0", "permittivity of vacuum", EPSILON_0, "pF/mm"),
        Quantity("epsilon_r", "film.permittivity of the circuit", film.permittivity, "1"),
        Quantity("A_w", "electrode in the skin; the leads do not overlap", film.area, "mm²"),
        Quantity("t", "film.thickness", film.thickness, "mm"),
    )
    return _step("Capacitance of a strip", "C", "epsilon_0 * epsilon_r * A_w / t", terms, PLATES)


def _ideal(amplifier: Circuit, circuit_gain: CircuitGain) -> Calculation:
    """What an ideal amplifier makes of 1 N on the film at the mid-band, against the network's own gain."""
    c = constants(amplifier)
    frequency, decibels = circuit_gain.mid_band
    turn, charge_by_1_N = 2 * math.pi * frequency * c.feedback_resistance, abs(c.d33)
    given = (
        Quantity("d", "charge by 1 N, the circuit's d33", charge_by_1_N / PICO, "pC/N"),
        Quantity("C_p", "film, lead and cable", c.capacitance / PICO, "pF"),
        Quantity("C_i", "amplifier.input_capacitance", c.input_capacitance / PICO, "pF"),
        Quantity("f", "frequency", frequency / KILO, "kHz"),
        Quantity("R_f", "amplifier.feedback_resistance", c.feedback_resistance / GIGA, "GΩ"),
        Quantity("C_f", "amplifier.feedback_capacitance", c.feedback_capacitance / PICO, "pF"),
    )
    if amplifier.amplifier.topology == "follower":
        formula, value = "d / (C_p + C_i)", charge_by_1_N / (c.capacitance + c.input_capacitance)
        source = "Horowitz and Hill, The Art of Electronics, 3rd ed., sec. 4.2.3"
    elif not c.feedback_capacitance:
        formula, value = "2 * pi * f * R_f * d", turn * charge_by_1_N
        source = "ideal operational amplifier in the network of Yamada et al. 2002, Figs 5 and 6"
    else:
        formula = "2 * pi * f * R_f * d / sqrt(1 + (2 * pi * f * R_f * C_f)**2)"
        value = turn * charge_by_1_N / math.sqrt(1 + (turn * c.feedback_capacitance) ** 2)
        source = "ideal operational amplifier, its feedback a resistor beside a capacitor"
    network = 10 ** (decibels / 20)
    symbols = re.findall(r"[A-Za-z]\w*", formula)
    return Calculation(
        f"Output of the ideal amplifier by 1 N on the film, at {frequency:.4g} Hz, the mid-band",
        Quantity("G", "gain", value, "V/N"),
        formula,
        tuple(quantity for quantity in given if quantity.symbol in symbols),
        source,
        f"The whole network, with its finite gain and its motional branch, gives {network:.4g} V/N there.",
    )
