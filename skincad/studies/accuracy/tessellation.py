"""The ladder of print meshes.

Print meshes of the skin: chord tolerance against measured deviation, by manifold3d and the CAD kernel. Both
get the same tolerance, absolute. manifold3d starts from the plan, the CAD kernel from its exact solid, which
is at hand for STEP anyway. Deviations are measured both ways against a mesh ten times finer.
"""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import trimesh

from skincad.base.progress import Progress
from skincad.fabrication.measures import measure
from skincad.fabrication.meshes import FINER, mesh
from skincad.inputs.design import Design
from skincad.shape.skin import skin_of
from skincad.solids.occ import solid, tessellate, triangles
from skincad.solids.plan import Part
from skincad.solids.skin import skin_part
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, timed

# chords in heights of a ridge, and the s that they take on a skin of so many RIDGES; measured
CHORDS, RIDGES = {3e-2: 0.3, 3e-3: 0.3, 3e-4: 0.4, 3e-5: 1.0, 3e-6: 6.0}, 9
KERNEL, MANIFOLD = "CAD kernel", "manifold3d"


def ladder(design: Design, repeats: int, progress: Progress | None) -> Ladder:
    """Return the skin's print meshes by both makers."""
    part = skin_part(design)
    exact = solid(part)
    formula = abs(exact.Volume() / part.volume - 1)
    trials = []
    for chord in _chords(design):
        if progress:
            progress(_stage(chord))
        shape, runs = timed(partial(mesh, part, chord), repeats)
        trials.append(_trial(part, MANIFOLD, chord, shape, runs))
        _, runs = timed(partial(tessellate, exact, chord), repeats)
        trials.append(_trial(part, KERNEL, chord, _of_kernel(exact, chord), runs))
    finer = f"a mesh by manifold3d with chords {FINER:g} times finer"
    measures = (
        ErrorMeasure(
            "deviation",
            "largest distance to the true surface, both ways",
            "mm",
            finer,
            f"its own error, a {FINER:g}th of the chord, is added to every deviation: none is understated",
        ),
        ErrorMeasure(
            "volume",
            "error of the volume",
            "1",
            "section area x path of its centroid, by Green's theorem",
            f"the CAD kernel's exact solid has the same volume to {formula:.0e}",
        ),
    )
    return Ladder("tessellation", f"print mesh of the skin of {design.name}", tuple(trials), measures)


def prices(design: Design, repeats: int) -> dict[str, float]:  # noqa: ARG001
    """Return the stages and their expected seconds, mostly those of measuring the deviation."""
    of_size = skin_of(design).count / RIDGES
    return {_stage(c): of_size * s for c, s in zip(_chords(design), CHORDS.values(), strict=True)}


def _chords(design: Design) -> list[float]:
    return [share * min(skin_of(design).heights) for share in CHORDS]


def _stage(chord: float) -> str:
    return f"tessellation: chord {chord:.2g} mm"


def _trial(
    part: Part, model: str, chord: float, shape: trimesh.Trimesh, runs: tuple[float, ...]
) -> Measurement:
    errors = {
        "deviation": measure(part, shape, chord).deviation,
        "volume": abs(float(shape.volume) / part.volume - 1),
    }
    return Measurement(model, f"chord {chord:.2g} mm", len(shape.faces), runs, errors)


def _of_kernel(solid: Any, chord: float) -> trimesh.Trimesh:
    """The kernel's triangles as one mesh, its faces joined at equal corners."""
    corners, faces = triangles(solid, chord)
    shape = trimesh.Trimesh(np.array([c.toTuple() for c in corners]), np.array(faces), process=False)
    shape.merge_vertices()
    return shape
