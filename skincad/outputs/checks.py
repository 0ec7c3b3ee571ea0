"""Output of a check, of films' stress and of films to buy: the verdict in one sentence, and its numbers."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

from skincad.base.estimate import Estimate
from skincad.base.progress import about
from skincad.fabrication.papers import macro
from skincad.mechanics.left_out import FRICTION
from skincad.mechanics.problem import NEGLIGIBLE
from skincad.mechanics.verdict import NO_MODEL, ContactCheck, Holding, LiftSignal
from skincad.outputs.delivery import Presentation, drawn
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.fabrication.making import Build
    from skincad.mechanics.film.stress import FilmStresses
    from skincad.outputs.figures.canvas import Picture


COMMAND = "check"
MOST_BARS = 60  # of a bar chart in a terminal; more features share bars
BLOCKS = "▁▂▃▄▅▆▇█"  # a ridge's force, in full eighths of the largest
CLEAR = "·"  # a ridge without load


def verdict(check: ContactCheck) -> str:
    """Return the contact verdict in one sentence, with its error."""
    return CHECK.said("verdict", check)


def verdict_of(build: Build) -> str:
    """Return the verdict of a build in one sentence, or that nobody asked for it."""
    return CHECK.said("verdict_of", build)


def advice_lines(check: ContactCheck) -> list[str]:
    """Return why the design fails and what would pass, as far as it is known: more only adds lines."""
    return CHECK.rows("advice", check)


def allowed_drops(check: ContactCheck | None) -> tuple[float, ...]:
    """Return how far each crest may lie lower, mm, if only that one does: it uses up the verdict's margin."""
    if check is None:
        return ()
    part_yield, margin = check.manufacture, check.margin
    if part_yield is None or margin is None or not check.passed:
        return ()
    return tuple(margin / slope if slope > 0 else math.inf for slope in part_yield.crest_sensitivity)


def allowance(check: ContactCheck | None) -> tuple[tuple[float, ...], float]:
    """Return these drops, mm, and the margin that each uses up, N."""
    return allowed_drops(check), (check.margin or 0.0) if check else 0.0


def awaits_advice(check: ContactCheck) -> bool:
    """Return whether only a change of the design, not a better model, can make a check pass."""
    return check.verdict == "fails" or check.next_step.startswith(NO_MODEL)


def holds_few(holding: Holding | None, signal: LiftSignal | None) -> bool:
    """Return whether less than half of the lifts are held, or a slow one is too weak to be heard."""
    if holding is None or holding.share is None:
        return False
    return holding.share < 0.5 or (signal is not None and signal.verdict == "too weak")


def _force_bars(check: ContactCheck) -> tuple[str, int]:
    """Each ridge's force as a block, in parts of the largest, and how many ridges share a block."""
    values = _values(check.ridge_force)
    shared = math.ceil(len(values) / MOST_BARS)
    groups = [values[i : i + shared] for i in range(0, len(values), shared)]
    return "".join(_block(group, max(values)) for group in groups), shared


def _block(group: list[float], largest: float) -> str:
    """Return the block of the mean of a group's forces, CLEAR where one of them is 0."""
    if min(group) <= 0.0:
        return CLEAR
    share = math.fsum(group) / len(group) / largest
    return BLOCKS[max(0, int(len(BLOCKS) * share + 1e-9) - 1)]


def _values(numbers: Iterable[Estimate]) -> list[float]:
    return [number.value or 0.0 for number in numbers]


def _largest_error(numbers: Iterable[Estimate]) -> float:
    return max(number.error or 0.0 for number in numbers)


def _ends(forces: Iterable[Estimate]) -> tuple[Estimate, Estimate]:
    """The smallest and the largest."""
    rising = sorted(forces, key=lambda force: force.value or 0.0)
    return rising[0], rising[-1]


def error_parts(check: ContactCheck) -> list[tuple[str, float]]:
    """Return the all-touch force's error, N, by the effect that is left out, first of mesh and method: ""."""
    value, error = check.all_touch_force.value or 0.0, check.all_touch_force.error or 0.0
    left_out = [(part.effect, part.threshold * value) for part in check.left_out]
    return [("", error - check.model_error), *left_out]


def html(check: ContactCheck) -> str:
    """Return the verdict, the force on each ridge as a bar with its error, and the other lines."""
    lines = [*CHECK.rows("answer", check)[1:], *CHECK.rows("notes", check), *check.next_line()]
    top = max((share.upper or share.value or 0.0) for share in check.ridge_force) or 1.0
    return macro("pages/check.html", "page", check, verdict(check), lines, CHECK.said("ends", check), top)


def check_figures(check: ContactCheck) -> dict[str, Callable[[], Picture]]:
    """Return each ridge's force, and of pins on magnets what forces sensors tell."""
    drawings = drawn("ridge-forces.png", "results:ridge_force_figure")(check)
    return drawings | (drawn("magnet.png", "results:magnet_figure")(check) if check.magnet else {})


def stress_figures(stresses: FilmStresses) -> dict[str, Callable[[], Picture]]:
    """Return the stress under the normal force, and under both forces (Fig 8)."""
    from skincad.outputs.figures.stress import film_stress_figure

    return {"film-stress.png": partial(film_stress_figure, *stresses.states)}


CHECK = Presentation(
    COMMAND=COMMAND,
    words="check.txt",
    facts={
        "force_bars": _force_bars,
        "values": _values,
        "largest_error": _largest_error,
        "ends_of": _ends,
        "crest_steps": lambda part_yield: [slope / 100 for slope in part_yield.crest_sensitivity],
        "error_parts": error_parts,
        "holds_few": holds_few,
        "awaits_advice": awaits_advice,
        "about": about,
        "skin_of": skin_of,
        "FRICTION": FRICTION,
        "NEGLIGIBLE": NEGLIGIBLE,
    },
    html=html,
    figures=check_figures,
)
FILM_STRESS = Presentation(
    COMMAND="film-stress",
    words="film-stress.txt",
    facts={"largest_error": _largest_error},
    figures=stress_figures,
)
FILM = Presentation(COMMAND="film", words="film.txt")
