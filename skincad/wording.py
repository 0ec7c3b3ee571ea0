"""Results in words: the verdict in one sentence, and what the commands print for a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skincad.job import MakeResult
    from skincad.mechanics.check import ContactCheck


def verdict(check: ContactCheck) -> str:
    """Return the contact verdict in one sentence, with its error."""
    all_touch = check.all_touch_force
    if check.beyond:
        return f"NO VERDICT: {check.beyond}."
    if check.ridges == 1:
        return f"Passes: the one ridge touches a {check.plate} plate from the first contact on."
    count = f"all {check.ridges} ridges touch"
    if all_touch.value is None:
        return (
            f"FAILS: {check.touching} of {check.ridges} ridges touch at {check.force:g} N; never all of them."
        )
    if check.passed:
        return f"Passes: {count} a {check.plate} plate at {check.force:g} N; they do from {all_touch} on."
    if check.touching == check.ridges:
        return f"FAILS narrowly: {count} at {check.force:g} N, but only from {all_touch} on, error included."
    return (
        f"FAILS: {check.touching} of {check.ridges} ridges touch a {check.plate} plate at {check.force:g} N; "
        f"all do from {all_touch} on."
    )


def check_lines(check: ContactCheck) -> list[str]:
    """Return what `check` prints."""
    shares = "  ".join(f"{share.value:.3f}" for share in check.ridge_force)
    error = max((share.error or 0.0) for share in check.ridge_force)
    return [
        verdict(check),
        f"  approach       {check.approach}",
        f"  ridge forces   {shares} (+- {error:.1g}) N",
        f"  model          {check.tier}, {check.unknowns} unknowns, {check.seconds['total']:.2f} s",
        *_manufacture_lines(check),
        *(f"  note           {warning}" for warning in check.warnings),
    ]


def _manufacture_lines(check: ContactCheck) -> list[str]:
    made = check.manufacture
    if made is None or made.passing.value is None or made.passing.error is None:
        return []
    crests = "  ".join(f"{slope:+.0f}" for slope in made.crest_sensitivity)
    return [
        f"  yield          {made.passing.value:.1%} (+- {made.passing.error:.1%}) of parts pass; "
        f"largest loss: {made.largest}",
        f"  per crest      {crests} N per mm that it is lower",
    ]


def make_lines(result: MakeResult) -> list[str]:
    """Return what `make` prints."""
    rows = [
        f"  {p.name:14} {p.volume:10.2f} mm3  {p.faces:4d} faces  mesh within {1000 * p.deviation:.2f} um"
        for p in result.parts
    ]
    return [
        *check_lines(result.check),
        "Parts:",
        *rows,
        *(str(finding) for finding in result.findings),
        f"{len(result.files)} files in {result.folder}, {result.seconds['total']:.1f} s",
        f"{result.name}: {'passed' if result.passed else 'FAILED'}",
    ]
