"""The exponential of a small matrix whose rates lie many powers of ten apart.

Scaling and squaring loses as many digits of the slow rates as the fastest is faster: 1e10 times leaves six of
sixteen. In decimal numbers of 120 digits the slow ones keep all of double's for rates 1e60 apart, and a
6 x 6 matrix takes some 20 ms.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

from skincad.base.errors import RefusedError
from skincad.circuit.network import Real

DIGITS = 120
MOST_SQUARINGS = 200  # 2^200 is 1e60: half of the digits

Rows = list[list[Decimal]]


def exponential(matrix: Real) -> Real:
    """Return the exponential of a matrix `(n, n)`, rounded to double precision.

    Taylor series of the matrix over a power of 2, then squared back. Raises RefusedError for entries that are
    not finite or that need more than 200 squarings.
    """
    size = float(np.abs(matrix).sum(axis=1).max())
    squarings = max(0, int(np.ceil(np.log2(size))) + 1) if 0 < size < np.inf else 0
    if not np.isfinite(size) or squarings > MOST_SQUARINGS:
        raise RefusedError(f"a step of {size:.3g} times the network's fastest time is too long")
    with localcontext() as context:
        context.prec = DIGITS
        scaled = [[Decimal(float(entry)) / 2**squarings for entry in row] for row in matrix]
        total = _series(scaled)
        for _ in range(squarings):
            total = _product(total, total)
        return np.array([[float(entry) for entry in row] for row in total])


def _series(scaled: Rows) -> Rows:
    """The Taylor series of a matrix of norm up to 1/2: each term is at most half the one before."""
    count = len(scaled)
    total = [[Decimal(int(i == j)) for j in range(count)] for i in range(count)]
    term, order = total, 0
    while any(abs(entry) > Decimal(10) ** -DIGITS for row in term for entry in row):
        order += 1
        term = [[entry / order for entry in row] for row in _product(term, scaled)]
        total = [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(total, term, strict=True)]
    return total


def _product(a: Rows, b: Rows) -> Rows:
    columns = list(zip(*b, strict=True))
    return [[sum((x * y for x, y in zip(r, c, strict=True)), Decimal(0)) for c in columns] for r in a]
