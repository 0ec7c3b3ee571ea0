"""A desk without a browser: what answers a move, what is older, and what `skincad check` says of the same."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

import pytest

import skincad
from skincad.live import apply_moves, start_session, view, words
from skincad.live import desk as desks

LONG = 120.0  # s, for a check on a machine with much else to do
# it passes, so that no advice is asked, and its best model is there in a second
SMALL = ["ridge.count=3", "skin.width=5", "skin.length=8", "contact.force=0.5", "contact.friction=0"]


@pytest.fixture
def seen() -> Counter[str]:
    return Counter()


@pytest.fixture
def desk(seen: Counter[str]) -> Iterator[desks.Desk]:
    live_desk = desks.Desk(
        skincad.load("plain-ridges", SMALL), "plain-ridges", lambda kind: seen.update([kind])
    )
    yield live_desk
    live_desk.close()


@pytest.mark.slow
def test_the_last_verdict_is_that_of_check(desk: desks.Desk, seen: Counter[str]) -> None:
    """To the last digit: it is the same function, in another process, by the model that the time allowed."""
    desk.begin()
    assert desk.wait_until_drawn(LONG)
    assert desk.wait_until_settled(LONG)
    desk.move({"contact.force": 0.4})
    assert desk.wait_until_drawn(LONG)
    assert desk.wait_until_settled(LONG)
    assert desk.verdict is not None
    assert desk.is_current(desk.verdict)
    verdict = desk.verdict.what
    wanted = skincad.check(desk.session.design, model=verdict.model)
    reply, said = (json.loads(json.dumps(check.as_json())) for check in (verdict, wanted))
    for answer in (reply, said):
        for key in ("seconds", "cause", "changes", "climbed", "next_tier"):  # times, and advice
            answer.pop(key)
    assert reply == said
    assert desk.better is not None
    assert desk.better.what[0].model == "linear"
    assert {"session", "view", "closed_form", "findings", "better", "verdict"} <= seen.keys()


def test_answers_are_older_once_the_design_moves_on_and_fresh_again_after_undo(desk: desks.Desk) -> None:
    design = desk.session.design
    desk.view = desks.Reply(design, view(design))
    desk.closed_form = desks.Reply(design, desks.closed_form(desk.session))
    desk.findings = desks.Reply(design, ())
    desk.verdict = desks.Reply(design, skincad.check(design, model="winkler"))
    assert desk.is_current(desk.verdict)
    assert words.best(desk) is desk.verdict.what  # type: ignore[union-attr]
    assert "older" not in words.verdict_html(desk) + words.findings_html(desk)
    desk.session = apply_moves(desk.session, {"ridge.height": 0.45}, 0.0)
    assert not desk.is_current(desk.verdict)
    assert words.best(desk) is None
    assert "older" in words.verdict_html(desk)
    assert "older" in words.findings_html(desk)
    desk.undo()
    assert desk.is_current(desk.verdict)


def test_what_cannot_be_made_says_so_and_the_skin_is_drawn() -> None:
    design = skincad.load("yamada-2002", ["mold.gate=20"])
    shown = view(design)
    assert "gate" in shown.refusal
    assert not shown.mold
    assert len(shown.skin.faces)
    assert desks.findings(shown) == ()


def test_the_page_tells_the_designs_own_line_escaped() -> None:
    session = apply_moves(
        start_session(skincad.load("yamada-2002")), {"material.name": "<b>no such</b>"}, 0.0
    )
    text = words.state_html(session)
    assert "&lt;b&gt;no such" in text
    assert "<b>no such" not in text


def test_saving_keeps_comments_and_never_overwrites(
    desk: desks.Desk, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    desk.move({"ridge.height": 0.45})
    assert "Saved" in desk.save("mine")
    assert "#" in (tmp_path / "mine.toml").read_text("utf-8")
    assert skincad.load("mine.toml") == desk.session.subject
    assert "exists already" in desk.save("mine.toml")
    assert "without folders" in desk.save("../mine")
    assert "without folders" in desk.save(".hidden")
    assert [path.name for path in tmp_path.iterdir()] == ["mine.toml"]


def test_findings_are_those_of_make_that_need_no_solids() -> None:
    design = skincad.load("nozzle-04")
    rows = desks.findings(view(design))
    assert rows
    assert [f.severity for f in rows] == sorted(
        (f.severity for f in rows), key=("error", "warning", "note").index
    )
