"""A cast part's measured crests: what of the table changes nothing, and what only mirrors the verdict."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from skincad import load
from skincad.inputs import Design
from skincad.mechanics import ContactCheck
from skincad.mechanics.check import check
from skincad.shape import skin_of

# gone
from tests.mechanics.designs import THREE

ERRORS = (0.006, 0.0, -0.008)  # mm, of the crests: no two alike, none symmetric
FORCE = 1.0  # N, at which the three touch
SAME = 1e-7  # relative; a shift of 0.1 mm leaves 1e-13 of a gap, the root of F9 is found to 1e-12
MODELS = ["linear", *(pytest.param(t, marks=pytest.mark.slow) for t in ("corrected", "finite-strain"))]


@pytest.fixture(scope="module")
def design() -> Design:
    return load("plain-ridges").with_(**THREE)


def judged(
    design: Design, folder: Path, model: str, errors: Sequence[float], order: Sequence[int] = (1, 2, 3)
) -> ContactCheck:
    """The verdict on a part whose crests are off by `errors` mm, its rows in this order of ridges."""
    crests = [
        skin_of(design).placed[r - 1].frame.at(0.0, design.ridge.height).z + errors[r - 1]
        for r in range(1, 4)
    ]
    rows = [f"{r},{crests[r - 1]!r}" for r in order]
    (folder / "crests.csv").write_text("ridge,crest_mm\n" + "\n".join(rows))
    return check(design, model=model, force=FORCE, measured=folder / "crests.csv")


def numbers(verdict: ContactCheck) -> np.ndarray:
    """F9, approach and the ridges' forces, each with its error."""
    estimates = [verdict.all_touch_force, verdict.approach, *verdict.ridge_force]
    return np.array([[estimate.value, estimate.error] for estimate in estimates], dtype=float)


@pytest.mark.parametrize("model", MODELS)
def test_the_datum_and_the_order_of_rows_change_nothing_and_a_mirror_mirrors(
    model: str, design: Design, tmp_path: Path
) -> None:
    part = judged(design, tmp_path, model, ERRORS)
    assert part.touching == 3
    for shift in (0.15, 0.02, -0.15):  # above the highest crest as designed, and below the lowest
        moved = judged(design, tmp_path, model, [e + shift for e in ERRORS])
        assert numbers(moved) == pytest.approx(numbers(part), rel=SAME)
        assert (moved.passed, moved.touching) == (part.passed, part.touching)
        side = "higher" if shift > 0 else "lower"
        assert any(f"mm {side} than designed" in w for w in moved.warnings) == (abs(shift) > 0.1)
    assert numbers(judged(design, tmp_path, model, ERRORS, (2, 1, 3))).tolist() == numbers(part).tolist()
    mirrored = numbers(judged(design, tmp_path, model, ERRORS[::-1]))
    mirrored[2:] = mirrored[:1:-1]
    # the mesh is no mirror image of itself: as far apart as the errors allow, and no further
    assert (np.abs(mirrored - numbers(part))[:, 0] <= numbers(part)[:, 1]).all()
