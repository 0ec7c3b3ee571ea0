"""Output of a check and of the films' stress: the verdict in one sentence, and the numbers behind it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from skincad.base.estimate import Estimate
from skincad.base.progress import about
from skincad.base.result import Writer
from skincad.mechanics.left_out import FRICTION
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs.delivery import Presentation, picture

if TYPE_CHECKING:
    from skincad.mechanics.film.stress import FilmStresses
    from skincad.outputs.figures.canvas import Picture


COMMAND = "check"
NARROW_SHARE = 0.1  # of all parts: a yield's interval as narrow is shown to a tenth of a percent
WIDEST_SHARE = 0.8  # a yield's interval that is wider says nothing
MOST_SHOWN = 30  # forces in a line; of more features their range
UNCHECKED = "Not checked whether all ridges touch."  # for a job without a check


def verdict(check: ContactCheck) -> str:
    """Return the contact verdict in one sentence, with its error."""
    needed, plate = _shown(check.all_touch_force), f"a {check.plate} plate at {check.force:g} N"
    every = "both ridges" if check.ridges == 2 else f"all {check.ridges} ridges"
    if check.out_of_range:
        return f"UNDECIDED: {check.out_of_range}."
    if check.ridges == 1:
        return f"Passes: the one ridge touches a {check.plate} plate at any force."
    if check.passed:
        return f"Passes: {every} touch {plate}; they already do at {needed}."
    some = f"{check.touching} of {check.ridges} ridges touch {plate}"
    if check.verdict == "fails":
        need = (
            "the force that all need is beyond the model's range"
            if check.all_touch_force.value is None
            else f"all need {needed}"
        )
        return f"FAILS: {some}; {need}."
    if check.touching < check.ridges:
        return f"UNDECIDED: {some}. All need {needed}, which may be less."
    return f"UNDECIDED: {some}, but the force they need is {needed}."


def _shown(positive: Estimate) -> str:
    """Return a number that can't be below 0: as a range where its error reaches that far."""
    return positive.span(rough=1.0)


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


def lines(check: ContactCheck) -> list[str]:
    """Return what `check` prints."""
    return [*verdict_lines(check), *advice_lines(check)]


def verdict_lines(check: ContactCheck) -> list[str]:
    """Return the lines that need no advice."""
    error = max((share.error or 0.0) for share in check.ridge_force)
    return [
        verdict(check),
        *([f"Next: {check.next_step}"] if check.next_step else []),
        *_margin_lines(check),
        f"  approach       {_shown(check.approach)}",
        f"  ridge forces   {_shares([share.value or 0.0 for share in check.ridge_force])} (± {error:.1g}) N",
        *_model_lines(check),
        *_manufacture_lines(check),
        *_self_contact_lines(check),
        *(f"  note           {warning}" for warning in check.warnings),
    ]


def _shares(forces: list[float]) -> str:
    """All forces, N, or of more than MOST_SHOWN the range."""
    if len(forces) > MOST_SHOWN:
        return f"{min(forces):.3f} to {max(forces):.3f}"
    return "  ".join(f"{force:.3f}" for force in forces)


def _margin_lines(check: ContactCheck) -> list[str]:
    if check.margin is None or check.ridges == 1 or check.all_touch_force.error is None:
        return []
    mesh = check.all_touch_force.error - check.model_error
    parts = [f"{mesh:.2g} N from mesh and method"]
    value = check.all_touch_force.value or 0.0
    open_friction = check.friction is None and check.model != "winkler"
    for part in check.left_out:
        why = "not knowing" if part.effect == FRICTION and open_friction else "leaving out"
        parts.append(f"{part.threshold * value:.2g} N for {why} {part.effect}")
    upper = check.all_touch_force.upper or 0.0
    applied = f"{check.force:g} N applied, up to {upper:.2f} N needed"
    return [
        f"  margin         {check.margin:.2f} N in the worst case ({applied})",
        f"  error          {', '.join(parts)}",
    ]


def _model_lines(check: ContactCheck) -> list[str]:
    lines = [f"  model          {check.model}, {check.unknowns} unknowns, {check.seconds['total']:.2f} s"]
    lines += [
        f"  tried first    {run.model}: {_shown(run.all_touch_force)}, {run.seconds:.2f} s"
        for run in check.models_tried
    ]
    if check.next_model and not check.next_step:
        model, seconds = check.next_model.model, check.next_model.seconds
        lines.append(f"  more accurate  --model {model}, about {about(seconds)} more")
    return lines


def passing_share(check: ContactCheck) -> str:
    """Return the share of parts that pass with its interval, as "90 % (80 to 93 %)"; "" without a yield.

    Where the interval holds nearly everything the share is unknown.
    """
    passing = check.manufacture.passing if check.manufacture else None
    if check.manufacture is None or passing is None or passing.value is None or passing.error is None:
        return ""
    low, high = check.manufacture.interval
    places = 1 if high - low < NARROW_SHARE else 0
    ends = f"{percent(low, places, math.floor)} to {percent(high, places, math.ceil)} %"
    if high - low > WIDEST_SHARE:
        return f"unknown ({ends} are possible)"
    return f"{100 * passing.value:.{places}f} % ({ends})"


def percent(share: float, places: int, to: Callable[[float], int]) -> str:
    """Return a share in percent, rounded away from the middle of its interval."""
    steps = 10**places
    return f"{to(round(100 * share * steps, 6)) / steps:g}"


def _manufacture_lines(check: ContactCheck) -> list[str]:
    part_yield, share = check.manufacture, passing_share(check)
    if part_yield is None or not share:
        return []
    lost = f"most are lost by {part_yield.largest}" if part_yield.largest else "none of those sampled fails"
    summary = share if share.startswith("unknown") else f"{share} of parts pass; {lost}"
    slopes = [slope / 100 for slope in part_yield.crest_sensitivity]
    crests = "  ".join(f"{slope:+.2g}" for slope in slopes)
    if len(slopes) > MOST_SHOWN:
        crests = f"{min(slopes):+.2g} to {max(slopes):+.2g}"
    return [
        f"  yield          {summary}",
        f"  crests         0.01 mm lower, each changes the force needed by {crests} N",
    ]


def _self_contact_lines(check: ContactCheck) -> list[str]:
    contact = check.self_contact
    if contact is None or check.out_of_range:
        return []
    force = float(f"{contact.begins.value or contact.free_to:.2g}")
    if not contact.where:
        return [f"  self-contact   none is found up to {force:g} N"]
    return [f"  self-contact   from about {force:g} N on, by small strain: {contact.where}"]


def advice_lines(check: ContactCheck) -> list[str]:
    """Return why the design fails and what would pass, as far as it is known: more only adds lines."""
    lines = [f"  cause          {check.cause}"] if check.cause else []
    for change in check.changes or ():
        lines += [
            f"  may pass       {change} alone, estimated with the {change.model} model"
            if change.model
            else f"  would pass     {change} alone"
        ]
    if check.changes == ():
        lines += ["  would pass     no single change that was tried"]
    return lines + [f"  note           {note}" for note in check.changes_notes]


def manifest(check: ContactCheck) -> dict[str, Any]:
    """Return what the manifest says of the result."""
    return check.as_json()


def figures(check: ContactCheck) -> dict[str, Callable[[], Picture]]:
    """Return the force on each ridge."""
    from skincad.outputs.figures.results import ridge_force_figure

    return {"ridge-forces.png": partial(ridge_force_figure, check)}


def files(check: ContactCheck) -> dict[str, Writer]:
    """Return the writer of the picture; the manifest, check.json, has all numbers."""
    return {name: picture(draw) for name, draw in figures(check).items()}


def stress_lines(stresses: FilmStresses) -> list[str]:
    """Return what `check --stress` prints beneath the verdict."""
    rows = []
    for state in stresses.states:
        pulled = f", pulled sideways by {state.tangential:g} N" if state.tangential else ""
        rows.append(f"  stress across the film at {state.force:g} N{pulled}")
        components = {"S1": state.s1, "S2": state.s2, "S1 - S2": state.differential}
        for name, values in components.items():
            error = max((v.error or 0.0) for v in values)
            numbers = "  ".join(f"{v.value:+.4f}" for v in values)
            rows.append(f"    {name:8} {numbers} (± {error:.1g}) MPa")
    return [*rows, *(f"  note           {note}" for note in stresses.warnings)]


def stress_figures(stresses: FilmStresses) -> dict[str, Callable[[], Picture]]:
    """Return the stress under the normal force, and under both forces (Fig 8)."""
    from skincad.outputs.figures.stress import film_stress_figure

    return {"film-stress.png": partial(film_stress_figure, *stresses.states)}


FILM_STRESS = Presentation(
    COMMAND="film-stress",
    lines=stress_lines,
    figures=stress_figures,
    files=lambda stresses: {name: picture(draw) for name, draw in stress_figures(stresses).items()},
)
