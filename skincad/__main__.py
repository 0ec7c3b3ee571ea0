"""The process that `skincad` and `python -m skincad` start: its signals, its descriptors, its streams."""

from __future__ import annotations

import codecs
import io
import os
import sys

from skincad.base.interrupt import ignore, listen

# what a terminal without these letters gets: a bar's eighths as the nearest of nine digits, 0 without load
IN_ASCII = {"±": "+-", **dict(zip("·▁▂▃▄▅▆▇█", "012346789", strict=True))}


def main() -> None:
    """Run the command line as a process of its own."""
    listen()
    _open_streams()
    from skincad.cli import main as command

    try:
        command()
    finally:  # nothing breaks into Python's own end
        ignore()


def _open_streams() -> None:
    """Give closed standard streams to nobody, and escape what a stream cannot show.

    A file that is opened takes the lowest descriptor that is free: without this it would get what libraries
    print to a closed stdout or stderr.
    """
    for descriptor in range(3):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    codecs.register_error("escape", escaped)
    sys.stdout = sys.stdout or os.fdopen(1, "w", encoding="utf-8")
    sys.stderr = sys.stderr or os.fdopen(2, "w", encoding="utf-8")
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="escape")


def escaped(failure: UnicodeError) -> tuple[str | bytes, int]:
    """Handle what an encoding lacks, as a codec's errors: by IN_ASCII, any other letter as its escape."""
    if isinstance(failure, UnicodeEncodeError):
        if letter := IN_ASCII.get(failure.object[failure.start]):
            return letter, failure.start + 1
        failure.end = failure.start + 1
    return codecs.backslashreplace_errors(failure)


if __name__ == "__main__":
    main()
