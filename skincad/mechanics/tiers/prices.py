"""Cost model: predicted times, and the size of a problem that they depend on.

The tiers' laws stand in table.py, those of the yield and of friction here. They were fitted to the templates
(`skincad accuracy`, ladder contact) on one core of an idle AMD EPYC. Measurements on this machine
(measured.py) scale them. A check also scales them by the time of its linear tier.
"""

from __future__ import annotations

from dataclasses import dataclass

from skincad.inputs.design import Design
from skincad.mechanics.problem import Pad, pad_of
from skincad.shape.skin import skin_of


@dataclass(frozen=True)
class CostModel:
    """`seconds` at a `size`, and its exponent; s of one core of the machine it was fitted on."""

    size: float
    seconds: float
    exponent: float

    def at(self, size: float) -> float:
        """Return the expected time, s."""
        return float(self.seconds * (size / self.size) ** self.exponent)


# Beside the tiers, by ridges. Yield: 0.17 s with 3, 0.4 to 0.7 with 9, 1.0 to 1.3 with 20, 4.9 with 40;
# within a factor of 1.6, but 2.6 too low on fingertip-soft. Friction: 0.3, 3.8 and 15 s with 9, 33 and 60
OVERHEAD = {"yield": CostModel(9, 0.47, 1.3), "friction": CostModel(9, 0.3, 2.06)}


def any_size(_: Design) -> float:
    """Return the size where the time does not depend on the design."""
    return 1.0


def plane_unknowns(design: Design) -> float:
    """Return about how many unknowns the plane has, order 3: within 30 % on the templates.

    Of a mirror-symmetric pad half is solved.
    """
    skin = skin_of(design)
    slots = skin.slot is not None and design.film_state != "ignored"
    mirrored = design.contact.plate.shape == "flat" and skin.heights == skin.heights[::-1]
    half = 0.5 if mirrored else 1.0
    return half * (3000 + skin.count * (3000 if slots else 1900))


def coarse_solid_unknowns(design: Design) -> float:
    """Return the unknowns of the coarse solid that corrects the plane, its section of order 2."""
    from skincad.mechanics.tiers.corrected import plain_pad

    return _solid_unknowns(plain_pad(design), 2)


def solid_unknowns(design: Design) -> float:
    """Return the unknowns of the solid on its first rung, its section of order 3."""
    return _solid_unknowns(pad_of(design), 3)


def _solid_unknowns(pad: Pad, order: int) -> float:
    """Unknowns of the coarse solid at an order in the section, by its mesh: a few hundredths of its price."""
    from skincad.mechanics.bodies import elements, layers
    from skincad.mechanics.bodies.meshed import meshed_piece
    from skincad.mechanics.tiers.corrected import LAYERS
    from skincad.mechanics.tiers.solid_level import coarse_sizes

    meshed = meshed_piece(pad, coarse_sizes(pad, 1.0))
    mesh = elements.curved(meshed.mesh, 1)
    functions = mesh.nv + (order - 1) * mesh.nedge + (mesh.ne if order > 2 else 0)
    height, half = meshed.height / meshed.unit, meshed.whole.length / 2 / meshed.unit
    borders = layers.graded(half, LAYERS.last * height, LAYERS.growth)
    return float(3 * functions * layers.line(borders, LAYERS.order).at.size)
