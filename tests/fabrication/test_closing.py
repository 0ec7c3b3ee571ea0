"""The closed mold as a stack."""

from __future__ import annotations

import pytest

import skincad
from skincad.fabrication.closing import closing_findings
from skincad.inputs.catalog import template_names
from skincad.solids.mold import mold


@pytest.mark.parametrize("name", template_names())
def test_a_thin_cover_is_told_with_the_thickness_that_does(name: str) -> None:
    design = skincad.load(name)
    assert list(closing_findings(design)) == []
    thin = design.with_(mold={"cover": 1.0})
    found = list(closing_findings(thin))
    if found:
        assert (found[0].severity, found[0].limit) == ("warning", 0.02)
        least = float(found[0].remedy.split(" of ")[1].split(" mm")[0])
        assert list(closing_findings(design.with_(mold={"cover": least}))) == []
    cover = mold(thin).part("cover").body
    assert cover.high - cover.low == 1.0  # kept, whatever its bow


def test_a_printed_cover_of_four_millimetres_over_a_wide_skin_bows() -> None:
    """Two screws held it, and nobody said that it gaped."""
    (told,) = closing_findings(skincad.load("nozzle-04", ["mold.cover=4.0"]))
    assert told.rule == "cover bow"
    assert told.measured > 0.2
