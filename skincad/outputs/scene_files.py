"""What a simulated scene leaves in its out folder: signals.csv, signals.png and the result as JSON."""

from __future__ import annotations

import csv
import math
from pathlib import Path

from skincad.base.errors import RefusedError
from skincad.base.manifest import manifest_name
from skincad.base.outfolder import checked_folder, replaced
from skincad.effects.kinds import Showing
from skincad.scenes.moments import frames
from skincad.scenes.scene import Scene
from skincad.scenes.simulation import Simulation

TABLE, PICTURE, ANIMATION = "signals.csv", "signals.png", "section.gif"
RECORDING = "recording.png"  # where an amplifier with a sampling rate is named


def write_scene(found: Simulation, folder: Path) -> list[str]:
    """Write a result into `folder`, whole or not at all; return the files' names.

    Raises RefusedError, with nothing touched, for one with numbers that are not finite.
    """
    from skincad.pictures.recording_figures import recording, recording_picture
    from skincad.pictures.scene_figures import scene_picture

    with replaced(folder, "simulate", found.as_json()) as staging:
        write_table(found, staging / TABLE)
        scene_picture(found, staging / PICTURE)
        _sections(found, staging)
        if seen := recording(found):
            recording_picture(found, seen, staging / RECORDING)
        return [*sorted(path.name for path in staging.iterdir()), manifest_name("simulate")]


def checked_scene_folder(scene: Scene, folder: Path) -> None:
    """Raise InputError, before the march, for an out folder that cannot take what will be written."""
    drawn = [_section_name(step) for step in scene.readout.steps]
    checked_folder(folder, "simulate", [TABLE, PICTURE, *drawn, *[ANIMATION] * bool(scene.readout.frames)])


def _section_name(step: int) -> str:
    return f"section-{step:04d}.png"


def _sections(found: Simulation, folder: Path) -> None:
    """Draw the section at the steps asked for and reached, and animate it."""
    march, scene = found.march, found.scene
    if not scene.readout.steps and not scene.readout.frames:
        return
    from skincad.pictures.section_figures import Moment, section_animation, section_picture

    def moment(step: int) -> Moment:
        assert isinstance(march.model, Showing)  # the scene was checked for it
        reading = march.readings[step]
        forces = f"{reading.normal:.2f} N normal, {reading.tangential:.2f} N tangential"
        title = f"{scene.name}: step {step}, {1e3 * march.time[step]:.4g} ms, {forces}"
        return Moment(title, march.model.shown(march.states[step]))

    for step in sorted({step for step in scene.readout.steps if step in march.states}):
        section_picture(moment(step), folder / _section_name(step))
    reached = [step for step in frames(scene) if step in march.states]
    if reached:
        section_animation([moment(step) for step in reached], folder / ANIMATION)


def write_table(found: Simulation, path: Path) -> None:
    """Write the signals as CSV, a row a step, with units in the header; `raw` is before the low-pass.

    What the readouts tell by ridge and step has its own columns. Raises RefusedError for a number that is not
    finite.
    """
    ridges, more = list(found.signals), read_columns(found)
    names = [
        name
        for r in ridges
        for name in (
            f"ridge {r} raw differential stress [MPa]",
            f"ridge {r} differential stress [MPa]",
            f"ridge {r} stress-rate [MPa/s]",
            f"ridge {r} stress-jerk [MPa/s2]",
        )
    ]
    head = [
        "step [1]",
        "time [s]",
        "normal force [N]",
        "tangential force [N]",
        "approach [mm]",
        "travel [mm]",
    ]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*head, *names, *more, "slipping ridges [1]"])
        for i, (time, reading) in enumerate(zip(found.march.time, found.march.readings, strict=True)):
            plate = (time, reading.normal, reading.tangential, reading.approach, reading.travel)
            told = [
                value
                for r in ridges
                for value in (
                    found.raw[r][i],
                    found.signals[r].value[i],
                    found.signals[r].rate[i],
                    found.signals[r].jerk[i],
                )
            ]
            told += [column[i] for column in more.values()]
            slipping = " ".join(str(r + 1) for r in found.slipping[i].nonzero()[0])
            if not all(map(math.isfinite, (*plate, *told))):
                raise RefusedError(f"step {i} has numbers that are not finite: nothing is written")
            writer.writerow([i, *(f"{float(v):.9g}" for v in (*plate, *told)), slipping])


def read_columns(found: Simulation) -> dict[str, list[float]]:
    """Return what readouts tell as `<name>_<unit>` of ridge, of signal, a number a step, by its header."""
    columns = {}
    for key, ridges in found.read.items():
        name, _, unit = key.rpartition("_")
        for ridge, signals in ridges.items() if isinstance(ridges, dict) else ():
            for signal, values in signals.items() if isinstance(signals, dict) else ():
                columns[f"ridge {ridge} {signal} {name} [{unit}]"] = values
    return columns
