"""Words and pictures of the films' stress."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from skincad.base.estimate import Estimate
from skincad.base.result import Writer
from skincad.mechanics.film.stress import FilmStresses
from skincad.outputs.delivery import picture

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "film-stress"


def lines(stresses: FilmStresses) -> list[str]:
    """Return what `check --stress` prints beneath the verdict."""
    rows = []
    for state in stresses.states:
        pulled = f", pulled sideways by {state.tangential:g} N" if state.tangential else ""
        rows.append(f"  stress across the film at {state.force:g} N{pulled}")
        components = {"S1": state.s1, "S2": state.s2, "S1 - S2": state.differential}
        rows += [_row(name, values) for name, values in components.items()]
    return [*rows, *(f"  note           {note}" for note in stresses.warnings)]


def _row(name: str, values: tuple[Estimate, ...]) -> str:
    error = max((v.error or 0.0) for v in values)
    numbers = "  ".join(f"{v.value:+.4f}" for v in values)
    return f"    {name:8} {numbers} (± {error:.1g}) MPa"


def manifest(stresses: FilmStresses) -> dict[str, Any]:
    """Return what the manifest says of the result."""
    return stresses.as_json()


def figures(stresses: FilmStresses) -> dict[str, Callable[[], Picture]]:
    """Return the stress under the normal force, and under both forces (Fig 8)."""
    from skincad.pictures.film_figures import film_stress_figure

    return {"film-stress.png": partial(film_stress_figure, *stresses.states)}


def files(stresses: FilmStresses) -> dict[str, Writer]:
    """Return the writer of the picture."""
    return {name: picture(draw) for name, draw in figures(stresses).items()}
