"""Pins as springs under a plate that presses and pulls: one contact point a pin, for scenes.

A pin gives way along its axis, across it, and turns its tip (pin_cell.py); its foot goes with the base, which
all pins push, pull and tilt. Tip and plate meet by Hertz when pressed and by Mindlin when pulled, both at the
force that the pin bears under the scene's largest normal force: Johnson, Contact Mechanics, 1985, eqs. 4.23
and 7.42. So the forces are those of the reduced model there; at smaller forces a contact is softer than here.
Small strain; a pin sticks or slips as a whole.
"""

from __future__ import annotations

import math

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.film.sliding import ContactPad
from skincad.mechanics.models.pin_cell import PinCell, crown_radius
from skincad.mechanics.models.reduced import PinCells, pin_cells, pin_model, pin_tops, pressed
from skincad.mechanics.problem import SizeError
from skincad.shape.skin import skin_of

MOST = 500  # pins: the dense block of a step
UNLOADED = 0.1  # of the mean force: what stands for that of a pin which bears less


def pin_springs(design: Design, force: float) -> ContactPad:
    """Return the pad of a design of pins, for normal forces up to `force` N.

    Raises SizeError for more pins than a dense block holds.
    """
    skin, count = skin_of(design), skin_of(design).count
    if count > MOST:
        raise SizeError("pin", f"a scene takes at most {MOST} pins", count, "take a larger pitch")
    cells, model = pin_cells(design), pin_model(design)
    borne, approach = pressed(model, force)
    least = np.maximum(borne, UNLOADED * force / count)
    indentation = np.where(
        borne == least,
        approach - model.gap - model.coupling @ borne,
        np.interp(least, model.force, model.indentation),
    )
    normal = model.coupling.toarray() + np.diag(indentation / least)
    radius = _contact_radius(design, least)
    across, both = _pulled(design, cells, radius)
    compliance = np.block([[across, both.T], [both, normal]])
    return ContactPad(
        compliance=compliance,
        gap=pin_tops(design).max() - pin_tops(design),
        x=np.array([placed.tip[0] for placed in skin.placed]),
        ridge=np.arange(1, count + 1),
        weight=math.pi * radius**2,
        strips=np.zeros((0, 3, 2 * count)),
        unknowns=2 * count,
    )


def _contact_radius(design: Design, force: Array) -> Array:
    """Radius of each contact, mm, by Hertz, at most the tip's."""
    material, radius = silicone(design), crown_radius(design)
    tip = skin_of(design).profile.tip_width / 2
    if not math.isfinite(radius):
        return np.full_like(force, tip)
    modulus = material.young_modulus.value / (1 - material.poisson_ratio**2)
    return np.minimum(np.cbrt(3 * force * radius / (4 * modulus)), tip)


def _pulled(design: Design, cells: PinCells, contact: Array) -> tuple[Array, Array]:
    """Compliances `(n, n)` mm/N along x under pulls along x, and up under these."""
    skin, material = skin_of(design), silicone(design)
    axis = np.array([placed.axis for placed in skin.placed])
    sine, cosine, toward = np.sin(skin.leans), np.cos(skin.leans), axis[:, 0]
    across, axial, radius = cells.across, cells.axial, crown_radius(design)
    arm = radius * sine if math.isfinite(radius) else 0.0 * sine
    own = across[:, 0, 0] * (1 - toward**2) + axial * toward**2
    if math.isfinite(radius):  # of a flat tip the cell's load covers all that touches
        shear = material.young_modulus.value / (2 * (1 + material.poisson_ratio))
        own = own + (2 - material.poisson_ratio) / (8 * shear * contact)
    per_sine = np.divide(toward, sine, out=np.zeros_like(sine), where=sine > 0)
    up = cosine * (axial * sine - sine * across[:, 0, 0] - arm * across[:, 0, 1]) * per_sine
    pull, lift = np.diag(own), np.diag(up)
    foot = np.array([placed.foot for placed in skin.placed])
    first, second = np.nonzero(~np.eye(skin.count, dtype=bool))
    aside = foot[first, :2] - foot[second, :2]
    moved, lifted = _at(cells.middle, aside, np.array(skin.heights)[first])
    pull[first, second], lift[first, second] = moved, lifted
    return (pull + pull.T) / 2, lift


def _at(cell: PinCell, aside: Array, height: Array) -> tuple[Array, Array]:
    """How far the tip of a pin of a `height`, mm, moves along x, with its foot and as that tilts, and how far
    its foot moves up, mm per N that pulls another's tip along x: `aside` `(k, 2)` mm from that one."""
    distance = np.hypot(*aside.T)
    cosine, sine = aside.T / distance
    outward, up, round_ = (np.interp(distance, cell.radius, part, right=0.0) for part in cell.by_pull[0])
    slope = np.interp(distance, cell.radius, np.gradient(cell.by_pull[0, 1], cell.radius), right=0.0)
    tilt = slope * cosine**2 + up * sine**2 / distance
    return outward * cosine**2 - round_ * sine**2 - height * tilt, up * cosine
