"""The slip story by the plate's mass: `python -m bench.table_plate_mass`.

`yamada-2002-slip` on the coarse mesh, quasi-static, with masses of skin and plate, viscous alone. The pull
goes on for 1 ms after the paper's 550 steps, for masses are late. A row: the largest normal force that the
skin feels; the steps from which ridges 1 to 9 slip for good, and all slip; the peak of ridge 3's band-limited
rate after pulling has begun again; the largest change of its differential stress from the quasi-static one by
step 550, by that one's largest; and what energy is missing, by the work. The paper's story is slip that runs
inward from both sides to about step 550: no single number tells it from the slip of a plate that bounces, so
read the steps beside the largest normal force.
"""

from __future__ import annotations

from time import perf_counter

import numpy as np

from skincad.scenes import LEVELS, Simulation, at_level, load_scene

SCENE = "yamada-2002-slip"
MASSES = (0.1, 1.0, 10.0, 400.0)  # g
PULLS_AGAIN = 0.0045  # s; the paper's step 450
LONGER = (
    "history.steps=650",
    "history.time_s=[0.0, 0.001, 0.002, 0.003, 0.0033, 0.0045, 0.0055, 0.0065]",
    "history.normal_force_N=[0.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]",
    "history.tangential_force_N=[0.0, 0.0, 3.4, 3.4, 2.6, 3.2, 4.0, 4.8]",
)
VISCOUS = "effects.viscosity={}"


def told(name: str, found: Simulation, still: Simulation, seconds: float) -> str:
    """Return a row."""
    time = found.march.time
    signal = found.signals[3]
    late = time >= PULLS_AGAIN
    peak = float(np.abs(signal.rate[late]).max()) if late.any() else float("nan")
    here = min(found.raw[3].size, still.raw[3].size)
    change = np.abs(found.raw[3][:here] - still.raw[3][:here]).max() / np.abs(still.raw[3]).max()
    steps = " ".join("-" if s is None else str(s) for s in found.slip_steps)
    gross = "-" if found.gross_slip_step is None else str(found.gross_slip_step)
    largest = float(found.march.column("normal").max())
    missing = found.energy["imbalance"]
    return (
        f"{name:24}{largest:8.3f}  {steps:38}{gross:>6}{peak:10.1f}{change:9.1%}{missing:10.1e}{seconds:8.0f}"
    )


def main() -> None:
    runs: dict[str, list[str]] = {"quasi-static": []}
    runs |= {f"{m:g} g": ["effects.inertia={}", VISCOUS, f"plate.mass={m}"] for m in MASSES}
    runs["viscous"] = [VISCOUS]
    print(
        f"{'':24}{'N max':>8}  {'ridges slip from step':38}{'gross':>6}{'MPa/s':>10}{'change':>9}"
        f"{'energy':>10}{'s':>8}"
    )
    still: Simulation | None = None
    for name, overrides in runs.items():
        began = perf_counter()
        answer = at_level(load_scene(SCENE, [*LONGER, *overrides]), LEVELS[0])
        still = still or answer
        print(told(name, answer, still, perf_counter() - began), flush=True)


if __name__ == "__main__":
    main()
