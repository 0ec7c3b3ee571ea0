"""Does a lead time that a study found hold: with noise, at half the time step, on a finer mesh?

`python -m bench.lead_times SCENE.toml ...` simulates each scene as the study did; with the noise of SEEDS
seeds that no study saw; at twice the steps; and on finer meshes. It prints the warning's lead time, the false
alarms, and of the noise the median with its 5th percentile and how often nothing false was told.
"""

from __future__ import annotations

import argparse

import numpy as np

import skincad
from skincad.scenes import Scene, Simulation, marched, read_out, simulate

SEEDS = range(1000, 1020)
FINE = 0.01  # of the largest differential stress


def told(found: Simulation) -> str:
    """Return the warning's lead time of a simulation, and its false alarms."""
    ahead = found.read["warning_lead_time_s"]
    return f"{'none' if ahead is None else f'{1e3 * ahead:.3g} ms'}, {false_of(found)} false"


def false_of(found: Simulation) -> int:
    """Return the number of warnings that are false, and of alarms of a ridge while nothing slips."""
    return sum(found.read[key]["false"] for key in ("warning_score", "event_score"))


def noisy(scene: Scene) -> str:
    """Return what the noise of SEEDS leaves of a scene's lead time."""
    march, leads, clean = marched(scene), list[float](), 0
    for seed in SEEDS:
        answer = read_out(
            scene.with_(effects={"piezo": {**scene.effects["piezo"], "noise_seed": seed}}), march
        )
        leads.append(1e3 * (answer.read["warning_lead_time_s"] or 0.0))
        clean += not false_of(answer)
    low, middle = np.percentile(leads, (5, 50))
    return f"median {middle:.3g} ms, 5th percentile {low:.3g} ms; no false alarm in {clean} of {len(SEEDS)}"


def main() -> None:
    """Print what holds of each scene's lead time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="+", metavar="SCENE", help="a template or a TOML file")
    for source in parser.parse_args().scenes:
        scene = skincad.load_scene(source)
        half = scene.with_(history={"steps": 2 * scene.history.steps})
        print(f"{source}:")
        print(f"  as found       {told(simulate(scene))}")
        print(f"  half the step  {told(simulate(half))}")
        print(f"  finer mesh     {told(simulate(scene.with_(effects={'small_strain': {}}), tol=FINE))}")
        print(f"  with noise     {noisy(scene)}", flush=True)


if __name__ == "__main__":
    main()
