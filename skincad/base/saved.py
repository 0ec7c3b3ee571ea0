"""When a person saves a file: files are looked at a few times a second, which any file system allows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from time import sleep

from skincad.base.interrupt import safe_point

POLL = 0.2  # s, assumption: no wait that a person notices, and next to no work


def saves(files: Sequence[Path]) -> Iterator[None]:
    """Yield at once, and again whenever a file has changed and all lie at rest for `POLL` s; for ever.

    A file that is away, as while an editor replaces it, is waited for. What is saved while the caller works
    on the last save is not missed.
    """
    seen: list[tuple[int, int]] | None = None
    while True:
        safe_point()
        now = _stamps(files)
        if now is not None and now != seen:
            sleep(POLL if seen else 0.0)
            if _stamps(files) == now:
                seen = now
                yield
                continue
        sleep(POLL)


def _stamps(files: Sequence[Path]) -> list[tuple[int, int]] | None:
    """When each file was written, ns, and its bytes; None while one is away."""
    try:
        return [(status.st_mtime_ns, status.st_size) for status in (file.stat() for file in files)]
    except FileNotFoundError:
        return None
