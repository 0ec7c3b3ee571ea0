"""What a material test says: the modulus, and the lines of a design that it goes into."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.base.tables import Ranged
from skincad.material.modulus import MaterialFit
from skincad.outputs.delivery import picture, text

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "fit-material"


def lines(fit: MaterialFit) -> list[str]:
    """Return what `fit-material` prints, with the TOML lines to paste into a design."""
    unit = "N" if fit.kind == "pad" else "MPa"
    halves = "  ".join(f"{part.young_modulus} from {part.start:.3g} to {part.end:.3g}" for part in fit.parts)
    return [
        f"The {fit.kind} test gives a Young's modulus of {fit.young_modulus} (95 %), "
        f"by {fit.rows_used} of {fit.rows} rows.",
        f"  error          scatter {fit.scatter:.2g}, model {fit.model:.2g}, misfit {fit.misfit:.2g} MPa",
        *([f"  by halves      {halves}"] if halves else []),
        *([f"  first touch    at {fit.offset} of approach"] if fit.offset else []),
        f"  residual       {fit.rms:.2g} {unit} rms, {fit.rms / fit.largest_load:.1%} of the largest load",
        *(f"  note           {warning}" for warning in fit.warnings),
        "",
        *toml_lines(fit),
    ]


def toml_lines(fit: MaterialFit) -> list[str]:
    """Return the lines of a design's TOML."""
    return ["[material]", f"young_modulus = {ranged_toml(fit.ranged)}"]


def ranged_toml(ranged: Ranged) -> str:
    """Return a number with its range as a TOML value."""
    return f"{{ value = {ranged.value}, low = {ranged.low}, high = {ranged.high} }}"


def manifest(fit: MaterialFit) -> dict[str, Any]:
    """Return what the manifest says of the result: all of it."""
    return fit.as_json()


def figures(fit: MaterialFit) -> dict[str, Callable[[], Picture]]:
    """Return the test's rows and what the model makes of them."""
    from skincad.pictures.fit_figures import fit_figure

    return {"fit.png": partial(fit_figure, fit)}


def files(fit: MaterialFit) -> dict[str, Writer]:
    """Return the writers of the picture and of the lines to paste."""
    pictures = {name: picture(draw) for name, draw in figures(fit).items()}
    return {"material.toml": text(lambda: "\n".join(toml_lines(fit)) + "\n"), **pictures}
