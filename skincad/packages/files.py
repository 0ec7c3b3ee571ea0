"""What the package's text files share: numbers as their shortest text that reads back the same."""

from __future__ import annotations

from collections.abc import Iterable


def numbers(values: Iterable[float]) -> str:
    """Return numbers as words apart by a space, each the shortest that reads back as the same double."""
    return " ".join(repr(float(value) + 0.0) for value in values)
