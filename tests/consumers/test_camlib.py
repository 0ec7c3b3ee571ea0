"""opencamlib's drop cutter against the section's opening by a disk: two ways to what a mill leaves."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh

from skincad.shape import Point, loop
from tests.consumers import Job, camlib

pytestmark = pytest.mark.skipif(bool(camlib.missing()), reason=camlib.missing())


def test_a_ball_reaches_what_the_section_says_in_every_templates_cavity(job: Job) -> None:
    assert camlib.complaints(job) == []


@pytest.mark.slow
@pytest.mark.parametrize("radius", [0.05, 0.1, 0.5])
def test_other_balls_too(job: Job, radius: float) -> None:
    if job.design.name != "yamada-2002":
        pytest.skip("one template shows it")
    theirs, ours = camlib.in_grooves(job, radius)["cavity"]
    assert theirs == pytest.approx(ours, abs=camlib.STEP + 2e-3)  # drops, and twice an EDM cavity's mesh


def test_a_square_groove_by_hand() -> None:
    """A right angle keeps (sqrt 2 - 1) r on its bisector."""
    wide, deep, radius = 2.0, 1.0, 0.25
    points = [(-5, 0), (-5, -5), (5, -5), (5, 0), (wide / 2, 0), (wide / 2, -deep)]
    points += [(-wide / 2, -deep), (-wide / 2, 0)]
    outline = loop([Point(float(x), float(z)) for x, z in points])
    floor = trimesh.creation.box(bounds=[[-5, -1, -5], [5, 1, -deep]])
    walls = [
        trimesh.creation.box(bounds=[[x, -1, -deep], [x + 5 - wide / 2, 1, 0]]) for x in (-5.0, wide / 2)
    ]
    block = trimesh.util.concatenate([floor, *walls])
    rest = camlib.centres(block, radius, np.arange(-2, 2 + camlib.STEP, camlib.STEP), 0.0)
    left = max(camlib.left(outline[4:7], rest, radius))
    assert left == pytest.approx((math.sqrt(2) - 1) * radius, abs=camlib.STEP)
