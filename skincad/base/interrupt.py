"""Ctrl-C and SIGTERM: a signal sets a flag, and work ends at its next safe point.

An exception in the middle of anything else could leave a C extension half imported, or a folder half moved. A
second signal ends the process at once.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from types import FrameType

INTERRUPTED = 130  # the exit status after Ctrl-C
SIGNALS = (signal.SIGINT, signal.SIGTERM)
_pending: list[int] = []  # the signal that was received and has not ended anything yet


def listen() -> None:
    """Take note of signals from now on.

    One that is ignored stays so, as a shell has it for what runs in the background.
    """
    for signum in SIGNALS:
        if signal.getsignal(signum) is not signal.SIG_IGN:
            signal.signal(signum, _received)


@contextmanager
def at_once() -> Iterator[None]:
    """Let a signal end what waits for a person's answer: nothing is half done meanwhile."""

    def end(signum: int, _: FrameType | None) -> None:
        _pending.append(signum)
        safe_point()

    before = {signum: signal.getsignal(signum) for signum in SIGNALS}
    for signum, handler in before.items():
        if handler is _received:
            signal.signal(signum, end)
    try:
        yield
    finally:
        for signum, handler in before.items():
            signal.signal(signum, handler)


def ignore() -> None:
    """Let no signal break into what is left: all is said and done."""
    for signum in SIGNALS:
        signal.signal(signum, signal.SIG_IGN)


def safe_point() -> None:
    """Raise KeyboardInterrupt, or SystemExit after SIGTERM, if a signal was received. Nothing is half done
    here: loops that take long call it in each round."""
    if _pending and current_thread() is main_thread():
        signum = _pending.pop()
        if signum == signal.SIGINT:
            raise KeyboardInterrupt
        sys.exit(128 + signum)


def _received(signum: int, _: FrameType | None) -> None:
    if _pending:
        signal.signal(signum, signal.SIG_DFL)
        signal.raise_signal(signum)
    _pending.append(signum)
