"""What a simulated scene leaves in its out folder: signals.csv, signals.png and the result as JSON."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from skincad.outfolder import SCENE_MANIFEST, replaced
from skincad.simulation import Simulation

TABLE, PICTURE = "signals.csv", "signals.png"


def write_scene(found: Simulation, folder: Path) -> list[str]:
    """Write a result into `folder`, whole or not at all; return the files' names."""
    from skincad.scene_figures import scene_picture

    with replaced(folder) as staging:
        write_table(found, staging / TABLE)
        scene_picture(found, staging / PICTURE)
        result = {"files": [TABLE, PICTURE], **found.as_json()}
        (staging / SCENE_MANIFEST).write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    return [TABLE, PICTURE, SCENE_MANIFEST]


def write_table(found: Simulation, path: Path) -> None:
    """Write the signals as CSV, a row a step, with units in the header; `raw` is before the low-pass."""
    ridges = list(found.signals)
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
        writer.writerow([*head, *names, "slipping ridges [1]"])
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
            slipping = " ".join(str(r + 1) for r in found.slipping[i].nonzero()[0])
            writer.writerow([i, *(f"{float(v):.9g}" for v in (*plate, *told)), slipping])
