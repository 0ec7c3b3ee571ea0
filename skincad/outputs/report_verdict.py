"""The report's parts that rest on the verdict: what it rests on, the models tried, yield, sensitivities."""

from __future__ import annotations

import math

from skincad.fabrication.making import Job
from skincad.mechanics.check import spread_of
from skincad.mechanics.manufacture import sensitivities
from skincad.mechanics.models import winkler
from skincad.mechanics.models.table import TIERS, prerequisites
from skincad.mechanics.plate_friction import PlateFriction
from skincad.mechanics.problem import Request
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs.checks import passing_share
from skincad.pictures.canvas import svg
from skincad.pictures.check_figures import ridge_force_figure
from skincad.pictures.markup import command_line, figure, heading, paragraph, table
from skincad.pictures.page import data_url
from skincad.pictures.report_figures import models_figure, sensitivity_figure

SVG = "image/svg+xml"
IN_A_ROW = 11  # crests, across a page
SPRINGS = ("ridges' common base", "slots and films", "free ends", "finite strain", "friction")


def verdict_section(check: ContactCheck, command: str) -> str:
    """Return what the verdict rests on."""
    rows = [("all ridges touch from", str(check.all_touch_force)), ("asked force", f"{check.force:g} N")]
    if check.margin is not None:
        rows.append(("margin to the worst case", f"{check.margin:.2f} N"))
    rows += [("approach", str(check.approach)), ("plate", check.plate)]
    if check.friction is not None:
        rows.append(("friction of the plate", f"{check.friction:g}"))
    rows.append(("model", f"{check.tier}, {check.unknowns} unknowns"))
    rows += [("note", warning) for warning in check.warnings]
    verdict_table = table(("verdict", "value"), rows)
    return (
        heading("What the verdict rests on", "verdict")
        + verdict_table
        + _budget(check)
        + command_line(command)
    )


def _budget(check: ContactCheck) -> str:
    """The error's parts, N."""
    force = check.all_touch_force
    if not force.value or not force.error:
        return ""
    parts = [("mesh and method", force.error - check.model_error)]
    parts += [(f"leaving out {part.effect}", part.threshold * force.value) for part in check.left_out]
    rows = [(name, f"{error:.2g}", f"{error / force.error:.0%}") for name, error in parts]
    total = ("together", f"{force.error:.2g}", "100%")
    return paragraph("What its error is made of:") + table(("from", "N", "part"), [*rows, total])


def forces_figure(check: ContactCheck, command: str) -> str:
    """Return the force on each ridge."""
    address = data_url(svg(ridge_force_figure(check)), SVG)
    return figure(
        address, f"Force on each ridge at {check.force:g} N, by the {check.tier} model.", command, "half"
    )


def models_section(job: Job, check: ContactCheck, command: str) -> str:
    """Return the models tried on the way, and their error against time."""
    design, known = job.design, {run.tier: run.unknowns for run in check.models_tried}
    known[check.tier] = check.unknowns
    springs, plate = winkler.answer(design, Request(check.force)), PlateFriction(design, check.force, ())
    models = [(run.tier, run.all_touch_force, run.unknowns) for run in check.models_tried]
    models.append((check.tier, check.all_touch_force, check.unknowns))
    if "winkler" not in {name for name, *_ in models}:
        models.insert(0, ("winkler", springs.all_touch_force, springs.unknowns))

    def seconds(name: str) -> float:
        names = (*prerequisites(name), name)
        return math.fsum(TIERS[n].law.at(known.get(n) or TIERS[n].size(design)) for n in names)

    rows, points = [], []
    for name, force, unknowns in models:
        left = SPRINGS if name == "winkler" else (*TIERS[name].leaves_out, *plate.left_out(name))
        rows.append((name, ", ".join(left) or "none of these", unknowns, f"{seconds(name):.2g}", str(force)))
        if force.value and force.error:
            points.append((name, seconds(name), force.error / force.value))
    head = ("model", "leaves out", "unknowns", "predicted time, s", "all ridges touch from")
    law = (
        "Times are predicted for one core, not measured in this run, so that the same design gives the same "
        "report; winkler is the closed form below. The error includes what a model leaves out."
    )
    drawn = ""
    if len(points) > 1:
        address = data_url(svg(models_figure(points)), SVG)
        drawn = figure(
            address,
            "Error of the models asked against their predicted time; diamond: the one that gave the verdict.",
            command,
        )
    return heading("Models asked", "models") + table(head, rows) + paragraph(law, "small") + drawn


def yield_section(job: Job, check: ContactCheck, command: str) -> str:
    """Return the share of parts that pass and what it is made of, and how each crest counts."""
    part_yield, spread = check.manufacture, spread_of(job.design)
    head = heading("Yield", "yield")
    if part_yield is None or part_yield.passing.value is None:
        why = "There is none: it needs a verdict by a meshed model on more than one ridge."
        return head + paragraph(why) + command_line(command)
    low, now, high = spread.modulus
    rows = [
        ("parts that pass", passing_share(check)),
        ("crests, one against another", f"normal, sigma {spread.crest_sigma:g} mm by {spread.process}"),
        ("modulus of a batch", f"uniform from {low:g} to {high:g} MPa; nominal {now:g} MPa"),
        ("most are lost by", part_yield.largest or "nothing: none of those sampled fails"),
        ("change of the force with the modulus", f"{part_yield.modulus_sensitivity:.3g} N per MPa"),
    ]
    crests = "".join(
        table(
            ("ridge", *(str(first + i) for i in range(1, len(slopes) + 1))),
            [("N for 0.01 mm lower", *(f"{slope / 100:+.2g}" for slope in slopes))],
            "small",
        )
        for first in range(0, len(part_yield.crest_sensitivity), IN_A_ROW)
        if (slopes := part_yield.crest_sensitivity[first : first + IN_A_ROW])
    )
    explanation = paragraph("How much the all-touch force changes when one crest comes out 0.01 mm lower:")
    return head + table(("yield", "value"), rows) + explanation + crests + command_line(command)


def sensitivity_section(job: Job, check: ContactCheck | None, source: str) -> str:
    """Return which dimension or modulus moves the force by how much."""
    closed_form = winkler.all_touch_force(job.design)
    force = check.all_touch_force.value if check else None
    changes = sensitivities(job.design, force or closed_form)
    head = heading("What moves the force", "sensitivities")
    if not changes:
        return head + paragraph("Nothing does: all ridges touch from the first contact on.")
    rows = [(change.key, change.now, change.unit, str(change.change)) for change in changes]
    by = "the verdict's force" if force else "the closed form's force, as there is no verdict"
    words = (
        f"Exponents of the closed form times {by}, {force or closed_form:.3g} N. Their errors come "
        "from plane finite elements on 19 designs; on 10 others 70 of 78 changes lay within them. Where the "
        "error exceeds the change, its sign is uncertain."
    )
    first = changes[0]
    sweep_command = (
        f"skincad sweep {source} --vary {first.key}={0.97 * first.now:.4g}:{1.03 * first.now:.4g}:3"
    )
    sweep_command += " --tier linear"
    address = data_url(svg(sensitivity_figure(changes)), SVG)
    caption = (
        "Change of the all-touch force for 1 % more of each key, by the closed form. To confirm the first:"
    )
    return (
        head
        + table(("key", "now", "unit", "for 1 % more of it"), rows)
        + paragraph(words, "small")
        + figure(address, caption, sweep_command)
    )
