"""Whether `check --budget` and `check --tol` keep what they promise, on every template.

`python -m bench.table_accuracy [--only KIND] [template]...` (budget, tol, mesh, scene) prints the model that
a budget buys and how long it took; the model that a tolerance of the whole error takes, its stated error of
the all-touch force and the true one, against the solid at finite strain; the same for the linear model's mesh
alone, against its finest refinement; and for scenes what budgets and tolerances take. Times are seconds
without imports."""

from __future__ import annotations

import argparse

from threadpoolctl import threadpool_limits

import skincad
from skincad.base import InputError
from skincad.inputs import Design, template_names
from skincad.mechanics import AUTO, NEGLIGIBLE, ContactCheck, load, pad_of, plane_piece
from skincad.mechanics.check import check
from skincad.mechanics.models.linear import REFINEMENTS, level
from skincad.scenes import load_scene, simulate

BUDGETS = 1.0, 3.0, 10.0
WHOLE = 0.2, 0.05, 0.01  # of model and mesh
TOLERANCES = 0.05, 0.01, 0.002  # of the mesh
BEST = "solid-finite-strain"
SMOOTH = "contact.friction=0"  # no model's error is smaller than what an unknown friction may change
KEPT = 1.5  # times the budget
SCENE_BUDGETS, SCENE_TOLERANCES, LONGEST = (4.0, 12.0), (0.05, 0.01), 40.0


def budgets(names: list[str]) -> int:
    """Print the table of budgets; return how many were not kept."""
    late = 0
    print(f"{'template':22}" + "".join(f"{f'--budget {b:g}':>32}" for b in BUDGETS))
    for name in names:
        cells = []
        for budget in BUDGETS:
            verdict = check(skincad.load(name, [SMOOTH]), budget=budget)
            spent = verdict.seconds["total"]
            late += spent > KEPT * budget
            cells.append(f"{verdict.model:>24} {spent:5.2f} s{'!' if spent > KEPT * budget else ' '}")
        print(f"{name:22}" + "".join(cells), flush=True)
    print(f"{late} of {len(names) * len(BUDGETS)} took more than {KEPT:g} times the budget\n")
    return late


def wholes(names: list[str]) -> int:
    """Print the table of tolerances of the whole error; return how many true errors exceed the stated one."""
    missed = 0
    head = "".join(f"{f'--tol {t:g}: model, time, error stated, true':>58}" for t in WHOLE)
    print(f"{'template':22}{head}   + is the best model, - says that it does not meet the tolerance")
    for name in names:
        design = skincad.load(name, [SMOOTH])
        try:
            truth = check(design, model=BEST).all_touch_force
        except InputError as refusal:
            print(f"{name:22}  no truth: {refusal}")
            continue
        cells = []
        for tol in WHOLE:
            verdict = check(design, tol=tol)
            force, scale = verdict.all_touch_force, max(truth.value or 0.0, NEGLIGIBLE * verdict.force)
            stated, true = (
                (force.error or 0.0) / scale,
                abs((force.value or 0.0) - (truth.value or 0.0)) / scale,
            )
            bad = true > stated + (truth.error or 0.0) / scale
            missed += bad
            short = any("not met" in warning for warning in verdict.warnings)
            mark = "!" if bad else "-" if short else "+" if verdict.model == BEST else " "
            cells.append(
                f"{verdict.model:>28} {verdict.seconds['total']:6.2f} s {stated:8.1e} {true:8.1e} {mark} "
            )
        print(f"{name:22}" + "".join(cells), flush=True)
    print(f"{missed} of {len(names) * len(WHOLE)} stated too small\n")
    return missed


def tolerances(names: list[str]) -> int:
    """Print the table of tolerances; return how many were missed by the truth or said to be not met."""
    missed = 0
    print(f"{'template':22}" + "".join(f"{f'--tol {t:g}: time, error stated, true':>36}" for t in TOLERANCES))
    for name in names:
        design = skincad.load(name)
        truth = finest(design)
        cells = []
        for tol in TOLERANCES:
            verdict = check(design, model="linear", tol=tol)
            stated, true = apart(verdict, truth)
            bad = true > tol or any("not met" in warning for warning in verdict.warnings)
            missed += bad
            cells.append(f"{verdict.seconds['total']:16.2f} s {stated:8.1e} {true:8.1e}{'!' if bad else ' '}")
        print(f"{name:22}" + "".join(cells), flush=True)
    print(f"{missed} of {len(names) * len(TOLERANCES)} not met")
    return missed


def finest(design: Design) -> tuple[float | None, float]:
    """Return F9 and approach of the linear ladder's last refinement."""
    pad, refinement = pad_of(design), REFINEMENTS[-1]
    answer = level(plane_piece(pad, refinement.fineness), refinement.order, design.contact.force)
    return answer.all_touch_force, answer.approach


def apart(found: ContactCheck, truth: tuple[float | None, float]) -> tuple[float, float]:
    """Return the largest relative error of F9 and approach, as the mesh's is stated and as it is."""
    approach, force = found.approach, found.all_touch_force
    left_out = sum(bound.approach for bound in found.left_out) * (approach.value or 0.0)
    stated = [((approach.error or 0.0) - left_out) / (approach.value or 1.0)]
    true = [abs((approach.value or 0.0) / truth[1] - 1)]
    if force.value is not None and truth[0] is not None and found.ridges > 1:
        scale = max(truth[0], NEGLIGIBLE * found.force)
        stated.append(((force.error or 0.0) - found.model_error) / scale)
        true.append(abs(force.value - truth[0]) / scale)
    return max(stated), max(true)


def scenes(_names: list[str]) -> int:
    """Print the table of scenes; return how many budgets were not kept, the coarsest mesh aside."""
    late = 0
    print(f"{'scene':28}" + "".join(f"{f'--budget {b:g}':>26}" for b in SCENE_BUDGETS), end="")
    print("".join(f"{f'--tol {t:g}':>30}" for t in SCENE_TOLERANCES))
    for name in template_names("scenes"):
        scene, cells = load_scene(name), []
        mesh_alone = scene if "finite_strain" in scene.effects else scene.with_(effects={"small_strain": {}})
        for budget in SCENE_BUDGETS:
            simulation = simulate(scene, budget=budget)
            spent, least = simulation.seconds["total"], simulation.error is None
            over = spent > KEPT * budget
            late += over and not least
            mark = "" if not over else "least" if least else "!"
            cells.append(f"{simulation.march.unknowns:>12} {spent:6.2f} s {mark:5}")
        for tol in SCENE_TOLERANCES:
            simulation = simulate(mesh_alone, tol=tol, budget=LONGEST)
            largest = max((float(abs(s).max()) for s in simulation.raw.values()), default=0.0)
            reached = max((simulation.error or {}).values(), default=0.0) / largest if largest else 0.0
            mark = "-" if any("not met" in w for w in simulation.warnings) else " "
            cells.append(
                f"{simulation.march.unknowns:>12} {simulation.seconds['total']:6.2f} s {reached:8.1e} {mark}"
            )
        print(f"{name:28}" + "".join(cells), flush=True)
    print(f"{late} budgets not kept within {KEPT:g} times; - is not met within {LONGEST:g} s")
    return late


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("names", nargs="*", default=template_names())
    parser.add_argument("--only", choices=("budget", "tol", "mesh", "scene"))
    options = parser.parse_args()
    for model in AUTO:  # imports are no part of a budget
        load(model)
    check(skincad.load("plain-ridges"), model="linear")
    for kind, table in {"budget": budgets, "tol": wholes, "mesh": tolerances, "scene": scenes}.items():
        if options.only in (None, kind):
            table(options.names)


if __name__ == "__main__":
    with threadpool_limits(limits=1, user_api="blas"):
        main()
