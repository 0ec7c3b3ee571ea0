"""GetFEM's part of `bench.getfem`: run by Debian's Python in a folder with pad.msh and asked.json, it writes
found.json. Nothing of skincad is imported.

Small strain: P2 displacements and P1 pressures on triangles with curved sides. Contact and Coulomb friction
on a rigid plane by Alart and Curnier's augmented Lagrangian with P1 multipliers, implicit in time. The back
moves, not the plate: up by the approach, an unknown that bears the force, and against the plate's travel.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import getfem  # type: ignore[import-not-found]
import numpy as np

ELASTIC = (
    "2*shear*Sym(Grad_u):Grad_Test_u - p*Trace(Grad_Test_u) - Test_p*Trace(Grad_u) - p*Test_p/lame",
    "-held.Test_u - (u - [0; 1]*approach + [1; 0]*travel).Test_held + held.[0; 1]*Test_approach",
    "(hold*(approach - start) - force)/width*Test_approach",
)


def main() -> None:
    data = json.loads(Path("asked.json").read_text())
    getfem.util("trace level", 0)
    getfem.util("warning level", 0)
    mesh = getfem.Mesh("import", "gmsh", "pad.msh")
    whole = 1 + max(data["back"], *data["ridges"])
    mesh.set_region(whole, np.hstack([mesh.region(ridge) for ridge in data["ridges"]]))
    rule = getfem.MeshIm(mesh, data["quadrature"])
    model = _model(data, mesh, rule, whole)
    rows = []
    for step, (force, travel) in enumerate(data["steps"]):
        model.set_variable("before", model.variable("u"))
        model.set_variable("travel", travel)
        if step == 0:  # from open contact a force finds nothing to bear it
            model.set_variable("hold", data["hold"])
            _solve(model, data)
            model.set_variable("hold", 0.0)
        model.set_variable("force", force)
        _solve(model, data)
        rows.append(_told(data, model, rule))
    Path("found.json").write_text(json.dumps({"unknowns": int(model.nbdof()), "steps": rows}))


def _model(asked: dict[str, Any], mesh: Any, rule: Any, whole: int) -> Any:
    """The equations; `whole` is the region of all that may touch."""
    spaces = [getfem.MeshFem(mesh, size) for size in (2, 1, 2, 1)]
    for space, degree in zip(spaces, (2, 1, 1, 2), strict=True):
        space.set_classical_fem(degree)
    displacement, pressure, multiplier, place = spaces
    model = getfem.Model("real")
    model.add_fem_variable("u", displacement)
    model.add_fem_variable("p", pressure)
    model.add_filtered_fem_variable("traction", multiplier, whole)
    model.add_filtered_fem_variable("held", displacement, asked["back"])
    model.add_variable("approach", 1)
    for name, value in asked["numbers"].items():
        model.add_initialized_data(name, value)
    for name in ("force", "travel", "hold"):
        model.add_initialized_data(name, 0.0)
    model.add_initialized_fem_data("before", displacement, np.zeros(displacement.nbdof()))
    model.add_initialized_fem_data("obstacle", place, asked["top"] - place.eval("y"))  # exact on curved sides
    for text, region in zip(ELASTIC, (-1, asked["back"], asked["back"]), strict=True):
        model.add_linear_term(rule, text, region)
    names = ("u", "traction", "obstacle", "augmentation", "coefficient")
    alart_and_curnier = 1
    model.add_integral_contact_with_rigid_obstacle_brick(
        rule, *names, whole, alart_and_curnier, "rate", "before"
    )
    return model


def _solve(model: Any, asked: dict[str, Any]) -> None:
    """Newton's iterations; a step that does not converge ends the process."""
    _, converged = model.solve("max_res", asked["residual"], "max_iter", asked["iterations"])
    if not converged:
        raise SystemExit("GetFEM's Newton iterations do not converge")


def _told(asked: dict[str, Any], model: Any, rule: Any) -> dict[str, Any]:
    """The approach, and per ridge the normal and tangential force on the skin."""

    def over(text: str) -> list[float]:
        return [float(getfem.asm("generic", rule, 0, text, ridge, model)) for ridge in asked["ridges"]]

    approach = float(np.ravel(model.variable("approach"))[0])
    return {"approach": approach, "normal": over("-traction(2)"), "tangential": over("traction(1)")}


if __name__ == "__main__":
    main()
