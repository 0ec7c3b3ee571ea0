"""The closed forms behind a verdict, of casting and of a film strip, as lines of formula, number and source.

Each result comes from the function that the program itself uses; tests hold it against its formula, which is
Python's arithmetic, and the numbers that are printed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from statistics import median
from types import MappingProxyType

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.circuit.network import PICO, charge, electrode
from skincad.fabrication.job import Job
from skincad.fabrication.pouring import DEAD_VOLUME, LayerPour, pours
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.models import winkler
from skincad.mechanics.models.winkler import compliances
from skincad.mechanics.problem import Answer, Request
from skincad.mechanics.validity import limits, plane_modulus
from skincad.outputs.pages import paragraph, rounded, table
from skincad.shape.curves import area
from skincad.shape.skin import skin_of
from skincad.solids.plan import PartRole

FOUNDATION = "elastic foundation: Johnson, Contact Mechanics, 1985, sec. 4.3"
ON_A_CIRCLE = "geometry of the base circle"
PIEZO = "IEEE Std 176-1987: D₃ = d₃₁T₁ + d₃₂T₂ + d₃₃T₃"
MM3 = 1e-3  # cm3


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


def calculation(step: Calculation) -> str:
    """Return a step as lines of HTML: formula, numbers put in, result; symbols; source."""
    numbers = {term.symbol: rounded(term.value) for term in step.given if not isinstance(term.value, tuple)}
    many = "" if len(numbers) == len(step.given) else " with the ridges' values of the table below"
    symbols = [
        signs(term.symbol) + escape(f" = {term}, " if term.symbol in numbers else " ") + escape(term.meaning)
        for term in step.given
    ]
    return (
        f'<div class="step">\n<h3>{escape(step.title)}</h3>\n'
        f'<p class="formula">{signs(step.result.symbol)} = {signs(step.formula)}<br>\n'
        f"= {signs(step.formula, numbers)}{many} "
        f'<span class="result">= {escape(str(step.result))}</span></p>\n'
        f'<p class="small">{"; ".join(symbols)}.<br>Source: {escape(step.source)}.</p>\n'
        f"{paragraph(step.remark, 'small') if step.remark else ''}</div>\n"
    )


def signs(formula: str, numbers: Mapping[str, str] = MappingProxyType({})) -> str:
    """Return a formula as HTML, with numbers in the place of some symbols."""

    def sign(match: re.Match[str]) -> str:
        letter, _, index = match[0].partition("_")
        number = numbers.get(match[0], "")
        symbol = SIGNS.get(letter, letter) + (f"<sub>{index}</sub>" if index else "")
        return f"({number})" if number.startswith("−") else number or symbol  # noqa: RUF001

    powers = re.sub(r"\*\*(\d)", r"<sup>\1</sup>", re.sub(r"[A-Za-z]\w*", sign, formula))
    return powers.replace("*", "·").replace("-", "−")  # noqa: RUF001


def ridge_table(quantities: Sequence[Quantity]) -> str:
    """Return the table of what differs from ridge to ridge."""
    columns = [quantity.value for quantity in quantities if isinstance(quantity.value, tuple)]
    heads = ["ridge i", *(", ".join(filter(None, (term.symbol, str(term)))) for term in quantities)]
    rows = [(ridge, *row) for ridge, row in enumerate(zip(*columns, strict=True), 1)]
    return table(heads, rows, "small")


def contact_calculations(design: Design, share: float | None = None) -> list[Calculation]:
    """Return the foundation's verdict, step by step; `share` N is the force on the most loaded ridge by the
    verdict's model, for its strain."""
    steps = [*_stiffness(design), *_gap(design)]
    if design.skin.curvature_radius_y is None:
        verdict = winkler.answer(design, Request(design.contact.force))
        steps += [_all_touch(design, verdict), _approach(design, verdict)]
    return steps if share is None else [*steps, _strain(design, share)]


def _stiffness(design: Design) -> list[Calculation]:
    """The modulus, the two springs of a ridge, and both in series."""
    material, skin, (base, column) = silicone(design), skin_of(design), compliances(design)
    modulus = Quantity("E1", "plane-strain modulus", plane_modulus(design), "MPa")
    base_compliance = Quantity("c_b", "compliance of the base under a ridge", base, "1")
    ridge_compliance = Quantity("c_r", "compliance of the ridge, of median height", column, "1")
    young = (
        Quantity("E", f"Young's modulus of {material.name}", material.young_modulus.value, "MPa"),
        Quantity("nu", "Poisson's ratio", material.poisson_ratio, "1"),
    )
    under = (
        Quantity("n", "ridges", skin.count, "1"),
        Quantity("T", "skin.thickness", skin.base.thickness, "mm"),
        Quantity("W", "skin.width", skin.base.width, "mm"),
    )
    itself = (
        Quantity("h", "ridge height, the median one", median(skin.heights), "mm"),
        Quantity("b_r", "ridge.root_width", skin.profile.root_width, "mm"),
        Quantity("b_t", "ridge.tip_width", skin.profile.tip_width, "mm"),
    )
    plane_strain = "plane strain: Johnson, Contact Mechanics, 1985, ch. 2"
    return [
        Calculation("Modulus in plane strain", modulus, "E / (1 - nu**2)", young, plane_strain),
        Calculation("A ridge's part of the base", base_compliance, "n * T / W", under, FOUNDATION),
        Calculation("The ridge itself", ridge_compliance, "2 * h / (b_r + b_t)", itself, FOUNDATION),
        Calculation(
            "Stiffness of a ridge on its foundation",
            Quantity("k", "stiffness of a ridge", winkler.ridge_stiffness(design), "N/mm"),
            "E1 * L / (c_b + c_r)",
            (
                modulus,
                Quantity("L", "skin.length", design.skin.length, "mm"),
                base_compliance,
                ridge_compliance,
            ),
            FOUNDATION,
            "Base and ridge are two springs in series.",
        ),
    ]


def _gap(design: Design) -> list[Calculation]:
    """The approach at which the last ridge touches."""
    skin = skin_of(design)
    depths = winkler.crest_depths(design)
    last = int(np.argmax(depths))
    lean = Quantity("phi", f"lean of ridge {last + 1}", abs(skin.lean(last + 1)), "rad")
    radius = Quantity("R", "skin.curvature_radius", design.skin.curvature_radius, "mm")
    lean_calculation = Calculation(
        f"Lean of ridge {last + 1}, the last to touch",
        lean,
        "m * p / R",
        (
            Quantity("m", "pitches from the middle", abs(last - (skin.count - 1) / 2), "1"),
            Quantity("p", "ridge.pitch", skin.pitch, "mm"),
            radius,
        ),
        ON_A_CIRCLE,
    )
    height = Quantity("h_l", f"height of ridge {last + 1}", skin.heights[last], "mm")
    formula, more = _gap_corrections(design, depths, last)
    gap = float(winkler.crest_gaps(design)[last])
    gap_calculation = Calculation(
        f"Approach needed until ridge {last + 1} touches",
        Quantity("g", f"gap of ridge {last + 1} when the first one touches", gap, "mm"),
        f"2 * (R + h_l) * sin(phi / 2)**2{formula}",
        (radius, height, lean, *more),
        ON_A_CIRCLE,
    )
    return [gap_calculation] if skin.count == 1 else [lean_calculation, gap_calculation]


def _gap_corrections(design: Design, depths: Array, last: int) -> tuple[str, list[Quantity]]:
    """Terms of a gap besides the circle's fall: the plate's rise, different heights, the first touch."""
    skin = skin_of(design)
    formula, quantities, first = "", list[Quantity](), int(np.argmin(depths))
    if design.contact.plate.shape != "flat":
        formula += " + z_p"
        rises = float(winkler.plate_rises(design)[last])
        quantities.append(Quantity("z_p", f"rise of the plate over ridge {last + 1}", rises, "mm"))
    if skin.uneven:
        formula += " + (h_m - h_l)"
        quantities.append(Quantity("h_m", "height of the highest ridge", max(skin.heights), "mm"))
    if depths[first]:
        formula += " - d_f"
        quantities.append(
            Quantity("d_f", f"the same of ridge {first + 1}, the first", float(depths[first]), "mm")
        )
    return formula, quantities


def _springs(design: Design, chosen: Mask) -> tuple[Quantity, Quantity]:
    stiff, gaps = winkler.stiffnesses(design), winkler.crest_gaps(design)
    return (
        Quantity("k_i", "stiffness of each ridge", tuple(np.broadcast_to(stiff, gaps.shape)[chosen]), "N/mm"),
        Quantity("g_i", "gap of each ridge", tuple(gaps[chosen]), "mm"),
    )


def _all_touch(design: Design, answer: Answer) -> Calculation:
    gaps = winkler.crest_gaps(design)
    error = answer.all_touch_force.error or 0.0
    return Calculation(
        "Force from which on all ridges touch",
        Quantity("F", "all-touch force", winkler.all_touch_force(design), "N"),
        "sum(k_i * (g - g_i))",
        (
            Quantity("g", "gap of the last ridge", float(gaps.max()), "mm"),
            *_springs(design, np.ones(gaps.size, dtype=bool)),
        ),
        FOUNDATION,
        f"As a model it is known to ± {error:.2g} N: ridges are independent springs here; their common base, "
        "slots and films are left out.",
    )


def _approach(design: Design, answer: Answer) -> Calculation:
    force, error = design.contact.force, answer.approach.error or 0.0
    touching = np.array([(share.value or 0.0) > 0 for share in answer.ridge_force])
    count = int(touching.sum())
    which = "all ridges" if count == touching.size else f"the {count} ridges"
    return Calculation(
        f"Approach at {force:g} N",
        Quantity("delta", "approach after the first touch", answer.approach.value or 0.0, "mm"),
        "(P + sum(k_i * g_i)) / sum(k_i)",
        (Quantity("P", "contact.force", force, "N"), *_springs(design, touching)),
        FOUNDATION,
        f"Summed over {which} that touch. As a model it is known to ± {error:.2g} mm.",
    )


def _strain(design: Design, share: float) -> Calculation:
    profile = skin_of(design).profile
    return Calculation(
        "Nominal strain of the most loaded ridge",
        Quantity("epsilon", "nominal strain", limits(design).strain(share), "1"),
        "2 * P_m / (E1 * L * (b_r + b_t))",
        (
            Quantity("P_m", "force on it, by the verdict's model", share, "N"),
            Quantity("E1", "plane-strain modulus", plane_modulus(design), "MPa"),
            Quantity("L", "skin.length", design.skin.length, "mm"),
            Quantity("b_r", "ridge.root_width", profile.root_width, "mm"),
            Quantity("b_t", "ridge.tip_width", profile.tip_width, "mm"),
        ),
        "force over modulus and mean area",
        "Small strain holds up to about 0.1; beyond it a model of finite strain is needed.",
    )


def casting_calculations(job: Job) -> list[Calculation]:
    """Return the cavity's volume by the shrinkage, and the silicone to weigh."""
    cavity, layers = [] if job.bent and job.skin.slot else [_cavity(job)], pours(job)
    return [*cavity, *(step for layer in layers for step in _mass(layer, len(layers) > 1))]


def _cavity(job: Job) -> Calculation:
    skin, cavity = job.skin_part.volume, job.closed.first(PartRole.SKIN).volume
    slots = math.fsum(area(slot.loop()) for slot in job.section.slots) * job.design.skin.length
    pockets = math.fsum(cut.volume for cut in job.skin_part.cuts)
    quantities = [
        Quantity("V", "skin as designed", MM3 * skin, "cm³"),
        Quantity("s", "linear shrinkage", job.shrinkage, "1"),
    ]
    if slots:
        quantities.append(Quantity("V_s", "slots in it, which shims keep as they are", MM3 * slots, "cm³"))
    if pockets:  # their depth follows the shrinkage, as a slot's length does
        slots, words = pockets, "pockets in it, which core pins keep as wide as they are"
        quantities.append(Quantity("V_s", words, MM3 * slots, "cm³"))
    return Calculation(
        "Cavity that cures to the skin",
        Quantity("V_c", "skin in the mold", MM3 * cavity, "cm³"),
        "(V + V_s) / (1 - s)**3 - V_s / (1 - s)" if slots else "V / (1 - s)**3",
        tuple(quantities),
        "the same shrinkage in all directions",
    )


def _mass(layer: LayerPour, one_of_several: bool) -> list[Calculation]:
    material, grams = layer.silicone, layer.mass
    whose = f"the layer of {material.name}" if one_of_several else "the mold"
    mold_mass = Quantity("m", f"silicone that {whose} takes", grams, "g")
    total = Quantity("m_t", "silicone to mix", layer.batch, "g")
    calculations = [
        Calculation(
            f"Silicone that {whose} takes",
            mold_mass,
            "rho * V_p",
            (
                Quantity("rho", f"density of {material.name}", material.density * 1e-3, "g/cm³"),
                Quantity("V_p", "skin, gate, vents, reservoir, bleeds", MM3 * layer.filled, "cm³"),
            ),
            "mass is density times volume",
        ),
        Calculation(
            "Silicone to mix",
            total,
            "m + m_0",
            (mold_mass, Quantity("m_0", "stays in cup and syringe", DEAD_VOLUME, "g")),
            "assumption of the casting sheet",
        ),
    ]
    if material.mix:
        a, b = material.mix
        shares = Quantity("a", "parts of A", a, "1"), Quantity("b", "parts of B", b, "1")
        part = Quantity("m_A", "component A to weigh", (grams + DEAD_VOLUME) * a / (a + b), "g")
        calculations.append(
            Calculation("Component A", part, "m_t * a / (a + b)", (total, *shares), "mix by mass, data sheet")
        )
    return calculations


def strip_calculations(design: Design) -> list[Calculation]:
    """Return a strip's electrode and its charge by the stress through it; none without films."""
    film, slot = design.film, skin_of(design).slot
    if film is None or slot is None:
        return []
    inside = Quantity("A", "electrode in the skin, of one strip", electrode(design), "mm²")
    coefficients = (film.d31, film.d32, film.d33)
    unit_charge = charge(1.0, 0.0, 0.0, area=inside.value, coefficients=coefficients)  # type: ignore[arg-type]
    return [
        Calculation(
            "Electrode of a strip",
            inside,
            "(L - 2 * e) * (b - 2 * e)",
            (
                Quantity("L", "skin.length", design.skin.length, "mm"),
                Quantity("b", "slot.depth", slot.depth, "mm"),
                Quantity("e", "bare margin of the film", film.margin, "mm"),
            ),
            "the cutting pattern",
        ),
        Calculation(
            "Charge of a strip by 1 MPa through it",
            Quantity("Q", "charge", float(unit_charge) / PICO, "pC"),
            "A * d_33 * sigma",
            (
                inside,
                Quantity("d_33", "film.d33", film.d33, "pC/N"),
                Quantity("sigma", "stress through the film, tension positive", 1.0, "MPa"),
            ),
            PIEZO,
        ),
    ]
