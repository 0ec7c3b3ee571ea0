"""The process that `skincad` and `python -m skincad` start: its descriptors, its streams, its signals.

A signal's exception inside the import of a C extension leaves the extension half made: it comes back as an
ImportError, or the process crashes. So a signal waits until no import is under way, nor anything else that
must not be broken off, and breaks in only where the command line catches it.
"""

from __future__ import annotations

import codecs
import io
import os
import signal
import sys
from types import FrameType

SOON = 0.0003  # s, until a signal that had to wait is looked at again: no command is done so fast
# functions that are not broken off: imports, what runs where an exception would be lost, and the places where
# an out folder is tried, put in place or removed
WHOLE = {"_find_and_load", "__del__", "_try_to_write", "_put_in_place", "_settle", "_discard"}
BREAKS_IN = ("skincad.cli", "run")


def main() -> None:
    """Run the command line as a process of its own."""
    for signum in (signal.SIGINT, signal.SIGTERM):
        if (
            signal.getsignal(signum) is not signal.SIG_IGN
        ):  # as a shell has it for what runs in the background
            signal.signal(signum, _received)
    _open_streams()
    from skincad.cli import main as command

    try:
        command()
    finally:  # all is said and done: nothing breaks into Python's own end
        for signum in (signal.SIGINT, signal.SIGTERM, signal.SIGALRM):
            signal.signal(signum, signal.SIG_IGN)


def _received(signum: int, frame: FrameType | None) -> None:
    """Break into the command if it may be broken here, else look again soon."""
    inside = False
    while frame is not None:
        if frame.f_code.co_name in WHOLE:
            inside = False
            break
        inside = inside or (frame.f_globals.get("__name__"), frame.f_code.co_name) == BREAKS_IN
        frame = frame.f_back
    if not inside:
        signal.signal(signal.SIGALRM, lambda _, later: _received(signum, later))
        signal.setitimer(signal.ITIMER_REAL, SOON)
    elif signum == signal.SIGINT:
        raise KeyboardInterrupt
    else:
        sys.exit(128 + signum)


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
    """Handle what an encoding lacks, as a codec's errors: "±" becomes "+-", any other letter its escape."""
    if isinstance(failure, UnicodeEncodeError):
        if failure.object[failure.start] == "±":
            return "+-", failure.start + 1
        failure.end = failure.start + 1
    return codecs.backslashreplace_errors(failure)


if __name__ == "__main__":
    main()
