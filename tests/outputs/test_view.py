"""The page to turn a design: what is in it, and that it does what its buttons say."""

from __future__ import annotations

import base64
import io
import json
import re
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

import skincad
from skincad.base import RefusedError
from skincad.fabrication import Job, mesh, opening_steps, print_chord
from skincad.mechanics import ContactCheck
from skincad.outputs import view
from tests.outputs.browser import Seen, shown

LARGEST = 3_000_000  # bytes: what a person still forwards
DESIGNS = {
    "three ridges": ("yamada-2002", ["ridge.count=3", "skin.width=5", "contact.force=1.3"]),
    "yamada-2002": ("yamada-2002", []),
    "steep-fingertip": ("steep-fingertip", []),
    "gripper-pad": ("gripper-pad", []),
    "bent": ("yamada-2002", ["skin.curvature_radius_y=200", "ridge.count=3"]),
}


@cache
def check_of(name: str) -> ContactCheck:
    """The check of one of DESIGNS; a load is drawn of one by finite elements of the section."""
    return skincad.check(skincad.load(*DESIGNS[name]), model="winkler" if name == "bent" else "linear")


def page_of(name: str, folder: Path) -> Path:
    """The page of one of DESIGNS as make has it, with the skin under its load where it is straight."""
    job = Job(skincad.load(*DESIGNS[name]))
    meshes = {part.name: mesh(part, print_chord(job.design)) for part in job.closed.parts}
    (folder / "view.html").write_text(view.view_page(job, meshes, check_of(name), "Passes."), "utf-8")
    return folder / "view.html"


def data(file: Path) -> dict[str, Any]:
    packed = re.search(r'id="data">([^<]*)<', file.read_text("utf-8"))
    assert packed is not None
    return json.loads(zlib.decompress(base64.b64decode(packed[1])))


def array(text: str, kind: str = "<f4") -> Any:
    return np.frombuffer(base64.b64decode(text), kind)


def rim(picture: Any) -> Any:
    """What is along the four edges of a picture, `(n, 3)`."""
    return np.concatenate([*picture[:2], *picture[-2:], *picture[:, :2], *picture[:, -2:]])


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return page_of("three ridges", tmp_path_factory.mktemp("view"))


def test_every_part_is_there_as_it_is_printed(file: Path) -> None:
    closed = Job(skincad.load(*DESIGNS["three ridges"])).closed
    parts = {part["name"]: part for part in data(file)["parts"]}
    assert list(parts) == [part.name for part in closed.parts]
    for part in closed.parts:
        points, faces = array(parts[part.name]["points"]), array(parts[part.name]["faces"], "<u4")
        a, b, c = points.reshape(-1, 3)[faces].reshape(-1, 3, 3).swapaxes(0, 1).astype(float)
        volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6
        assert volume == pytest.approx(part.volume, rel=5e-3)  # chords of what is small and round


@pytest.mark.parametrize("name", ["three ridges", "bent"])
def test_the_steps_carry_the_sheets_words_and_move_what_leaves(name: str) -> None:
    job = Job(skincad.load(*DESIGNS[name]))
    for step in opening_steps(job):
        for move in step.moves:
            for part in move.parts:
                way = view.way_out(job.closed.part(part), move)
                length = abs(way["angle"]) if "angle" in way else np.linalg.norm(way["shift"])
                assert length == pytest.approx(abs(move.travel))


def test_the_load_is_the_checks(file: Path) -> None:
    load = data(file)["load"]
    design = skincad.load(*DESIGNS["three ridges"])
    rest, moved = (array(load[key]).reshape(-1, 3) for key in ("rest", "moved"))
    fall = load["plate"][0] - load["plate"][1]
    # the crest lies between two points of the outline
    assert fall == pytest.approx(check_of("three ridges").approach.value, rel=3e-3)
    assert np.ptp(rest[:, 1]) == pytest.approx(design.skin.length)
    assert np.ptp(rest[:, 0]) == pytest.approx(design.skin.width, rel=1e-6)  # single precision
    assert np.abs((moved - rest)[rest[:, 2] == 0]).max() == 0  # the back is held
    assert array(load["pressure"]).max() > 0


def test_a_solid_under_load_is_closed(file: Path) -> None:
    """Of every edge both directions, and outside is outside: else a cut through it isn't filled."""
    load = data(file)["load"]
    faces = array(load["faces"], "<u4").reshape(-1, 3)
    edges = np.vstack([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ways, counts = np.unique(edges, axis=0, return_counts=True)
    assert (counts == 1).all()
    assert {tuple(edge) for edge in ways.tolist()} == {tuple(edge) for edge in ways[:, ::-1].tolist()}
    corners = array(load["rest"]).reshape(-1, 3)[faces].astype(float)
    assert np.abs(corners[:, :, 0]).max(axis=1).min() > 0  # nothing stands where a half meets its image
    volume = float(np.einsum("ij,ij->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))) / 6
    design = skincad.load(
        "yamada-2002", [*DESIGNS["three ridges"][1], "slot=none", "film=none", "contact.film=none"]
    )  # they are filled
    assert volume == pytest.approx(skincad.section(design).area * design.skin.length, rel=1e-4)  # chords


def test_a_trimesh_without_the_library_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    assert "SPDX-License-Identifier: MIT" in view.three_js()
    monkeypatch.setattr(view, "VIEWER_START", "no such words")
    with pytest.raises(RefusedError, match="trimesh"):
        view.three_js()


BROWSED = [
    pytest.param("yamada-2002", marks=pytest.mark.slow),
    *(
        pytest.param(name, marks=pytest.mark.evidence(subject=subject))
        for name, subject in (
            ("steep-fingertip", "steep-fingertip"),
            ("gripper-pad", "gripper-pad"),
            ("bent", "views: doubly curved"),
        )
    ),
]


@pytest.mark.slow
def test_without_webgl_the_picture_is_shown(tmp_path: Path) -> None:
    job = Job(skincad.load(*DESIGNS["three ridges"]))
    meshes = {part.name: mesh(part, print_chord(job.design)) for part in job.closed.parts}
    dot = io.BytesIO()
    Image.new("RGB", (40, 20), "red").save(dot, "png")
    page = view.view_page(job, meshes, None, "Passes.", dot.getvalue())
    (tmp_path / "view.html").write_text(page, "utf-8")
    with shown(tmp_path / "view.html", flat=True) as seen:
        seen.page.wait_for_selector("#picture:not(.hidden)")
        assert np.median(seen.picture("#picture"), axis=(0, 1)).tolist() == [255.0, 0.0, 0.0]
        assert "draws nothing in three dimensions" in seen.page.inner_text("#stage")


@pytest.mark.parametrize("name", BROWSED)
def test_in_a_browser_without_a_network(name: str, tmp_path: Path) -> None:
    file = page_of(name, tmp_path)
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


@contextmanager
def opened(file: Path, window: str, *, touch: bool = False) -> Iterator[Seen]:
    """A page that is ready; in the end it must have complained of nothing."""
    with shown(file, WINDOWS[window], touch=touch) as seen:
        seen.page.wait_for_selector("body[data-ready]")
        yield seen
        assert seen.complaints == []


WINDOWS = {"wide": (1400, 900), "narrow": (420, 860)}


def pixels_per_mm(seen: Seen) -> float:
    """What the scale bar says."""
    bar = seen.page.locator("#ruler div").bounding_box()
    assert bar is not None
    return bar["width"] / float(seen.page.get_attribute("#ruler", "data-mm"))


@pytest.mark.slow
@pytest.mark.parametrize("window", WINDOWS)
def test_the_scale_bar_is_true_and_follows_the_zoom(window: str, file: Path) -> None:
    (skin,) = (part for part in data(file)["parts"] if part["name"] == "skin")
    right = np.array([1.0, 0.55, 0.0]) / np.hypot(1.0, 0.55)  # of a view from (0.55, -1, 0.75)
    wide = np.ptp(array(skin["points"]).reshape(-1, 3) @ right)
    with opened(file, window) as seen:
        page = seen.page
        page.click("#none")
        assert page.is_hidden("#ruler")  # nothing to measure
        page.check("input[data-part=skin]")
        page.click("#fit")
        before = pixels_per_mm(seen)
        page.evaluate("document.getElementById('ruler').style.visibility = 'hidden'")
        columns = np.flatnonzero((seen.picture().min(axis=2) < 250).any(axis=0))
        assert np.ptp(columns) + 1 == pytest.approx(before * wide, abs=3.0)  # edges are lines, 1 pixel wide
        page.evaluate("document.getElementById('ruler').style.visibility = ''")
        for key, factor in (("+", 1.25), ("-", 0.8), ("-", 0.8)):
            page.keyboard.press(key)
            assert pixels_per_mm(seen) == pytest.approx(before * factor, rel=0.02)  # whole pixels
            before *= factor
            bar = page.locator("#ruler div").bounding_box()
            assert 55 <= bar["width"] <= 141  # type: ignore[index]
            assert page.inner_text("#ruler") == f"{float(page.get_attribute('#ruler', 'data-mm')):g} mm"  # type: ignore[arg-type]
        stage = page.locator("#stage").bounding_box()
        page.mouse.move(stage["x"] + 150, stage["y"] + 150)  # type: ignore[index]
        page.mouse.wheel(0, -400)
        page.wait_for_timeout(200)
        assert pixels_per_mm(seen) > 1.05 * before


@pytest.mark.slow
def test_keys_press_what_their_list_says(file: Path) -> None:
    with opened(file, "wide") as seen:
        page = seen.page
        assert not page.is_visible("#keys")
        page.keyboard.press("?")
        assert page.is_visible("#keys")
        listed = page.locator("#key-list kbd").all_inner_texts()
        assert set("?FMSTENBXYZC+-") == set(listed)
        page.keyboard.press("n")  # not behind the list
        assert page.inner_text("#step") == "closed"
        page.keyboard.press("?")
        assert not page.is_visible("#keys")
        page.click("#help")
        assert page.is_visible("#keys")
        page.keyboard.press("Escape")
        assert not page.is_visible("#keys")
        for key, cut in (("x", "x"), ("c", "''")):
            page.keyboard.press(key)
            assert page.is_checked(f"input[name=cut][value={cut}]")
        page.keyboard.press("e")
        assert page.input_value("#apart") == "1"
        page.keyboard.press("n")
        assert page.inner_text("#step").startswith("step 1 of")
        page.keyboard.press("b")
        assert page.inner_text("#step") == "closed"
        page.keyboard.press("s")
        assert page.is_visible("#of-skin")


@pytest.mark.slow
def test_what_the_pointer_is_on_is_named(file: Path) -> None:
    with opened(file, "wide") as seen:
        page = seen.page
        box = page.locator("#stage canvas").bounding_box()
        assert box is not None
        middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        page.mouse.move(*middle)
        assert page.is_visible("#name")
        page.click("#none")
        page.check("input[data-part=skin]")
        page.click("#fit")
        page.mouse.move(*middle)
        assert page.inner_text("#name") == "skin"
        page.mouse.move(box["x"] + 4, box["y"] + 4)
        assert not page.is_visible("#name")
        page.click("#skin")
        page.mouse.move(*middle)
        assert page.inner_text("#name") == "skin under load"


@pytest.mark.slow
def test_a_thumb_can_use_it(file: Path) -> None:
    """420 pixels: nothing is wider, buttons are 40 pixels high, a drag turns, two fingers zoom."""
    with opened(file, "narrow", touch=True) as seen:
        page = seen.page
        for mode in ("#skin", "#mold"):
            page.click(mode)
            assert seen.overflow() == 0
            assert page.evaluate("document.getElementById('panel').scrollWidth") <= 420
            for what in ("button", "#panel input[type=range]", "#parts label"):
                for box in (each.bounding_box() for each in page.locator(what).all() if each.is_visible()):
                    assert box is not None
                    assert box["height"] >= 40
                    assert box["x"] >= 0
                    assert box["x"] + box["width"] <= 420
        stage = page.locator("#stage canvas").bounding_box()
        assert stage is not None
        assert stage["height"] > 400
        x, y = stage["x"] + 200, stage["y"] + 200
        before, scale = seen.picture(), pixels_per_mm(seen)
        seen.touch(((x, y), (x + 90, y + 20)))
        turned = seen.picture()
        assert (np.abs(turned - before).max(axis=2) > 50).mean() > 0.02
        assert pixels_per_mm(seen) == pytest.approx(scale)
        assert page.is_visible("#name")  # of the part that was touched
        seen.touch(((x - 20, y), (x - 90, y)), ((x + 20, y), (x + 90, y)))
        assert pixels_per_mm(seen) > 1.3 * scale
        assert seen.overflow() == 0
