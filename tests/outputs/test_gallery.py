"""The gallery of designs: its rows follow from the designs, its forces are current, its page is whole."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import skincad
from skincad.inputs import template_names
from skincad.outputs import forces, gallery
from tests.conftest import Made

DOCS = Path(__file__).parent.parent.parent / "docs"
NAMES = template_names()
REPORTS = pytest.mark.evidence(subject="reports")  # of yamada-2002


def test_the_page_shows_every_design_and_picture() -> None:
    """`python -m bench.gallery --pictures` draws them; mkdocs makes the page."""
    page = gallery.page()
    assert re.findall(r"^## (.+)$", page, re.M) == NAMES
    assert re.findall(r"\(gallery/(.+)\.png\)", page) == NAMES
    assert sorted(path.stem for path in (DOCS / "gallery").iterdir()) == NAMES


def test_every_force_is_of_the_design_that_ships() -> None:
    assert sorted(forces()) == NAMES
    assert {name: row["revision"] for name, row in forces().items()} == {
        name: skincad.load_design(name).revision for name in NAMES
    }


def test_a_changed_design_has_no_force_and_others_are_pressed_with_more() -> None:
    higher = skincad.load_design("yamada-2002", ["ridge.height=0.6"])
    assert gallery.force_of(higher).value is None
    row = gallery.entries()["lab-bench"]
    needed = row["all_touch_force_N"]
    assert needed["value"] + needed["error"] < row["force_N"] == 4.0


def test_the_smallest_detail_is_the_narrowest_of_groove_tooth_and_slot() -> None:
    bare = skincad.load_design("plain-ridges")
    assert gallery.smallest_detail(bare) == (0.25, "tooth between two ridges' roots")
    assert gallery.smallest_detail(bare.with_(ridge={"tip_width": 0.2}))[0] == 0.2
    assert gallery.smallest_detail(skincad.load_design("cast-in"))[1] == "film"


def assert_alike(shown: Path, drawn: Path) -> None:
    """Two pictures are the same but for size, palette and fonts: 1.1 is what tilted strips make."""
    one, other = (
        np.asarray(Image.open(path).convert("L").resize((363, 203)), dtype=float) for path in (shown, drawn)
    )
    assert np.abs(one - other).mean() < 1.0


@pytest.mark.slow
def test_the_picture_of_yamada_2002_is_what_the_program_draws(made: Made) -> None:
    assert_alike(DOCS / "gallery" / "yamada-2002.png", made.folder / "picture.png")


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", [name for name in NAMES if name != "yamada-2002"])
def test_every_picture_is_what_the_program_draws(name: str, tmp_path: Path) -> None:
    result = skincad.make(skincad.load_design(name), preview=True)
    skincad.write(result, tmp_path / "out", formats=("png",))
    assert_alike(DOCS / "gallery" / f"{name}.png", tmp_path / "out" / "picture.png")


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", [n if n != "yamada-2002" else pytest.param(n, marks=REPORTS) for n in NAMES])
def test_every_force_is_what_the_model_gives(name: str) -> None:
    known, row = gallery.force_of(skincad.load_design(name)), forces()[name]
    again = skincad.check(skincad.load_design(name), model=row["model"]).all_touch_force
    assert known.value == pytest.approx(again.value, rel=1e-3)
    assert known.error == pytest.approx(again.error, rel=0.1)
