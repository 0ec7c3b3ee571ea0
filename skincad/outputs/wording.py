"""Results in words: the verdict in one sentence, and what the commands print for a person."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from skincad.base.estimate import Estimate
    from skincad.base.tables import Ranged
    from skincad.circuit.bode import CircuitGain
    from skincad.material.modulus import MaterialFit
    from skincad.mechanics.film.answer import FilmStress
    from skincad.mechanics.verdict import ContactCheck
    from skincad.outputs.making import MakeResult
    from skincad.scenes.simulation import Simulation


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
        *_margin_lines(check),
        f"  approach       {check.approach}",
        f"  ridge forces   {shares} (+- {error:.1g}) N",
        *_model_lines(check),
        *_manufacture_lines(check),
        *(f"  note           {warning}" for warning in check.warnings),
    ]


def _margin_lines(check: ContactCheck) -> list[str]:
    if check.margin is None or check.ridges == 1 or check.all_touch_force.error is None:
        return []
    mesh = check.all_touch_force.error - check.model_error
    parts = [f"{mesh:.2g} N of mesh and method"]
    value = check.all_touch_force.value or 0.0
    parts += [f"{effect.threshold * value:.2g} N of {effect.effect} left out" for effect in check.left_out]
    return [
        f"  margin         {check.margin:.2f} N from the pessimistic end to {check.force:g} N",
        f"  error          {', '.join(parts)}",
    ]


def _model_lines(check: ContactCheck) -> list[str]:
    lines = [f"  model          {check.tier}, {check.unknowns} unknowns, {check.seconds['total']:.2f} s"]
    lines += [f"  before it      {tier}: {force}, {spent:.2f} s" for tier, force, spent in check.climbed]
    if check.next_tier:
        tier, seconds = check.next_tier
        lines.append(f"  next           --tier {tier}, about {seconds:.2g} s more")
    return lines


def _manufacture_lines(check: ContactCheck) -> list[str]:
    made = check.manufacture
    if made is None or made.passing.value is None or made.passing.error is None:
        return []
    loss = f"largest loss: {made.largest}" if made.largest else "all that were sampled"
    crests = "  ".join(f"{slope:+.0f}" for slope in made.crest_sensitivity)
    return [
        f"  yield          {made.passing.value:.1%} (+- {made.passing.error:.1%}) of parts pass; {loss}",
        f"  per crest      {crests} N per mm that it is lower",
    ]


def stress_lines(states: list[FilmStress], file: str) -> list[str]:
    """Return what `check --stress` prints beneath the verdict."""

    def row(name: str, values: tuple[Estimate, ...]) -> str:
        error = max((v.error or 0.0) for v in values)
        numbers = "  ".join(f"{v.value:+.4f}" for v in values)
        return f"    {name:8} {numbers} (+- {error:.1g}) MPa"

    lines = []
    for state in states:
        lines.append(f"  stress across the film at {state.force:g} N, pulled by {state.tangential:g} N")
        lines += [row("S1", state.s1), row("S2", state.s2), row("S1 - S2", state.differential)]
    notes = dict.fromkeys(note for state in states for note in state.warnings)
    return [*lines, *(f"  note           {note}" for note in notes), f"  picture        {file}"]


def scene_lines(found: Simulation) -> list[str]:
    """Return what `simulate` prints."""
    march, history = found.march, found.scene.history
    last, asked = len(march.readings) - 1, history.steps
    end = f"stopped at step {last} of {asked}: {march.stopped}" if march.stopped else f"{asked} steps"
    first = [f"{r}: {step}" for r, step in enumerate(found.slip_steps, 1) if step is not None]
    lines = [f"{found.scene.name}: {end}."]
    lines += [f"  slips for good ridge and its step: {'  '.join(first) or 'none'}"]
    leads = {ridge: lead for ridge, lead in found.lead.items() if lead is not None}
    lines += [f"  lead           ridge {r} slips {lead:.3g} ms before all do" for r, lead in leads.items()]
    lines += [
        f"  error          {error:.1g} MPa of ridge {ridge}'s differential stress, of mesh"
        for ridge, error in (found.error or {}).items()
    ]
    lines += [
        f"  felt           {ridge_name(event['ridge'] or 'all')}: {event['kind']} at step {event['step']}"
        for event in found.read.get("events", ())
    ]
    for ridge, ahead in found.read.get("lead_time_s", {}).items():
        if ahead is not None:
            lines.append(f"  warned         {1e3 * ahead:.3g} ms before gross slip by {ridge_name(ridge)}")
    energy = found.energy
    return [
        *lines,
        f"  energy         {energy['work_mJ']:.3g} mJ of work, {energy['dissipated_mJ']:.3g} mJ of friction, "
        f"{energy['imbalance']:.1e} missing",
        f"  model          {march.unknowns} unknowns, {found.seconds['total']:.2f} s",
        *(f"  note           {warning}" for warning in found.warnings),
    ]


def ridge_name(ridge: int | str) -> str:
    """Return a told ridge's name, or what all of them are called."""
    return "all told ridges" if ridge == "all" else f"ridge {ridge}"


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


def material_lines(fit: MaterialFit) -> list[str]:
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
        "[material]",
        f"young_modulus = {ranged_toml(fit.ranged)}",
    ]


def ranged_toml(ranged: Ranged) -> str:
    """Return a number with its range as a TOML value."""
    return f"{{ value = {ranged.value}, low = {ranged.low}, high = {ranged.high} }}"


def circuit_lines(found: CircuitGain, files: list[str]) -> list[str]:
    """Return what `circuit` prints."""
    slopes, sweep = found.slopes, found.circuit.sweep
    fitted = f"from {sweep.low:g} to {sweep.fit_high:g} Hz"
    if slopes.cutoff.value is None:
        lines = [f"{found.name}: {slopes.below} {fitted}, without a cut-off."]
    else:
        lines = [
            f"{found.name}: {slopes.below} up to a cut-off of {slopes.cutoff}, "
            f"{slopes.above} above, {fitted}."
        ]
    lines.append(f"  fit            two lines are {slopes.rms:.2g} dB rms from the curve")
    if found.measured:
        fit, given = found.measured.calibration, found.measured.slopes
        held = ", ".join(fit.at_bounds) or "none"
        fixed = len(fit.combinations) - len(fit.open_combinations)
        lines += [
            f"  measured       {given.below}, cut-off {given.cutoff}, {given.above}",
            f"  calibrated     {fit.rms:.2g} dB rms, {fit.agreeing} of {fit.starts} starts agree",
            f"  fixed          {fixed} of {len(fit.combinations)} combinations; at bounds: {held}",
        ]
    lines += [f"  note           {warning}" for warning in found.warnings]
    return [*lines, *(f"  written        {file}" for file in files)]
