"""What a law's energy in plane strain has more than neo-Hooke's; laws are in skincad/laws.

Bodies have neo-Hooke's energy with the volume's part (neo_hooke.py) and add this, so that they are
neo-Hooke's to the last digit where no law is given, and have the same small strain whatever the law.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any, NamedTuple

import ngsolve as ng

from skincad.laws.rubber import Rubber

PLAIN = ((1.0, 2.0),)  # neo-Hooke's powers
# Of (d / s)^2 below, up to which a power of both stretches is summed as a series. With TERMS the series is
# exact to 2e-14 for powers from -14 to 14; above, the root's second derivative loses 3 digits at most
NEAR, TERMS = 0.01, 11


class Functions(NamedTuple):
    """Functions of symbols or of arrays; `positive(c, a, b)` is a where c is above 0, and b elsewhere."""

    exp: Callable[[Any], Any] = ng.exp
    log: Callable[[Any], Any] = ng.log
    sqrt: Callable[[Any], Any] = ng.sqrt
    positive: Callable[[Any, Any, Any], Any] = ng.IfPos


SYMBOLS = Functions()
NO_LAWS: Mapping[str, Rubber] = MappingProxyType({})


def excess(law: Rubber, h: Any, of: Functions = SYMBOLS) -> Any:
    """Return the energy density beyond neo-Hooke's, in units of the law's own shear modulus, in terms of the
    displacement gradient `h[i, j]` of two dimensions. Infinite or nan where the law ends."""
    trace, minor = h[0, 0] + h[1, 1], h[0, 0] * h[1, 1] - h[0, 1] * h[1, 0]
    squares = h[0, 0] * h[0, 0] + h[1, 1] * h[1, 1] + h[0, 1] * h[0, 1] + h[1, 0] * h[1, 0]
    volume = 1 + trace + minor
    logarithm = of.log(volume)
    plain = squares / 2 + trace - logarithm
    if law.powers == PLAIN:
        return law.energy(plain, of) - plain
    middle = 1 + trace + squares / 2  # of the two stretches' squares
    first = h[0, 0] - h[1, 1] + (h[0, 0] ** 2 + h[1, 0] ** 2 - h[0, 1] ** 2 - h[1, 1] ** 2) / 2
    second = h[0, 1] + h[1, 0] + h[0, 0] * h[0, 1] + h[1, 0] * h[1, 1]
    difference = (first * first + second * second) / (
        middle * middle
    )  # (d / s)^2, squares are s + d and s - d
    measure = 0
    for share, power in law.powers:
        both = _both(middle, difference, volume, power / 2, of)
        measure = measure + share * (2 / power**2 * both - 2 / power * logarithm)
    return law.energy(measure, of) - plain


def _both(middle: Any, difference: Any, volume: Any, half: float, of: Functions) -> Any:
    """Return (s + d)^b + (s - d)^b - 2, with s - d as J^2 / (s + d), which keeps its digits."""
    series, chosen = 0.0, [1.0]  # binomials; scipy's are nan for negative integers
    for i in range(2 * TERMS - 2):
        chosen.append(chosen[-1] * (half - i) / (i + 1))
    for binomial in chosen[:0:-2]:
        series = difference * (series + binomial)
    near = 2 * (1 + series) * of.exp(half * of.log(middle))
    root = of.sqrt(of.positive(difference - NEAR, difference, 1.0 + 0 * difference))
    large = of.log(middle * (1 + root))
    far = of.exp(half * large) + of.exp(half * (2 * of.log(volume) - large))
    return of.positive(difference - NEAR, far, near) - 2
