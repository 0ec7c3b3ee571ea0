"""Numbers that mean harm, given to every option that takes one: refused at once, by the option's own name."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, get_args, get_origin, get_type_hints

import pytest
import typer

from skincad.base import InputError
from skincad.cli import run
from skincad.cli.app import app

NUMBERS = ("nan", "1e999", "-inf", "-1", "0", "abc", "")
ALLOWED = {("--pull", "-1"), ("--pull", "0"), ("--at", "0"), ("--port", "0"), ("--rest", "0")}
BAR = "extension_mm,force_N\n" + "\n".join(f"{i / 10},{i}" for i in range(12))
PAD = BAR.replace("extension", "approach")
WITH = {  # what a command needs beside the option to come as far as to look at it
    "check": ["yamada-2002"],
    "make": ["yamada-2002"],
    "simulate": ["yamada-2002-slip"],
    "accuracy": ["yamada-2002"],
    "fit-material": ["bar.csv"],
    "accept": ["pad.csv", "yamada-2002"],
    "live": ["yamada-2002"],
    "listen": ["yamada-2002", "--csv", "pad.csv"],
    "export": ["yamada-2002"],
    "solve": ["yamada-2002", "--target", "approach=1", "--vary", "skin.length=8:12"],
    "optimise": ["shape-for-4-N"],
    "sweep": ["yamada-2002", "--vary", "skin.length=8:12:3"],
}
BESIDE = {
    "--pull": ["--stress", "s.png"],
    "--area": ["--gauge-length", "10"],
    "--gauge-length": ["--area", "10"],
    "--up-to": ["--gauge-length", "10", "--area", "10"],
}


def numeric() -> list[tuple[str, str]]:
    """Every command and its option whose type has a float or an int in it."""
    keys = []
    for command in app.registered_commands:
        assert command.callback
        name = command.name or command.callback.__name__
        for hint in get_type_hints(command.callback, include_extras=True).values():
            kind, option = get_args(hint)[:2] if get_origin(hint) is Annotated else (None, None)
            if {float, int} & {kind, *get_args(kind)}:
                keys.append((name, option.default))  # as typer takes the first of its names
    return keys


def test_the_search_finds_them_all() -> None:
    assert sorted(numeric()) == [
        ("accept", "--approach-error"), ("accept", "--force-error"), ("accept", "--good-share"),
        ("accuracy", "--repeats"), ("check", "--budget"), ("check", "--force"), ("check", "--pull"),
        ("check", "--tol"), ("export", "--bandwidth"), ("export", "--every"), ("export", "--noise"),
        ("export", "--rate"),
        ("fit-material", "--area"), ("fit-material", "--gauge-length"),
        ("fit-material", "--up-to"), ("listen", "--bandwidth"), ("listen", "--baud"), ("listen", "--every"),
        ("listen", "--noise"), ("listen", "--rate"), ("listen", "--rest"), ("listen", "--timeout"),
        ("live", "--port"),
        ("make", "--budget"), ("optimise", "--workers"), ("simulate", "--at"),
        ("simulate", "--budget"), ("simulate", "--tol"), ("solve", "--evaluations"), ("solve", "--force"),
        ("solve", "--tol"), ("sweep", "--force"), ("sweep", "--sample"), ("sweep", "--tol"),
        ("sweep", "--workers"),
    ]  # fmt: skip


def refusal(arguments: list[str]) -> str:
    """The words of an error that `main` tells with status 2; no result is ever printed."""
    try:
        run(arguments)
    except InputError as failure:
        return str(failure)
    except typer.BadParameter.__mro__[2] as failure:  # typer's own usage error
        return str(failure.format_message())  # type: ignore[attr-defined]
    return ""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bar.csv").write_text(BAR)
    (tmp_path / "pad.csv").write_text(PAD)
    return tmp_path


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize(("command", "option"), numeric())
def test_a_bad_number_is_refused_by_the_name_that_was_typed(
    command: str, option: str, number: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    if (option, number) in ALLOWED:
        return
    before = sorted(folder.iterdir())
    words = refusal([command, *WITH[command], *BESIDE.get(option, []), option, number])
    assert words.startswith((f"{option}: ", f"Invalid value for '{option}'")), words
    assert not {other for _, other in numeric() if other != option and f"{other}: " in words}
    assert capsys.readouterr().out == ""
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize("number", NUMBERS)
def test_so_is_a_pads_largest_force(number: str, folder: Path) -> None:
    words = refusal(["fit-material", "pad.csv", "--design", "plain-ridges", "--up-to", number])
    assert words.startswith(("--up-to: ", "Invalid value for '--up-to'")), words


def test_a_bad_pull_is_refused_before_the_verdict(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("skincad.check", None)
    for wrong in ("--pull nan", "--set slot=none", "--set contact.film=loose", "--force nan"):
        assert refusal(["check", "yamada-2002", "--stress", "s.png", *wrong.split()])


def test_a_step_that_does_not_come_is_refused_by_the_name_that_was_typed(folder: Path) -> None:
    assert refusal(["simulate", "hold", "--at", "100000"]).startswith("--at: must be from 0 to ")
    wrong = ["simulate", "hold", "--set", "readout.steps=[100000]"]
    assert refusal(wrong).startswith("readout.steps: must be from 0 to ")
