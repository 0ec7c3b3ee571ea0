"""Output of a simulated scene: words, signals as CSV, and pictures."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from skincad.base.arrays import Array
from skincad.base.errors import RefusedError
from skincad.base.reading import Cell, csv_text
from skincad.base.result import Writer
from skincad.effects.kinds import SectionPad
from skincad.outputs.delivery import Presentation, picture
from skincad.scenes.errors import BySource
from skincad.scenes.march import GROSS_SLIP, frames
from skincad.scenes.plan import (
    DEFAULT_TOLERANCE,
    FINITE_STRAIN,
    FREE_ENDS,
    IN_CHOSEN_STEPS,
    SMALL_STRAIN,
    chosen_steps,
    model_of,
)
from skincad.scenes.runs import marches_masses
from skincad.scenes.scene import Scene
from skincad.scenes.simulation import Simulation
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture
    from skincad.outputs.figures.stress import Moment

COMMAND = "simulate"
TABLE, PICTURE, ANIMATION = "signals.csv", "signals.png", "section.gif"
MODELS = {
    SMALL_STRAIN: "Small strain",
    IN_CHOSEN_STEPS: "Finite strain in {} chosen steps, linear in between",
    FINITE_STRAIN: "Finite strain in each step",
}
WORTH_ADDING = 0.05  # relative change of signals from which an effect is worth adding
WORTH_KNOWING = 0.05  # ms, of a lead, from which on the plate's mass is asked for
ALONE = {"finite_strain", "free_ends", "inertia", "viscosity"}  # to one of them no other is proposed
ADDING = {  # how to add an effect, where one setting won't do
    "inertia": "add [effects.inertia] and plate.mass to the scene",
    "finite_strain": f"`skincad simulate {{scene}} --tol {DEFAULT_TOLERANCE:g}` includes finite strain",
}
HEARD = 6.0  # dB of signal over noise; assumption: a signal less than twice the noise is not told from it
MAX_RIDGE_LINES = 3  # ridges that have lines of their own
RECORDING = "recording.png"  # where an amplifier with a sampling rate is named
STRIPS, MANY_STRIPS = "strips.png", 4  # and of how many monitored ridges on it is drawn


def names(scene: Scene) -> list[str]:
    """Return the names of what will be written, if the scene runs to its end."""
    sections = [_section_name(step) for step in scene.readout.steps]
    strips = [STRIPS] * (len(scene.readout.ridges) >= MANY_STRIPS)
    return [TABLE, PICTURE, *strips, *sections, *[ANIMATION] * bool(scene.readout.frames)]


def lines(simulation: Simulation) -> list[str]:
    """Return when the skin slips, how sure that is, the warning, and what to know of it.

    Notes on effects that are left out stand in the details: the error counts them.
    """
    left_out = {effect.warning for effect in simulation.left_out}
    return [
        f"{simulation.scene.name}: {_answer(simulation)}.",
        f"  error          {_how_sure(simulation)}",
        f"  run            {_run(simulation)}",
        *_plate(simulation),
        *_warned(simulation),
        *_signal(simulation),
        *(f"  note           {warning}" for warning in simulation.warnings if warning not in left_out),
    ]


def _run(simulation: Simulation) -> str:
    """How many steps were run, and by which model."""
    march, history = simulation.march, simulation.scene.history
    end = _end(simulation) if march.stopped else f"{history.step_count} steps"
    if history.step_count > history.steps:
        end += f" ({history.steps} equal ones, and corners of the history between them)"
    chosen = chosen_steps(march)
    by = MODELS[model_of(simulation.scene)].format(0 if chosen is None else len(chosen) - 1)
    scene = simulation.scene
    masses = marches_masses(scene) or "inertia" in scene.effects
    of_plate = " and the plate's" * (scene.plate.mass is not None)
    more = ["free ends"] * (FREE_ENDS in scene.effects) + [f"the skin's{of_plate} mass"] * masses
    return f"{end}. {by}{', with ' * bool(more)}{' and '.join(more)}."


def _plate(simulation: Simulation) -> list[str]:
    """What a plate as heavy as the skin would change, where nobody gave the plate's mass."""
    heavy = simulation.heavy_plate
    if heavy is None:
        return []
    gross = heavy.gross_slip_step
    if gross is None and simulation.gross_slip_step is None:
        return []
    begin = f"no plate.mass is given, so it has none. Under {heavy.mass:.2g} g, as heavy as the skin,"
    whole = "never slips as a whole" if gross is None else f"slips as a whole from step {gross} on"
    moved = [(ridge, change) for ridge, change in heavy.lead_change.items() if change]
    leads = "".join(
        f"; ridge {ridge}'s lead is {abs(change):.2g} ms {'longer' if change > 0 else 'shorter'}"
        for ridge, change in moved[:1]
    )
    return [f"  plate          {begin} the skin {whole}{leads}."]


def _answer(simulation: Simulation) -> str:
    """When the skin slips, after why the run ended early where it did."""
    family = skin_of(simulation.scene.design).family
    march, gross = simulation.march, simulation.gross_slip_step
    steps = {ridge: step for ridge, step in enumerate(simulation.slip_steps, 1) if step is not None}
    begin = f"STOPPED {_end(simulation)}; " if march.stopped and march.stopped != GROSS_SLIP else ""
    if not steps:
        return f"{begin}no {family} slips for good"
    step = min(steps.values())
    first = [str(ridge) for ridge in steps if steps[ridge] == step]
    who = f"{family} {first[0]}" if len(first) == 1 else f"{family}s {', '.join(first[:-1])} and {first[-1]}"
    if gross is not None:
        early = f"; {who} for good from step {step} on" if step < gross else ""
        return f"{begin}the whole skin slips from step {gross} on{early}"
    if len(steps) == len(first):
        return f"{begin}{who} slip{'s' * (len(first) == 1)} from step {step} until the end"
    count = f"{len(steps)} of {len(simulation.slip_steps)} {family}s"
    return f"{begin}{count} slip until the end; {who} first, from step {step} on"


def _warned(simulation: Simulation) -> list[str]:
    """Whether a detector which listens to all monitored ridges warns before gross slip, in how many runs."""
    if simulation.gross_slip_step is None or not (leads := simulation.read.get("lead_time_s")):
        return []
    who = "all" if "all" in leads else next(iter(leads))
    if leads[who] is not None:
        return [_warning_line(simulation, who)]
    spread = _spreads(simulation).get(who)
    if spread is None:
        return ["  warned         no alarm comes before gross slip"]
    runs, warned = spread["seeds"], spread["warned"]
    others = f"; {_milliseconds(spread)} before it in the others" if warned else ""
    return [f"  warned         no warning in {runs - warned} of {runs} runs with other noise{others}"]


def _signal(simulation: Simulation) -> list[str]:
    """The least signal over the amplifier's noise, and whether it is too weak to hear slip."""
    ratios = {
        r: level for r, level in simulation.read.get("signal_to_noise_dB", {}).items() if level is not None
    }
    if not ratios:
        return []
    least = min(ratios, key=lambda ridge: ratios[ridge])
    weak = f": too weak, slip is heard from about {HEARD:g} dB on" if ratios[least] < HEARD else ""
    return [f"  signal         {ratios[least]:.0f} dB over the noise in {ridge_name(least)}{weak}"]


def _how_sure(simulation: Simulation) -> str:
    """The largest error of a slip's step, or of a stress where no ridge slips."""
    slips = [error for error in simulation.slip_step_errors if error is not None and error.total is not None]
    if slips:
        worst = max(slips, key=lambda error: error.total or 0.0)
        more = f"; {_count(worst.left_out)} by effects left out" if worst.left_out else ""
        return f"a slip may come up to {_count(worst.total or 0.0)} earlier or later{more}"
    known = {r: error for r, error in simulation.stress_errors.items() if error.total is not None}
    if not known:
        return "not known: only one mesh or step was run"
    worst_ridge = max(known, key=lambda r: known[r].total or 0.0)
    error = known[worst_ridge]
    more = f", {error.left_out:.2g} of it by effects left out" if error.left_out else ""
    return f"up to {error.total:.2g} MPa in ridge {worst_ridge}'s differential stress{more}"


def next_step(simulation: Simulation) -> str:
    """Return what to do next: add the effect whose absence costs most, else an amplifier."""
    march, scene = simulation.march, simulation.scene
    if march.interrupted:
        return ""
    if skin_of(scene.design).symmetry == "revolved":
        return f"{PICTURE} shows which pin slips when."
    if march.failed:
        steps = 2 * scene.history.steps
        return f"`skincad simulate {{scene}} --set history.steps={steps}`: smaller steps may help."
    missing = max(simulation.left_out, key=lambda effect: effect.change, default=None)
    if missing and missing.change >= WORTH_ADDING and not ALONE.intersection(scene.effects):
        name = missing.effect
        how = ADDING.get(name, f"`skincad simulate {{scene}} --set effects.{name}={{}}` adds {name}")
        return f"{how}; leaving it out may change signals by {missing.change:.0%}."
    return _addition(simulation)


def _addition(simulation: Simulation) -> str:
    """What to add where nothing that matters is left out: the plate's mass, or an amplifier."""
    scene, heavy = simulation.scene, simulation.heavy_plate
    if heavy and any(abs(change or 0.0) >= WORTH_KNOWING for change in heavy.lead_change.values()):
        given = f"`skincad simulate {{scene}} --set plate.mass={heavy.mass:.2g}`"
        return f"{given} counts the plate's mass, in g: give your own."
    if "piezo" not in scene.effects and scene.design.film:
        return "`skincad simulate {scene} --set effects.piezo.circuit=yamada-2002` adds the slip detector."
    return f"{PICTURE} shows the signals of each monitored ridge."


def details(simulation: Simulation) -> list[str]:
    """Return slips, errors, events and energy in full, and the notes on effects that are left out."""
    march, energy = simulation.march, simulation.energy
    left_out = {effect.warning for effect in simulation.left_out}
    return [
        f"  slip           {_slips(simulation)}",
        *_slip_error(simulation),
        *_detector_lines(simulation),
        f"  energy         {energy['work_mJ']:.3g} mJ of work, {energy['dissipated_mJ']:.3g} mJ lost to "
        f"friction, {energy['imbalance']:.1e} of the work unaccounted for",
        f"  model          {march.unknowns} unknowns, {simulation.seconds['total']:.2f} s",
        *(f"  note           {warning}" for warning in simulation.warnings if warning in left_out),
    ]


def _end(simulation: Simulation) -> str:
    march = simulation.march
    return f"after {len(march.readings) - 1} of {simulation.scene.history.step_count} steps: {march.stopped}"


def _slips(simulation: Simulation) -> str:
    """From which step each ridge slips until the end."""
    family = skin_of(simulation.scene.design).family
    steps = {ridge: step for ridge, step in enumerate(simulation.slip_steps, 1) if step is not None}
    starts = ", ".join(f"{ridge} from step {step}" for ridge, step in steps.items())
    end = ", each" * (len(steps) > 1) + " until the end"
    if simulation.gross_slip_step is not None:
        end += f"; all of them from step {simulation.gross_slip_step}"
    touching = set(simulation.march.ridge[simulation.march.readings[-1].touches].tolist())
    clear = [str(ridge) for ridge in range(1, len(simulation.slip_steps) + 1) if ridge not in touching]
    clearance = f"; clear of the plate at the end: {', '.join(clear)}" if clear else ""
    return f"{family} {starts}{end}{clearance}" if steps else f"no {family} slips for good{clearance}"


def _slip_error(simulation: Simulation) -> list[str]:
    """By how many steps a ridge's slip may be off at most; nothing where that is unknown."""
    errors = [error for error in simulation.slip_step_errors if error is not None and error.total is not None]
    if not errors:
        return []
    numbers = max((error.total or 0.0) - error.left_out for error in errors)
    sources = (
        "mesh, time step and chosen steps" if any(error.drift for error in errors) else "mesh and time step"
    )
    line = f"  its error      up to {_count(numbers)} from {sources}"
    left_out = max(error.left_out for error in errors)
    return [f"{line}, {_count(left_out)} from what is left out (notes)" if left_out else line]


def _count(steps: float) -> str:
    whole = math.ceil(round(steps, 6))
    return f"{whole} step" + "s" * (whole != 1)


def _detector_lines(simulation: Simulation) -> list[str]:
    """Lead times, the detector's events and warnings, and the signals' error."""
    rows = _lead_lines(simulation)
    for event in simulation.read.get("events", ()):
        who = f"{ridge_name(event['ridge'])}: " if event["ridge"] else ""
        why = f" (no true warning: {event['reason']})" if event["reason"] else ""
        rows.append(f"  felt           {who}{event['kind']} at step {event['step']}{why}")
    spreads = _spreads(simulation)
    rows += [
        _warning_line(simulation, ridge)
        for ridge, ahead in simulation.read.get("lead_time_s", {}).items()
        if ridge != "all" and (ahead is not None or spreads.get(ridge, {}).get("warned"))
    ]
    if (score := simulation.read.get("warning_score")) and (false := score["false"]):
        warnings = score["true"] + false
        rows.append(f"  false alarms   {false} of {warnings} warnings: no ridge slips on until gross slip")
    if point := simulation.read.get("detector"):
        share, false = point["share_of_gross_slips_warned_of"], point["false_alarms_per_minute_of_handling"]
        idle = point["of_these_while_nothing_slips"]
        rows.append(
            f"  detector       {point['alarms']}: warns of {100 * share:.0f} % of gross slips, {false:g} "
            f"false alarms a minute of handling, {idle:g} while nothing slips"
        )
    return rows


def _spreads(simulation: Simulation) -> dict[str, dict[str, Any]]:
    """By ridge, what the leads are with other noise."""
    return {spread["ridge"]: spread for spread in simulation.read.get("lead_time_by_noise", ())}


def _warning_line(simulation: Simulation, ridge: str) -> str:
    """By how much the detector warns by a ridge, and the spread where that depends on the noise."""
    ahead, spread = simulation.read["lead_time_s"][ridge], _spreads(simulation).get(ridge, {"warned": 0})
    who = ridge_name(ridge)
    words = f"not by {who}" if ahead is None else f"{1e3 * ahead:.3g} ms before gross slip by {who}"
    if spread["warned"]:
        ends = f"{span} " if " to " in (span := _milliseconds(spread)) else ""
        words += f" ({ends}with {spread['warned']} of {spread['seeds']} noise seeds)"
    return f"  warned         {words}"


def _milliseconds(spread: Mapping[str, float]) -> str:
    low, high = (f"{1e3 * spread[end]:.3g}" for end in ("smallest_s", "largest_s"))
    return f"{low} ms" if low == high else f"{low} to {high} ms"


def _lead_lines(simulation: Simulation) -> list[str]:
    """Leads and errors by ridge, each on its line; of more than MOST_LINES ridges in one."""
    leads = {ridge: lead for ridge, lead in simulation.lead.items() if lead.value is not None}
    errors = {r: error for r, error in simulation.stress_errors.items() if error.mesh is not None}

    def words(ridge: int) -> str:
        """How wrong a ridge's stress may be, and what that is made of."""
        parts = ", ".join(_parts(errors[ridge], ""))
        return f"{_known_sum(errors[ridge]):.2g} MPa in ridge {ridge}'s differential stress: {parts}"

    if max(len(leads), len(errors)) <= MAX_RIDGE_LINES:
        rows = []
        for r, ahead in leads.items():
            rows.append(f"  lead           ridge {r} slips {ahead} before all ridges do")
            error = simulation.slip_errors.leads[r - 1]
            if error.total is not None:
                rows.append(f"  its error      {', '.join(_parts(error, ' ms'))}")
        return rows + [f"  error          {words(r)}" for r in errors]
    by_ridge = ", ".join(f"{ridge} {ahead}" for ridge, ahead in leads.items())
    family = skin_of(simulation.scene.design).family
    rows = [f"  lead           from a {family}'s slip to that of all: {family} {by_ridge}"] * bool(leads)
    if errors:
        worst = max(errors, key=lambda r: _known_sum(errors[r]))
        rows.append(f"  error          the largest is {words(worst)}")
    return rows


def _known_sum(error: BySource) -> float:
    """The sum of what is known."""
    return math.fsum(share for share in error if share is not None)


def _parts(error: BySource, unit: str) -> list[str]:
    """An error's sources, the first with its unit; none for what is left out where that is 0."""
    of_step = "unknown" if error.time_step is None else f"{error.time_step:.1g}"
    parts = [f"{error.mesh:.1g}{unit} from the mesh", f"{of_step} from the time step"]
    if error.drift:
        parts.append(f"{error.drift:.2g} from what is linear between chosen steps")
    return [*parts, f"{error.left_out:.2g} from what is left out (notes)"] if error.left_out else parts


def ridge_name(ridge: int | str) -> str:
    """Return the name of a ridge that is read out, or what all of them are called."""
    return "all monitored ridges together" if ridge == "all" else f"ridge {ridge}"


def figures(simulation: Simulation) -> dict[str, Callable[[], Picture]]:
    """Return the signals, the recorder's view of them, and the wanted sections that the run reached."""
    from skincad.outputs.figures.scenes import recording, recording_figure, scene_figure, strips_figure
    from skincad.outputs.figures.stress import section_figure

    drawings: dict[str, Callable[[], Picture]] = {PICTURE: partial(scene_figure, simulation)}
    if len(simulation.raw) >= MANY_STRIPS:
        drawings[STRIPS] = partial(strips_figure, simulation)
    if record := recording(simulation):
        drawings[RECORDING] = partial(recording_figure, simulation, record)
    return drawings | {
        _section_name(s): partial(section_figure, _moment(simulation, s)) for s in _section_steps(simulation)
    }


def files(simulation: Simulation) -> dict[str, Writer]:
    """Return the writer of each file."""
    from skincad.outputs.figures.stress import section_animation, section_picture

    drawings = figures(simulation)
    writers = {TABLE: partial(write_table, simulation)} | {
        name: picture(draw) for name, draw in drawings.items()
    }
    for step in _section_steps(simulation):
        writers[_section_name(step)] = partial(section_picture, _moment(simulation, step))
    if moving := [step for step in frames(simulation.scene) if step in simulation.march.states]:
        writers[ANIMATION] = partial(section_animation, [_moment(simulation, step) for step in moving])
    return writers


def _section_steps(simulation: Simulation) -> list[int]:
    """The steps that are drawn."""
    return sorted({step for step in simulation.scene.readout.steps if step in simulation.march.states})


def _moment(simulation: Simulation, step: int) -> Moment:
    from skincad.outputs.figures.stress import Moment

    march = simulation.march
    assert isinstance(march.pad, SectionPad)  # the scene was checked for it
    reading = march.readings[step]
    forces = f"{reading.normal:.2f} N normal, {reading.tangential:.2f} N tangential"
    title = f"{simulation.scene.name}: step {step}, {1e3 * march.time[step]:.4g} ms, {forces}"
    return Moment(title, march.pad.shown(march.states[step]))


def _section_name(step: int) -> str:
    return f"section-{step:04d}.png"


def write_table(simulation: Simulation, path: Path) -> None:
    """Write the signals as CSV, a row a step, with units in the header; `raw` is before the low-pass.

    Readouts by ridge and step have their own columns. Raises RefusedError for a number that is not
    finite.
    """
    ridges, more = list(simulation.signals), readout_columns(simulation)
    signals: dict[str, Callable[[int], Array]] = {
        "raw differential stress [MPa]": lambda r: simulation.raw[r],
        "differential stress [MPa]": lambda r: simulation.signals[r].value,
        "stress-rate [MPa/s]": lambda r: simulation.signals[r].rate,
        "stress-jerk [MPa/s2]": lambda r: simulation.signals[r].jerk,
    }
    columns = {f"ridge {r} {name}": of(r) for r in ridges for name, of in signals.items()} | more
    head = [
        "step [1]",
        "time [s]",
        "normal force [N]",
        "tangential force [N]",
        "approach [mm]",
        "travel [mm]",
    ]
    rows: list[list[Cell]] = [[*head, *columns, "slipping ridges [1]"]]
    for i, (time, reading) in enumerate(zip(simulation.march.time, simulation.march.readings, strict=True)):
        plate = (time, reading.normal, reading.tangential, reading.approach, reading.travel)
        cells = [column[i] for column in columns.values()]
        slipping = " ".join(str(r + 1) for r in simulation.slipping[i].nonzero()[0])
        if not all(map(math.isfinite, (*plate, *cells))):
            raise RefusedError(f"step {i} has numbers that are not finite: nothing is written")
        rows.append([i, *(f"{float(v):.9g}" for v in (*plate, *cells)), slipping])
    path.write_text(csv_text(rows), encoding="utf-8", newline="")


def readout_columns(simulation: Simulation) -> dict[str, list[float]]:
    """Return the readouts `<name>_<unit>` by ridge and signal: a number a step, by column header."""
    columns = {}
    for key, ridges in simulation.read.items():
        name, _, unit = key.rpartition("_")
        for ridge, signals in ridges.items() if isinstance(ridges, dict) else ():
            for signal, values in signals.items() if isinstance(signals, dict) else ():
                columns[f"ridge {ridge} {signal} {name} [{unit}]"] = values
    return columns


SIMULATION = Presentation(
    COMMAND=COMMAND,
    lines=lines,
    next_step=next_step,
    details=details,
    files=files,
    figures=figures,
)
