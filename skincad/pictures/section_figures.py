"""The deformed section with its stress under the plate, as a picture of a step and as an animation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from skincad.mechanics.film.fields import DeformedSection
from skincad.pictures.canvas import (
    Axes,
    Normalize,
    Picture,
    PolyCollection,
    ScalarMappable,
    Triangulation,
    agg,
    colormaps,
    own_style,
    to_rgb,
)
from skincad.pictures.film_figures import FILM, MAP, colour_limit

Frame = tuple[float, float, float, float]
PLATE, AROUND = "#9a9a9a", "#d7e3d0"  # a tint that no stress has: unstressed skin is white
WIDTH, DPI = 9.0, 100
ABOVE, BESIDE = 0.12, 0.03  # margins in the section's height and width
FRAME_WIDTH, COLOURS = 720, 48  # pixels; with 60 frames below 2 MB (measured on yamada-2002-slip: 1.0 MB)
SECONDS = 6.0  # of an animation


@dataclass(frozen=True, eq=False)
class Moment:
    """A step's section and what is said of it."""

    title: str
    shown: DeformedSection


def section_picture(moment: Moment, path: Path) -> None:
    """Write a PNG of a section, coloured by the stress across the ridges."""
    with own_style():
        picture = _sheet([moment]).image(moment)
    _few_colours(picture, 255).save(path, format="PNG", optimize=True)


def section_figure(moment: Moment) -> Picture:
    """Return the figure that `section_picture` writes."""
    with own_style():
        sheet = _sheet([moment])
        sheet.image(moment)
    return sheet.figure


def section_animation(moments: Sequence[Moment], path: Path) -> None:
    """Write a GIF of sections, all on one scale of colours and in one frame."""
    pictures = []
    with own_style():
        sheet = _sheet(moments)
        for moment in moments:
            picture = sheet.image(moment)
            height = round(picture.height * FRAME_WIDTH / picture.width)
            small = picture.resize((FRAME_WIDTH, height), Image.Resampling.LANCZOS)
            pictures.append(_few_colours(small, COLOURS))
    times = [round(1000 * SECONDS / len(pictures))] * len(pictures)
    pictures[0].save(
        path, format="GIF", save_all=True, append_images=pictures[1:], duration=times, loop=0, optimize=True
    )


def _few_colours(picture: Image.Image, count: int) -> Image.Image:
    """The picture in the plain colours and as many of the stress's scale as make up `count`."""
    plain = [to_rgb(c) for c in (PLATE, AROUND, FILM, "white", "black", "#555555", "#cccccc")]
    scale = colormaps[MAP](np.linspace(0.0, 1.0, count - len(plain)))[:, :3]
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.round(255 * np.concatenate([plain, scale])).astype(np.uint8).tobytes())
    return picture.quantize(palette=palette, dither=Image.Dither.NONE)


def _limit(moments: Sequence[Moment]) -> float:
    """Largest stress of the colours, MPa: that below which nearly all silicone lies."""
    every = (m.shown for m in moments)
    return max(colour_limit(s.place, s.triangles[~s.film], s.stress[:, 0]) for s in every) or 1e-6


def _frame(moments: Sequence[Moment]) -> Frame:
    """Limits in x and z, mm, that hold all of them and some plate."""
    points = np.concatenate([m.shown.place + m.shown.shift for m in moments])
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    wide, tall = BESIDE * (right - left), ABOVE * (high - low)
    return left - wide, right + wide, low - tall / 3, high + tall


@dataclass(frozen=True, eq=False)
class _Sheet:
    """A figure that is drawn on again and again, with one scale of colours and one frame."""

    figure: Picture
    axes: Axes
    limit: float
    frame: Frame

    def image(self, moment: Moment) -> Image.Image:
        self.axes.clear()
        _draw_section(self.axes, moment.shown, self.limit, self.frame)
        self.axes.set_title(moment.title)
        canvas: Any = self.figure.canvas  # Agg's, whose drawing is untyped
        canvas.draw()
        self.figure.set_layout_engine("none")  # as it is laid out now, so that frames do not jump
        return Image.fromarray(np.array(canvas.buffer_rgba())).convert("RGB")


def _sheet(moments: Sequence[Moment]) -> _Sheet:
    left, right, low, high = frame = _frame(moments)
    figure = agg((WIDTH, WIDTH * (high - low) / (right - left) + 1.2), DPI)
    axes, limit = figure.add_subplot(), _limit(moments)
    scale = ScalarMappable(Normalize(-limit, limit), MAP)
    bar = figure.colorbar(scale, ax=axes, location="bottom", shrink=0.6, aspect=50, extend="both")
    bar.set_label("stress along x, MPa; films black", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    return _Sheet(figure, axes, limit, frame)


def _draw_section(axes: Axes, shown: DeformedSection, limit: float, frame: Frame) -> None:
    left, right, low, high = frame
    points, silicone = shown.place + shown.shift, shown.triangles[~shown.film]
    skin = Triangulation(points[:, 0], points[:, 1], silicone)
    axes.tripcolor(skin, shown.stress[:, 0], cmap=MAP, vmin=-limit, vmax=limit, shading="gouraud")
    if shown.film.any():
        strips = list(points[shown.triangles[shown.film]])
        axes.add_collection(PolyCollection(strips, facecolor=FILM, edgecolor=FILM, linewidth=0.4))
    ends = np.array([left, right])
    plate = shown.plate + math.tan(shown.angle) * ends
    axes.fill_between(ends, plate, high, color=PLATE, linewidth=0)
    axes.set_facecolor(AROUND)
    axes.grid(visible=False)
    axes.set_xlim(left, right)
    axes.set_ylim(low, high)
    axes.set_aspect("equal")
    axes.tick_params(labelsize=7)
    axes.set_ylabel("z, mm", fontsize=8)
    axes.set_xlabel("x, mm", fontsize=8)
