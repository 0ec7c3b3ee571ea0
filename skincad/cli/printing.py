"""How commands hand on a result: the out folder, the lines printed, the status."""

from __future__ import annotations

import os
import re
import shlex
import sys
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import typer

from skincad.base.errors import shown
from skincad.base.interrupt import INTERRUPTED, safe_point
from skincad.base.reading import strict_json
from skincad.cli.options import Display

if TYPE_CHECKING:
    from skincad.base.result import Result
    from skincad.outputs.delivery import Delivery


def out_folder(folder: Path | None, default: str | Path, command: str, names: Iterable[str]) -> Path:
    """Return where a command writes its files, out/<default> unless it is told; raises InputError, before
    any work, where they can't be written."""
    from skincad.outputs.delivery import ready

    target = folder or Path("out") / default
    ready(target, command, names)
    return target


def say(*lines: str) -> None:
    """Print lines. A reader who has had enough, as `head`, does not change a command's status."""
    safe_point()
    _print(_text(lines))


def show(data: dict[str, Any], as_json: bool, lines: Iterable[str]) -> None:
    """Print a command's result."""
    safe_point()
    _print(strict_json(data) if as_json else _text(lines))


def _text(lines: Iterable[str]) -> str:
    return "\n".join(shown(line) for line in "\n".join(lines).split("\n"))


def as_typed(
    source: str, settings: Iterable[str], force: float | None = None, **options: object
) -> Callable[[str], str]:
    """Return what fills a result's next step with the design as it is typed, and the `force` N as a setting.

    What the next step gives anew is left out; so is an option that is None or auto.
    """
    given = list(settings)
    if force is not None:
        given = [text for text in given if not text.startswith("contact.force=")]
        given.append(f"contact.force={force:g}")

    def fill(step: str) -> str:
        changed = set(re.findall(r"--set '?([^\s=']+)=", step))
        kept = [setting for setting in given if setting.partition("=")[0].strip() not in changed]
        words = [source, *(word for setting in kept for word in ("--set", setting))]
        for name, value in options.items():
            if value not in (None, "auto") and f"--{name} " not in step:
                words += [f"--{name}", str(value)]
        return re.sub(r"\{\w+\}", lambda _: shlex.join(words), step)

    return fill


def report(
    result: Result,
    typed: Callable[[str], str] | None = None,
    *,
    verbose: bool = False,
    more: Iterable[str] = (),
    last: bool = True,
) -> list[str]:
    """Return what a command prints of a result: the answer, how sure it is, `more`, what to do next if it
    is known (`last`), and if `verbose` all numbers."""
    presenter = result.presenter()
    after = presenter.details(result) if verbose else []
    return [*presenter.lines(result), *more, *(result.next_line(typed) if last else []), *after]


def deliver(
    result: Result,
    written: Delivery,
    display: Display,
    typed: Callable[[str], str] | None = None,
    last: bool = True,
    beside: Mapping[str, Any] | None = None,
) -> None:
    """Print a result, and what was written of it: its files lie there, so nothing is undone any more.

    `beside` are further keys of its JSON.
    """
    data = result.as_json()
    seconds = data.get("seconds", {})
    total = seconds.get("total", 0.0) + written.seconds["total"]
    data |= {"files": written.sizes(), "seconds": {**seconds, **written.seconds, "total": total}}
    data |= beside or {}
    more = [f"  files          {written}, {total:.1f} s"]
    named = re.findall(r"[\w-]+\.(?:html|png)", "".join(result.next_line()))
    last = last and {name for name, _ in written.files}.issuperset(named)  # it names no missing file
    if display.as_json:
        _print(strict_json(data))
    else:
        _print(_text(report(result, typed, verbose=display.verbose, more=more, last=last)))


def leave(result: Result) -> NoReturn:
    """End a command with its result's status."""
    if result.exit_status == INTERRUPTED:
        raise KeyboardInterrupt
    raise typer.Exit(result.exit_status)


def _print(text: str) -> None:
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
