"""Who computes beside the page: the newest question counts, and nothing that dies takes the page along.

A worker's process imports this file: it imports little.
"""

from __future__ import annotations

import os
import signal
import time
from queue import Empty, Queue
from threading import Event
from typing import Any

import pytest

from skincad.base import InputError
from skincad.live import worker

LONG = 60.0  # s, in which a process has started and answered, on a machine with much else to do


def job(question: str, tell: worker.Tell) -> None:
    """What a question asks for; it runs in a process of its own."""
    if question == "refuse":
        raise InputError("key", "is refused")
    if question == "fail":
        raise ZeroDivisionError("on purpose")
    if question == "die":
        os.kill(os.getpid(), signal.SIGKILL)
    if question == "look up":
        for _ in range(100_000):
            tell("stage", ("working", None))
            time.sleep(0.01)
    if question == "deaf":
        tell("stage", ("deaf", None))
        time.sleep(1000.0)
    tell("answer", question)


@pytest.fixture
def told() -> Queue[Any]:
    return Queue()


@pytest.fixture
def process(told: Queue[Any]) -> Any:
    process = worker.Worker(job, lambda *news: told.put(news))
    yield process
    process.close()


def last(told: Queue[Any], question: str) -> list[tuple[str, Any]]:
    """The news of a question until its last, without stages."""
    news = []
    while True:
        try:
            news_question, kind, what = told.get(timeout=LONG)
        except Empty:
            pytest.fail(f"nothing was told of {question}")
        if news_question == question and kind != "stage":
            news.append((kind, what))
            if kind in ("done", "refused", "failed"):
                return news


def test_answers_come_in_order_and_failures_are_told(process: worker.Worker, told: Queue[Any]) -> None:
    for question, news in (
        ("one", [("answer", "one"), ("done", None)]),
        ("refuse", [("refused", "key: is refused")]),
        ("fail", [("failed", "ZeroDivisionError: on purpose")]),
        ("two", [("answer", "two"), ("done", None)]),
    ):
        process.ask(question)
        assert last(told, question) == news
        assert not process.busy


@pytest.mark.slow
@pytest.mark.dear("two processes import what computes")
def test_one_that_dies_is_told_and_another_takes_its_place(process: worker.Worker, told: Queue[Any]) -> None:
    process.ask("die")
    ((kind, why),) = last(told, "die")
    assert kind == "failed"
    assert "was ended" in why
    process.ask("one")
    assert last(told, "one")[0] == ("answer", "one")


def test_an_older_question_is_left_for_a_newer_one(process: worker.Worker, told: Queue[Any]) -> None:
    """Without a new process: it looks up where it tells its progress."""
    process.ask("look up")
    assert told.get(timeout=LONG)[1] == "stage"
    before = process._process.pid
    process.ask("one")
    assert last(told, "one")[0] == ("answer", "one")
    assert process._process.pid == before


@pytest.mark.slow
def test_one_that_does_not_look_up_is_ended(
    process: worker.Worker, told: Queue[Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(worker, "PATIENCE", 0.1)
    process.ask("one")
    last(told, "one")
    process.ask("deaf")
    assert told.get(timeout=LONG)[1] == "stage"
    process.ask("two")
    assert last(told, "two")[0] == ("answer", "two")


def test_a_thread_works_off_the_newest_alone() -> None:
    seen, gates, begun = [], Queue[None](), Event()

    def work(thing: int, newer: Any) -> None:
        begun.set()
        gates.get(timeout=LONG)
        seen.append((thing, newer()))

    newest = worker.LatestRunner(work)
    newest.give(0)
    assert begun.wait(LONG)  # it is at 0, and waits
    for thing in range(1, 10):
        newest.give(thing)
    gates.put(None)
    gates.put(None)
    assert newest.idle(LONG)
    assert seen == [(0, True), (9, False)]
