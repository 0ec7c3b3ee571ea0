"""The circuit's solvers as ratios to one pass of scipy's lfilter (order 4) over the same number of points.

`python -m bench.bench_circuit` prints times of one run on one BLAS thread.
"""

from __future__ import annotations

import numpy as np
from scipy.signal import butter, lfilter
from threadpoolctl import threadpool_limits

from bench.measure import best
from skincad.circuit import band_limited, circuit_network, load_circuit, noise_samples, recorded, run, stepper
from skincad.circuit.response import response
from skincad.scenes import fed
from skincad.scenes.detector import at_rest, detector


def main() -> None:
    """Print the table."""
    network = circuit_network(load_circuit("yamada-2002"))
    numerator, denominator = butter(4, 0.1)
    print(f"{'what':42} {'points':>8} {'s':>7} {'lfilter, s':>10} {'ratio':>7}")
    for points in (100_000, 1_000_000):
        charge = network.charge * np.random.default_rng(1).standard_normal(points).cumsum()
        frequency = np.geomspace(10.0, 20_000.0, points)
        step = stepper(network, 1e5)
        unit = best(lambda x=charge: lfilter(numerator, denominator, x))
        works = {
            "response by the node equations": lambda f=frequency: response(network, f),
            "time response, exact first-order hold": lambda q=charge, s=step: run(s, q),
            "recording at 650 Hz": lambda q=charge: recorded(q, 1e5, 650.0),
            "low-pass, with rate and jerk": lambda q=charge: band_limited(np.arange(q.size) / 1e5, q, 5e3),
            "noise samples": lambda n=points: noise_samples(network, 1e5, n, seed=1),
        }
        for name, work in works.items():
            spent = best(work)
            print(f"{name:42} {points:8d} {spent:7.3f} {unit:10.4f} {spent / unit:7.1f}")
    felt, feels = charge[:, None, None] * np.ones((1, 2, 2)), detector(1e5, 5e3, 1e-12)
    spent = best(lambda: fed(feels, at_rest(2), felt))
    print(f"{'detector of two ridges':42} {felt.shape[0]:8d} {spent:7.3f} {unit:10.4f} {spent / unit:7.1f}")
    spent = best(lambda: stepper(network, 1e5))
    print(f"{'its step, once a circuit and rate':42} {'':8} {spent:7.3f}")


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
