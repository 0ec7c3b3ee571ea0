"""What a check says: the verdict in one sentence, and what stands behind it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.mechanics.verdict import ContactCheck

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "check"
UNCHECKED = "Not checked whether all ridges touch."  # what a job says that leaves the check out


def verdict(check: ContactCheck) -> str:
    """Return the contact verdict in one sentence, with its error."""
    needed, plate = check.all_touch_force, f"a {check.plate} plate at {check.force:g} N"
    every = "both ridges" if check.ridges == 2 else f"all {check.ridges} ridges"
    if check.beyond:
        return f"NO VERDICT: {check.beyond}."
    if check.ridges == 1:
        return f"Passes: the one ridge touches a {check.plate} plate at any force."
    if check.passed:
        return f"Passes: {every} touch {plate}; they already do at {needed}."
    if needed.value is not None and check.touching == check.ridges:
        return f"FAILS narrowly: {every} touch {plate}, but they need {needed}, which may be more."
    some = f"FAILS: {check.touching} of {check.ridges} ridges touch {plate}"
    return (
        f"{some}; the force that all need is beyond the model's range."
        if needed.value is None
        else f"{some}; all need {needed}."
    )


def allowed_drops(check: ContactCheck | None) -> tuple[float, ...]:
    """Return by how much each crest may lie lower alone, mm, until the verdict's margin is used up."""
    if check is None:
        return ()
    made, margin = check.manufacture, check.margin
    if made is None or margin is None or not check.passed:
        return ()
    return tuple(margin / slope if slope > 0 else math.inf for slope in made.crest_sensitivity)


def allowance(check: ContactCheck | None) -> tuple[tuple[float, ...], float]:
    """Return these drops, mm, and the margin that each uses up, N."""
    return allowed_drops(check), (check.margin or 0.0) if check else 0.0


def lines(check: ContactCheck) -> list[str]:
    """Return what `check` prints."""
    return [*verdict_lines(check), *advice_lines(check)]


def verdict_lines(check: ContactCheck) -> list[str]:
    """Return what is known before any advice is."""
    shares = "  ".join(f"{share.value:.3f}" for share in check.ridge_force)
    error = max((share.error or 0.0) for share in check.ridge_force)
    return [
        verdict(check),
        *_margin_lines(check),
        f"  approach       {check.approach}",
        f"  ridge forces   {shares} (± {error:.1g}) N",
        *_model_lines(check),
        *_manufacture_lines(check),
        *(f"  note           {warning}" for warning in check.warnings),
    ]


def _margin_lines(check: ContactCheck) -> list[str]:
    if check.margin is None or check.ridges == 1 or check.all_touch_force.error is None:
        return []
    mesh = check.all_touch_force.error - check.model_error
    parts = [f"{mesh:.2g} N from mesh and method"]
    value = check.all_touch_force.value or 0.0
    parts += [f"{part.threshold * value:.2g} N for leaving out {part.effect}" for part in check.left_out]
    upper = check.all_touch_force.upper or 0.0
    return [
        f"  margin         {check.margin:.2f} N: {check.force:g} N less the {upper:.2f} N needed at most",
        f"  error          {', '.join(parts)}",
    ]


def _model_lines(check: ContactCheck) -> list[str]:
    lines = [f"  model          {check.tier}, {check.unknowns} unknowns, {check.seconds['total']:.2f} s"]
    lines += [
        f"  tried first    {asked.tier}: {asked.all_touch_force}, {asked.seconds:.2f} s"
        for asked in check.climbed
    ]
    if check.next_tier:
        tier, seconds = check.next_tier
        lines.append(f"  finer          --tier {tier} would take about {seconds:.2g} s more")
    return lines


def passing_share(check: ContactCheck) -> str:
    """Return the share of parts that pass with its error, in percent; "" where it is not known."""
    passing = check.manufacture.passing if check.manufacture else None
    if passing is None or passing.value is None or passing.error is None:
        return ""
    return f"{passing.value:.1%} (± {passing.error:.1%})"


def _manufacture_lines(check: ContactCheck) -> list[str]:
    made, share = check.manufacture, passing_share(check)
    if made is None or not share:
        return []
    loss = f"most are lost by {made.largest}" if made.largest else "none of those sampled fails"
    crests = "  ".join(f"{slope / 100:+.2g}" for slope in made.crest_sensitivity)
    return [
        f"  yield          {share} of parts pass; {loss}",
        f"  crests         0.01 mm lower, each changes the force needed by {crests} N",
    ]


def advice_lines(check: ContactCheck) -> list[str]:
    """Return why the design fails and what would pass, as far as it is known: more only adds lines."""
    changes = [f"{change} alone" for change in check.changes or ()]
    if check.changes == ():
        changes = ["no single change that was tried"]
    causes = [f"  cause          {check.cause}"] if check.cause else []
    return causes + [f"  would pass     {change}" for change in changes]


def manifest(check: ContactCheck) -> dict[str, Any]:
    """Return what the manifest says of the result."""
    return check.as_json()


def figures(check: ContactCheck) -> dict[str, Callable[[], Picture]]:
    """Return the force on each ridge."""
    from skincad.pictures.check_figures import ridge_force_figure

    return {"ridge-forces.png": partial(ridge_force_figure, check)}


def files(check: ContactCheck) -> dict[str, Writer]:
    """Return the writer of the picture; the manifest, check.json, has all numbers."""
    from skincad.outputs.delivery import picture

    return {name: picture(draw) for name, draw in figures(check).items()}
