"""Who slips when, by which law of friction: `python -m bench.table_friction_laws [SCENE [SETTING]...]`.

Without arguments `yamada-2002-slip`, `steady-pull` and the latter with SKINS, on the coarse mesh. By a
constant shear stress, capped by Coulomb at CAP times the coefficient, that is found by marches, so that gross
slip takes what it takes by Coulomb, less LESS for it to come within the history; and by a table whose
coefficient falls with the pressure to the power of -1/3, as a Hertzian contact's does with its load, found
alike. A row: the shear stress at the mean pressure in gross slip; the steps from which ridges slip for good,
and all slip; by how many ms the first comes before; the order of slip; and the warning of the order, if there
is one.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np

from skincad.scenes import LEVELS, Scene, Simulation, at_level, load_scene

CAP = 2.0  # times the coefficient: up to half of the mean pressure Coulomb holds; from 4 on sets cycle
POWER = -1 / 3
LESS, SAME = 2e-3, 1e-3  # of the force at gross slip
TRIES = 6
PRESSURES = np.geomspace(0.005, 2.0, 14)  # MPa; the skin of the paper bears 0.1 on average, 0.4 at most
SKINS: dict[str, dict[str, dict[str, float]]] = {
    "levelled by half": {"ridge": {"levelling": 0.5}},
    "all crests level": {"ridge": {"levelling": 1.0}},
    "half as slender": {"ridge": {"height": 0.25}},
    "flatter": {"skin": {"curvature_radius": 40.0}},
}


def by_shear(stress: float, mu: float) -> dict[str, object]:
    return {"law": "shear", "shear_stress": stress, "coefficient": CAP * mu}


def by_table(stress: float, mu: float) -> dict[str, object]:
    """A coefficient that falls with pressure, from CAP times Coulomb's on; `stress` at 0.1 MPa."""
    answer = np.minimum(stress / 0.1 * (PRESSURES / 0.1) ** POWER, CAP * mu)
    return {"law": "table", "table": [[float(p), float(m)] for p, m in zip(PRESSURES, answer, strict=True)]}


Law = Callable[[float, float], dict[str, object]]  # friction's table by a shear stress, MPa, and Coulomb's mu
LAWS: dict[str, Law] = {"shear stress": by_shear, "power law": by_table}


def marched(scene: Scene, table: dict[str, object]) -> Simulation:
    return at_level(scene.with_(effects={"friction": None}).with_(effects={"friction": table}), LEVELS[0])


def calibrated(scene: Scene, law: Law, coulomb: Simulation) -> tuple[float, Simulation]:
    """Return the shear stress by which gross slip takes what it takes by Coulomb, and that march."""
    mu, last = float(scene.effects["friction"]["coefficient"]), coulomb.march.loads[-1]
    # a pull that goes on beyond, so that gross slip is reached by any law
    further = [1.3 * each for each in scene.history.tangential_force_N or []]
    longer = scene.with_(history={"tangential_force_N": further})
    stress = float(last[1].sum() / last[2].sum())
    for _ in range(TRIES):
        answer = marched(longer, law(stress, mu))
        part = float(answer.march.loads[-1][1].sum() / last[1].sum())
        if abs(part - (1 - LESS)) < SAME:
            break
        stress *= (1 - LESS) / part
    return stress, marched(scene, law(stress, mu))


def row(name: str, stress: float | None, found: Simulation) -> str:
    known = {i + 1: step for i, step in enumerate(found.slip_steps) if step is not None}
    order = " ".join(str(r) for r in sorted(known, key=lambda r: (known[r], r)))
    steps = " ".join("-" if step is None else str(step) for step in found.slip_steps)
    gross, time = found.gross_slip_step, 1e3 * found.march.time
    lead = "-" if gross is None or not known else f"{time[gross] - time[min(known.values())]:.2f}"
    said = next((w for w in found.warnings if "order of slip" in w), "")
    told = "" if stress is None else f"{stress:.4f}"
    return f"{name:14}{told:>8}  {steps:36}{gross!s:>6}{lead:>7}  {order:18} {said}"


def print_scene(name: str, scene: Scene) -> None:
    print(f"{name}\n{'':14}{'MPa':>8}  {'ridges slip from step':36}{'gross':>6}{'ms':>7}  order")
    coulomb = at_level(scene, LEVELS[0])
    print(row("Coulomb", None, coulomb), flush=True)
    for label, law in LAWS.items():
        stress, found = calibrated(scene, law, coulomb)
        print(row(label, stress, found), flush=True)


def main() -> None:
    if len(sys.argv) > 1:
        print_scene(" ".join(sys.argv[1:]), load_scene(sys.argv[1], sys.argv[2:]))
        return
    for name in ("yamada-2002-slip", "steady-pull"):
        print_scene(name, load_scene(name))
    for what, change in SKINS.items():
        print_scene(f"steady-pull, {what}", load_scene("steady-pull").with_(skin=change))


if __name__ == "__main__":
    main()
