"""Time of a print of resin: layers are exposed whole, however much of them is filled.

So the time is the height's, and that of a plate its tallest part's.
"""

from __future__ import annotations

import math

from skincad.inputs.process import Process


def exposure_time(height: float, process: Process) -> float:
    """Return how long the layers of a height in mm take, s: the first ones longer, the next ones fading to
    the usual exposure in equal steps, as PrusaSlicer has them; each with its lift."""
    layers = max(1, round(height / process.layer))
    first = min(layers, process.first_layers)
    fading = min(layers - first, process.fading)
    step = (process.first_exposure - process.exposure) / (process.fading + 1)
    faded = math.fsum(process.first_exposure - number * step for number in range(1, fading + 1))
    rest = (layers - first - fading) * process.exposure
    return first * process.first_exposure + faded + rest + layers * process.lift
