"""The command line as a process: what it exits with, and what it says where it fails."""

from __future__ import annotations

import json
import os
import sys
from traceback import print_exc
from typing import Any, NoReturn, TextIO

import typer

from skincad.base.errors import ExhaustedError, FaultError, InputError, RefusedError, exhausted, shown
from skincad.base.interrupt import INTERRUPTED, safe_point
from skincad.cli.app import app

TRACEBACK = "SKINCAD_TRACEBACK"  # the environment variable that lets a traceback of skincad's own faults pass
SIGNALLED = 128  # a status above it means a signal
COMPLETE = "_SKINCAD_COMPLETE"  # set by a shell that asks how a word may go on

# typer carries a parser of its own; its public BadParameter leads to the base of its errors
_USAGE_ERROR: type[Exception] = typer.BadParameter.__mro__[2]


def main() -> None:
    """Run the command line and exit: 0 done, 1 a check failed or stayed undecided, 2 bad input, 3 a resource
    ran out or skincad itself failed, 130 interrupted, 143 terminated."""
    arguments = sys.argv[1:] or ["--help"]
    try:
        status = run(arguments)
    except InputError as failure:
        _leave(str(failure), 2)
    except _USAGE_ERROR as failure:
        text = failure.format_message() if hasattr(failure, "format_message") else str(failure)
        context = getattr(failure, "ctx", None)
        _leave(f"{text} (see {context.command_path if context else 'skincad'} --help)", 2)
    except BrokenPipeError:  # the reader of our output has had enough
        _drop(sys.stdout)
        status = 0
    except KeyboardInterrupt:
        _leave("interrupted", INTERRUPTED)
    except SystemExit as end:
        if not isinstance(end.code, int) or end.code < SIGNALLED:  # a shell's completion is done
            raise
        _leave("terminated", end.code)
    except Exception as failure:  # whatever it is, no traceback reaches a user who has not asked for it
        if os.environ.get(TRACEBACK):
            print_exc()
        _leave(*describe_failure(failure), as_json="--json" in arguments)
    sys.exit(status)


def run(arguments: list[str]) -> int:
    """Run a command and return its status."""
    status, command = 0, typer.main.get_command(app)
    if COMPLETE in os.environ:
        command.main(arguments, prog_name="skincad")
    safe_point()
    try:
        with command.make_context("skincad", arguments) as context:
            command.invoke(context)
    except typer.Exit as end:
        status = end.exit_code
    except InputError as failure:
        raise _by_flag(failure, _parameters(command, arguments)) from None
    sys.stdout.flush()
    return status


def _parameters(command: Any, arguments: list[str]) -> dict[str, str]:
    """What a person calls the parameters of the subcommand that was asked for, by their names in Python."""
    subcommand = next(
        (command.commands[argument] for argument in arguments if argument in command.commands), command
    )
    written = [word.partition("=")[0] for word in arguments]

    def called(parameter: Any) -> str:
        if not parameter.opts[0].startswith("-"):
            return str(parameter.metavar or parameter.name)
        flags = sorted(parameter.opts, key=len, reverse=True)
        return str(next((flag for flag in flags if flag in written), flags[0]))

    return {parameter.name: called(parameter) for parameter in subcommand.params}


def _by_flag(failure: InputError, flags: dict[str, str]) -> InputError:
    """Return the error with an argument's name as its flag: `force` as `--force`."""
    others = tuple(_by_flag(other, flags) for other in failure.others)
    key = flags.get(failure.key, failure.key)
    return InputError(key, failure.rule, failure.value, failure.remedy, others)


def describe_failure(failure: Exception) -> tuple[str, int]:
    """Return the line that describes a failure not caused by input, and its exit status."""
    if lacking := exhausted(failure):
        return f"out of {lacking} ({str(failure) or type(failure).__name__}); allow more, or ask for less", 3
    if isinstance(failure, RefusedError):
        return str(failure), 3 if isinstance(failure, ExhaustedError | FaultError) else 1
    what = f"internal error: {type(failure).__name__}: {failure}"
    return f"{what}; please report it with its traceback, which {TRACEBACK}=1 shows", 3


def _leave(message: str, status: int, *, as_json: bool = False) -> NoReturn:
    """Exit with a line on stderr, and the same as an object on stdout where that is asked for."""
    line = shown(" ".join(message.split()))
    _say(sys.stdout, json.dumps({"passed": False, "error": line}) + "\n" if as_json else "")
    _say(sys.stderr, f"skincad: {line}\n")
    sys.exit(status)


def _say(stream: TextIO, text: str) -> None:
    """Write where that can be; if the stream is closed, the exit status still says it."""
    try:
        stream.write(text)
        stream.flush()
    except OSError:
        _drop(stream)


def _drop(stream: TextIO) -> None:
    """Drop whatever is still to be written to a stream, so that Python doesn't fail at its end by trying."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
