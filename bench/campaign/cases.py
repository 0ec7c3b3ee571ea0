"""A case: tables as a person writes them, what is asked of them, and the figures that come out.

The campaign makes cases up, the catalogue (tests/hard_cases.toml) lists them; both run them here.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit

from skincad.inputs import Design, load

CHORD = 2e-3  # mm, asked of print meshes
ONE_MESH = 1e-3  # s; a budget that buys the coarsest mesh alone


@dataclass(frozen=True)
class Case:
    """`kind` is a key of FIGURES; `tables` are of a design, scene or circuit, `skin` of a scene's design;
    `arguments` are those of the function that the kind calls."""

    kind: str
    tables: dict[str, Any]
    skin: dict[str, Any] | None = None
    arguments: dict[str, Any] = field(default_factory=dict)

    @property
    def design(self) -> Design:
        if self.skin is None and self.kind == "simulate":
            return load(self.tables["skin"])
        return Design(**(self.tables if self.skin is None else self.skin))

    def toml(self) -> str:
        table = {"kind": self.kind, "arguments": self.arguments, "tables": self.tables, "skin": self.skin}
        return tomlkit.dumps({key: value for key, value in table.items() if value})


Figures = dict[str, Any]


def section_figures(case: Case) -> Figures:
    """The exact section alone: area by Green's theorem and of a polygon within 1e-6 mm, slots."""
    import shapely

    from skincad.shape import area, polygon, section

    shape = section(case.design)
    outline = shapely.Polygon(polygon(shape.outline, 1e-6))
    slots = sum(area(slot.loop()) for slot in shape.slots)
    return {
        "area": area(shape.outline),
        "polygon_area": outline.area,
        "perimeter": outline.length,
        "simple": bool(outline.is_valid),
        "slots": len(shape.slots),
        "slot_area": abs(slots),
        "bounds": list(outline.bounds),
    }


def solid_figures(case: Case) -> Figures:
    """The skin's exact solid and its print mesh."""
    from skincad.fabrication import mesh
    from skincad.solids import skin_part, solid

    part = skin_part(case.design)
    exact, printed = solid(part), mesh(part, CHORD)  # KernelError unless valid, of the formula's volume
    return {
        "volume": exact.Volume(),
        "formula": part.volume,
        "faces": len(exact.Faces()),
        "mesh_volume": float(printed.volume),
        "mesh_area": float(printed.area),
        "watertight": bool(printed.is_watertight and printed.is_winding_consistent),
        "triangles": len(printed.faces),
    }


def mold_figures(case: Case) -> Figures:
    """All parts of the mold, exact and as meshes, closed and while it opens: what is wrong with them."""
    from bench.campaign.soundness import faults

    return {"faults": list(faults(case.design, **case.arguments))}


def check_figures(case: Case) -> Figures:
    """What `check` says; ridges' forces as a list, `mesh_error` what of the error is not the model's."""
    from skincad.mechanics.check import check

    verdict = check(case.design, **case.arguments)
    threshold, approach = verdict.all_touch_force, verdict.approach
    mesh = None if threshold.error is None else threshold.error - verdict.model_error
    same = ("passed", "force", "ridges", "touching", "model", "unknowns", "residual")
    return {name: getattr(verdict, name) for name in same} | {
        "all_touch_force": threshold.value,
        "all_touch_error": threshold.error,
        "mesh_error": mesh,
        "approach": approach.value,
        "approach_error": approach.error,
        "ridge_force": [f.value for f in verdict.ridge_force],
        "share_error": max(f.error or 0.0 for f in verdict.ridge_force),
        "sum": sum(f.value or 0.0 for f in verdict.ridge_force),
        "yield": None if verdict.manufacture is None else verdict.manufacture.passing.value,
        "beyond": verdict.out_of_range,
        "warnings": list(verdict.warnings),
    }


@contextmanager
def scene_file(case: Case) -> Iterator[Path]:
    """A scene's file with its skin's beside it, where it has one of its own."""
    with tempfile.TemporaryDirectory() as folder:
        tables = dict(case.tables)
        if case.skin is not None:
            (Path(folder) / "skin.toml").write_text(tomlkit.dumps(case.skin), "utf-8")
            tables["skin"] = "skin.toml"
        file = Path(folder) / "scene.toml"
        file.write_text(tomlkit.dumps(tables), "utf-8")
        yield file


def scene_figures(case: Case) -> Figures:
    """What `simulate` says, by default on the coarsest mesh; lists over steps, entry 0 unloaded."""
    from skincad.scenes import load_scene, marches_masses, simulate

    with scene_file(case) as file:
        scene = load_scene(file)
    simulation = simulate(scene, **{"budget": ONE_MESH, **case.arguments})
    march, drives = simulation.march, scene.history.drives()
    friction = scene.parts.get("friction")
    mu, kinetic = getattr(friction, "coefficient", 0.0), getattr(friction, "kinetic", None)
    columns = ("normal", "tangential", "approach", "travel", "elastic", "dissipated")
    return {name: march.column(name).tolist() for name in columns} | {
        "steps": len(march.readings) - 1,
        "stopped": march.stopped,
        "failed": march.failed,
        "coefficient": mu,
        "kinetic": mu if kinetic is None else kinetic,
        "masses": marches_masses(scene) or "inertia" in scene.effects,
        "driven": drives[0].tangential is None,
        "asked_normal": [d.normal for d in drives][: len(march.readings)],
        "touching": march.column("touches").sum(axis=1).tolist(),
        "residual": float(march.column("residual").max()),
        "stress": {str(r): np.asarray(v).tolist() for r, v in simulation.raw.items()},
        "last_stress": [float(v[-1]) for v in simulation.raw.values()],
        "slip_steps": simulation.slip_steps,
        "gross_slip_step": simulation.gross_slip_step,
        "imbalance": simulation.energy["imbalance"],
        "work": simulation.energy["work_mJ"],
        "json": simulation.as_json(),
    }


def circuit_figures(case: Case) -> Figures:
    """What `circuit` says, beside the gain in fractions at three frequencies, both in dB."""
    from bench.campaign import rational
    from skincad.circuit import Circuit, decibels, film_load, gain

    circuit = Circuit(**case.tables)
    circuit_gain = gain(circuit)
    some = circuit_gain.frequency[[0, circuit_gain.frequency.size // 2, -1]]
    passed = decibels(film_load(circuit, some))
    return {
        "gain": circuit_gain.gain.tolist(),
        "some": circuit_gain.gain[[0, circuit_gain.frequency.size // 2, -1]].tolist(),
        "in_fractions": [
            rational.gain(circuit_gain.constants, float(f)) + p for f, p in zip(some, passed, strict=True)
        ],
        "cutoff": circuit_gain.slopes.cutoff.value,
        "below": circuit_gain.slopes.below.value,
        "above": circuit_gain.slopes.above.value,
        "json": circuit_gain.as_json(),
    }


FIGURES: dict[str, Callable[[Case], Figures]] = {
    "section": section_figures,
    "solid": solid_figures,
    "mold": mold_figures,
    "check": check_figures,
    "simulate": scene_figures,
    "circuit": circuit_figures,
}


def figures(case: Case) -> Figures:
    """Return what comes out of a case; raises InputError or RefusedError as skincad does."""
    return FIGURES[case.kind](case)
