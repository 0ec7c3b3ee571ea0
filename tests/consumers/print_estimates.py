"""What PrusaSlicer says of a print's material and time, with a profile of a process's own values.

What a process has no key for is left at the program's default, except slowing down for cooling, skirts and
the first layer's shrinking, which are off, and speeds of small things, which are those of large ones.
"""

from __future__ import annotations

import re
import zipfile
from pathlib import Path
from typing import NamedTuple

from skincad.inputs import Process
from tests.consumers.prusaslicer import run

TOWER = 5.0  # s/mm: it adds that of each layer's height to what one tilts
UNITS = {"d": 86400.0, "h": 3600.0, "m": 60.0, "s": 1.0}
BED = 400.0  # mm, larger than any part here: whether parts fit is not asked


class SlicerEstimate(NamedTuple):
    """What a slicer says: volume of material, mm3, and time, s."""

    volume: float
    seconds: float


def of_filament(path: Path, process: Process, folder: Path) -> SlicerEstimate:
    """Return what its G-code of an STL says."""
    code = folder / f"{path.stem}.gcode"
    wide = [f"{of}extrusion-width" for of in ("", "first-layer-", "perimeter-", "external-perimeter-")]
    wide += [f"{of}infill-extrusion-width" for of in ("", "solid-")] + ["top-infill-extrusion-width"]
    fast = [f"{of}infill-speed" for of in ("", "solid-", "top-solid-")] + ["bridge-speed"]
    settings: dict[str, object] = {
        "gcode-flavor": "marlin",
        "layer-height": process.layer,
        "first-layer-height": process.layer,
        "nozzle-diameter": process.pixel,
        **dict.fromkeys(wide, process.line),
        "perimeters": process.loops,
        "top-solid-layers": process.shells,
        "bottom-solid-layers": process.shells,
        "fill-density": f"{100 * process.infill:g}%",
        "fill-pattern": "rectilinear",
        "external-perimeter-speed": process.outer_speed,
        "small-perimeter-speed": process.outer_speed,
        "perimeter-speed": process.loop_speed,
        "gap-fill-speed": process.loop_speed,
        **dict.fromkeys(fast, process.fill_speed),
        "first-layer-speed": process.first_speed,
        "travel-speed": process.travel_speed,
        "default-acceleration": process.acceleration,
        "skirts": 0,
        "slowdown-below-layer-time": 0,
        "elefant-foot-compensation": 0,
        "bed-shape": _square(BED),
    }
    run("--export-gcode", str(path), "-o", str(code), *(f"--{k}={v}" for k, v in settings.items()))
    text = code.read_text()
    volume = re.search(r"^; filament used \[cm3\] = ([\d.]+)", text, re.M)
    time = re.search(r"^; estimated printing time \(normal mode\) = (.*)", text, re.M)
    if not volume or not time:
        raise ValueError(f"{code}: says neither material nor time")
    seconds = sum(float(n) * UNITS[unit] for n, unit in re.findall(r"(\d+)([dhms])", time[1]))
    return SlicerEstimate(1000 * float(volume[1]), seconds)


def of_resin(path: Path, process: Process, folder: Path) -> SlicerEstimate:
    """Return what the `config.ini` of its layers says; few pixels, which the time doesn't ask for."""
    layers, tilt = folder / f"{path.stem}.sl1", process.lift - TOWER * process.layer
    settings: dict[str, object] = {
        "layer-height": process.layer,
        "initial-layer-height": process.layer,
        "exposure-time": process.exposure,
        "initial-exposure-time": process.first_exposure,
        "faded-layers": process.fading,
        "fast-tilt-time": tilt,
        "slow-tilt-time": tilt,
        "elefant-foot-compensation": 0,
        "supports-enable": 0,
        "pad-enable": 0,
        "support-object-elevation": 0,
        "display-width": BED,
        "display-height": BED,
        "display-pixels-x": 400,
        "display-pixels-y": 400,
        "max-print-height": BED,
        "bed-shape": _square(BED),
    }
    run("--export-sla", str(path), "-o", str(layers), *(f"--{k}={v}" for k, v in settings.items()))
    with zipfile.ZipFile(layers) as archive:
        archive_settings = dict(re.findall(r"^(\w+) = (.*)$", archive.read("config.ini").decode(), re.M))
    return SlicerEstimate(
        1000 * float(archive_settings["usedMaterial"]), float(archive_settings["printTime"])
    )


def _square(side: float) -> str:
    return f"0x0,{side}x0,{side}x{side},0x{side}"
