"""What arrays hold: Array numbers, Index positions or numbers of things, Mask true or false."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]
