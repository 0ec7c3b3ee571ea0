"""What else could give the paper's slopes: each reading's distance from its statements, with all of it free.

`python -m bench.table_readings` fits each reading to 20 dB/dec up to 1.2 kHz and 60 above, from 10 Hz to
8 kHz, level free, and prints dB rms with the constants that were found. By `film` the motional capacitance is
at most 0.1 of the static one, as PVDF has it; by `any` it is free.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import least_squares
from threadpoolctl import threadpool_limits

from skincad.circuit import (
    ANY_RATIO,
    BOUNDS,
    FILM_RATIO,
    FITTED,
    Complex,
    Constants,
    Real,
    decibels,
    paper_target,
)
from skincad.circuit.network import network
from skincad.circuit.response import response
from tests.circuit.paper import printed_response

STARTS, SEED, STEPS = 24, 2002, 300  # as the calibration's
FREQUENCY, WANTED = paper_target()
Ranges = dict[str, tuple[float, float]]


def free(ratio: float) -> Ranges:
    """The network's constants, within the calibration's bounds."""
    return {name: BOUNDS[name] for name in FITTED} | {"motional_capacitance": (1e-6, ratio)}


def solved(values: dict[str, float]) -> Complex:
    """The paper's network, solved."""
    return response(network(made(values)), FREQUENCY)


def printed(values: dict[str, float]) -> Complex:
    """The paper's closed form, as printed."""
    return printed_response(made(values), FREQUENCY)


def refinement(values: dict[str, float]) -> Complex:
    """A film behind one resonance that passes the load, or the charge, on."""
    return rate() / pressed(values["resonance"], values["damping"])


def rigged(values: dict[str, float]) -> Complex:
    """A film under a probe whose sensor reads less, the indenter at 9 kHz before it."""
    sensor = pressed(values["resonance"], values["damping"])
    return rate() * sensor / pressed(9000.0, values["indenter"])


def made(values: dict[str, float]) -> Constants:
    """Constants of fitted values, the motional capacitance as a ratio."""
    whole = {**values, "motional_capacitance": values["motional_capacitance"] * values["capacitance"]}
    return Constants(d33=-33e-12, **whole)


def rate() -> Complex:
    """20 dB/dec."""
    return np.asarray(2j * np.pi * FREQUENCY)


def pressed(own: float, damping: float) -> Complex:
    """A mass on a damped spring, its load by that of the spring."""
    ratio = FREQUENCY / own
    return np.asarray(1 - ratio**2 + 2j * damping * ratio)


READINGS: dict[str, tuple[Callable[[dict[str, float]], Complex], Ranges]] = {
    "network, film": (solved, free(FILM_RATIO)),
    "network, any": (solved, free(ANY_RATIO)),
    "closed form as printed, film": (printed, free(FILM_RATIO)),
    "closed form as printed, any": (printed, free(ANY_RATIO)),
    "one resonance above 8 kHz": (refinement, {"resonance": (8100.0, 1e5), "damping": (1e-3, 5.0)}),
    "rig": (rigged, {"resonance": (300.0, 5000.0), "damping": (0.01, 5.0), "indenter": (0.3, 2.0)}),
    "rig, a sensor of metal alone": (
        rigged, {"resonance": (300.0, 5000.0), "damping": (0.01, 0.05), "indenter": (0.3, 2.0)},
    ),
}  # fmt: skip


def fitted(way: Callable[[dict[str, float]], Complex], ranges: Ranges) -> tuple[float, dict[str, float]]:
    """Return the least distance, dB rms, and its values: logarithms, from STARTS points drawn evenly."""
    low, high = np.log(list(ranges.values())).T

    def values(point: Real) -> dict[str, float]:
        return dict(zip(ranges, np.exp(point).tolist(), strict=True))

    def misfit(point: Real) -> Real:
        rest = decibels(way(values(point))) - WANTED
        return np.asarray(rest - rest.mean())

    draw = np.random.default_rng(SEED)
    runs = [
        least_squares(
            misfit, draw.uniform(low, high), bounds=(low, high), x_scale="jac", max_nfev=STEPS, diff_step=1e-6
        )
        for _ in range(STARTS)
    ]
    best = min(runs, key=lambda run: run.cost)
    return float(np.std(best.fun)), values(best.x)


def main() -> None:
    for name, (way, ranges) in READINGS.items():
        rms, found = fitted(way, ranges)
        print(
            f"{name:30} {rms:6.2f} dB rms: " + ", ".join(f"{k} {v:.3g}" for k, v in found.items()), flush=True
        )


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
