"""ezdxf's own flattening of the section's arcs."""

from __future__ import annotations

from pathlib import Path

import shapely

from skincad.shape import section
from tests.conftest import Made
from tests.consumers import Job, dxf


def test_the_section_re_reads_with_its_area_and_slots(job: Job) -> None:
    assert dxf.complaints(job) == []


def test_arcs_that_became_chords_would_be_seen(made: Made, tmp_path: Path) -> None:
    job = Job(skin_of(made), made)
    (outline,) = dxf.polygons(made.folder / "drawings/section.dxf", "OUTLINE")
    corners = shapely.Polygon([s.start for s in section(job.design).outline])
    assert abs(outline.area - corners.area) > 1e3 * dxf.CHORD * outline.length


def skin_of(made: Made):
    import skincad

    return skincad.load(made.folder / "design.toml")
