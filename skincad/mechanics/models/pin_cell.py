"""One pin alone: its force against indentation, how it gives way under a pull, and what both do to the base.

The cell is the pin on a disc of base that is bonded below, wide enough for the pin not to be felt at its rim.
Loads on the pin are harmonics round its axis (bodies/harmonics.py). A load that is spread over a part of the
tip moves it as far as the same load would move a half-space, and as far as the pin and its base give way:
the latter is what a contact of any size sees, and what differs from pin to pin by height and thickness.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from skincad.base.arrays import Array
from skincad.base.machine import one_blas_thread
from skincad.inputs.design import Design
from skincad.mechanics.bodies import elements
from skincad.mechanics.bodies.harmonics import pulled, pushed
from skincad.mechanics.bodies.mesh import PadPiece, plane_piece
from skincad.mechanics.models import linear
from skincad.mechanics.problem import Pad, pad_of
from skincad.mechanics.validity import crown_radius
from skincad.shape.curves import Point, loop
from skincad.shape.skin import skin_of

# Thicknesses of the base beyond a pin's foot. A row of pins is felt as by the plane model one thickness away
# to 1.2 %, with 4 of them to 11 %; 484 fine pins then touch at 1.0 % more force, and with 8 at 0.4 % less
REACH = 6.0
FINENESS, ORDER = 1.0, 3
LOADED = 0.3  # of the tip's radius, over which loads are spread
RESOLVED = 3.0  # edges of the tip's mesh in the smallest contact that is taken from it
SAMPLES = 60  # radii at which the base's displacement is taken
BELOW = 1e-5  # units under the base where it is sampled: on its surface no point is surely inside
# A magnet is that many times as stiff as the silicone; ten times more change how it goes by 1e-3, and a tip's
# give by 1e-2.
# It has a bore as wide as CORE of it, as no strip crosses a section's middle
RIGID, RIGID_RATIO, CORE = 1e3, 0.3, 0.02
POINTS = 24  # of a root, over which its sinking is a mean
MOST_LOADED = 1.2  # times the force at which a contact by Hertz would be as wide as the tip: the table's end
# Of a half-space under a load spread evenly over a disc of radius a, times E* a: its mean sinking, 16 / (3
# pi^2), and per moment of a pressure that rises evenly, E* a^3, 32 / pi x the integral of (J_2(x) / x)^2.
# Both are means weighted by the load: Johnson, Contact Mechanics, 1985, sec. 3.4; Abramowitz and Stegun
# 11.4.33. A pull spread evenly turns the surface by (1 - 2 nu) / (2 pi (1 - nu)) / (E* a^2), the side that it
# points to down: Cerruti's depression over a disc, whose x / r^2 integrates to pi x inside; Johnson, sec. 3.6
SINKING, TURNING = 16 / (3 * math.pi**2), 0.864594


@dataclass(frozen=True)
class PinCell:
    """The cell of a `design` of one pin.

    `axial` mm/N and `across` `(2, 2)` are what pin and base give way beside the contact's half-space: along
    the axis; across it, by force and by moment (mm/N, 1/N, 1/(N mm)), where a positive moment lifts the side
    that the force points to. `radius` `(m,)` mm are distances on the base from the axis; `by_push` `(2, m)`
    is how far the base moves there, outward and up, per N along the axis; `by_pull` `(2, 3, m)` outward, up
    and round, by the cosine and the sine of the angle to the pull, per N across the tip and per N mm of
    moment. `magnet` `(5,)` is how far the middle of the pin's magnet goes: along the axis per N along it,
    mm/N; across it, and by what angle its upper end goes on ahead of it, per N across (mm/N, 1/N) and then
    per N mm of moment; zeros without one.
    """

    design: Design
    axial: float
    across: Array
    radius: Array
    by_push: Array
    by_pull: Array
    magnet: Array

    def sinking(self, distance: Array, foot: float) -> Array:
        """Return how far a pin with a root of radius `foot` mm sinks at these distances, mm per N on this
        one: the mean over its root, 0 beyond the cell."""
        ring, angle = disc()
        away = np.hypot(distance[:, None] + foot * ring * np.cos(angle), foot * ring * np.sin(angle))
        return np.asarray(-np.interp(away, self.radius, self.by_push[1], right=0.0).mean(axis=1))


def lone(design: Design, height: float, thickness: float) -> Design:
    """Return one pin of a `height` mm like the design's on a flat round base of a `thickness` mm, the
    cell, with its magnet where that lies on the axis."""
    pin = skin_of(design).profile
    width = 2 * (pin.feet[0].x + REACH * thickness)
    flat = {"curvature_radius": 1e8, "curvature_radius_y": None, "thickness": thickness}
    disc_of_base = {"outline": "round", "width": width, "length": width}
    # one pitch for all, so that pins alike in all else share a cell
    alone = {"pattern": "square", "columns": 1, "rows": 1, "height": height, "pitch": 1.0}
    nothing = dict.fromkeys(("rings", "margin", "heights", "levelling"))
    pocket = design.features.pocket if design.on_magnets else None
    skin = design.skin.model_copy(update=flat | disc_of_base)
    table = design.features.model_copy(update=alone | nothing | {"pocket": pocket})
    return design.model_copy(update={"name": "cell", "skin": skin, "pin": table})


@lru_cache(maxsize=64)
def pin_cell(cell: Design) -> PinCell:
    """Return the cell of a design of one pin, see `lone`, in small strain."""
    shape, (meshed, loaded) = skin_of(cell).profile, _meshed(cell)
    pad = meshed.whole
    modulus = pad.young_modulus / (1 - pad.poisson_ratio**2)
    with one_blas_thread():
        axial, across, radius, by_push, by_pull, magnet = _compliances(meshed, cell, loaded)
    if shape.crown:
        shear = 2 * (1 - pad.poisson_ratio)
        pull, tilt = (2 - pad.poisson_ratio) / shear, (2 * pad.poisson_ratio - 1) / (math.pi * shear)
        axial -= SINKING / (modulus * loaded)
        spread = [[pull * SINKING / loaded, tilt / loaded**2], [tilt / loaded**2, TURNING / loaded**3]]
        across = across - np.array(spread) / modulus
    return PinCell(cell, axial, across, radius, by_push, by_pull, magnet)


def _meshed(cell: Design) -> tuple[PadPiece, float]:
    """The cell's mesh, fine within the radius of its tip, mm, over which loads are spread."""
    shape = skin_of(cell).profile
    loaded = shape.tip_width / 2 * (LOADED if shape.crown else 1.0)
    pad = replace(magnet_pad(cell), focus=loaded if shape.crown else 0.0)
    return plane_piece(pad, FINENESS), loaded


def magnet_pad(cell: Design) -> Pad:
    """Return a cell's pad, with its magnet as a stiff strip if it has one."""
    pad = pad_of(cell)
    if not ((pocket := cell.features.pocket) and pocket.magnet):
        return pad
    (low, high), wide = pocket.magnet_span, pocket.magnet.diameter / 2
    corners = [Point(CORE * wide, low), Point(wide, low), Point(wide, high), Point(CORE * wide, high)]
    halves = loop(corners), loop([Point(-x, z) for x, z in reversed(corners)])
    return replace(pad, strips=halves, film_modulus=RIGID * pad.young_modulus, film_ratio=RIGID_RATIO)


def hertz(force: Array, radius: float, modulus: float) -> Array:
    """Return by how far a sphere of a `radius` mm approaches a plate under `force` N; `modulus` is E* in MPa.
    Johnson, Contact Mechanics, 1985, eq. 4.23."""
    return np.cbrt(9 * force**2 / (16 * radius * modulus**2))


@lru_cache(maxsize=64)
def pin_curve(cell: Design) -> tuple[Array, Array]:
    """Return force, N, and indentation, mm, `(t,)` of a cell's tip pressed along its axis: below what the
    mesh resolves Hertz's and the compliance of pin and base."""
    meshed, shape = _meshed(cell)[0], skin_of(cell).profile
    pad = meshed.whole
    modulus, tip = pad.young_modulus / (1 - pad.poisson_ratio**2), shape.tip_width / 2
    if not shape.crown:
        end = pad.young_modulus * math.pi * tip**2
        best = linear.level(meshed, ORDER, end)
        return np.array([0.0, end]), np.array([0.0, best.approach])
    radius = crown_radius(cell)
    end = MOST_LOADED * 4 * modulus * tip**3 / (3 * radius)
    best = linear.level(meshed, ORDER, end)
    table = linear.reduced_model(pad, best, end, {})
    force, indentation = table.force * table.scale, table.indentation[0] * table.unit
    edge = LOADED * tip / 9
    light = np.cbrt(3 * force * radius / (4 * modulus)) < RESOLVED * edge
    beside = (indentation - hertz(force, radius, modulus))[~light][0] / force[~light][0]
    sparse = hertz(force, radius, modulus) + beside * force
    return force, np.where(light, sparse, indentation)


def _compliances(
    meshed: PadPiece, cell: Design, loaded: float
) -> tuple[float, Array, Array, Array, Array, Array]:
    """Compliances of the tip under loads over `loaded` mm of it, and the displacements of base and magnet, of
    PinCell."""
    pad, unit = meshed.whole, meshed.unit
    mesh = elements.curved(meshed.mesh, ORDER)
    foot, rim = skin_of(cell).profile.feet[0].x / unit, cell.skin.width / 2 / unit
    radius = foot + (rim - foot) * np.linspace(0.0, 1.0, SAMPLES + 1)[:-1] ** 1.5
    falls = (unit * radius) ** 2 / (2 * cell.skin.curvature_radius)  # as no base is quite flat
    low, beside, span = (cell.skin.thickness - falls) / unit - BELOW, 0.0, (0.0, 0.0)
    if (pocket := cell.features.pocket) and pocket.magnet:
        beside, span = pocket.magnet.diameter / 4, pocket.magnet_span
    at = np.append(radius, beside / unit), np.append(low, sum(span) / 2 / unit)
    axial, by_push = pushed(mesh, ORDER, pad.materials, loaded / unit, at)
    across, by_pull = pulled(mesh, ORDER, pad.materials, loaded / unit, at)
    per_force, per_turn = pad.young_modulus * unit, pad.young_modulus * unit**2
    across /= np.array([[per_force, per_turn], [per_turn, per_turn * unit]])
    by_push /= per_force
    by_pull /= np.array([per_force, per_turn])[:, None, None]
    magnet = np.zeros(5)
    if beside:  # it is rigid: how it goes up beside the axis tells its tilt
        out, up = by_pull[:, :2, -1].T
        magnet = np.array([-by_push[1, -1], out[0], -up[0] / beside, out[1], -up[1] / beside])
    return axial / per_force, across, radius * unit, by_push[:, :-1], by_pull[:, :, :-1], magnet


def disc() -> tuple[Array, Array]:
    """Return relative radii and angles of points that share a disc's area evenly: Vogel, Math. Biosci. 44
    (1979) 179."""
    number = np.arange(POINTS) + 0.5
    turn = np.asarray(number * math.pi * (3 - math.sqrt(5)), dtype=float)
    return np.asarray(np.sqrt(number / POINTS)), turn
