"""What the package's text files share: how numbers are written."""

from __future__ import annotations

from collections.abc import Iterable

DIGITS = 12  # of a number; what is smaller by more than that than the largest beside it is rounding


def numbers(values: Iterable[float]) -> str:
    """Return numbers as words apart by a space, to DIGITS digits of the largest."""
    all_of_them = [float(value) for value in values]
    least = 10.0**-DIGITS * max(map(abs, all_of_them), default=0.0)
    return " ".join(f"{0.0 if abs(value) < least else value:.{DIGITS}g}" for value in all_of_them)


def exactly(values: Iterable[float]) -> str:
    """Return numbers as words apart by a space, each the shortest that reads back as the same double."""
    return " ".join(repr(float(value) + 0.0) for value in values)
