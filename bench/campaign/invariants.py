"""What must hold for every case that is not refused: each broken one is told as (kind, words).

Relative tolerances of 1e-9 are rounding over some hundred terms; those of the solvers are their own promises.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from bench.campaign.cases import CHORD, ONE_MESH, Case, Figures, figures
from skincad.base import InputError, RefusedError
from skincad.inputs import SOFTEST, STIFFEST
from skincad.inputs.material import silicone
from skincad.mechanics import LARGEST_STRAIN
from skincad.shape import skin_of

Fault = tuple[str, str]
NEXT = {"winkler": "linear", "linear": "corrected", "corrected": "solid"}
POWER = 2.0**-7  # of modulus and force: a change of units, exact in floating point
MESHES = 1e-2  # of approach: two forces may be answered on two refinements of the mesh ladder


def faults(case: Case, found: Figures, *, dear: bool = False) -> Iterator[Fault]:
    """Yield what is wrong with a case, run again in other ways; with `dear` also by the next model."""
    yield from sane(case, found)
    if case.kind == "check":
        yield from _heavier(case, found)
        yield from _other_units(case, found)
        yield from _mirrored(case, found)
        yield from _next_model(case, found) if dear else ()
    if case.kind == "simulate":
        yield from _pulled_back(case, found)


def sane(case: Case, found: Figures) -> Iterator[Fault]:
    """Yield what is wrong with a case's figures as they are."""
    yield from _FAULTS[case.kind](case, found)


def _section(case: Case, found: Figures) -> Iterator[Fault]:
    if not found["simple"]:
        yield "section crosses itself", str(found["bounds"])
    most = 1e-6 * found["perimeter"] + 1e-9 * found["area"]
    if not abs(found["area"] - found["polygon_area"]) <= most:
        yield "area closure", f"Green {found['area']:.12g} mm2, polygon {found['polygon_area']:.12g}"
    low, high = found["bounds"][0], found["bounds"][2]
    if not abs(low + high) <= 1e-9 * (high - low):
        yield "section is not its mirror image", f"x from {low!r} to {high!r}"


def _solid(case: Case, found: Figures) -> Iterator[Fault]:
    if not found["watertight"]:
        yield "mesh is open", f"{found['triangles']} triangles"
    # chords keep within CHORD of the surface, so the volume between is at most that times the area
    error, most = abs(found["mesh_volume"] - found["formula"]), CHORD * found["mesh_area"]
    if not error <= most:
        yield "volume closure", f"mesh off by {error:.3g} mm3, {most:.3g} allowed"
    if not abs(found["volume"] / found["formula"] - 1) <= 1e-8:  # the kernel's promise is 1e-9
        yield "volume closure", f"solid {found['volume']:.12g} mm3, formula {found['formula']:.12g}"


def _mold(case: Case, found: Figures) -> Iterator[Fault]:
    for fault in found["faults"]:
        yield "mold: " + fault.split(":")[0].split(" ")[0], fault


def _check(case: Case, found: Figures) -> Iterator[Fault]:
    force, shares = found["force"], np.array(found["ridge_force"], dtype=float)
    if not (np.isfinite(shares).all() and math.isfinite(found["approach"])):
        yield "not finite", str(shares)
        return
    if not abs(shares.sum() / force - 1) <= 1e-9:
        yield "balance", f"ridges carry {shares.sum():.12g} N of {force:.12g}"
    if shares.min() < 0:
        yield "tension", f"{shares.min():.3g} N"
    if not found["residual"] <= 1e-6:
        yield "residual", str(found["residual"])
    if found["touching"] != int((shares > 0).sum()):
        yield "touching", f"{found['touching']} of forces {shares}"
    if found["approach"] < 0:
        yield "approach", str(found["approach"])
    numbers = [found[key] for key in ("all_touch_error", "approach_error", "share_error")]
    if any(n is not None and not (n >= 0 and math.isfinite(n)) for n in numbers):
        yield "error is no number", str(numbers)
    yield from _threshold(found)


def _threshold(found: Figures) -> Iterator[Fault]:
    """All touch above the all-touch force with its error, not all below it."""
    value, error, force = found["all_touch_force"], found["all_touch_error"] or 0.0, found["force"]
    if value is None:
        if found["touching"] == found["ridges"]:
            yield "threshold", "all touch, and no force is told from which on"
        return
    if value < 0:
        yield "threshold", f"{value:.3g} N"
    all_touch = found["touching"] == found["ridges"]
    if value + error < force and not all_touch:
        yield "threshold", f"{found['touching']} touch at {force:.6g} N, all from {value:.6g} +- {error:.3g}"
    if value - error > force and all_touch:
        yield "threshold", f"all touch at {force:.6g} N, only from {value:.6g} +- {error:.3g}"
    if found["passed"] and not (all_touch and value + error <= force):
        yield "passed", f"{value:.6g} +- {error:.3g} N at {force:.6g}"


def _heavier(case: Case, found: Figures) -> Iterator[Fault]:
    """Twice the force: the approach grows, by no more than twice; the all-touch force stays."""
    other = _again(case, force=2 * found["force"])
    if other is None:
        return
    one, two = found["approach"], other["approach"]
    if not one * (1 - MESHES) <= two <= 2 * one * (1 + MESHES):
        yield "approach over force", f"{one:.6g} mm, {two:.6g} mm at twice the force"
    values, errors = zip(*((f["all_touch_force"], f["mesh_error"]) for f in (found, other)), strict=True)
    if None in values or None in errors:
        return
    if not abs(values[0] - values[1]) <= sum(errors) + 1e-9 * values[0]:
        yield "all-touch force hangs on the force", f"{values[0]:.6g} and {values[1]:.6g} N, errors {errors}"


def _other_units(case: Case, found: Figures) -> Iterator[Fault]:
    """Modulus and force in another unit: same approach, forces in that unit, to rounding."""
    tables = _softer(case.tables, POWER)
    if tables is None:
        return
    other = _again(replace(case, tables=tables), force=POWER * found["force"])
    if other is None or other["unknowns"] != found["unknowns"]:
        return
    if not math.isclose(other["approach"], found["approach"], rel_tol=1e-7, abs_tol=1e-12):
        yield "units", f"approach {found['approach']:.12g} and {other['approach']:.12g} mm"
    shares = np.array(other["ridge_force"]) / POWER - np.array(found["ridge_force"])
    if not np.abs(shares).max() <= 1e-7 * found["force"]:
        yield "units", f"shares differ by {np.abs(shares).max():.3g} of {found['force']:.3g} N"


def _softer(tables: dict[str, Any], factor: float) -> dict[str, Any] | None:
    """The tables with skin and film softer by a factor; None where they leave their range by it."""
    material, film = tables["material"], tables.get("film")
    modulus = material.get("young_modulus")
    if not isinstance(modulus, float) or not SOFTEST < modulus * factor < STIFFEST:
        return None
    table = {**tables, "material": {**material, "young_modulus": modulus * factor}}
    if film is not None:
        if not 1.0 <= film.get("young_modulus", 3000.0) * factor <= 1e6:
            return None
        table["film"] = {**film, "young_modulus": film.get("young_modulus", 3000.0) * factor}
    return table


def _mirrored(case: Case, found: Figures) -> Iterator[Fault]:
    """Numbering from the other side: the shares turn round, a flat plate's are their own image."""
    plate = case.tables.get("contact", {}).get("plate", {"shape": "flat"})
    turned = {key: -value if key in ("tilt", "position") else value for key, value in plate.items()}
    other: Figures | None = found
    if plate["shape"] != "flat":
        if plate["shape"] == "step":
            return  # a step higher at -x is not in the model
        contact = {**case.tables["contact"], "plate": turned}
        other = _again(replace(case, tables={**case.tables, "contact": contact}))
    if other is None:
        return
    shares, image = np.array(found["ridge_force"]), np.array(other["ridge_force"])[::-1]
    error = 2 * max(found["share_error"], other["share_error"]) + 1e-9 * found["force"]
    if not np.abs(shares - image).max() <= error:
        yield "mirror image", f"shares differ by {np.abs(shares - image).max():.3g} N, error {error:.3g}"


def _again(case: Case, **arguments: Any) -> Figures | None:
    try:
        return figures(replace(case, arguments={**case.arguments, **arguments}))
    except (InputError, RefusedError):
        return None


def _next_model(case: Case, found: Figures) -> Iterator[Fault]:
    """The error holds against the next model, with that one's own; both within their range."""
    above = NEXT.get(found["model"])
    if above is None or found["beyond"]:
        return
    other = _again(case, model=above)
    if other is None or other["beyond"]:
        return
    for key, error in (("all_touch_force", "all_touch_error"), ("approach", "approach_error")):
        one, two, widths = found[key], other[key], (found[error], other[error])
        if None in (one, two, *widths):
            continue
        if not abs(one - two) <= sum(widths):
            yield (
                f"error bar of {found['model']}, {key}",
                f"{one:.6g} +- {widths[0]:.3g}, {above} {two:.6g} +- {widths[1]:.3g}",
            )


def _scene(case: Case, found: Figures) -> Iterator[Fault]:
    json.dumps(found["json"], allow_nan=False)  # ValueError where one is none
    normal, across = np.array(found["normal"]), np.array(found["tangential"])
    values = np.array(found["asked_normal"])
    whole = slice(None, -1 if found["stopped"] == "gross slip" else None)  # which may come within a step
    heavy = "inertia" in case.tables["effects"]  # masses bear what the skin does not
    off = float(np.abs(normal - values)[whole].max())
    if not heavy and not off <= 1e-9 * max(values.max(), 1e-300):
        yield "plate's balance", f"off by {off:.3g} N"
    if not found["residual"] <= 1e-10:
        yield "residual", str(found["residual"])
    if (np.abs(across) > found["coefficient"] * normal + 1e-9 * normal.max()).any():
        yield "cone", f"{np.abs(across).max():.6g} N across"
    if not ((np.array(found["touching"]) > 0) == (normal > 0)).all():
        yield "touching", "load without contact, or contact without load"
    yield from _range(case, found)
    lost, work = np.array(found["dissipated"]), max(abs(found["work"]), *found["elastic"])
    # of a point that turns round within a step the mean force is not the one that it slid under: with masses
    # only the sum over all steps tells, and none where they carry a point on while its friction falls
    if not found["masses"]:
        given = lost.min() < -1e-9 * work
    else:
        given = found["kinetic"] == found["coefficient"] and lost.sum() < -1e-4 * work
    if given:
        yield "friction gives work", f"{lost.min():.3g} mJ of {work:.3g}"
    if min(found["elastic"]) < -1e-9 * work:
        yield "stored energy", f"{min(found['elastic']):.3g} mJ"


def _range(case: Case, found: Figures) -> Iterator[Fault]:
    """No accepted state is beyond the range that `check` has: by hand, not by the program's own limits."""
    design = case.design
    stuff = silicone(design)
    height = design.skin.thickness + max(skin_of(design).heights)
    if not max(found["approach"]) < height:
        yield "pressed flat", f"{max(found['approach']):.3g} of {height:.3g} mm"
    if "finite_strain" in case.tables["effects"]:
        return
    area = (skin_of(design).profile.root_width + skin_of(design).profile.tip_width) / 2 * design.skin.length
    modulus, ratio = stuff.young_modulus.value, stuff.poisson_ratio
    # shared evenly at least: what a ridge bears more, the march itself looks after
    mean = max(found["normal"]) / skin_of(design).count / area
    across = max(map(abs, found["tangential"])) / skin_of(design).count / area
    strain = max(mean * (1 - ratio**2) / modulus, across * (1 + ratio) / modulus)
    if not strain <= LARGEST_STRAIN * (1 + 1e-9):
        yield "strained beyond the range", f"{strain:.3g} in the mean"


def _pulled_back(case: Case, found: Figures) -> Iterator[Fault]:
    """Pulling to the other side mirrors forces and signals (the skin is its own mirror image)."""
    history = {
        key: [-v for v in value] if key in ("tangential_force_N", "displacement_mm") else value
        for key, value in case.tables["history"].items()
    }
    other = _again(replace(case, tables={**case.tables, "history": history}), budget=ONE_MESH)
    if other is None:
        return
    if other["failed"] or found["failed"]:
        return  # a march may stop at a step whose sets cycle, from one side sooner than from the other
    if other["steps"] != found["steps"]:
        yield "mirror image", f"{found['steps']} steps there, {other['steps']} back: {other['stopped']}"
        return
    scale = max(found["normal"])
    there, back = np.array(found["tangential"]), np.array(other["tangential"])
    if not np.abs(there + back).max() <= 1e-6 * scale:
        yield "mirror image", f"tangential forces differ by {np.abs(there + back).max():.3g} N"
    if not np.allclose(found["approach"], other["approach"], rtol=1e-6, atol=1e-12):
        yield "mirror image", "approaches differ"


def _circuit(case: Case, found: Figures) -> Iterator[Fault]:
    json.dumps(found["json"], allow_nan=False)
    off = np.abs(np.array(found["some"]) - np.array(found["in_fractions"])).max()
    if not off <= 1e-6:  # dB; a resonance off by one digit of its frequency
        yield "loop equations", f"{off:.3g} dB off"


_FAULTS: dict[str, Callable[[Case, Figures], Iterator[Fault]]] = {
    "section": _section,
    "solid": _solid,
    "mold": _mold,
    "check": _check,
    "simulate": _scene,
    "circuit": _circuit,
}
