"""A pseudo-terminal that a board's lines come from in real time."""

from __future__ import annotations

import os
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Event, Thread

import numpy as np


@contextmanager
def board(head: str, values: np.ndarray, rate: float) -> Iterator[str]:
    """Yield a port that gives samples `values` `(n, channels)` V again and again, once somebody reads."""
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    over = Event()
    tails = ["".join(f",{value:.6f}" for value in row) for row in values.tolist()]

    def send() -> None:
        sent, began = 0, time.monotonic()
        while not over.wait(0.01):
            due = round(rate * (time.monotonic() - began))
            lines = [f"{k}{tails[k % len(tails)]}\n" for k in range(sent, due)]
            again = f"{head}\n" if sent == 0 or due // int(rate) > sent // int(rate) else ""
            data = memoryview((again + "".join(lines)).encode())
            try:
                while data and not over.is_set():
                    data = data[os.write(ours, data) :]
            except BlockingIOError:  # nobody reads: a board goes on sampling
                pass
            sent = due

    os.set_blocking(ours, False)
    sender = Thread(target=send, daemon=True)
    sender.start()
    try:
        yield os.ttyname(theirs)
    finally:
        over.set()
        sender.join(timeout=10)
        os.close(theirs)
        os.close(ours)
