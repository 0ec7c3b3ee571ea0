"""The film's own values: capacitance from its size, charge from the three stresses.

Source: parallel plates (the edge's stray field left out: right while the electrode is much wider than the
film is thick); piezoelectric charge D3 = d31 T1 + d32 T2 + d33 T3 (IEEE Std 176-1987), 1 the draw axis.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.constants import epsilon_0

from skincad.inputs.design import Design
from skincad.shape.skin import skin_of

MM, MM2 = 1e-3, 1e-6  # m, m2
PICO = 1e-12


def electrode(design: Design) -> float:
    """Return the area of a strip's electrode, mm2: where the metal of both faces lies over each other, as the
    cutting pattern draws it; bare at its edges and at both ends of the skin.

    It gives the charge and has the capacitance. The leads of the two faces run side by side and overlap
    nowhere (fabrication/electrodes.py): they have no piezoelectric part, and only a stray capacitance, which
    is left out. As coplanar strips (C = eps K(k') / K(k), k = gap / (gap + 2 width); Gupta, Garg, Bahl,
    Bhartia, Microstrip Lines and Slotlines, 2nd ed. 1996, chapter 7) it lies between that in air and that on
    a half space of film: 0.02 to 0.12 pF a millimetre of lead in `yamada-2002`, about that of a cable.
    """
    slot = skin_of(design).slot
    assert design.film is not None
    assert slot is not None
    margin = design.film.margin
    return (design.skin.length - 2 * margin) * (slot.depth - 2 * margin)


def capacitance(area: float, thickness: float, permittivity: float) -> float:
    """Return the film's static capacitance, F, of electrodes in mm2 and a thickness in mm."""
    return float(epsilon_0) * permittivity * area * MM2 / (thickness * MM)


def charge(
    through: ArrayLike,
    along: ArrayLike,
    transverse: ArrayLike,
    *,
    area: float,
    coefficients: tuple[float, float, float],
    draw_axis: Literal["length", "width"] = "length",
) -> NDArray[np.float64]:
    """Return the charge on a strip, C, from mean stresses in MPa, tension positive, of any one shape.

    `through` the film, `along` the strip's length (y) and `across` its width in the section. In plane strain
    `along` is not zero: it counts as much as the others. `area` mm2; `coefficients` d31, d32, d33 in pC/N.
    """
    d31, d32, d33 = (d * PICO for d in coefficients)
    of_length, of_width = (d31, d32) if draw_axis == "length" else (d32, d31)
    total = d33 * np.asarray(through) + of_length * np.asarray(along) + of_width * np.asarray(transverse)
    return np.asarray(area * total, float)  # MPa times mm2 is N
