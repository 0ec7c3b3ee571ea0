"""Pictures of what the skin feels: the stress in the ridges under normal and tangential force (Fig 8)."""

from __future__ import annotations

from typing import Any

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.base.estimate import Estimate
from skincad.mechanics.film.fields import RidgeField
from skincad.mechanics.film.stress import FilmStress
from skincad.pictures.canvas import (
    BLACK,
    BLUE,
    GREY,
    VERMILION,
    Axes,
    Figure,
    Picture,
    PolyCollection,
    Triangulation,
    sheet,
)

SERIES = (("S1", BLUE, "o", -0.15), ("S2", VERMILION, "s", 0.15), ("S1 - S2", BLACK, "D", 0.0))
AREA_IN_SCALE = 0.97  # share of the silicone's drawn area whose stress lies within the colours
MAP = "RdBu_r"
WINDOW = 0.27  # of the field's extent, each way from the films
FILM = "#111111"
SIZE, DPI = (9.0, 6.9), 100  # 900 pixels wide
NOTED_RIDGE = (
    3  # or the last before the middle: "the third ridge from an end", as the paper's figures 12 and 13
)


def film_stress_figure(normal: FilmStress, both: FilmStress) -> Picture:
    """Return a figure laid out as the paper's Fig 8: (a) `normal` force alone, (b) `both` forces.

    S1, S2 and their difference by ridge with error bars; below, the stress in the deformed section of the
    ridges that both carry as fields.
    """
    ridges = [r for r in (v.ridge for v in normal.fields) if r in {v.ridge for v in both.fields}][:2]
    with sheet(SIZE if ridges else (SIZE[0], 4.0), DPI, 255) as figure:
        columns = 2 * max(1, len(ridges))
        grid = figure.add_gridspec(2 if ridges else 1, columns, height_ratios=[1.0, 0.8] if ridges else None)
        left = figure.add_subplot(grid[0, : columns // 2])
        right = figure.add_subplot(grid[0, columns // 2 :], sharey=left)
        _draw_ridges(left, normal, f"(a) normal force {normal.force:g} N")
        _draw_ridges(right, both, f"(b) normal {both.force:g} N, tangential {both.tangential:g} N to +x")
        left.set_ylabel("mean stress across the film, MPa\n(tension positive)")
        figure.legend(
            handles=left.get_legend_handles_labels()[0], loc="outside upper right", ncols=3, frameon=False
        )
        if ridges:
            states = [[v for v in stress.fields if v.ridge in ridges] for stress in (normal, both)]
            _draw_fields(figure, [figure.add_subplot(grid[1, i]) for i in range(columns)], states)
        figure.supxlabel(_note(normal, both), x=0.02, ha="left", fontsize=9)
        figure.suptitle(f"{normal.name}: stress in the ridges")
    return figure


def _draw_ridges(axes: Axes, stress: FilmStress, title: str) -> None:
    ridges = np.arange(1, stress.ridges + 1)
    axes.axhline(0.0, color=GREY, linewidth=0.8)
    for (label, colour, marker, offset), estimates in zip(
        SERIES, (stress.s1, stress.s2, stress.differential), strict=True
    ):
        values, errors = _numbers(estimates)
        style: dict[str, Any] = {
            "color": colour,
            "marker": marker,
            "markersize": 4.5,
            "capsize": 3,
            "linewidth": 1.0,
        }
        axes.errorbar(ridges + offset, values, errors, label=label, linestyle="none", **style)
    axes.set_title(title)
    axes.set_xlabel("ridge")
    if stress.ridges <= 20:
        axes.set_xticks(ridges)
    axes.grid(visible=False, axis="x")


def _numbers(estimates: tuple[Estimate, ...]) -> tuple[list[float], list[float]]:
    return [e.value or 0.0 for e in estimates], [e.error or 0.0 for e in estimates]


def _draw_fields(figure: Figure, places: list[Axes], states: list[list[RidgeField]]) -> None:
    """Draw the fields of both states on one scale of colours, deformed as they are."""
    fields = [field for state in states for field in state]
    limit = max(colour_limit(field.place, field.triangles[~field.film], field.stress) for field in fields)
    for axes, field in zip(places, fields, strict=True):
        points = field.place + field.shift
        triangles = field.triangles
        silicone = Triangulation(points[:, 0], points[:, 1], triangles[~field.film])
        drawn = axes.tripcolor(silicone, field.stress, cmap=MAP, vmin=-limit, vmax=limit, shading="gouraud")
        if field.film.any():
            axes.add_collection(
                PolyCollection(list(points[triangles[field.film]]), facecolor=FILM, edgecolor=FILM)
            )
        nearest = np.hypot(*(field.place - field.middle).T).argmin()
        middle, half = points[nearest], WINDOW * float(np.ptp(field.place, axis=0).max())
        axes.set_xlim(middle[0] - half, middle[0] + half)
        axes.set_ylim(middle[1] - half, middle[1] + half)
        axes.set_aspect("equal")
        axes.set_title(f"ridge {field.ridge}", fontsize=9)
        axes.tick_params(labelsize=7)
        axes.set_xlabel("x, mm", fontsize=8)
        axes.grid(visible=False)
    places[0].set_ylabel("z, mm", fontsize=8)
    bar = figure.colorbar(drawn, ax=places, location="bottom", shrink=0.6, aspect=40, extend="both")
    bar.set_label("stress across the ridge in the deformed section, MPa; films black", fontsize=8)
    bar.ax.tick_params(labelsize=7)


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


def _share(value: float, error: float) -> str:
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
            f"      {_share(share.value, share.error or 0.0)} S1 at ridge {ridge}{middle}."
        )
    friction = [e.value for e in both.needed_friction]
    if both.tangential:
        highest = [mu or 0.0 for mu in friction]
        lifted = [str(i + 1) for i, mu in enumerate(friction) if mu is None]
        needs = (
            f"it takes the normal force off ridge {', '.join(lifted)}"
            if lifted
            else f"it needs friction of {max(highest):.2g} at ridge {1 + int(np.argmax(highest))}"
        )
        lines.append(f"(b) Full stick is an assumption, normal force first: {needs}.")
    return "\n".join(lines)
