"""The picture of a design, shaded without a display: the skin, a ridge of its section, the mold taken apart.

Rays are orthographic, one a pixel, cast by Embree.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.lib.stride_tricks import sliding_window_view
from trimesh.ray.ray_pyembree import RayMeshIntersector

from skincad.base.arrays import Array, Index, Mask
from skincad.fabrication.meshes import upright
from skincad.inputs.design import Design
from skincad.outputs.figures.canvas import Axes, Picture, sheet
from skincad.outputs.view import explosion_offset
from skincad.shape.curves import polygon
from skincad.shape.skin import section, skin_of
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole

SKIN, STRIP = "#eebfa6", "#b5482a"
_PIXELS = (640, 760)
Colour = tuple[float, float, float]
Image = Array
_LIGHT = np.array([0.35, -0.55, 0.76])  # from the viewer's upper right, in the scene's frame
_OVERSAMPLE = 2


def design_figure(design: Design, closed: ClosedMold, meshes: dict[str, trimesh.Trimesh]) -> Picture:
    """Return skin, ridge section and opened mold. `meshes` by part name, in the mold's frame, mm."""
    with sheet((13.2, 7.4), 128, dpi=110) as figure:
        grid = figure.add_gridspec(2, 2, width_ratios=[1.15, 1.0])
        _draw_skin(figure.add_subplot(grid[0, 0]), design, meshes["skin"])
        _draw_ridge(figure.add_subplot(grid[1, 0]), design)
        _draw_mold(figure.add_subplot(grid[:, 1]), closed, meshes)
        figure.suptitle(design.name)
    return figure


def _show(axes: Axes, title: str) -> None:
    axes.set_title(title)
    axes.set_axis_off()


def _draw_skin(axes: Axes, design: Design, skin: trimesh.Trimesh) -> None:
    shown = upright(skin)
    camera = view([shown], 32.0, 28.0, (720, 350))
    axes.imshow(shaded([shown], [PartRole.SKIN.colour], camera))
    count = skin_of(design).count
    size = f"{design.skin.width:g} x {design.skin.length:g} x {section(design).top:.4g} mm"
    _show(axes, f"skin: {count} ridge{'s' * (count > 1)}, {size}")


def _draw_ridge(axes: Axes, design: Design) -> None:
    """The middle ridges' section with its film strips, mm."""
    shape, skin = section(design), skin_of(design)
    axes.fill(*polygon(shape.outline, 1e-4).T, facecolor=SKIN, edgecolor="#333", linewidth=0.8)
    for slot in shape.slots:
        axes.fill(*polygon(slot.loop(), 1e-4).T, facecolor="white", edgecolor="#333", linewidth=0.5)
        if design.film:
            axes.fill(*polygon(slot.loop(design.film.thickness), 1e-4).T, facecolor=STRIP)
    height = skin.heights[(skin.count - 1) // 2]
    reach = min(1.7 * skin.pitch, 0.5 * design.skin.width)
    axes.set_xlim(-reach, reach)
    axes.set_ylim(design.skin.thickness - 0.9 * reach + height, shape.top + 0.12 * reach)
    axes.set_aspect("equal")
    axes.set_xlabel("x, mm")
    axes.set_ylabel("z, mm")
    axes.grid(visible=False)
    axes.set_title("section through the middle ridges" + (", strips S1 and S2" if shape.slots else ""))


def _draw_mold(axes: Axes, closed: ClosedMold, meshes: dict[str, trimesh.Trimesh]) -> None:
    exploded, colours, labels = [], [], []
    for part in closed.parts:
        if part.name not in meshes:
            continue
        mesh = meshes[part.name].copy()
        mesh.vertices = mesh.vertices + explosion_offset(part, closed)
        exploded.append(mesh)
        colours.append(part.colour)
        if part.made != "bought":
            labels.append((part.name, mesh))
    camera = view(exploded, 38.0, 30.0, _PIXELS)
    axes.imshow(shaded(exploded, colours, camera))
    anchors = []  # on each part's right upper edge, seen from in front
    for name, shape in labels:
        low, high = shape.bounds
        edge = np.array([high[0], (low[1] + high[1]) / 2, 0.2 * low[2] + 0.8 * high[2]])
        anchors.append((camera.pixel(edge), name))
    free = 0.0
    for (x, y), name in sorted(anchors, key=lambda anchor: anchor[0][1]):
        free = max(free, y)
        line = {"arrowstyle": "-", "color": "#666", "linewidth": 0.6}
        axes.annotate(name, (x, y), (_PIXELS[0] + 10, free), fontsize=8, va="center", arrowprops=line)
        free += 0.028 * _PIXELS[1]
    _show(axes, "mold, taken apart (it is poured with the ridges down)")


@dataclass(frozen=True)
class Camera:
    """An orthographic view: unit vectors of the picture's right, up and towards the viewer; scale."""

    right: Array
    up: Array
    towards: Array
    centre: Array  # mm, in the picture's plane
    per_mm: float  # pixels
    size: tuple[int, int]  # width, height in pixels

    def pixel(self, point: Array) -> tuple[float, float]:
        """Return where a point of the scene lies in the picture, pixels from its upper left."""
        column = (float(point @ self.right) - self.centre[0]) * self.per_mm + self.size[0] / 2
        row = self.size[1] / 2 - (float(point @ self.up) - self.centre[1]) * self.per_mm
        return column, row


def view(meshes: list[trimesh.Trimesh], azimuth: float, height: float, size: tuple[int, int]) -> Camera:
    """Return the view from these angles (degrees: from -y towards +x, and above the horizon) that just
    holds the meshes in `size` pixels."""
    a, h = np.radians(azimuth), np.radians(height)
    towards = np.array([np.sin(a) * np.cos(h), -np.cos(a) * np.cos(h), np.sin(h)])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    up = np.cross(towards, right)
    corners = np.vstack([mesh.vertices for mesh in meshes])
    flat = np.column_stack([corners @ right, corners @ up])
    low, high = flat.min(axis=0), flat.max(axis=0)
    per_mm = 0.96 * float(np.min(np.array(size) / (high - low)))
    return Camera(right, up, towards, (low + high) / 2, per_mm, size)


def shaded(meshes: list[trimesh.Trimesh], colours: list[Colour], camera: Camera) -> Image:
    """Return the picture, `(height, width, 3)` from 0 to 1: matt surfaces on white, edges drawn dark."""
    whole = trimesh.util.concatenate(meshes)
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    hit = _hit(whole, camera)
    normals = np.asarray(whole.face_normals)
    brightness = 0.45 + 0.55 * np.clip(normals @ _LIGHT, 0, 1)
    paint = np.array(colours)[owner] * brightness[:, None]
    image = np.vstack([paint, np.ones(3)])[hit]  # -1, the last: white
    image[_edges(hit, owner, normals)] *= 0.35
    blocks = image.reshape(camera.size[1], _OVERSAMPLE, camera.size[0], _OVERSAMPLE, 3)
    return np.asarray(blocks.mean(axis=(1, 3)))


def _hit(whole: trimesh.Trimesh, camera: Camera) -> Index:
    """Return which face is seen at each of `_OVERSAMPLE` squared points of each pixel, -1 for none; a pixel
    whose neighbours all show the same face is sampled once."""
    caster = RayMeshIntersector(whole)
    far = float(np.abs(whole.bounds).max()) * 4 * camera.towards

    def cast(column: Array, row: Array) -> Index:
        """Faces seen at places in the picture, pixels from its upper left."""
        x = camera.centre[0] + (column - camera.size[0] / 2) / camera.per_mm
        y = camera.centre[1] - (row - camera.size[1] / 2) / camera.per_mm
        origins = x[:, None] * camera.right + y[:, None] * camera.up + far
        return np.asarray(caster.intersects_first(origins, np.broadcast_to(-camera.towards, origins.shape)))

    wide, high = camera.size
    row, column = np.indices((high, wide)).reshape(2, -1) + 0.5
    middle = cast(column, row).reshape(high, wide)
    near = np.pad(middle, 1, mode="edge")
    windows = sliding_window_view(near, (3, 3))
    mixed = (windows != middle[:, :, None, None]).any(axis=(2, 3))
    hit = middle.repeat(_OVERSAMPLE, 0).repeat(_OVERSAMPLE, 1)
    fine = mixed.repeat(_OVERSAMPLE, 0).repeat(_OVERSAMPLE, 1)
    row, column = (np.array(np.nonzero(fine)) + 0.5) / _OVERSAMPLE
    hit[fine] = cast(column, row)
    return hit


def _edges(hit: Index, owner: Index, normals: Array) -> Mask:
    """Pixels whose right or lower neighbour shows another part, or a face at more than 25 degrees."""
    part, facing = np.append(owner, -1), np.vstack([normals, np.zeros(3)])  # -1, the last: nothing is hit
    edge = np.zeros(hit.shape, dtype=bool)
    for axis in (0, 1):
        other = np.roll(hit, -1, axis)
        differ = hit != other  # a face has no edge within itself
        one, next_one = hit[differ], other[differ]
        turned = (np.einsum("ij,ij->i", facing[one], facing[next_one]) < 0.9) & (one >= 0)
        edge[differ] |= (part[one] != part[next_one]) | turned
    return edge
