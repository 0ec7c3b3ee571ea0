"""Output of a check and of the films' stress: the verdict in one sentence, and the numbers behind it."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from html import escape
from typing import TYPE_CHECKING

from skincad.base.estimate import Estimate
from skincad.base.progress import about
from skincad.base.result import Writer
from skincad.mechanics.left_out import FRICTION
from skincad.mechanics.verdict import NO_MODEL, ContactCheck
from skincad.outputs.delivery import Presentation, picture
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.fabrication.making import Build
    from skincad.mechanics.film.stress import FilmStresses
    from skincad.outputs.figures.canvas import Picture


COMMAND = "check"
NARROW_SHARE = 0.1  # of all parts: a yield's interval as narrow is shown to a tenth of a percent
WIDEST_SHARE = 0.8  # a yield's interval that is wider says nothing
MOST_SHOWN = 30  # forces in a line; of more features their range
MOST_BARS = 60  # of a bar chart in a terminal; more features share bars
BLOCKS = "▁▂▃▄▅▆▇█"  # a ridge's force, in full eighths of the largest
CLEAR = "·"  # a ridge without load
BARS_SIZE = (460, 110)  # pixels of a notebook's bars
GREEN, AMBER, RED, BLUE, INK = "#009e73", "#e69f00", "#c24e00", "#0072b2", "#222222"


def verdict(check: ContactCheck) -> str:
    """Return the contact verdict in one sentence, with its error."""
    needed, plate = _shown(check.all_touch_force), f"a {check.plate} plate at {check.force:g} N"
    of = check.family
    every = f"both {of}s" if check.ridges == 2 else f"all {check.ridges} {of}s"
    if check.out_of_range:
        return f"UNDECIDED: {check.out_of_range}."
    if check.ridges == 1:
        one = "face" if of == "flat" else f"one {of}"
        return f"Passes: the {one} touches a {check.plate} plate at any force."
    if check.passed:
        return f"Passes: {every} touch {plate}; they already do at {needed}."
    some = f"{check.touching} of {check.ridges} {of}s touch {plate}"
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
    """Return the verdict, its margin and error, the forces as bars, and what to know of them."""
    forces = "" if check.contact_width else f"  {f'{check.family} forces':15}{force_bars(check)}"
    return [*answer_lines(check), *([forces] if forces else []), *notes(check)]


def answer_lines(check: ContactCheck) -> list[str]:
    """Return the verdict, and its margin and error where it has any."""
    width = check.contact_width
    lines = [] if width is None else [f"  approach       {check.approach}, the contact {width} wide"]
    return [verdict(check), *lines, *_margin_lines(check)]


def notes(check: ContactCheck) -> list[str]:
    """Return what to know of the verdict; none is hidden, as each may change its meaning."""
    return [f"  note           {warning}" for warning in check.warnings]


def whether(build: Build | None) -> str:
    """Return what a check tells of a design, as words."""
    skin = skin_of(build.design) if build else None
    if skin and skin.symmetry == "none":
        return "how the face touches"
    return f"whether all {skin.family if skin else 'ridge'}s touch"


def force_bars(check: ContactCheck) -> str:
    """Return each ridge's force as a block, in parts of the largest, then the smallest and the largest."""
    values = [share.value or 0.0 for share in check.ridge_force]
    shared = math.ceil(len(values) / MOST_BARS)
    groups = [values[i : i + shared] for i in range(0, len(values), shared)]
    bars = "".join(_block(group, max(values)) for group in groups)
    each = f", {shared} {check.family}s a bar" if shared > 1 else ""
    return f"{bars}  {_ends(check)}{each}"


def _ends(check: ContactCheck) -> str:
    """The smallest and the largest force with their errors."""
    forces = sorted(check.ridge_force, key=lambda share: share.value or 0.0)
    return str(forces[0]) if len(forces) == 1 else f"{forces[0]} to {forces[-1]}"


def _block(group: list[float], largest: float) -> str:
    """Return the block of the mean of a group's forces, CLEAR where one of them is 0."""
    if min(group) <= 0.0:
        return CLEAR
    share = math.fsum(group) / len(group) / largest
    return BLOCKS[max(0, int(len(BLOCKS) * share + 1e-9) - 1)]


def next_step(check: ContactCheck) -> str:
    """Return what to do next: make what passes, ask the model that decides, or change what fails."""
    if check.passed:
        return "`skincad make {design}` makes its mold."
    if check.next_step and not awaits_advice(check):
        step = check.next_step.replace("`--model", "`skincad check {design} --model")
        return step.replace("contact.friction:", "contact.friction (as `--set contact.friction=0.5`):")
    if check.changes:
        change = check.changes[0]
        surely = f"may pass, by the {change.model} model" if change.model else "passes"
        value = change.after if isinstance(change.after, str) else f"{change.after:g}"
        return f"`skincad check {{design}} --set {change.key}={value}` {surely}."
    if check.next_step:
        return check.next_step
    if check.changes is None or check.search_cut_short:
        return "`skincad check {design} --advice` looks for a change with which it passes."
    upper = check.all_touch_force.upper
    return "change two keys: no single change passes" + (f"; or press with {upper:.3g} N." if upper else ".")


def awaits_advice(check: ContactCheck) -> bool:
    """Return whether only a change of the design, not a better model, can make a check pass."""
    return check.verdict == "fails" or check.next_step.startswith(NO_MODEL)


def details(check: ContactCheck) -> list[str]:
    """Return all numbers behind the verdict, and the advice as far as it is known."""
    return [*number_lines(check), *advice_lines(check)]


def number_lines(check: ContactCheck) -> list[str]:
    """Return the numbers that need no advice."""
    error = max((share.error or 0.0) for share in check.ridge_force)
    values = [share.value or 0.0 for share in check.ridge_force]
    return [
        f"  {f'each {check.family}':15}{_shares(values)} (± {error:.1g}) N",
        f"  approach       {_shown(check.approach)}",
        *_model_lines(check),
        *_manufacture_lines(check),
        *_self_contact_lines(check),
    ]


def _shares(forces: list[float]) -> str:
    """All forces, N, or of more than MOST_SHOWN the range."""
    if len(forces) > MOST_SHOWN:
        return f"{min(forces):.3f} to {max(forces):.3f}"
    return "  ".join(f"{force:.3f}" for force in forces)


def _margin_lines(check: ContactCheck) -> list[str]:
    if check.margin is None or check.ridges == 1 or check.all_touch_force.error is None:
        return []
    upper = check.all_touch_force.upper or 0.0
    applied = f"{check.force:g} N applied, up to {upper:.2f} N needed"
    return [
        f"  margin         {check.margin:.2f} N in the worst case ({applied})",
        f"  error          {', '.join(_error_parts(check))}",
    ]


def _error_parts(check: ContactCheck) -> list[str]:
    """Return the parts of the all-touch force's error, N, the largest first."""
    value, error = check.all_touch_force.value or 0.0, check.all_touch_force.error or 0.0
    parts = {f"from mesh and method of the {check.model} model": error - check.model_error}
    open_friction = check.friction is None and check.model != "winkler"
    for part in check.left_out:
        why = "not knowing" if part.effect == FRICTION and open_friction else "leaving out"
        parts[f"for {why} {part.effect}"] = part.threshold * value
    largest_first = sorted(parts.items(), key=lambda entry: -entry[1])
    return [f"{float(f'{part:.2g}'):g} N {why}" for why, part in largest_first]


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


def figures(check: ContactCheck) -> dict[str, Callable[[], Picture]]:
    """Return the force on each ridge."""
    from skincad.outputs.figures.results import ridge_force_figure

    return {"ridge-forces.png": partial(ridge_force_figure, check)}


def files(check: ContactCheck) -> dict[str, Writer]:
    """Return the writer of the picture; the manifest, check.json, has all numbers."""
    return {name: picture(draw) for name, draw in figures(check).items()}


def html(check: ContactCheck) -> str:
    """Return the verdict, the force on each ridge as a bar with its error, and the other lines."""
    colour = {"passes": GREEN, "fails": RED}.get(check.verdict, AMBER)
    words = "\n".join([*answer_lines(check)[1:], *notes(check), *check.next_line()])
    return (
        f"<p style='border-left:4px solid {colour};padding-left:8px'><b>{escape(verdict(check))}</b></p>"
        f"{_bars_svg(check)}<pre style='white-space:pre-wrap'>{escape(words)}</pre>"
    )


def _bars_svg(check: ContactCheck) -> str:
    """Return a bar for each ridge up to its force, and a line over its error, as SVG."""
    wide, high = BARS_SIZE
    top = max((share.upper or share.value or 0.0) for share in check.ridge_force) or 1.0
    step = wide / check.ridges
    shapes = []
    for ridge, share in enumerate(check.ridge_force):
        value, error = share.value or 0.0, share.error or 0.0
        left, up = ridge * step, high * (1 - value / top)
        low, far = (high * (1 - max(end, 0.0) / top) for end in (value - error, value + error))
        shapes.append(
            f"<g><title>{check.family} {ridge + 1}: {escape(str(share))}</title>"
            f"<rect x='{left + 0.1 * step:.2f}' y='{up:.2f}' width='{0.8 * step:.2f}' "
            f"height='{high - up:.2f}' fill='{BLUE}'/>"
            f"<path d='M{left + step / 2:.2f} {low:.2f}V{far:.2f}' stroke='{INK}'/></g>"
        )
    axis = f"<path d='M0 {high}H{wide}' stroke='{INK}'/>"
    label = f"force on {check.family}s 1 to {check.ridges}: {_ends(check)}"
    return (
        f"<svg xmlns='http://www.w3.org/2000/svg' width='{wide}' viewBox='0 -2 {wide} {high + 20}' "
        f"role='img'>{''.join(shapes)}{axis}"
        f"<text x='0' y='{high + 14}' font-size='11' font-family='sans-serif'>{label}</text></svg>"
    )


CHECK = Presentation(
    COMMAND=COMMAND,
    lines=lines,
    next_step=next_step,
    details=details,
    html=html,
    files=files,
    figures=figures,
)


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
