"""PrusaSlicer: what its `--info` says of a mesh, and how much material its layers hold.

It exits with 0 on a broken mesh, so its words are read. Layers are those of a resin printer: pictures, whose
grey is counted. Its default gap closing fills slots under 0.1 mm; here it closes none.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import trimesh
from manifold3d import Manifold, Mesh
from PIL import Image

from skincad.fabrication import PartReport
from skincad.inputs import Process
from tests.consumers import Job, volume_slack

PROGRAM = "prusa-slicer"
PIXELS = 1250  # along the longer side of the part
LAYERS = 37  # so that no middle of a layer lies on a step of round numbers, where either side is right
MARGIN = 2.0  # mm of display round the part
SLICED = 3e-4  # relative: grey has 256 steps, corners are rounded to 1e-6 mm
DEFAULT_CLOSING = 0.049  # mm, the program's own slice_closing_radius


def missing() -> str:
    """Return why it can't run here, or ""."""
    return "" if shutil.which(PROGRAM) else "prusa-slicer is not installed"


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
    """Return the volume of an STL's layers, mm3."""
    low, high = trimesh.load_mesh(path).bounds
    wide, deep, high = high - low + [2 * MARGIN, 2 * MARGIN, 0.0]
    size = round(PIXELS * wide / max(wide, deep)), round(PIXELS * deep / max(wide, deep))
    settings = {
        "layer-height": high / LAYERS,
        "initial-layer-height": high / LAYERS,
        "slice-closing-radius": closing,
        "elefant-foot-compensation": 0,
        "supports-enable": 0,
        "pad-enable": 0,
        "support-object-elevation": 0,
        "faded-layers": 0,
        "gamma-correction": 1,
        "display-width": wide,
        "display-height": deep,
        "display-pixels-x": size[0],
        "display-pixels-y": size[1],
        "display-orientation": "landscape",
        "max-print-height": high + 1,
        "bed-shape": f"0x0,{wide}x0,{wide}x{deep},0x{deep}",
    }
    options = [f"--{key}={value}" for key, value in settings.items()]
    with tempfile.TemporaryDirectory() as folder:
        layers = Path(folder) / "layers.sl1"
        run("--export-sla", str(path), "-o", str(layers), *options)
        filled = _grey(layers)
    return filled * (wide / size[0]) * (deep / size[1]) * high / LAYERS


def _grey(archive: Path) -> float:
    """Filled pixels of all layers, parts of one by their grey."""
    total = 0.0
    with zipfile.ZipFile(archive) as layers:
        for name in layers.namelist():
            if name.endswith(".png") and not name.startswith("thumbnail"):
                with layers.open(name) as picture:
                    total += np.asarray(Image.open(picture).convert("L")).sum(dtype=float) / 255
    return total


def run(*arguments: str) -> str:
    """Run the program and return what it prints; raises RuntimeError with its words where it fails."""
    process = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False, timeout=300)
    if process.returncode:
        raise RuntimeError(f"{PROGRAM} {' '.join(arguments)}: {process.stderr[-2000:]}")
    return process.stdout


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
    wide, long = process.build_x, process.build_y
    bed = f"0x0,{wide}x0,{wide}x{long},0x{long}"
    settings: dict[str, object] = {"layer-height": process.layer, "bed-shape": bed}
    if process.exposure:
        out = folder / f"{path.stem}.sl1"
        settings |= {"display-width": wide, "display-height": long, "max-print-height": process.build_z}
        settings |= {"display-pixels-x": round(10 * wide), "display-pixels-y": round(10 * long)}
        settings |= {"supports-enable": 0, "pad-enable": 0}
        way = "--export-sla"
    else:
        out, way = folder / f"{path.stem}.gcode", "--export-gcode"
        settings |= {"nozzle-diameter": process.pixel, "skirts": 0, "max-print-height": process.build_z}
    run(way, str(path), "-o", str(out), "--dont-arrange", *(f"--{k}={v}" for k, v in settings.items()))
    return out.stat().st_size
