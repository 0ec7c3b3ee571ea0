"""The page to turn a design: what is in it, and that it does what its buttons say."""

from __future__ import annotations

import base64
import json
import re
import zlib
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import skincad
from skincad.base.errors import RefusedError
from skincad.fabrication.job import Job
from skincad.fabrication.sheet import opening_steps
from skincad.outputs import view
from skincad.outputs.view import three_js, way_out
from skincad.solids.mold import mold

LARGEST = 3_000_000  # bytes: what a person still forwards
BENT = ("yamada-2002", ["skin.curvature_radius_y=200"])
DESIGNS = {
    "yamada-2002": ("yamada-2002", []),
    "steep-fingertip": ("steep-fingertip", []),
    "gripper-pad": ("gripper-pad", []),
    "bent": BENT,
}


def page_of(name: str, folder: Path) -> Path:
    """The page of one of DESIGNS, with the skin under its load where it is straight."""
    template, settings = DESIGNS[name]
    model = "winkler" if name == "bent" else "linear"
    design = skincad.load(template, settings)
    result = skincad.make(design, preview=True)
    build = result.built()
    judged = replace(result, build=replace(build, check=skincad.check(design, model=model)))
    skincad.write(judged, folder, formats="html")
    return folder / "view.html"


def told(page: Path) -> dict[str, Any]:
    packed = re.search(r'id="data">([^<]*)<', page.read_text("utf-8"))
    assert packed is not None
    return json.loads(zlib.decompress(base64.b64decode(packed[1])))


def array(text: str, kind: str = "<f4") -> Any:
    return np.frombuffer(base64.b64decode(text), kind)


def rim(picture: Any) -> Any:
    """What is along the four edges of a picture, `(n, 3)`."""
    return np.concatenate([*picture[:2], *picture[-2:], *picture[:, :2], *picture[:, -2:]])


@pytest.fixture(scope="module")
def yamada_page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return page_of("yamada-2002", tmp_path_factory.mktemp("view") / "made")


def test_every_part_is_there_as_it_is_printed(yamada_page: Path) -> None:
    design = skincad.load("yamada-2002")
    closed = mold(design)
    parts = {part["name"]: part for part in told(yamada_page)["parts"]}
    assert list(parts) == [part.name for part in closed.parts]
    for part in closed.parts:
        points, faces = array(parts[part.name]["points"]), array(parts[part.name]["faces"], "<u4")
        a, b, c = points.reshape(-1, 3)[faces].reshape(-1, 3, 3).swapaxes(0, 1).astype(float)
        volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
        assert volume == pytest.approx(part.volume, rel=5e-3)  # chords of what is small and round


@pytest.mark.parametrize("name", ["yamada-2002", "bent"])
def test_the_steps_carry_the_sheets_words_and_move_what_leaves(name: str) -> None:
    design = skincad.load(*DESIGNS[name])
    closed = mold(design)
    for step in opening_steps(Job(design, closed)):
        for move in step.moves:
            for part in move.parts:
                way = way_out(closed.part(part), move)
                length = abs(way["angle"]) if "angle" in way else np.linalg.norm(way["shift"])
                assert length == pytest.approx(abs(move.travel))


def test_the_load_is_the_checks(yamada_page: Path) -> None:
    load = told(yamada_page)["load"]
    design = skincad.load("yamada-2002")
    rest, moved = (array(load[key]).reshape(-1, 3) for key in ("rest", "moved"))
    check = skincad.check(design, model="linear")
    fall = load["plate"][0] - load["plate"][1]
    assert fall == pytest.approx(
        check.approach.value, rel=3e-3
    )  # the crest between two points of the outline
    assert np.ptp(rest[:, 1]) == pytest.approx(design.skin.length)
    assert np.ptp(rest[:, 0]) == pytest.approx(design.skin.width, rel=1e-6)  # single precision
    assert np.abs((moved - rest)[rest[:, 2] == 0]).max() == 0  # the back is held
    assert array(load["pressure"]).max() > 0


def test_a_solid_under_load_is_closed(yamada_page: Path) -> None:
    """Of every edge both directions, and outside is outside: else a cut through it isn't filled."""
    load = told(yamada_page)["load"]
    faces = array(load["faces"], "<u4").reshape(-1, 3)
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ways, counts = np.unique(edges, axis=0, return_counts=True)
    assert (counts == 1).all()
    assert {tuple(edge) for edge in ways.tolist()} == {tuple(edge) for edge in ways[:, ::-1].tolist()}
    corners = array(load["rest"]).reshape(-1, 3)[faces].astype(float)
    assert np.abs(corners[:, :, 0]).max(axis=1).min() > 0  # nothing stands where a half meets its image
    volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6
    design = skincad.load("yamada-2002", ["slot=none", "film=none", "contact.film=none"])  # they are filled
    assert volume == pytest.approx(skincad.section(design).area * design.skin.length, rel=1e-4)  # chords


def test_a_trimesh_without_the_library_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "SPDX-License-Identifier: MIT" in three_js()
    monkeypatch.setattr(view, "VIEWER_START", "no such words")
    with pytest.raises(RefusedError, match="trimesh"):
        three_js()


@pytest.mark.slow
@pytest.mark.xdist_group("browser")
@pytest.mark.parametrize("name", DESIGNS)
def test_in_a_browser_without_a_network(name: str, tmp_path: Path) -> None:
    from tests.outputs.browser import shown

    file = page_of(name, tmp_path / "made")
    assert file.stat().st_size <= LARGEST
    with shown(file) as seen:
        page = seen.page
        page.wait_for_selector("body[data-ready]")
        whole = seen.drawn()
        assert whole > 0.1  # of the stage: it is filled, not only framed
        closed = seen.picture()

        page.fill("#apart", "1")
        assert rim(seen.picture()).min() > 250  # nothing leaves the picture
        page.click("#fit")
        opened = seen.picture()
        assert np.abs(opened - closed).max() > 50
        page.fill("#apart", "0")
        page.click("#fit")
        assert np.abs(seen.picture() - closed).max() < 50  # back again, but for the antialiasing

        page.check("input[value=y]")
        half = seen.picture()
        assert np.abs(half - closed).max() > 50
        page.fill("#place", "0.2")
        assert np.abs(seen.picture() - half).max() > 50
        page.check("#flip")
        assert seen.drawn() < whole
        page.check("input[name=cut][value='']")

        page.click("#none")
        assert seen.drawn() == 0
        page.check("input[data-part=skin]")
        assert 0 < seen.drawn() < whole
        page.click("#all")

        design = skincad.load(*DESIGNS[name])
        for step in opening_steps(Job(design)):
            page.click("#on")
            assert page.inner_text("#told") == step.words
            page.wait_for_function("document.body.dataset.still === 'yes'")
        assert page.is_disabled("#on")
        left = seen.drawn()
        assert left > 0
        page.click("#back")

        if name == "bent":
            assert page.is_disabled("#skin")
            assert page.is_visible("#unloaded")
        else:
            page.click("#skin")
            deformed = seen.picture()
            assert (np.ptp(deformed, axis=2) > 90).sum() > 100  # the bright colours of the pressure
            page.fill("#load", "0")
            assert np.abs(seen.picture() - deformed).max() > 50
        assert seen.requests == [file.as_uri()]
        assert seen.complaints == []
