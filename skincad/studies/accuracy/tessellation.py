"""The ladder of print meshes.

Print meshes of the skin: chord tolerance, in heights of a ridge, against measured deviation. Deviations are
measured both ways against a mesh ten times finer. The CAD kernel's meshes: `python -m bench.holds`.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from skincad.fabrication.measures import measure
from skincad.fabrication.meshes import FINER, mesh
from skincad.inputs.design import Design
from skincad.shape.skin import skin_of
from skincad.solids.occ import solid
from skincad.solids.skin import skin_part
from skincad.studies.accuracy.ladder import ErrorMeasure, Ladder, Measurement, timed

CHORDS = (3e-2, 3e-3, 3e-4, 3e-5, 3e-6)  # heights of a ridge


def ladder(design: Design, repeats: int, tell: Callable[[str], None]) -> Ladder:
    """Return the skin's print meshes."""
    part, trials = skin_part(design), []
    for share in CHORDS:
        chord = share * min(skin_of(design).heights)
        tell(setting := f"chord {chord:.2g} mm")
        shape, runs = timed(partial(mesh, part, chord), repeats)
        errors = {
            "deviation": measure(part, shape, chord).deviation,
            "volume": abs(float(shape.volume) / part.volume - 1),
        }
        trials.append(Measurement("manifold3d", setting, len(shape.faces), runs, errors))
    finer = f"a mesh by manifold3d with chords {FINER:g} times finer"
    added = f"its own error, a {FINER:g}th of the chord, is added to every deviation: none is understated"
    exact = "section area x path of its centroid, by Green's theorem"
    formula = abs(solid(part).Volume() / part.volume - 1)
    same = f"the CAD kernel's exact solid has the same volume to {formula:.0e}"
    measures = (
        ErrorMeasure("deviation", "largest distance to the true surface, both ways", "mm", finer, added),
        ErrorMeasure("volume", "error of the volume", "1", exact, same),
    )
    return Ladder("tessellation", f"print mesh of the skin of {design.name}", tuple(trials), measures)
