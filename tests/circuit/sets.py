"""Random constants within the calibration's bounds, and a network's output from rest."""

from __future__ import annotations

import numpy as np

from skincad.circuit import BOUNDS, Constants, Network, run, state_space, stepper


def random_sets(count: int, seed: int = 6) -> list[Constants]:
    """Return constants drawn evenly in their logarithms."""
    draw, sets = np.random.default_rng(seed), []
    for _ in range(count):
        values = {name: float(np.exp(draw.uniform(*np.log(bounds)))) for name, bounds in BOUNDS.items()}
        values["motional_capacitance"] *= values["capacitance"]
        sets.append(Constants(d33=-33e-12, **values))
    return sets


def state_response(network: Network, charge: float, frequency: np.ndarray) -> np.ndarray:
    """Return the response `(n,)` V/N of the state equations, solved at jw, to `charge` C/N."""
    s = state_space(network)
    rows = 2j * np.pi * frequency[:, None, None] * np.eye(s.b.size) - s.a
    return np.asarray(np.linalg.solve(rows, s.b[:, None] * charge)[:, :, 0] @ s.c + s.d * charge)


def output(network: Network, charge: np.ndarray, rate: float) -> np.ndarray:
    """Return the output `(n,)` V for a charge `(n,)` C sampled at `rate` Hz, at rest before."""
    return run(stepper(network, rate), charge)[0]
