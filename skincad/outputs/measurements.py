"""Output of what is measured: a material test's modulus, a part's press, and a recording of its films."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import tomlkit

from skincad.base.result import Writer
from skincad.inputs.silicone import Silicone
from skincad.material.acceptance import Acceptance
from skincad.material.laws import FITTED_SHARE
from skincad.material.modulus import MaterialFit
from skincad.outputs.delivery import Presentation, picture, text
from skincad.outputs.tomls import aligned, ranged_toml
from skincad.scenes.acceptance import CANT_TELL, RecordingAcceptance
from skincad.scenes.strip_assignment import WORKS

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture


def toml_lines(fit: MaterialFit) -> list[str]:
    """Return the lines of a design's TOML."""
    modulus = ["[material]", f"young_modulus = {ranged_toml(fit.ranged)}"]
    if fit.law is None:
        return modulus
    table = tomlkit.dumps({key: _rounded(value) for key, value in fit.law.model_dump().items()})
    return [*modulus, "", "[material.law]", *table.splitlines()]


def _law_table(fit: MaterialFit) -> list[str]:
    """The laws that were compared, with their errors."""
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
    return aligned(rows)


def _rounded(value: Any) -> Any:
    """Constants to 6 digits: no test says more."""
    if isinstance(value, tuple):
        return [_rounded(item) for item in value]
    return float(f"{value:.6g}") if isinstance(value, float) else value


def _fit_figures(fit: MaterialFit) -> dict[str, Callable[[], Picture]]:
    """The test's rows and what the model makes of them."""
    from skincad.outputs.figures.results import fit_figure

    return {"fit.png": partial(fit_figure, fit)}


def _fit_files(fit: MaterialFit) -> dict[str, Writer]:
    """The writers of the picture and of the lines to paste."""
    pictures = {name: picture(draw) for name, draw in _fit_figures(fit).items()}
    return {"material.toml": text(lambda: "\n".join(toml_lines(fit)) + "\n"), **pictures}


def _press_figures(result: Acceptance) -> dict[str, Callable[[], Picture]]:
    """The rows and the curves of a good part."""
    from skincad.outputs.figures.results import acceptance_figure

    return {"accept.png": partial(acceptance_figure, result)}


def _press_files(result: Acceptance) -> dict[str, Writer]:
    """The writers of the picture and of the words."""
    pictures = {name: picture(draw) for name, draw in _press_figures(result).items()}
    return {"accept.txt": text(lambda: f"{result}\n"), **pictures}


def _like_pairs(result: RecordingAcceptance) -> list[tuple[str, ...]]:
    """Which strips could have changed places without the recording's showing it."""
    return sorted({tuple(sorted((strip.name, other))) for strip in result.strips for other in strip.alike})


FIT = Presentation(
    COMMAND="fit-material",
    words="fit-material.txt",
    facts={"FITTED_SHARE": FITTED_SHARE, "law_table": _law_table, "toml_lines": toml_lines},
    files=_fit_files,
    figures=_fit_figures,
)
ACCEPTANCE = Presentation(
    COMMAND="accept", words="accept.txt", facts={}, files=_press_files, figures=_press_figures
)
RECORDING = Presentation(
    COMMAND="accept",
    words="accept-recording.txt",
    facts={"CANT_TELL": CANT_TELL, "WORKS": WORKS, "like_pairs": _like_pairs},
    files=lambda _: {},
)
