"""What the skin feels: the stress in the ridges by force (Fig 8), and in the whole section step by step."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from skincad.base.arrays import Array, Index
from skincad.base.estimate import Estimate
from skincad.mechanics.bodies.film_field import Patch
from skincad.mechanics.film.fields import DeformedSection, RidgeField
from skincad.mechanics.film.stress import FilmStress
from skincad.outputs.figures.canvas import (
    AROUND,
    BLACK,
    BLUE,
    FILM,
    FRAME,
    GREY,
    LABEL,
    NOTE,
    PALE,
    PLATE,
    SIGNED_MAP,
    SMALL,
    VERMILION,
    Axes,
    Figure,
    Normalize,
    Picture,
    PolyCollection,
    ScalarMappable,
    Triangulation,
    agg,
    colormaps,
    own_style,
    sheet,
    to_rgb,
)

SERIES = (("S1", BLUE, "o", -0.15), ("S2", VERMILION, "s", 0.15), ("S1 - S2", BLACK, "D", 0.0))
AREA_IN_SCALE = 0.97  # share of the silicone's drawn area whose stress lies within the colours
WINDOW = 0.27  # of the field's extent, each way from the films
SIZE = (9.0, 6.9)  # 900 pixels wide
# or the last before the middle: "the third ridge from an end", as the paper's figures 12 and 13
NOTED_RIDGE = 3
Frame = tuple[float, float, float, float]
WIDTH = 9.0  # inches
ABOVE, BESIDE = 0.12, 0.03  # margins in the section's height and width
FRAME_WIDTH, COLOURS = 720, 48  # pixels; with 60 frames below 2 MB (measured on yamada-2002-slip: 1.0 MB)
SECONDS = 6.0  # of an animation


def film_stress_figure(normal: FilmStress, both: FilmStress) -> Picture:
    """Return a figure laid out as the paper's Fig 8: (a) `normal` force alone, (b) `both` forces.

    S1, S2 and their difference by ridge with error bars; below, the stress in the deformed section of the
    ridges that both carry as fields.
    """
    ridges = [r for r in (v.ridge for v in normal.fields) if r in {v.ridge for v in both.fields}][:2]
    with sheet(SIZE if ridges else (SIZE[0], 4.0), 255) as figure:
        columns = 2 * max(1, len(ridges))
        grid = figure.add_gridspec(2 if ridges else 1, columns, height_ratios=[1.0, 0.8] if ridges else None)
        left = figure.add_subplot(grid[0, : columns // 2])
        right = figure.add_subplot(grid[0, columns // 2 :], sharey=left)
        _draw_ridges(left, normal, f"(a) normal force {normal.force:g} N")
        _draw_ridges(right, both, f"(b) normal {both.force:g} N, tangential {both.tangential:g} N to +x")
        left.set_ylabel("mean stress across the film, MPa\n(tension positive)")
        handles = left.get_legend_handles_labels()[0]
        figure.legend(handles=handles, loc="outside upper right", ncols=3, frameon=False)
        if ridges:
            states = [[v for v in stress.fields if v.ridge in ridges] for stress in (normal, both)]
            _draw_fields(figure, [figure.add_subplot(grid[1, i]) for i in range(columns)], states)
        figure.supxlabel(_note(normal, both), x=0.02, ha="left", fontsize=LABEL)
        figure.suptitle(f"{normal.name}: stress in the ridges")
    return figure


def _draw_ridges(axes: Axes, stress: FilmStress, title: str) -> None:
    ridges = np.arange(1, stress.ridges + 1)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    series = zip(SERIES, (stress.s1, stress.s2, stress.differential), strict=True)
    for (label, colour, marker, offset), estimates in series:
        values, errors = [e.value or 0.0 for e in estimates], [e.error or 0.0 for e in estimates]
        style: dict[str, Any] = {"color": colour, "marker": marker, "markersize": 4.5, "capsize": 3}
        axes.errorbar(ridges + offset, values, errors, label=label, linestyle="none", linewidth=1.0, **style)
    axes.set(title=title, xlabel="ridge")
    if stress.ridges <= 20:
        axes.set_xticks(ridges)
    axes.grid(visible=False, axis="x")


def _draw_fields(figure: Figure, places: list[Axes], states: list[list[RidgeField]]) -> None:
    """Draw the fields of both states on one scale of colours, deformed as they are."""
    fields = [field for state in states for field in state]
    limit = max(colour_limit(field.place, field.triangles[~field.film], field.stress) for field in fields)
    for axes, field in zip(places, fields, strict=True):
        drawn = _draw_silicone(axes, field, field.stress, limit)
        nearest = np.hypot(*(field.place - field.middle).T).argmin()
        middle, half = (field.place + field.shift)[nearest], WINDOW * float(np.ptp(field.place, axis=0).max())
        axes.set(xlim=(middle[0] - half, middle[0] + half), ylim=(middle[1] - half, middle[1] + half))
        axes.set_title(f"ridge {field.ridge}", fontsize=LABEL)
    places[0].set_ylabel("z, mm", fontsize=SMALL)
    words = "stress across the ridge in the deformed section, MPa; films black"
    _name_colours(figure, drawn, places, 40, words)


def _draw_silicone(axes: Axes, body: Patch, stress: Array, limit: float, **film: Any) -> ScalarMappable:
    """Draw a deformed body in the colours of its stress, with its films; `film` is their edges' look."""
    points = body.place + body.shift
    silicone = Triangulation(points[:, 0], points[:, 1], body.triangles[~body.film])
    drawn = axes.tripcolor(silicone, stress, cmap=SIGNED_MAP, vmin=-limit, vmax=limit, shading="gouraud")
    if body.film.any():
        strips = list(points[body.triangles[body.film]])
        axes.add_collection(PolyCollection(strips, facecolor=FILM, edgecolor=FILM, **film))
    axes.set_aspect("equal")
    axes.tick_params(labelsize=NOTE)
    axes.set_xlabel("x, mm", fontsize=SMALL)
    axes.grid(visible=False)
    return drawn


def _name_colours(figure: Figure, scale: ScalarMappable, places: Any, aspect: float, words: str) -> None:
    bar = figure.colorbar(scale, ax=places, location="bottom", shrink=0.6, aspect=aspect, extend="both")
    bar.set_label(words, fontsize=SMALL)
    bar.ax.tick_params(labelsize=NOTE)


def colour_limit(place: Array, triangles: Index, values: Array) -> float:
    """Return the size below which SHOWN of the triangles' area lies; at films' corners a stress has no bound.

    `place` `(p, 2)` and `values` `(p,)` of points, `triangles` `(t, 3)` of them.
    """
    a, b, c = (place[triangles[:, i]] for i in range(3))
    area = np.abs((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    size = np.abs(values[triangles].mean(axis=1))
    order = np.argsort(size)
    below = np.searchsorted(np.cumsum(area[order]), AREA_IN_SCALE * area.sum())
    return float(size[order][min(below, size.size - 1)])


def band_share(value: float, error: float) -> str:
    """A share of S1 in words: beyond 150 % a ratio is easier to read."""
    if abs(value) > 1.5:
        return str(Estimate(value, error, "times"))
    return f"{Estimate(100 * value, 100 * error, '%')} of".replace(" ±", "% ±").replace(" % of", "% of")


def _note(normal: FilmStress, both: FilmStress) -> str:
    """What the picture shows of the paper's statement, with its figures."""
    ridge = min(NOTED_RIDGE, normal.ridges // 2)
    share = normal.lean_share(ridge) if ridge else Estimate(None, None, "1")
    lines = []
    if share.value is not None:
        middle = ", zero at the middle one" if normal.ridges % 2 else ""
        lines.append(
            "(a) Outer ridges lean, so under the normal force alone their S1 - S2 is not zero:\n"
            f"      {band_share(share.value, share.error or 0.0)} S1 at ridge {ridge}{middle}."
        )
    friction = [e.value for e in both.needed_friction]
    if both.tangential:
        highest = [mu or 0.0 for mu in friction]
        lifted = [str(i + 1) for i, mu in enumerate(friction) if mu is None]
        needs = f"it needs friction of {max(highest):.2g} at ridge {1 + int(np.argmax(highest))}"
        if lifted:
            needs = f"it takes the normal force off ridge {', '.join(lifted)}"
        lines.append(f"(b) Full stick is an assumption, normal force first: {needs}.")
    return "\n".join(lines)


Moment = tuple[str, DeformedSection]  # what is said of a step, and its section


def section_picture(moment: Moment, path: Path) -> None:
    """Write a PNG of a section, coloured by the stress across the ridges."""
    with own_style():
        _, picture = next(_images([moment]))
    _few_colours(picture, 255).save(path, format="PNG", optimize=True)


def section_figure(moment: Moment) -> Picture:
    """Return the figure that `section_picture` writes."""
    with own_style():
        return next(_images([moment]))[0]


def section_animation(moments: Sequence[Moment], path: Path) -> None:
    """Write a GIF of sections, all on one scale of colours and in one frame."""
    pictures = []
    with own_style():
        for _, picture in _images(moments):
            height = round(picture.height * FRAME_WIDTH / picture.width)
            small = picture.resize((FRAME_WIDTH, height), Image.Resampling.LANCZOS)
            pictures.append(_few_colours(small, COLOURS))
    first, *rest = pictures
    moving = {"duration": [round(1000 * SECONDS / len(pictures))] * len(pictures), "loop": 0}
    first.save(path, format="GIF", save_all=True, append_images=rest, optimize=True, **moving)


def _few_colours(picture: Image.Image, count: int) -> Image.Image:
    """The picture in the plain colours and as many of the stress's scale as make up `count`."""
    plain = [to_rgb(c) for c in (PLATE, AROUND, FILM, "white", "black", FRAME, PALE)]
    scale = colormaps[SIGNED_MAP](np.linspace(0.0, 1.0, count - len(plain)))[:, :3]
    palette = Image.new("P", (1, 1))
    palette.putpalette(np.round(255 * np.concatenate([plain, scale])).astype(np.uint8).tobytes())
    return picture.quantize(palette=palette, dither=Image.Dither.NONE)


def moments_limit(moments: Sequence[Moment]) -> float:
    """Largest stress of the colours, MPa: that below which nearly all silicone lies."""
    return max(colour_limit(s.place, s.triangles[~s.film], s.stress[:, 0]) for _, s in moments) or 1e-6


def _images(moments: Sequence[Moment]) -> Iterator[tuple[Picture, Image.Image]]:
    """Draw sections one after the other on one figure, with one scale of colours and one frame."""
    points = np.concatenate([shown.place + shown.shift for _, shown in moments])
    (left, low), (right, high) = points.min(axis=0), points.max(axis=0)
    wide, tall = BESIDE * (right - left), ABOVE * (high - low)
    left, right, low, high = frame = left - wide, right + wide, low - tall / 3, high + tall  # and some plate
    figure = agg((WIDTH, WIDTH * (high - low) / (right - left) + 1.2))
    axes, limit = figure.add_subplot(), moments_limit(moments)
    scale = ScalarMappable(Normalize(-limit, limit), SIGNED_MAP)
    _name_colours(figure, scale, axes, 50, "stress along x, MPa; films black")
    for title, shown in moments:
        axes.clear()
        _draw_section(axes, shown, limit, frame)
        axes.set_title(title)
        canvas: Any = figure.canvas  # Agg's, whose drawing is untyped
        canvas.draw()
        figure.set_layout_engine("none")  # as it is laid out now, so that frames do not jump
        yield figure, Image.fromarray(np.array(canvas.buffer_rgba())).convert("RGB")


def _draw_section(axes: Axes, shown: DeformedSection, limit: float, frame: Frame) -> None:
    left, right, low, high = frame
    _draw_silicone(axes, shown, shown.stress[:, 0], limit, linewidth=0.4)
    ends = np.array([left, right])
    plate = shown.plate + math.tan(shown.angle) * ends
    axes.fill_between(ends, plate, high, color=PLATE, linewidth=0)
    axes.set_facecolor(AROUND)
    axes.set(xlim=(left, right), ylim=(low, high))
    axes.set_ylabel("z, mm", fontsize=SMALL)
