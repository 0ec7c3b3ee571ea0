"""GetFEM's part of `bench.ring_friction`: run by Debian's Python in a folder with mesh.npz and asked.json, it
writes found.json. Nothing of skincad is imported.

Half of a skin in three dimensions, small strain: triquadratic displacements on bricks, and on wedges at the
axis. The volumetric part has the quadrature of linear bricks, as in CalculiX's C3D20R. The stiffness is
condensed once to the displacements of the crests. Contact and Coulomb friction on a rigid plane are GetFEM's:
Alart and Curnier's augmented Lagrangian with linear multipliers, implicit in time, along x and y. The back
moves, not the plate: up by the approach, an unknown that bears the force, and against the plate's travel.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import getfem  # type: ignore[import-not-found]
import numpy as np
from scipy import sparse
from scipy.sparse import linalg

DEVIATORIC = "2*shear*(Sym(Grad_u) - Div_u*Id(3)/3):Grad_Test_u"
VOLUMETRIC = "bulk*Div_u*Div_Test_u"
HELD = 1e9  # times the stiffest unknown: the plane of symmetry
CREST = 0.5  # least upward part of a crest's normal
# What the augmented Lagrangian cuts: of linear multipliers themselves a little is left beyond the contact
PRESSURE = "(augmentation*(u(3) - obstacle) - traction(3))"
TRIAL = "Norm([traction(1); traction(2)] - augmentation*[u(1) - before(1); u(2) - before(2)])"
INTEGRALS = {
    "normal": "-traction(3)",
    "tangential": "traction(1)",
    "ahead": "-traction(3)*X(1)/Norm([X(1); X(2)])",
    "touches": f"Heaviside{PRESSURE}",
    "slips": f"Heaviside{PRESSURE}*Heaviside({TRIAL} - coefficient*{PRESSURE})",
}


def main() -> None:
    data = json.loads(Path("asked.json").read_text())
    getfem.util("trace level", 0)
    getfem.util("warning level", 0)
    mesh = _mesh()
    _crests(mesh, data["rings"], data["base"])
    space = getfem.MeshFem(mesh, 3)
    space.set_classical_fem(2)
    contact = np.array(space.basic_dof_on_region(1))
    stiffness = _condensed(mesh, space, contact, data)
    rule = getfem.MeshIm(mesh, data["quadrature"])
    model, drive = _model(mesh, space, rule, contact, stiffness, data)
    rows = _history(model, drive, rule, data)
    Path("found.json").write_text(json.dumps(rows))


def _mesh() -> Any:
    """The mesh, its corners in GetFEM's order."""
    mesh = getfem.Mesh("empty", 3)
    with np.load("mesh.npz") as parts:
        for kind in ("PRISM", "QK"):
            if parts[kind].size:
                mesh.add_convex(getfem.GeoTrans(f"GT_{kind}(3,2)"), parts[kind])
    return mesh


def _crests(mesh: Any, rings: list[float], base: float) -> None:
    """Mark the crests: all of them region 1, and one a ring from region 2 on, by the nearest radius."""
    faces = mesh.outer_faces_with_direction([0.0, 0.0, 1.0], np.arccos(CREST))
    points = mesh.pts()
    members: list[list[Any]] = [[] for _ in rings]
    for face in faces.T:
        corners = points[:, np.ravel(mesh.pid_in_faces(face.reshape(2, 1)))]
        if corners[2].mean() > base:
            radius = np.hypot(*corners[:2]).mean()
            members[int(np.argmin(np.abs(np.array(rings) - radius)))].append(face)
    for i, one in enumerate(members):
        mesh.set_region(2 + i, np.array(one).T)
    mesh.set_region(1, np.hstack([np.array(one).T for one in members]))


def _condensed(mesh: Any, space: Any, contact: Any, data: dict[str, Any]) -> Any:
    """The stiffness of the crests' unknowns, the back held and the plane y = 0 kept."""
    model = getfem.Model("real")
    model.add_fem_variable("u", space)
    for name in ("shear", "bulk"):
        model.add_initialized_data(name, data[name])
    model.add_linear_term(getfem.MeshIm(mesh, data["full"]), DEVIATORIC)
    model.add_linear_term(getfem.MeshIm(mesh, data["reduced"]), VOLUMETRIC)
    model.assembly("build_matrix")
    matrix = model.tangent_matrix()
    start, index = matrix.csc_ind()
    whole = sparse.csc_matrix((matrix.csc_val(), index, start), shape=(space.nbdof(),) * 2)
    place = space.basic_dof_nodes()
    axis = np.arange(space.nbdof()) % 3
    fixed = (place[2] < 1e-9) | ((axis == 1) & (np.abs(place[1]) < 1e-9))
    free = np.flatnonzero(~fixed)
    solve = linalg.splu(
        whole[free][:, free].tocsc(),
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    moves = np.flatnonzero(~fixed[contact])
    at = np.searchsorted(free, contact[moves])
    give = np.empty((moves.size, moves.size))
    for part in np.array_split(np.arange(moves.size), max(1, moves.size // 200)):
        side = np.zeros((free.size, part.size))
        side[at[part], np.arange(part.size)] = 1.0
        give[:, part] = solve.solve(side)[at]
    stiff = np.zeros((contact.size,) * 2)
    stiff[np.ix_(moves, moves)] = np.linalg.inv((give + give.T) / 2)
    stiff[np.diag_indices(contact.size)] += np.where(fixed[contact], HELD * stiff.max(), 0.0)
    return stiff


def _model(mesh: Any, space: Any, rule: Any, contact: Any, stiffness: Any, data: dict[str, Any]) -> Any:
    """The condensed skin on the plate."""
    crest = getfem.MeshFem("partial", space, contact)
    multiplier, place = getfem.MeshFem(mesh, 3), getfem.MeshFem(mesh, 1)
    multiplier.set_classical_fem(1)
    place.set_classical_fem(2)
    model = getfem.Model("real")
    model.add_fem_variable("u", crest)
    model.add_filtered_fem_variable("traction", multiplier, 1)
    model.add_variable("approach", 1)
    along, down = (stiffness[:, axis::3].sum(axis=1) for axis in (0, 2))
    name = "approach"
    model.add_explicit_matrix("u", "u", _matrix(stiffness))
    model.add_explicit_matrix("u", name, _matrix(-down[:, None]), 1)
    held = model.add_explicit_matrix(name, name, _matrix(np.ones((1, 1))))
    loads = [model.add_explicit_rhs(part, np.zeros(size)) for part, size in (("u", contact.size), (name, 1))]
    for part, value in {"augmentation": data["augmentation"], "coefficient": 0.0, "rate": 1.0}.items():
        model.add_initialized_data(part, value)
    model.add_initialized_fem_data("before", crest, np.zeros(contact.size))
    model.add_initialized_fem_data("obstacle", place, data["top"] - place.eval("z"))
    alart_and_curnier = 1
    model.add_integral_contact_with_rigid_obstacle_brick(
        rule,
        "u",
        "traction",
        "obstacle",
        "augmentation",
        "coefficient",
        1,
        alart_and_curnier,
        "rate",
        "before",
    )

    def drive(force: float, travel: float, hold: float, start: float) -> None:
        model.set_private_matrix(held, _matrix(np.array([[down[2::3].sum() + hold]])))
        model.set_private_rhs(loads[0], -travel * along)
        model.set_private_rhs(loads[1], np.array([force + travel * along[2::3].sum() + hold * start]))

    return model, drive


def _matrix(values: Any) -> Any:
    """A dense matrix as GetFEM takes it."""
    matrix = getfem.Spmat("empty", *values.shape)
    matrix.assign(*(np.arange(size) for size in values.shape), values)
    return matrix


def _history(model: Any, drive: Any, rule: Any, data: dict[str, Any]) -> list[dict[str, Any]]:
    """The states at the ends of steps to a force, travel and coefficient, from the unloaded skin."""
    rows = []
    for step, (force, travel, coefficient) in enumerate(data["steps"]):
        model.set_variable("before", model.variable("u"))
        model.set_variable("coefficient", coefficient)
        if step == 0:  # from open contact a force finds nothing to bear it
            drive(0.0, travel, data["hold"], data["start"])
            _solve(model, data)
        drive(force, travel, 0.0, 0.0)
        _solve(model, data)
        rows.append(_told(model, rule, data))
    return rows


def _solve(model: Any, data: dict[str, Any]) -> None:
    """Newton's iterations; a step that does not converge ends the process."""
    _, converged = model.solve("max_res", data["residual"], "max_iter", data["iterations"], "noisy")
    if not converged:
        raise SystemExit("GetFEM's Newton iterations do not converge")


def _told(model: Any, rule: Any, data: dict[str, Any]) -> dict[str, Any]:
    """The approach, and by ring the integrals of INTEGRALS."""
    told = {"approach": float(np.ravel(model.variable("approach"))[0])}
    for name, text in INTEGRALS.items():
        regions = range(2, 2 + len(data["rings"]))
        told[name] = [float(getfem.asm("generic", rule, 0, text, region, model)) for region in regions]
    return told


if __name__ == "__main__":
    main()
