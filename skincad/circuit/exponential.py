"""The exponential of a small matrix whose rates lie many powers of ten apart.

Scaling and squaring loses as many digits of the slow rates as the fastest is faster: 1e10 times leaves six of
sixteen. In decimal numbers of 120 digits the slow ones keep all of double's for rates 1e60 apart, and a
6 x 6 matrix takes some 20 ms.
"""

from __future__ import annotations

from decimal import Decimal, localcontext

import numpy as np

from skincad.base.errors import RefusedError
from skincad.circuit.elements import Real

DIGITS = 120
MOST_SQUARINGS = 200  # 2^200 is 1e60: half of the digits


def exponential(matrix: Real) -> Real:
    """Return the exponential of a matrix `(n, n)`, rounded to double precision.

    Taylor series of the matrix over a power of 2, so that each term is at most half the one before, then
    squared back. Raises RefusedError for entries that are not finite or that need more than 200 squarings.
    """
    size = float(np.abs(matrix).sum(axis=1).max())
    squarings = max(0, int(np.ceil(np.log2(size))) + 1) if 0 < size < np.inf else 0
    if not np.isfinite(size) or squarings > MOST_SQUARINGS:
        raise RefusedError(f"a step of {size:.3g} times the network's fastest time is too long")
    with localcontext() as context:
        context.prec = DIGITS
        scaled = np.array([[Decimal(float(x)) / 2**squarings for x in row] for row in matrix])
        term = total = np.eye(len(matrix), dtype=int) * Decimal(1)
        order = 0
        while np.abs(term).max() > Decimal(10) ** -DIGITS:
            order += 1
            term = term @ scaled / order
            total = total + term
        for _ in range(squarings):
            total = total @ total
        return np.asarray(total.astype(float))
