"""Output of a material test: the modulus, and the lines of a design that hold it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import tomlkit

from skincad.base.result import Writer
from skincad.inputs.silicone import Silicone
from skincad.material.laws import FITTED_SHARE
from skincad.material.modulus import MaterialFit
from skincad.outputs.delivery import Presentation, picture, text
from skincad.outputs.tomls import aligned, ranged_toml

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture

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
        *([f"  zero           at a strain of {fit.zero}"] if fit.zero else []),
        f"  residual       {fit.rms:.2g} {unit} rms, {fit.rms / fit.largest_load:.1%} of the largest load",
        *(f"  note           {warning}" for warning in fit.warnings),
        *law_lines(fit),
        "",
        *toml_lines(fit),
    ]


def toml_lines(fit: MaterialFit) -> list[str]:
    """Return the lines of a design's TOML."""
    modulus = ["[material]", f"young_modulus = {ranged_toml(fit.ranged)}"]
    if fit.law is None:
        return modulus
    table = tomlkit.dumps({key: _rounded(value) for key, value in fit.law.model_dump().items()})
    return [*modulus, "", "[material.law]", *table.splitlines()]


def law_lines(fit: MaterialFit) -> list[str]:
    """Return the table of laws, if any were compared."""
    if not fit.laws:
        return []
    reach = fit.laws[0].reach
    head = f"Laws fitted to strains up to {FITTED_SHARE * reach:.3g}, and judged beyond, up to {reach:.3g}"
    how = "missed: rms by the largest stress; *: the least beyond, or as little with fewer constants"
    rows = [("", "constants", "missed there", "missed beyond", "modulus, MPa")]
    rows += [
        (
            ("* " if row.best else "  ") + row.name,
            str(row.constants),
            f"{row.rms_seen:.2%}",
            f"{row.rms_judged:.2%}",
            f"{row.law.young_modulus(Silicone().poisson_ratio):.4g}",
        )
        for row in fit.laws
    ]
    return ["", f"{head}. {how}", *aligned(rows)]


def _rounded(value: Any) -> Any:
    """Constants to 6 digits: no test says more."""
    if isinstance(value, tuple):
        return [_rounded(item) for item in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def figures(fit: MaterialFit) -> dict[str, Callable[[], Picture]]:
    """Return the test's rows and what the model makes of them."""
    from skincad.outputs.figures.results import fit_figure

    return {"fit.png": partial(fit_figure, fit)}


def files(fit: MaterialFit) -> dict[str, Writer]:
    """Return the writers of the picture and of the lines to paste."""
    pictures = {name: picture(draw) for name, draw in figures(fit).items()}
    return {"material.toml": text(lambda: "\n".join(toml_lines(fit)) + "\n"), **pictures}


FIT = Presentation(COMMAND=COMMAND, lines=lines, files=files, figures=figures)
