"""gmsh re-reads STEP: number and volume of solids, and the assembly's names and colours."""

from __future__ import annotations

import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path

from skincad.solids.mold import mold
from tests.consumers import Job

VOLUME = 1e-9  # relative, of the kernel that wrote it against the one that reads it
# mm3: what the kernel's quadrature of a thin strip is off, whose faces are 1000 times as long as thick
STRIP = 1e-8
COLOUR = 1e-3
TAIL = 5.0  # mm, of a shim beyond a comb: the lap by which it draws its film in
_HEAD = 'SetFactory("OpenCASCADE");\nGeometry.OCCTargetUnit = "MM";\n'
_SCRIPT = """Printf("FILE");
solids() = ShapeFromFile("{path}");
For i In {{0 : #solids() - 1}}
  mass() = Mass Volume{{solids(i)}};
  Printf("VOLUME %.17g", mass(0));
  box() = BoundingBox Volume{{solids(i)}};
  Printf("LENGTH %.17g %.17g", box(1), box(4));
EndFor
"""


@dataclass(frozen=True)
class Read:
    """What gmsh says of a STEP file: volumes in mm3, least and largest y in mm, names and linear colours by
    solid."""

    volumes: tuple[float, ...]
    along: tuple[tuple[float, float], ...]
    names: tuple[str, ...]
    colours: tuple[tuple[float, ...], ...]


def missing() -> str:
    """Return why it can't run here, or ""."""
    return "" if shutil.which("gmsh") else "gmsh is not installed"


@lru_cache(maxsize=8)
def read(path: Path) -> Read:
    """Return what gmsh reads from a STEP file."""
    (text,) = _said([path])
    return Read(
        tuple(float(volume) for volume in re.findall(r"VOLUME (\S+)", text)),
        tuple((float(low), float(high)) for low, high in re.findall(r"LENGTH (\S+) (\S+)", text)),
        tuple(name.rpartition("/")[2] for name in re.findall(r"Label '(.*?)' \(3D\)", text)),
        tuple(tuple(map(float, colour.split(","))) for colour in re.findall(r"Color \((.*?)\) \(3D", text)),
    )


def _said(paths: list[Path]) -> list[str]:
    """What gmsh, run once, says of each file."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "read.geo"
        script.write_text(_HEAD + "".join(_SCRIPT.format(path=path.resolve()) for path in paths))
        process = subprocess.run(
            ["gmsh", str(script), "-"], capture_output=True, text=True, check=False, timeout=300
        )
    if process.returncode or "Error" in process.stdout + process.stderr:
        raise RuntimeError(f"gmsh on {paths}: {(process.stdout + process.stderr)[-2000:]}")
    return process.stdout.split("FILE")[1:]


def complaints(job: Job) -> list[str]:
    """Return every STEP file without one solid of its volume and name, and what the assembly lost."""
    wrong = []
    paths = [job.file(f"solids/{part.name}.step") for part in job.result.parts]
    for part, path, text in zip(job.result.parts, paths, _said(paths), strict=True):
        volumes = [float(volume) for volume in re.findall(r"VOLUME (\S+)", text)]
        if f"PRODUCT('{part.name}'" not in path.read_text():
            wrong.append(f"{part.name}.step: of another name")
        if len(volumes) != 1 or abs(volumes[0] - part.volume) > VOLUME * part.volume:
            wrong.append(f"{part.name}.step: {volumes} mm3, made were {part.volume:.12g}")
    return wrong + _of_assembly(job)


def _of_assembly(job: Job) -> list[str]:
    parts, named = mold(job.design).parts, read(job.file("solids/assembly.step"))
    if named.names != tuple(part.name for part in parts) or len(named.volumes) != len(parts):
        return [f"assembly.step: {len(named.volumes)} solids named {', '.join(named.names)}"]
    wrong = []
    for part, volume, colour in zip(parts, named.volumes, named.colours, strict=True):
        if abs(volume - part.volume) > VOLUME * part.volume + STRIP:
            wrong.append(f"assembly.step: {part.name} of {volume:.12g} mm3, planned {part.volume:.12g}")
        if any(abs(a - _linear(b)) > COLOUR for a, b in zip(colour, part.colour, strict=True)):
            wrong.append(f"assembly.step: {part.name} is coloured {colour}")
    return wrong + short_tails(named)


def short_tails(shapes: Read) -> list[str]:
    """Return every straight shim of an assembly that does not stand out of both ends' combs by `TAIL`."""
    rows = list(zip(shapes.names, shapes.along, strict=True))
    if not all(any(name == f"end-{end}-comb" for name, _ in rows) for end in "ab"):
        return []
    low = min(along[0] for name, along in rows if name == "end-a-comb")
    high = max(along[1] for name, along in rows if name == "end-b-comb")
    return [
        f"assembly.step: {name} stands out by {low - a:.3f} and {b - high:.3f} mm"
        for name, (a, b) in rows
        if name.startswith("shim") and min(low - a, b - high) < TAIL
    ]


def _linear(value: float) -> float:
    """A file's sRGB value as the linear one that gmsh prints (IEC 61966-2-1)."""
    return value / 12.92 if value <= 0.04045 else ((value + 0.055) / 1.055) ** 2.4
