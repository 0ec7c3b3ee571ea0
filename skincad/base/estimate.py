"""A number with its error, and the unit system.

Lengths are mm, forces N, stresses MPa, times s, masses tonne; `circuit/` alone uses SI.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from numbers import Real

from skincad.base.errors import UnclearError

ROUGH = 0.25  # of its value: an error beyond it is better read as a range


@dataclass(frozen=True, slots=True)
class Estimate:
    """A value with the half-width of the interval that it is claimed to lie in.

    `value` is None where there is no such number (ridges that cannot all touch have no smallest
    force), `error` is None where nobody has estimated it yet. Raises ValueError for an error below 0 and for
    numbers that are not finite: whoever computes one has made a mistake, and must not hand it on.

    `float(estimate)` is the value; ValueError where there is none. `<`, `<=`, `>` and `>=` with a number say
    what holds all over the interval; where the interval holds the number, or value or error are unknown, they
    raise UnclearError, so that no `if` silently takes a branch. `==` compares value, error and unit.
    """

    value: float | None
    error: float | None
    unit: str

    def __post_init__(self) -> None:
        if self.error is not None and not 0 <= self.error < math.inf:
            raise ValueError(f"an error must be finite and not below 0, got {self.error}")
        if self.value is not None and not math.isfinite(self.value):
            raise ValueError(f"a value must be finite, or None, got {self.value}")

    @property
    def lower(self) -> float | None:
        """The smallest value that the error allows; None while value or error are unknown."""
        return None if self.value is None or self.error is None else self.value - self.error

    @property
    def upper(self) -> float | None:
        """The largest value that the error allows; None while value or error are unknown."""
        return None if self.value is None or self.error is None else self.value + self.error

    def __float__(self) -> float:
        if self.value is None:
            raise ValueError("this estimate has no value: there is no such number")
        return self.value

    def __lt__(self, number: float) -> bool:
        return self._clearly_below(number, False)

    def __le__(self, number: float) -> bool:
        return self._clearly_below(number, True)

    def __gt__(self, number: float) -> bool:
        return not self <= number

    def __ge__(self, number: float) -> bool:
        return not self < number

    def _clearly_below(self, number: float, equal: bool) -> bool:
        """Whether all of the interval lies below a number, or, with `equal`, on it; False where none does."""
        if not isinstance(number, Real):
            raise TypeError(f"an estimate compares with a number, not with {type(number).__name__}")
        lower, upper = self.lower, self.upper
        if lower is not None and upper is not None:
            if upper < number or (equal and upper == number):
                return True
            if lower > number or (not equal and lower == number):
                return False
        between = f"whether {self} is above or below {float(number):g} {self.unit}"
        raise UnclearError(f"{between} is unclear; compare its value, lower or upper")

    def within(self, lowest: float, highest: float) -> Estimate:
        """Return what of the interval lies in a range, and its middle; itself where all of it does or is
        unknown, as much of the range next to its nearer end as the error where nothing does."""
        if self.lower is None or self.upper is None or lowest <= self.lower <= self.upper <= highest:
            return self
        low, high = (min(max(end, lowest), highest) for end in (self.lower, self.upper))
        if low == high:
            low, high = max(low - (self.error or 0.0), lowest), min(high + (self.error or 0.0), highest)
        return Estimate((low + high) / 2, (high - low) / 2, self.unit)

    def as_json(self) -> dict[str, float | None]:
        """Return `{"value", "error"}`; the unit is the key's suffix."""
        return {"value": self.value, "error": self.error}

    def span(self, lowest: float = 0.0, rough: float = ROUGH) -> str:
        """Return a rough number as `70 to 890 EUR`: where the error is more than `rough` of it, and from
        `lowest` on; else as `str` does."""
        if self.value is None or self.error is None or self.error <= rough * abs(self.value):
            return str(self)
        low, high = max(lowest, self.value - self.error), self.value + self.error
        digits = 1 - math.floor(math.log10(max(abs(low), abs(high))))
        places = max(0, digits)
        return f"{round(low, digits):.{places}f} to {round(high, digits):.{places}f} {self.unit}"

    def __str__(self) -> str:
        if self.value is None:
            return "none"
        if not self.error:
            return f"{self.value:.4g} {self.unit}"
        places = _places(self.error)
        return f"{self.value:.{places}f} ± {self.error:.{places}f} {self.unit}"


def _places(error: float) -> int:
    """Decimals that show the first two digits of the error."""
    return max(0, min(9, 1 - int(f"{error:e}".split("e")[1])))
