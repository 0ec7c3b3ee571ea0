"""The closed forms of casting and of a film strip: the cavity, the silicone to weigh, a strip's charge."""

from __future__ import annotations

import math

from skincad.base.formula import Calculation, Quantity
from skincad.circuit.film import PICO, charge, electrode
from skincad.fabrication.sheet import DEAD_VOLUME, poured_volume
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.curves import area
from skincad.shape.skin import section, skin_of
from skincad.solids.mold import ClosedMold
from skincad.solids.roles import PartRole
from skincad.solids.shrinkage import shrinkage
from skincad.solids.skin import skin_part

PIEZO = "IEEE Std 176-1987: D₃ = d₃₁T₁ + d₃₂T₂ + d₃₃T₃"
MM3 = 1e-3  # cm3


def casting_calculations(design: Design, closed: ClosedMold) -> list[Calculation]:
    """Return the cavity's volume by the shrinkage, and the silicone to weigh."""
    cavity = [] if _bent_with_slots(design) else [_cavity(design, closed)]
    return [*cavity, *_mass(design, closed)]


def _bent_with_slots(design: Design) -> bool:
    return skin_of(design).slot is not None and design.skin.curvature_radius_y is not None


def _cavity(design: Design, closed: ClosedMold) -> Calculation:
    skin, cavity = skin_part(design).volume, closed.first(PartRole.SKIN).volume
    slots = math.fsum(area(slot.loop()) for slot in section(design).slots) * design.skin.length
    quantities = [
        Quantity("V", "skin as designed", MM3 * skin, "cm³"),
        Quantity("s", "linear shrinkage", shrinkage(design), "1"),
    ]
    if slots:
        quantities.append(Quantity("V_s", "slots in it, which shims keep as they are", MM3 * slots, "cm³"))
    return Calculation(
        "Cavity that cures to the skin",
        Quantity("V_c", "skin in the mold", MM3 * cavity, "cm³"),
        "(V + V_s) / (1 - s)**3 - V_s / (1 - s)" if slots else "V / (1 - s)**3",
        tuple(quantities),
        "the same shrinkage in all directions",
    )


def _mass(design: Design, closed: ClosedMold) -> list[Calculation]:
    material, volume = silicone(design), poured_volume(design, closed)
    grams = volume * material.density * 1e-6
    mold_mass = Quantity("m", "silicone that the mold takes", grams, "g")
    total = Quantity("m_t", "silicone to mix", grams + DEAD_VOLUME, "g")
    calculations = [
        Calculation(
            "Silicone that the mold takes",
            mold_mass,
            "rho * V_p",
            (
                Quantity("rho", f"density of {material.name}", material.density * 1e-3, "g/cm³"),
                Quantity("V_p", "skin, gate, vents, reservoir, bleeds", MM3 * volume, "cm³"),
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
