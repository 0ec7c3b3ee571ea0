"""The page in a browser: what is moved there is shown there, by whoever looks on, without a fault."""

from __future__ import annotations

import json
import random
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.live import Page, free_port, session, words
from tests.live.browser import Looking, looking

pytestmark = pytest.mark.slow
LONG = 300.0  # s, for a check on a machine with much else to do
SETTLE = 3000  # ms, for a browser on a busy machine to show the last click
HOST = "127.0.0.1"


@contextmanager
def served(subject: session.Editable, source: str) -> Iterator[tuple[Page, str]]:
    page = Page(subject, source, HOST, free_port(HOST, 0))
    try:
        assert page.desk.wait_until_drawn(LONG)
        yield page, f"http://{HOST}:{page.server.get_port()}"
    finally:
        page.close()


def told(page: Page) -> dict[str, object]:
    """The verdict that the page shows, without times, as `skincad check --json` has it."""
    verdict = words.best(page.desk)
    assert not isinstance(verdict, str)
    assert verdict is not None
    return without_times(verdict.as_json())


def without_times(answer: dict[str, object]) -> dict[str, object]:
    """An answer without times, and without the advice that the page had time for."""
    rest = json.loads(re.sub(r"about [\d.]+ (s|min)", "about TIME", json.dumps(answer)))
    advice = "cause", "changes", "changes_notes", "changes_searched"
    return {
        key: value for key, value in rest.items() if key not in ("seconds", "climbed", "next_tier", *advice)
    }


def only_here(seen: Looking) -> bool:
    """Whether a browser asked nothing but this server."""
    return all(url.removeprefix("blob:").startswith(f"http://{HOST}") for url in seen.requests)


@pytest.mark.dear("two browsers draw by software")
@pytest.mark.parametrize(
    "moves", [10, pytest.param(60, marks=pytest.mark.evidence(subject="live: 60 moves in a browser"))]
)
def test_random_moves_two_browsers_and_the_verdict_of_check(
    moves: int, capfd: pytest.CaptureFixture[str]
) -> None:
    """Sliders are clicked anywhere, so many moves break a rule; then all is taken back, step by step."""
    dice = random.Random(18)
    with (
        served(skincad.load("yamada-2002"), "yamada-2002") as (page, address),
        looking(address, 2) as (one, other),
    ):
        for folder in ("slot", "film", "material", "mold", "pressing"):
            one.fold(folder)
        refused = 0
        for _ in range(moves):
            one.anything(dice)
            if page.desk.session.refusal is not None:
                refused += 1
                one.press("Undo")
        assert refused > moves // 20  # 60 moves: more than 3
        assert len(page.desk.session.past) > moves // 4
        assert page.desk.wait_until_drawn(LONG)
        for _ in range(2 * len(page.desk.session.past) + 1):  # what waits is dropped first
            if page.desk.session.past or page.desk.session.pending:
                one.press("Undo")
        assert page.desk.session.subject == skincad.load("yamada-2002")
        for seen in (one, other):  # what the last click brings would undo what is written before it comes
            seen.wait_for("as it was loaded")
        one.page.wait_for_timeout(SETTLE)
        one.write("height, mm", "0.45")
        other.wait_for("1 change")
        assert other.value("height, mm") == "0.45"
        assert page.desk.wait_until_settled(LONG)
        one.wait_for("the verdict of")
        design = page.desk.session.design
        assert design == skincad.load("yamada-2002", ["ridge.height=0.45"])
        shown = told(page)  # by the model that the time allowed
        assert shown == without_times(skincad.check(design, model=str(shown["tier"])).as_json())
        for seen in (one, other):
            assert only_here(seen)
            assert not seen.complaints
    printed = capfd.readouterr()
    assert "Traceback" not in printed.err + printed.out
    assert "exception" not in printed.err + printed.out


def test_a_refused_value_waits_and_files_are_those_of_make(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    small = ["ridge.count=3", "skin.width=5", "skin.length=8", "contact.force=0.5"]
    with (
        served(skincad.load("plain-ridges", small), "plain-ridges") as (page, address),
        looking(address) as (seen,),
    ):
        before = page.desk.session.subject
        one_wider = f"{2 * page.desk.session.design.ridge.pitch:g}"
        seen.write("root width, mm", one_wider)
        seen.wait_for("ridge.root_width")
        assert page.desk.session.refusal is not None
        assert seen.page.get_by_text(str(page.desk.session.refusal)).count()
        assert page.desk.session.subject == before
        assert seen.value("root width, mm") == one_wider
        seen.press("Undo")
        seen.wait_for("as it was loaded")
        assert seen.value("root width, mm") == f"{page.desk.session.design.ridge.root_width:g}"

        seen.fold("Save and make")
        seen.press("Save as TOML")
        seen.wait_for("Saved as")
        assert skincad.load("plain-ridges-live.toml") == before
        seen.press("Make its files")
        seen.wait_for("files in out/plain-ridges")

        seen.page.set_viewport_size({"width": 420, "height": 800})  # a telephone: answers first
        answer = seen.page.get_by_text("Section:").bounding_box()
        assert answer is not None
        assert 0 < answer["y"] < 800
    out = tmp_path / "out" / "plain-ridges"
    assert json.loads((out / "make.json").read_text("utf-8"))["name"] == "plain-ridges"
    assert skincad.load(str(out / "design.toml")) == before
    assert "Traceback" not in capfd.readouterr().err


def test_a_scenes_history_and_signals_are_plots_that_follow(capfd: pytest.CaptureFixture[str]) -> None:
    """A force is written beside its slider, then a point added and one removed: both plots follow."""
    scene = skincad.load_scene(
        "yamada-2002-press-and-pull", ["readout.ridges=[3]", "history.steps=12"], skin="steep-fingertip"
    )
    with served(scene, "yamada-2002-press-and-pull") as (page, address), looking(address) as (seen,):
        assert page.desk.wait_until_settled(LONG)
        assert page.desk.is_current(page.desk.signals)
        charts = seen.page.locator(".uplot")
        charts.nth(1).wait_for()
        for place, words in enumerate(("normal force, N", "ridge 3, MPa")):
            assert words in charts.nth(place).inner_text()
        last = len(scene.history.time_s)
        seen.write(f"normal force {last}, N", "3.5")
        seen.wait_for("1 change")
        assert page.desk.session.subject.history.normal_force_N[-1] == 3.5
        assert page._plots["history"].data[1][-1] == 3.5
        assert page.desk.wait_until_settled(LONG)
        assert page.desk.is_current(page.desk.signals)
        assert np.array_equal(page._plots["S1 - S2"].data[1], page.desk.signals.what.stress[3])
        for button, changes, count in (("Add a point", 2, last + 1), ("Remove the last", 3, last)):
            seen.press(button)
            seen.wait_for(f"{changes} changes")
            assert len(page.desk.session.subject.history.time_s) == count
            assert page._plots["history"].data[0].size == count
        assert only_here(seen)
        assert not seen.complaints
    assert "Traceback" not in capfd.readouterr().err
