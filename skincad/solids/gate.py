"""How wide the pouring gate is: so wide that a thumb fills the mold in its time, where the skin has room.

A front of silicone, h deep on a floor tilted by a, levels itself at most at rho g h^2 sin(a) / (3 mu)
(Nusselt's film; Bird, Stewart and Lightfoot, Transport Phenomena, sec. 2.2). What the thumb presses
meanwhile: 128 mu l Q / (pi d^4) in the tip or the gate, by the plunger's area (Hagen-Poiseuille; silicones
thin a little as they are sheared, which is left out). Range: Newtonian, a mix that is fresh.
"""

from __future__ import annotations

import math

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import Section

GRAVITY = 9.81  # m/s2
# mm, source: outer and inner diameters of needle tubing by gauge (Birmingham wire gauge, regular wall)
TIPS = {
    10: (3.40, 2.69),
    12: (2.77, 2.16),
    14: (2.11, 1.60),
    16: (1.65, 1.19),
    18: (1.27, 0.84),
    20: (0.91, 0.60),
    22: (0.72, 0.41),
    25: (0.51, 0.26),
}
TIP_LENGTH = 12.7  # mm, source: blunt tips are sold half an inch long
TIP_PLAY = 0.1  # mm, assumption: least play of a tip in the gate
TUBE_WALL = 0.5  # mm, assumption: of a tube in a gate that is wider than the largest tip
LUER = (4.03, 4.48)  # mm, source: ISO 80369-7, male slip, largest at its end, and 7.5 mm of 6 % behind
LUER_BORE, LUER_LENGTH = 2.1, 10.0  # mm, assumption: of a plastic syringe's slip
# ml and mm, source: inner diameters that makers of plastic syringes state for pumps
SYRINGES = {5: 12.06, 10: 14.5, 20: 19.13, 30: 21.7, 60: 26.72}
THUMB = 30.0  # N, assumption: what a thumb presses for minutes; it can do three times as much for seconds
WIDTHS = (2.0, 2.3, 2.9, 3.5, 4.2)  # mm, of a gate: for tips of 16, 14, 12 and 10 gauge, and a luer slip
BESIDE = 1.3  # assumption: what is poured by the skin's volume: vent, cup, holes and flash besides


def wanted_gate(design: Design, shape: Section) -> float:
    """Return the narrowest usual gate, mm, through which a thumb fills the mold in its time; `design` is what
    is poured, `shape` its section."""
    material, choice = silicone(design), design.mold
    volume = BESIDE * shape.area * design.skin.length * choice.cavities
    plunger = next((wide for ml, wide in SYRINGES.items() if 1000 * ml >= volume), max(SYRINGES.values()))
    seconds = max(filling_time(design), choice.fill_time)
    forces = {wide: press(material.viscosity, volume, wide, plunger) / seconds for wide in WIDTHS}
    return next((wide for wide, force in forces.items() if force <= THUMB), WIDTHS[-1])


def filling_time(design: Design) -> float:
    """Return the least time in which a front keeps its slope along the skin, s."""
    skin, tilt, material = design.skin, math.radians(max(design.mold.pour_tilt, 1.0)), silicone(design)
    weight = material.density * GRAVITY * math.sin(tilt) * (1e-3 * skin.thickness) ** 2
    return 3 * material.viscosity * 1e-3 * skin.length / weight


def press(viscosity: float, volume: float, gate: float, plunger: float) -> float:
    """Return the thumb's force times the time in which a volume, mm3, is pressed through a gate, N s: it
    falls as the time grows. Viscosity in Pa s, the plunger's diameter in mm."""
    length, bore = outlet(gate)
    pressure = 128 * viscosity * length * 1e-3 * volume * 1e-9 / (math.pi * (bore * 1e-3) ** 4)
    return pressure * math.pi / 4 * (plunger * 1e-3) ** 2


def tip(gate: float) -> int | None:
    """Return the gauge of the widest blunt tip that goes into a gate; None where a luer slip or a tube
    does."""
    if gate >= LUER[0]:
        return None
    return next((gauge for gauge, (outer, _) in TIPS.items() if outer + TIP_PLAY <= gate), None)


def outlet(gate: float) -> tuple[float, float]:
    """Return length and bore, mm, of what the silicone is pressed through."""
    if (gauge := tip(gate)) is not None:
        return TIP_LENGTH, TIPS[gauge][1]
    if LUER[0] <= gate <= LUER[1]:
        return LUER_LENGTH, LUER_BORE
    return TIP_LENGTH, max(gate - TIP_PLAY - 2 * TUBE_WALL, gate / 2)
