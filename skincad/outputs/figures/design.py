"""The picture of a design, shaded without a display: the skin, its section, the mold taken apart.

Rays are orthographic, one a pixel, cast by Embree.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import trimesh
from numpy.lib.stride_tricks import sliding_window_view
from scipy.optimize import linear_sum_assignment
from trimesh.ray.ray_pyembree import RayMeshIntersector

from skincad.base.arrays import Array, Index, Mask
from skincad.fabrication.meshes import upright
from skincad.inputs.design import Design
from skincad.outputs.figures.canvas import (
    BLACK,
    BLUE,
    FRAME,
    OUTLINE,
    SKIN,
    SMALL,
    STRIP,
    THIN,
    Axes,
    Picture,
    sheet,
)
from skincad.outputs.view import explosion_offset
from skincad.shape.curves import polygon
from skincad.shape.shots import face
from skincad.shape.skin import Section, Skin, pictured_section, section, skin_of, summit
from skincad.solids.bone import bone_of
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole

Colour = tuple[float, float, float]
Image = Array
Pixel = tuple[float, float]
_SKIN_PIXELS, _PIXELS = (720, 320), (640, 760)
_LIGHT = np.array([0.35, -0.55, 0.76])  # from the viewer's upper right, in the scene's frame
_OVERSAMPLE = 2
_GRID = 5  # pixels between the rays that look for a place on each part
_LABEL_STEP = 0.028  # of the picture's height, between two names
_RELIEF = 0.2  # of the section's width: as high as its surface is drawn, at most
_HEIGHT_SCALES = (1, 2, 3, 4, 5, 8, 10, 15, 20)
_LEAST_RELIEF = 0.05  # of the skin's height, of a face that is plane
_SCALE_BAR = 0.3  # of what it measures, at most


def design_figure(design: Design, closed: ClosedMold, meshes: dict[str, trimesh.Trimesh]) -> Picture:
    """Return skin, section and opened mold. `meshes` by part name, in the mold's frame, mm."""
    with sheet((13.2, 7.4), 128, dpi=110) as figure:
        grid = figure.add_gridspec(3, 2, width_ratios=[1.15, 1.0], height_ratios=[1.0, 0.62, 0.9])
        shape, outline = section(design), pictured_section(design, 1e-4)
        _draw_skin(figure.add_subplot(grid[0, 0]), design, meshes["skin"])
        _draw_whole(figure.add_subplot(grid[1, 0]), design, shape, outline)
        _draw_middle(figure.add_subplot(grid[2, 0]), design, shape, outline)
        _draw_mold(figure.add_subplot(grid[:, 1]), closed, meshes, skin_of(design))
        figure.suptitle(design.name)
    return figure


def _show(axes: Axes, title: str) -> None:
    axes.set_title(title)
    axes.set_axis_off()


def _draw_skin(axes: Axes, design: Design, skin: trimesh.Trimesh) -> None:
    shown = upright(skin)
    camera = view([shown], 32.0, 28.0, _SKIN_PIXELS)
    axes.imshow(shaded([shown], [PartRole.SKIN.colour], camera))
    low, high = shown.bounds
    _scale_bar(axes, camera, low, high[0] - low[0])
    size = f"{design.skin.across} x {summit(design):.4g} mm"
    _show(axes, f"skin: {skin_of(design).counted}, {size}")


def scale_length(width: float) -> float:
    """Return the length of a scale bar, mm: the largest 1, 2 or 5 times a power of ten that is short enough
    for something `width` mm wide."""
    power = 10.0 ** math.floor(math.log10(_SCALE_BAR * width))
    return max(k * power for k in (1, 2, 5) if k * power <= _SCALE_BAR * width * (1 + 1e-9))


def _scale_bar(axes: Axes, camera: Camera, corner: Array, width: float) -> None:
    """A bar along x below the edge that begins at `corner`: lengths along x have its scale."""
    length = scale_length(width)
    away = np.array([0.0, 14.0])  # pixels below the edge
    start, end = (np.array(camera.pixel(corner + np.array([x, 0.0, 0.0]))) + away for x in (0.0, length))
    along = (end - start) / np.linalg.norm(end - start)
    across = 4.0 * np.array([-along[1], along[0]])
    axes.plot(*np.transpose([start, end]), color=BLACK, linewidth=2.0, solid_capstyle="butt", gid="scale bar")
    for place in (start, end):
        axes.plot(*np.transpose([place - across, place + across]), color=BLACK, linewidth=THIN)
    at = tuple((start + end) / 2 + [-6, 8])
    axes.annotate(f"{length:g} mm along x", at, ha="right", va="top", fontsize=SMALL)


def _draw_section(axes: Axes, outline: Array) -> None:
    axes.fill(*outline.T, facecolor=SKIN, edgecolor=OUTLINE, linewidth=THIN)
    axes.set(xlabel="x, mm", ylabel="z, mm")
    axes.grid(visible=False)


def _draw_layers(axes: Axes, design: Design) -> None:
    """The faces of shots, dashed, and a bone, as its shadow along y."""
    if bone := bone_of(design):
        within = bone.shadow(1, 0.0)
        for piece in getattr(within, "geoms", [within]):
            axes.fill(*np.array(piece.exterior.coords).T, facecolor=FRAME, edgecolor=OUTLINE, linewidth=THIN)
    for number in range(1, len(design.shot or ()) + 1):
        line = polygon(face(design, number, design.skin.width / 2), 1e-3)
        ends = np.vstack([line, [-line[0, 0], line[0, 1]]])
        axes.plot(*ends.T, color=OUTLINE, linewidth=THIN, linestyle=(0, (2, 2)))


def _draw_whole(axes: Axes, design: Design, shape: Section, outline: Array) -> None:
    """The surface over the whole width, its heights drawn larger so that its curvature is seen, mm."""
    _draw_section(axes, outline)
    _draw_layers(axes, design)
    for slot in shape.slots:  # too thin, at this scale, for a film within
        axes.fill(*polygon(slot.loop(), 1e-4).T, facecolor=STRIP if design.film else "white")
    half, top = 0.5 * design.skin.width, float(outline[:, 1].max())
    points = pictured_section(design, 1e-3)
    between = (points[:, 1] > 1e-6) & (np.abs(points[:, 0]) < (1 - 1e-6) * half)
    low = float(points[between, 1].min(initial=top))  # a plane face has corners alone
    low = 0.0 if design.shot or design.mold.bone else low
    relief = max(top - low, _LEAST_RELIEF * top)
    scale = max(k for k in _HEIGHT_SCALES if k == 1 or k * relief <= _RELIEF * 2 * half)
    axes.axhline(top, color=BLUE, linewidth=THIN, linestyle=(0, (5, 3)))
    low = max(top - 1.35 * relief, -0.03 * top)
    axes.set(xlim=(-1.02 * half, 1.02 * half), ylim=(low, top + 0.12 * relief), aspect=scale)
    stated = f"heights x {scale}" if scale > 1 else "true to scale"
    axes.set_title(f"section over the whole width, {stated}; dashed: a flat plate at first touch")


def _draw_middle(axes: Axes, design: Design, shape: Section, outline: Array) -> None:
    """The section through the middle features, with its film strips, mm."""
    skin = skin_of(design)
    _draw_section(axes, outline)
    _draw_layers(axes, design)
    for slot in shape.slots:
        axes.fill(*polygon(slot.loop(), 1e-4).T, facecolor="white", edgecolor=OUTLINE, linewidth=0.5)
        if design.film:
            axes.fill(*polygon(slot.loop(design.film.thickness), 1e-4).T, facecolor=STRIP)
    height = skin.heights[(skin.count - 1) // 2]
    reach, top = min(1.7 * skin.pitch, 0.5 * design.skin.width), float(outline[:, 1].max())
    low = 0.0 if design.shot or design.mold.bone else top - 0.55 * reach - height
    axes.set(xlim=(-reach, reach), ylim=(low, top + 0.12 * reach), aspect="equal")
    strips = ", strips S1 and S2" if shape.slots else ""
    what = f" through the middle {skin.family}s" if skin.heights[0] else ""
    axes.set_title(f"section{what}, true to scale{strips}")


def _draw_mold(axes: Axes, closed: ClosedMold, meshes: dict[str, trimesh.Trimesh], skin: Skin) -> None:
    parts = [part for part in (*closed.parts, *closed.plugs) if part.name in meshes]
    exploded = [meshes[part.name].copy() for part in parts]
    for part, shape in zip(parts, exploded, strict=True):
        shape.vertices = shape.vertices + explosion_offset(part, closed)
    camera = view(exploded, 38.0, 30.0, _PIXELS)
    axes.imshow(shaded(exploded, [part.colour for part in parts], camera))
    named = [i for i, part in enumerate(parts) if part.made != "bought"]
    anchors = _anchors(exploded, named, camera)
    line = {"arrowstyle": "-", "color": FRAME, "linewidth": 0.6, "shrinkA": 2, "shrinkB": 0}
    for i, anchor, end in zip(named, anchors, label_places(anchors, _PIXELS), strict=True):
        axes.annotate(parts[i].name, anchor, end, fontsize=SMALL, va="center", arrowprops=line)
        axes.plot(*anchor, ".", color=OUTLINE, markersize=4)
    low, high = trimesh.util.concatenate(exploded).bounds
    _scale_bar(axes, camera, low, high[0] - low[0])
    _show(axes, f"mold, taken apart (it is poured with {skin.turned_down} down)")


def _anchors(shapes: list[trimesh.Trimesh], named: list[int], camera: Camera) -> list[Pixel]:
    """A place on each named part where it is seen, as far to the right as it goes; of a hidden part its
    middle."""
    wide, high = camera.size
    row, column = (np.indices((high // _GRID, wide // _GRID)) + 0.5) * _GRID
    whole = trimesh.util.concatenate(shapes)
    owner = np.append(np.repeat(np.arange(len(shapes)), [len(shape.faces) for shape in shapes]), -1)
    hit = _cast(RayMeshIntersector(whole), whole, camera, column.ravel(), row.ravel())
    seen = owner[hit].reshape(row.shape)
    around = sliding_window_view(np.pad(seen, 1, constant_values=-1), (3, 3))
    places = []
    for i in named:
        inner = (around == i).all(axis=(2, 3))
        shown = inner if inner.any() else seen == i
        if not shown.any():
            places.append(camera.pixel(shapes[i].bounds.mean(axis=0)))
            continue
        last = np.argmax(np.where(shown, column, -1.0))
        places.append((float(column.ravel()[last]), float(row.ravel()[last])))
    return places


def label_places(anchors: Sequence[Pixel], size: tuple[int, int]) -> list[Pixel]:
    """Return where each anchor's name stands, in a column right of a picture of `size` pixels, so that no two
    leaders cross: of all ways to give the places to the names, the one with the shortest leaders in all.
    """
    step, free = _LABEL_STEP * size[1], 0.0
    rows = []
    for y in sorted(anchor[1] for anchor in anchors):
        rows.append(max(free, y))
        free = rows[-1] + step
    ends = [(size[0] + 10.0, row) for row in rows]
    lengths = np.linalg.norm(np.array(anchors)[:, None] - np.array(ends)[None], axis=2)
    return [ends[j] for j in linear_sum_assignment(lengths)[1]]


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
    wide, high = camera.size
    row, column = np.indices((high, wide)).reshape(2, -1) + 0.5
    middle = _cast(caster, whole, camera, column, row).reshape(high, wide)
    near = np.pad(middle, 1, mode="edge")
    windows = sliding_window_view(near, (3, 3))
    mixed = (windows != middle[:, :, None, None]).any(axis=(2, 3))
    hit = middle.repeat(_OVERSAMPLE, 0).repeat(_OVERSAMPLE, 1)
    fine = mixed.repeat(_OVERSAMPLE, 0).repeat(_OVERSAMPLE, 1)
    row, column = (np.array(np.nonzero(fine)) + 0.5) / _OVERSAMPLE
    hit[fine] = _cast(caster, whole, camera, column, row)
    return hit


def _cast(
    caster: RayMeshIntersector, whole: trimesh.Trimesh, camera: Camera, column: Array, row: Array
) -> Index:
    """Faces seen at places in the picture, pixels from its upper left; -1 for none."""
    far = float(np.abs(whole.bounds).max()) * 4 * camera.towards
    x = camera.centre[0] + (column - camera.size[0] / 2) / camera.per_mm
    y = camera.centre[1] - (row - camera.size[1] / 2) / camera.per_mm
    origins = x[:, None] * camera.right + y[:, None] * camera.up + far
    return np.asarray(caster.intersects_first(origins, np.broadcast_to(-camera.towards, origins.shape)))


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
