"""The film's own values: capacitance from its size, charge from the three stresses.

Source: parallel plates (the edge's stray field left out: right while the electrode is much wider than the
film is thick); piezoelectric charge D3 = d31 T1 + d32 T2 + d33 T3 (IEEE Std 176-1987), 1 the draw axis.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.constants import epsilon_0

from skincad.inputs.design import Design

MM, MM2 = 1e-3, 1e-6  # m, m2
PICO = 1e-12


@dataclass(frozen=True)
class Electrode:
    """Areas in mm2: what lies in the skin gives charge, the whole with its lead has capacitance."""

    inside: float
    whole: float


def electrode(design: Design) -> Electrode:
    """Return a strip's electrode, mm2, as the cutting pattern draws it: bare at its edges and its far end.

    The lead's own cut corner (half the depth, shorter) is left out: the capacitance of a strip is that of the
    electrode in the skin and of `film.lead` beyond it.
    """
    assert design.film is not None
    assert design.slot is not None
    margin = design.film.electrode_margin
    across = design.slot.depth - 2 * margin
    inside = (design.skin.length - margin) * across
    return Electrode(inside, inside + max(0.0, design.film.lead - margin) * across)


def capacitance(area: float, thickness: float, permittivity: float) -> float:
    """Return the film's static capacitance, F, of electrodes in mm2 and a thickness in mm."""
    return float(epsilon_0) * permittivity * area * MM2 / (thickness * MM)


def charge(
    through: ArrayLike,
    along: ArrayLike,
    across: ArrayLike,
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
    total = d33 * np.asarray(through) + of_length * np.asarray(along) + of_width * np.asarray(across)
    return np.asarray(area * total, float)  # MPa times mm2 is N
