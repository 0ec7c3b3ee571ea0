"""The picture of a design: the skin, one ridge of its section, and the mold taken apart."""

from __future__ import annotations

import numpy as np
import trimesh

from skincad.fabrication.meshes import upright
from skincad.inputs.design import Design
from skincad.pictures.canvas import Axes, Picture, sheet
from skincad.pictures.exploded import explosion_offset
from skincad.pictures.render import shaded, view
from skincad.shape.curves import polygon
from skincad.shape.skin import section, skin_of
from skincad.solids.mold import ClosedMold
from skincad.solids.roles import PartRole

SKIN, STRIP = "#eebfa6", "#b5482a"
_PIXELS = (640, 760)


def design_figure(design: Design, closed: ClosedMold, meshes: dict[str, trimesh.Trimesh]) -> Picture:
    """Return skin, ridge section and opened mold. `meshes` by part name, in the mold's frame, mm."""
    with sheet((13.2, 7.4), 110, 128) as figure:
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
    anchors = [(camera.pixel(_right_edge(shape)), name) for name, shape in labels]
    free = 0.0
    for (x, y), name in sorted(anchors, key=lambda anchor: anchor[0][1]):
        free = max(free, y)
        line = {"arrowstyle": "-", "color": "#666", "linewidth": 0.6}
        axes.annotate(name, (x, y), (_PIXELS[0] + 10, free), fontsize=8, va="center", arrowprops=line)
        free += 0.028 * _PIXELS[1]
    _show(axes, "mold, taken apart (it is poured with the ridges down)")


def _right_edge(shape: trimesh.Trimesh) -> np.ndarray:
    """A point on the part's right upper edge, seen from in front."""
    low, high = shape.bounds
    return np.array([high[0], (low[1] + high[1]) / 2, 0.2 * low[2] + 0.8 * high[2]])
