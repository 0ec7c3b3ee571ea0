"""PrusaSlicer: what it says of meshes, how much material its layers hold and how high, and what prints take.

It exits with 0 on a broken mesh, so its words are read. Layers of a resin printer are pictures, whose grey is
counted. Its default gap closing fills slots under 0.1 mm; `sliced` closes none. What a process has no key for
is left at the program's default, except slowing down for cooling, skirts and the first layer's shrinking,
which are off. What skincad says of layers is not used.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import trimesh
from manifold3d import Manifold, Mesh
from PIL import Image

from skincad.base import Array, Mask
from skincad.fabrication import PartReport
from skincad.inputs import Process
from tests.consumers import Job, volume_slack

PROGRAM = "prusa-slicer"
PIXELS = 1250  # along the longer side of the part
LAYERS = 37  # so that no middle of a layer lies on a step of round numbers, where either side is right
MARGIN = 2.0  # mm of display round the part
SLICED = 3e-4  # relative: grey has 256 steps, corners are rounded to 1e-6 mm
DEFAULT_CLOSING = 0.049  # mm, the program's own slice_closing_radius
NOZZLE = 0.45  # mm, wide as a line is laid
REACH = 2.0  # mm to either side along y in which a line's cover is looked for: solid layers leave gaps
TOWER = 5.0  # s/mm: it adds that of each layer's height to what one tilts
UNITS = {"d": 86400.0, "h": 3600.0, "m": 60.0, "s": 1.0}
BED = 400.0  # mm, larger than any part here: whether parts fit is not asked

Settings = dict[str, object]
BARE: Settings = {
    "elefant-foot-compensation": 0,
    "supports-enable": 0,
    "pad-enable": 0,
    "support-object-elevation": 0,
}


class SlicerEstimate(NamedTuple):
    """What a slicer says: volume of material, mm3, and time, s."""

    volume: float
    seconds: float


def missing() -> str:
    """Return why it can't run here, or ""."""
    return "" if shutil.which(PROGRAM) else "prusa-slicer is not installed"


def run(*arguments: str) -> str:
    """Run the program and return what it prints; raises RuntimeError with its words where it fails."""
    process = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False, timeout=300)
    if process.returncode:
        raise RuntimeError(f"{PROGRAM} {' '.join(arguments)}: {process.stderr[-2000:]}")
    return process.stdout


def export(path: Path, out: Path, settings: Settings, *flags: str) -> Path:
    """Slice a file to one for a resin printer (.sl1) or a nozzle (.gcode), whose path is returned."""
    kind = {".sl1": "--export-sla", ".gcode": "--export-gcode"}[out.suffix]
    run(kind, str(path), "-o", str(out), *flags, *(f"--{key}={value}" for key, value in settings.items()))
    return out


def bed(wide: float, deep: float) -> Settings:
    """Return the setting of a rectangular bed, mm."""
    return {"bed-shape": f"0x0,{wide}x0,{wide}x{deep},0x{deep}"}


def display(size: Array, pixels: Array, high: float) -> Settings:
    """Return the settings of a screen of `size` (2,) mm and `pixels` (2,), and of its bed."""
    return {
        "display-width": size[0],
        "display-height": size[1],
        "display-pixels-x": pixels[0],
        "display-pixels-y": pixels[1],
        "display-orientation": "landscape",
        "max-print-height": high,
        **bed(*size),
    }


def pictures(archive: Path) -> Iterator[Array]:
    """Yield the grey of each layer of a resin print, 0 to 255, from the bed up."""
    with zipfile.ZipFile(archive) as layers:
        for name in sorted(n for n in layers.namelist() if n.endswith(".png") and "thumbnail" not in n):
            with layers.open(name) as picture:
                yield np.asarray(Image.open(picture).convert("L"))


def info(path: Path) -> list[dict[str, str]]:
    """Return what `--info` says of each object in an STL or 3MF."""
    text = run("--info", str(path))
    return [dict(re.findall(r"^(\w+) = +(.*?) *$", part, re.M)) for part in text.split(f"[{path.name}]")[1:]]


def sections(path: Path) -> float:
    """Return the volume of the same layers by manifold3d: the STL's sections at their middles, mm3."""
    shape = trimesh.load_mesh(path)
    low, high = shape.bounds[:, 2]
    solid = Manifold(Mesh(shape.vertices.astype(np.float32), shape.faces.astype(np.uint32)))
    middles = low + (high - low) * (np.arange(LAYERS) + 0.5) / LAYERS
    return float(sum(solid.slice(float(z)).area() for z in middles) * (high - low) / LAYERS)


def sliced(path: Path, closing: float = 0.0) -> float:
    """Return the volume of an STL's layers, mm3: filled pixels, parts of one by their grey."""
    low, high = trimesh.load_mesh(path).bounds
    wide, deep, high = high - low + [2 * MARGIN, 2 * MARGIN, 0.0]
    size = np.array([wide, deep])
    pixels = np.rint(PIXELS * size / size.max()).astype(int)
    settings = {
        **BARE,
        "layer-height": high / LAYERS,
        "initial-layer-height": high / LAYERS,
        "slice-closing-radius": closing,
        "faded-layers": 0,
        "gamma-correction": 1,
        **display(size, pixels, high + 1),
    }
    with tempfile.TemporaryDirectory() as folder:
        archive = export(path, Path(folder) / "layers.sl1", settings)
        filled = sum(grey.sum(dtype=float) / 255 for grey in pictures(archive))
    return float(filled * np.prod(size / pixels) * high / LAYERS)


def complaints(job: Job) -> list[str]:
    """Return what is not manifold, not one part or not of its volume, as read or as sliced."""
    wrong = [
        text for part in job.printed for text in _of_mesh(part, info(job.file(f"solids/{part.name}.stl")))
    ]
    molded = [part for part in job.printed if part.name != "skin"]
    objects = info(job.file("solids/mold.3mf"))
    if len(objects) != len(molded):
        wrong.append(f"mold.3mf: {len(objects)} objects")
    wrong += [f"mold.3mf, {t}" for p, said in zip(molded, objects, strict=False) for t in _of_mesh(p, [said])]
    for part in job.printed:
        path = job.file(f"solids/{part.name}.stl")
        volume, true = sliced(path), sections(path)
        if abs(volume - true) > SLICED * true:
            wrong.append(f"{part.name}: its layers hold {volume:.6g} mm3, its sections {true:.6g}")
    return wrong


def _of_mesh(part: PartReport, said: list[dict[str, str]]) -> list[str]:
    if len(said) != 1:
        return [f"{part.name}: {len(said)} objects"]
    mesh = said[0]
    wrong = [] if mesh["manifold"] == "yes" else [f"{part.name}: not manifold"]
    if mesh["number_of_parts"] != "1":
        wrong.append(f"{part.name}: {mesh['number_of_parts']} parts")
    single = 1e-6 * part.volume  # it computes in single precision
    if abs(float(mesh["volume"]) - part.volume) > volume_slack(part) + single:
        wrong.append(f"{part.name}: {mesh['volume']} mm3 of {part.volume:.6g}")
    return wrong


def sliced_plate(path: Path, process: Process, folder: Path) -> int:
    """Slice a plate where its parts lie, with a process's layer and bed, and return the file's bytes. Raises
    RuntimeError where the program does not."""
    settings: Settings = {"layer-height": process.layer, "max-print-height": process.build_z}
    settings |= bed(process.build_x, process.build_y)
    if process.exposure:
        size = np.array([process.build_x, process.build_y])
        settings |= {**display(size, np.rint(10 * size).astype(int), process.build_z), **BARE}
    else:
        settings |= {"nozzle-diameter": process.pixel, "skirts": 0}
    out = folder / f"{path.stem}{'.sl1' if process.exposure else '.gcode'}"
    return export(path, out, settings, "--dont-arrange").stat().st_size


def filament_estimate(path: Path, process: Process, folder: Path) -> SlicerEstimate:
    """Return what the G-code of an STL says; small things have the speed of large ones."""
    wide = [f"{of}extrusion-width" for of in ("", "first-layer-", "perimeter-", "external-perimeter-")]
    wide += [f"{of}infill-extrusion-width" for of in ("", "solid-")] + ["top-infill-extrusion-width"]
    fast = [f"{of}infill-speed" for of in ("", "solid-", "top-solid-")] + ["bridge-speed"]
    settings: Settings = {
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
        **bed(BED, BED),
    }
    code = export(path, folder / f"{path.stem}.gcode", settings)
    text = code.read_text()
    volume = re.search(r"^; filament used \[cm3\] = ([\d.]+)", text, re.M)
    time = re.search(r"^; estimated printing time \(normal mode\) = (.*)", text, re.M)
    if not volume or not time:
        raise ValueError(f"{code}: says neither material nor time")
    seconds = sum(float(n) * UNITS[unit] for n, unit in re.findall(r"(\d+)([dhms])", time[1]))
    return SlicerEstimate(1000 * float(volume[1]), seconds)


def resin_estimate(path: Path, process: Process, folder: Path) -> SlicerEstimate:
    """Return what the `config.ini` of its layers says; few pixels, which the time doesn't ask for."""
    tilt = process.lift - TOWER * process.layer
    settings: Settings = {
        **BARE,
        "layer-height": process.layer,
        "initial-layer-height": process.layer,
        "exposure-time": process.exposure,
        "initial-exposure-time": process.first_exposure,
        "faded-layers": process.fading,
        "fast-tilt-time": tilt,
        "slow-tilt-time": tilt,
        **display(np.array([BED, BED]), np.array([400, 400]), BED),
    }
    with zipfile.ZipFile(export(path, folder / f"{path.stem}.sl1", settings)) as archive:
        said = dict(re.findall(r"^(\w+) = (.*)$", archive.read("config.ini").decode(), re.M))
    return SlicerEstimate(1000 * float(said["usedMaterial"]), float(said["printTime"]))


def resin_levels(path: Path, places: Array, layer: float, pixel: float, folder: Path) -> Array:
    """Return the heights `(n,)` mm over the bed at `places` `(n,)` mm along x from the part's middle.

    A level face comes out at the top of the highest layer that has material there.
    """
    levels = np.zeros(len(places))
    for number, lit in enumerate(resin_layers(path, layer, pixel, folder), 1):
        if number == 1:  # the block's whole foot: its middle is the part's
            rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
            row, column = rows.mean(), columns.mean()
        at = np.rint(column + places / pixel).astype(int)
        beside = lit[round(row), at[:, None] + [-1, 0, 1]]  # no gauge sees a single pixel
        levels[beside.all(axis=1)] = number * layer
    return levels


def resin_layers(path: Path, layer: float, pixel: float, folder: Path) -> Iterator[Mask]:
    """Yield which pixels are lit, `(rows, columns)`, layer by layer from the bed up."""
    low, high = trimesh.load_mesh(path).bounds
    pixels = np.ceil((high[:2] - low[:2] + 2 * MARGIN) / pixel).astype(int)
    settings: Settings = {
        **BARE,
        "layer-height": layer,
        "initial-layer-height": layer,
        "faded-layers": 0,
        "display-mirror-x": 0,
        **display(pixels * pixel, pixels, high[2] + 1),
    }
    for grey in pictures(export(path, folder / "layers.sl1", settings)):
        yield grey > 127


def filament_levels(path: Path, places: Array, layer: float, folder: Path) -> Array:
    """The same of G-code for a 0.4 mm nozzle."""
    settings: Settings = {
        "layer-height": layer,
        "first-layer-height": layer,
        "nozzle-diameter": 0.4,
        "extrusion-width": NOZZLE,
        "first-layer-extrusion-width": NOZZLE,
        "skirts": 0,
        "fill-density": "15%",
        "elefant-foot-compensation": 0,
        **bed(300, 300),
    }
    lines = _extruded(export(path, folder / "part.gcode", settings).read_text())
    foot = lines[lines[:, 4] == lines[:, 4].min()]
    middle = (foot[:, :4].reshape(-1, 2).min(axis=0) + foot[:, :4].reshape(-1, 2).max(axis=0)) / 2
    levels = np.zeros(len(places))
    for i, place in enumerate(places):
        spots = middle + np.column_stack([np.full(9, place), np.linspace(-REACH, REACH, 9)])
        levels[i] = lines[_covering(lines, spots), 4].max()
    return levels


def _covering(lines: Array, spots: Array) -> Mask:
    """Which lines from (x, y) to (x, y) mm, `(n, 5)` with z, cover one of the spots `(m, 2)` mm."""
    along = (lines[:, 2:4] - lines[:, :2])[:, None]
    away = spots - lines[:, None, :2]
    share = (away * along).sum(axis=2) / np.maximum((along**2).sum(axis=2), 1e-12)
    off = away - np.clip(share, 0.0, 1.0)[..., None] * along
    return np.asarray((np.hypot(off[..., 0], off[..., 1]) < NOZZLE / 2).any(axis=1))


def _extruded(code: str) -> Array:
    """Lines that are laid: x, y of both ends and z, `(n, 5)` mm."""
    x = y = z = 0.0
    rows = []
    for line in code.splitlines():
        if not re.match(r"G[01] ", line):
            continue
        word = {key: float(value) for key, value in re.findall(r"([XYZE])(-?[\d.]+)", line.split(";")[0])}
        before, x, y, z = (x, y), word.get("X", x), word.get("Y", y), word.get("Z", z)
        if word.get("E", 0.0) > 0 and ("X" in word or "Y" in word):
            rows.append((*before, x, y, z))
    return np.array(rows)
