"""Records of ridges that all stick: outputs that follow two loads, which run and stop, jump and turn.

No scene marches so abruptly; a detector must not take a load that stops or turns round for a slip.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from skincad.circuit import band_limited

RATE, BAND = 1e5, 5e3  # Hz
STEPS, COUNT = 600, 60
MOST = 5  # ridges, two at least


def sticking() -> Iterator[tuple[np.ndarray, float]]:
    """Yield outputs `(n, ridges, 2)` with noise, and the noise of a pair, rms."""
    draw = np.random.default_rng(31)
    time = np.arange(STEPS) / RATE
    for _ in range(COUNT):
        ridges = int(draw.integers(2, MOST + 1))
        pull, press = (band_limited(time, _load(draw), BAND).value for _ in range(2))
        press = press * draw.choice([0.0, 0.1, 1.0])
        pair = pull[:, None] * draw.uniform(0.5, 1.2, ridges)
        pair += press[:, None] * draw.uniform(-0.2, 0.2, ridges)
        total = press[:, None] * draw.uniform(0.5, 1.2, ridges) * draw.choice([1.0, 3.0])
        noise = 10 ** draw.uniform(-3, -2)
        outputs = np.stack([total + pair, total - pair], axis=2) / 2
        yield outputs + draw.normal(0, noise / np.sqrt(2), outputs.shape), float(noise)


def _load(draw: np.random.Generator) -> np.ndarray:
    """Return a rate that is constant from time to time, or runs straight from value to value; often 0."""
    at = np.sort(draw.integers(5, STEPS, draw.integers(2, 7)))
    values = draw.uniform(-1, 1, at.size + 1) * (draw.random(at.size + 1) < 0.75)
    if draw.random() < 0.3:
        return np.interp(np.arange(STEPS), at, values[1:])
    values[0] = 0.0
    return values[np.searchsorted(at, np.arange(STEPS), side="right")]
