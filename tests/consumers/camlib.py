"""opencamlib drops a ball-end mill onto the cavity's STL: what it leaves, beside the section's own answer.

The ball comes down z on lines along x, so its centres are a rolled-off profile; it has passed everything
above them. What stays on a ridge's groove is the distance of its surface to those balls.
"""

from __future__ import annotations

from importlib.util import find_spec

import numpy as np
import trimesh
from numpy.typing import NDArray

from skincad.fabrication import laid_on_end, left_standing
from skincad.inputs import processes
from skincad.shape import Loop, Segment
from skincad.solids import Part, Prism
from skincad.solids.mold import mold
from tests.consumers import Job

STEP = 2e-3  # mm between drops
POINTS = 24  # of each segment


def missing() -> str:
    """Return why it can't run here, or ""."""
    return "" if find_spec("opencamlib") else "opencamlib is not installed: it has wheels up to Python 3.11"


def centres(shape: trimesh.Trimesh, radius: float, x: NDArray[np.float64], y: float) -> NDArray[np.float64]:
    """Return where a ball's centre comes to rest over each x, `(n, 2)` (x, z) mm."""
    import opencamlib as ocl

    surface = ocl.STLSurf()
    for corners in shape.triangles:
        surface.addTriangle(ocl.Triangle(*(ocl.Point(*(float(v) for v in c)) for c in corners)))
    cutter = ocl.BallCutter(2 * radius, 10 * (np.ptp(shape.bounds[:, 2]) + radius))
    drop = ocl.BatchDropCutter()  # holds surface and cutter by address only: both must outlive it
    drop.setSTL(surface)
    drop.setCutter(cutter)
    for at in x:
        drop.appendPoint(ocl.CLPoint(float(at), y, float(shape.bounds[0, 2] - 10 * radius)))
    drop.run()
    return np.array([[point.x, point.z + radius] for point in drop.getCLPoints()])  # of the ball's lowest


def left(outline: Loop, rest: NDArray[np.float64], radius: float) -> list[float]:
    """Return for each segment how far its points are, at most, from a ball of the drops or above them, mm."""
    return [_left(segment, rest, radius) for segment in outline]


def _left(segment: Segment, rest: NDArray[np.float64], radius: float) -> float:
    points = segment.points(np.linspace(0, 1, POINTS))
    low, high = points[:, 0].min() - 8 * radius, points[:, 0].max() + 8 * radius
    near = rest[(rest[:, 0] > low) & (rest[:, 0] < high)]
    distances = points[:, None, 0] - near[None, :, 0]
    below = np.maximum(near[None, :, 1] - points[:, None, 1], 0.0)  # the ball came down past what is higher
    return float(np.maximum(np.hypot(distances, below).min(axis=1) - radius, 0.0).max())


def in_grooves(job: Job, radius: float) -> dict[str, tuple[float, float]]:
    """Return by part what such a ball leaves at most in a groove, mm: by opencamlib, and by the section.

    A cavity that is parted has its grooves in several parts.
    """
    parts = [p for p in mold(job.design).parts if any(s.feature is not None for s in _outline(p))]
    return {part.name: _in_grooves(job, part, radius) for part in parts if part.name.startswith("cavity")}


def _in_grooves(job: Job, part: Part, radius: float) -> tuple[float, float]:
    outline, shape = _outline(part), trimesh.load_mesh(job.file(f"solids/{part.name}.stl"))
    assert not laid_on_end(job.plan, part)
    corners = np.array([s.start for s in outline])
    middle, lowest = (corners[:, 0].max() + corners[:, 0].min()) / 2, corners[:, 1].min()
    shape.apply_translation([middle, 0.0, lowest - shape.bounds[0, 2]])  # from the bed into the mold's frame
    grooves = [s for s in outline if s.feature is not None]
    wide = [s.start.x for s in grooves] + [s.end.x for s in grooves]
    over = np.arange(min(wide) - 4 * radius, max(wide) + 4 * radius, STEP)
    depths = left_standing(outline, radius, from_above=True)
    ours = max(depth for depth, s in zip(depths, outline, strict=True) if s.feature is not None)
    return max(left(grooves, centres(shape, radius, over, 0.0), radius)), ours


def _outline(part: Part) -> Loop:
    return part.body.outline if isinstance(part.body, Prism) and part.body.axis == "y" else ()


def complaints(job: Job) -> list[str]:
    """Return by how much the two answers differ, for the radius that a mill's profile has."""
    radius = processes(job.design.printer)["cnc"].reach
    deviations = {part.name: part.deviation for part in job.result.parts}
    grooves = in_grooves(job, radius)
    wrong = [] if grooves else ["no cavity with a groove"]
    for name, (theirs, ours) in grooves.items():
        # a ball rests up to one deviation off, and between two drops a wall moves by half a step
        if abs(theirs - ours) > 2 * deviations[name] + STEP:
            wrong.append(f"{name}: a ball leaves {theirs:.4f} mm by drop cutter, {ours:.4f} by section")
    return wrong
