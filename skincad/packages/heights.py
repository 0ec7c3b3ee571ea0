"""The skin's surface as a height map, for tactile simulators that work on images.

At each x the highest point of the section's outline is exact; a doubly curved skin turns it about its axis,
which leaves x as it is: z = c + sqrt((z0 - c)^2 - y^2).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.shape import curves
from skincad.shape.skin import section, skin_of

PIXELS_PER_PITCH, MAX_PIXELS = 50, 4096  # pixels: in a pitch, and of an image's longer side
LEVELS = 65535  # of a pixel; 0 is where there is no skin
CHORD = 1e-4  # of the pitch, of the polygon that heights are taken from


@dataclass(frozen=True, eq=False)
class HeightMap:
    """Heights `(rows, columns)` mm over the back's plane z = 0, NaN where there is no skin: row 0 at the
    largest y, column 0 at the smallest x; squares of `pixel` mm whose middles are meant, the first one's at
    `corner` (x, y) mm."""

    height: Array
    pixel: float
    corner: tuple[float, float]

    @property
    def scale(self) -> float:
        """Height of one level of the image, mm."""
        return float(np.nanmax(self.height)) / LEVELS

    def levels(self) -> NDArray[np.uint16]:
        """Return the image: height over `scale`, 0 without skin."""
        return np.nan_to_num(self.height / self.scale).round().astype(np.uint16)

    def about(self) -> dict[str, Any]:
        """Return what a reader of the image needs."""
        return {
            "unit": "mm",
            "height": "level x scale_mm, over the flat back z = 0; level 0: no skin",
            "scale_mm": self.scale,
            "pixel_mm": self.pixel,
            "first_pixel_xy_mm": list(self.corner),
            "rows": "from the largest y down; columns: from the smallest x up",
        }


def height_map(design: Design) -> HeightMap:
    """Return the heights of a skin, ridges included."""
    skin, radius = design.skin, design.skin.curvature_radius_y
    centre, angle = (0.0, 0.0) if radius is None else (skin.thickness - radius, skin.length / 2 / radius)
    reach = skin.length / 2 if radius is None else (section(design).top - centre) * math.sin(angle)
    pixel = max(skin_of(design).pitch / PIXELS_PER_PITCH, max(skin.width, 2 * reach) / MAX_PIXELS)
    columns, rows = (max(1, math.floor(size / pixel)) for size in (skin.width, 2 * reach))
    x = (np.arange(columns) - (columns - 1) / 2) * pixel
    y = ((rows - 1) / 2 - np.arange(rows)) * pixel
    top = _tops(design, x)
    if radius is None:
        height = np.tile(top, (rows, 1))
    else:
        arm = top - centre
        with np.errstate(invalid="ignore"):
            height = centre + np.sqrt(arm**2 - y[:, None] ** 2)
        height[np.abs(y)[:, None] > arm * math.sin(angle)] = np.nan
    return HeightMap(height, pixel, (float(x[0]), float(y[0])))


def _tops(design: Design, x: NDArray[np.floating[Any]]) -> Array:
    """Largest z of the outline at each x, mm, between its corners along chords."""
    corners = curves.polygon(section(design).outline, CHORD * skin_of(design).pitch)
    tops = np.full(x.size, -np.inf)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        (x0, z0), (x1, z1) = sorted([tuple(a), tuple(b)])
        here = (x >= x0) & (x <= x1)
        if x1 > x0:
            tops[here] = np.maximum(tops[here], z0 + (z1 - z0) * (x[here] - x0) / (x1 - x0))
    return tops
