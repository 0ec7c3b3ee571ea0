"""Solids of ridges of unlike height: straight and curved along y, the skin and its mold."""

from __future__ import annotations

import pytest

import skincad
from skincad.solids import PartRole, skin_solid
from skincad.solids.mold import mold
from tests.bent_skin import bent

UNLIKE = "ridge.heights=[0.45, 0.5, 0.56]"


@pytest.mark.parametrize("radius", [None, 25.0])
def test_the_solid_is_the_sections_area_along_its_path(radius: float | None) -> None:
    """`skin_solid` holds the CAD kernel's volume against area x path; a higher ridge adds to both."""
    settings = ["ridge.count=3", UNLIKE, "skin.width=5.0"]
    design = bent("yamada-2002", radius, *settings) if radius else skincad.load("yamada-2002", settings)
    lower = design.with_(ridge={"heights": [0.45, 0.5, 0.5]})
    more = skin_solid(design).val().Volume() - skin_solid(lower).val().Volume()
    # 0.06 mm of a ridge 0.5 mm wide at its tip, wider below, 12 mm long; bent it is longer by a tenth
    assert 0.06 * 0.5 * 12.0 < more < 1.2 * 0.06 * 0.65 * 12.0


@pytest.mark.parametrize("radius", [None, 25.0])
def test_the_mold_is_as_deep_as_its_highest_ridge(radius: float | None) -> None:
    settings = ["ridge.count=3", UNLIKE, "skin.width=5.0"]
    design = bent("yamada-2002", radius, *settings) if radius else skincad.load("yamada-2002", settings)
    closed = mold(design)
    outline = closed.first(PartRole.SKIN).body.outline
    assert -min(s.start.z for s in outline) == pytest.approx(4.55, abs=0.02)  # a summit on its side's lean
    assert len(closed.parts) == len(mold(design.with_(ridge={"height": 0.5})).parts)
