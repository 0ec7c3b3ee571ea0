"""What `accept` calls of pins and faces with hidden faults.

`python -m bench.accept_families pins 25000 25090`, or `faces 25000 25105`. A seed is two parts of one of the
`DESIGNS`, a good one and one with one of `CAUSES`, each pressed ten times up to twice the design's force, or
as far as the model goes. A good part's modulus is uniform in the material's
range, its crests scatter by the mold's process; a face errs at three places, with the parabola through them.
Rows and zero have normal errors.

Parts are made otherwise than the judge's curves. Each pin has finite strain by its own force, on a finer cell
of a higher order; all are solved by Newton's method, and the approach is off evenly within the error that
`check` states of pins. Pins tilt to any side. A soft back is a layer of another material. A face is solved on
a mesh twice as fine and of a higher order, with free ends of finer layers. Both share with the judge the base
that pins stand on, and friction on a dry plate.

Seeds from 24000 on were looked at first: rows beyond finite strain are refused since, and a face's own error
by its mesh, FACE_ERROR, was chosen. Those from 25000 on judged, once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

import skincad
from bench import runner
from bench.table_accept import (
    FAR,
    FINE_ENDS,
    PRESS,
    RANGE,
    ROWS,
    SETTINGS,
    Call,
    Setting,
    along,
    section_of,
    table,
)
from skincad.base import Array, InputError, RefusedError, Stopwatch, one_blas_thread
from skincad.inputs import Design, PressCurve
from skincad.inputs.material import silicone
from skincad.material import Acceptance, PadCurve, PressModel, good_curve, judge, small_strain_curve
from skincad.material.press_model import FACE_HEIGHT, press_model
from skincad.mechanics import pad_of, plane_piece, press, spread_of
from skincad.mechanics.models import corrected, finite_strain, linear, reduced
from skincad.mechanics.problem import focused
from skincad.shape import FACE, skin_of

DESIGNS: dict[str, tuple[tuple[str, dict[str, Any]], ...]] = {
    "pins": (
        ("pillars-9", {}),
        ("magnet-pillars", {}),
        (
            "pillars-9",
            {"pin": {"heights": None, "height": 4.0, "pocket": None}, "skin": {"curvature_radius": 60.0}},
        ),
    ),
    "faces": (
        ("flat-magnet", {}),
        ("flat-magnet", {"skin": {"curvature_radius": 30.0, "thickness": 4.0}}),
        ("flat-magnet", {"skin": {"outline": "round", "curvature_radius": 40.0}}),
    ),
}
CAUSES = {  # kind -> the cause that is right
    "softer": "modulus", "stiffer": "modulus", "bent": "crests", "tilted": "crests", "short": "ridge",
    "missing": "ridge", "two missing": "ridge", "soft back": "back", "soft holder": "back",
    "dry plate": "friction",
}  # fmt: skip
STRAINED_AT = (0.05, 0.15, 0.4, 0.7, 1.0, 1.7, 2.6)  # of the largest force, as far as the model goes
HOLDER = 0.15, 0.8  # of a good part's approach at the largest force
ONE_PRESS = tuple(setting for setting in SETTINGS if setting.presses == ("",))
FINE_SECTION = 0.5, 3  # fineness and order of what finite strain changes


def faults(kind: str) -> dict[str, str]:
    """Return the faults of pins or faces and their causes; nothing of a face can be missing."""
    return {name: cause for name, cause in CAUSES.items() if kind == "pins" or cause != "ridge"}


@cache
def design_of(kind: str, number: int) -> Design:
    name, changes = DESIGNS[kind][number]
    return skincad.load(name).with_(**changes)


@cache
def first_curve(kind: str, number: int) -> PadCurve:
    design = design_of(kind, number)
    return small_strain_curve(design, silicone(design).young_modulus.value, Stopwatch(None))


@cache
def largest_of(kind: str, number: int) -> float:
    """Return the largest force of a design's press, N."""
    design = design_of(kind, number)
    largest = min(PRESS * design.contact.force, RANGE * float(first_curve(kind, number).force[-1]))
    return min(largest, float(good_curve(design, 1.3 * largest, Stopwatch(None)).force[-1]))


@cache
def model_of(kind: str, number: int, far: bool) -> PressModel:
    """Return the judge's model; `far` goes on for parts much softer."""
    design, largest = design_of(kind, number), largest_of(kind, number)
    curve = good_curve(design, (FAR if far else 1.3) * largest, Stopwatch(None))
    return press_model(design, curve, Stopwatch(None))


def strained(design: Design, largest: float) -> tuple[Array, Array]:
    """Return forces `(k,)` N and by what factor finite strain changes the approach of a section there."""
    pad, finite, rows = focused(pad_of(design), largest / 2), None, [(0.0, 1.0)]
    meshed = plane_piece(pad, FINE_SECTION[0])
    for force in (share * largest for share in STRAINED_AT):
        try:
            finite = finite_strain.level(meshed, FINE_SECTION[1], force, before=finite)
        except (InputError, RefusedError):
            break
        rows.append((force, finite.approach / linear.level(meshed, FINE_SECTION[1], force).approach))
    force, ratio = np.array(rows).T
    return force, ratio


@dataclass(frozen=True, eq=False)
class Part:
    """A part: its fault ("" of a good one), modulus by the design's, crests' drops `(n,)` mm, the layer at
    its back, its holder's mm/N, how far the plate sticks from 0 to 1, and by what factor its approach is
    off."""

    fault: str
    scale: float
    drops: Array
    shot: dict[str, float] | None = None
    holder: float = 0.0
    sticks: float = 0.0
    off: float = 1.0


def part_of(rng: np.random.Generator, kind: str, number: int, fault: str) -> Part:
    design = design_of(kind, number)
    skin, spread = skin_of(design), spread_of(design)
    low, value, high = spread.modulus
    height = float(skin.profile.height) if kind == "pins" else FACE_HEIGHT * design.skin.thickness
    x, y = np.array([placed.tip[:2] for placed in skin.placed]).T if kind == "pins" else (np.array(FACE), 0.0)
    angle = rng.uniform(0, 2 * math.pi) if kind == "pins" else 0.0
    side = x * math.cos(angle) + y * math.sin(angle)
    out = np.hypot(x, y)
    scale, drops = rng.uniform(low, high) / value, spread.crest_sigma * rng.standard_normal(x.size)
    if design.skin.round and kind == "faces":
        drops[[0, -1]] = drops[[0, -1]].mean()
    sign, size = rng.choice([-1, 1]), rng.uniform(0.08, 0.4) * height
    one, more = rng.permutation(x.size)[:2], {}
    if fault == "softer":
        scale = low / value / rng.uniform(1.15, 2.5)
    elif fault == "stiffer":
        scale = high / value * rng.uniform(1.15, 2.5)
    elif fault == "bent":
        drops = drops + sign * size * (out / out.max()) ** 2
    elif fault == "tilted":
        drops = drops + sign * size * side / abs(side).max()
    elif fault == "short":
        drops[one[0]] += rng.uniform(0.2, 0.6) * height
    elif fault in ("missing", "two missing"):
        drops[one[: 1 + (fault == "two missing")]] += height
    elif fault == "soft back":
        thick, soft = rng.uniform(0.1, 0.3) * design.skin.thickness, rng.uniform(0.1, 0.4)
        more = {"shot": {"thickness": thick, "young_modulus": soft * value}}
    elif fault == "soft holder":
        largest = largest_of(kind, number)
        depth = float(np.interp(largest, first_curve(kind, number).force, first_curve(kind, number).approach))
        more = {"holder": rng.uniform(*HOLDER) * depth / largest}
    elif fault == "dry plate":
        more = {"sticks": rng.uniform(0.3, 1.0)}
    return Part(fault, float(scale), drops, off=1 + MODEL_ERROR[kind] * rng.uniform(-1, 1), **more)


@cache
def own_strain(kind: str, number: int) -> tuple[Array, Array]:
    """Return what finite strain changes of a section, or of one pin by its force."""
    design, largest = design_of(kind, number), largest_of(kind, number)
    if kind == "faces":
        return strained(design, largest)
    return strained(reduced.pin_cells(design).stiffest.design, largest / skin_of(design).count)


def pins_approach(part: Part, kind: str, number: int, forces: Array) -> Array:
    """Return the approach `(n,)` mm of pins at forces `(n,)` N of the design's modulus."""
    design = design_of(kind, number)
    if part.shot:
        design = design.with_(shot=[part.shot])
    known, ratio = own_strain(kind, number)
    curves = []
    for stuck in (False, True) if part.sticks else (False,):
        model = reduced.pin_model(design, stuck=stuck)
        indentation = model.indentation * along(known, ratio, model.force)
        model = replace(model, indentation=indentation).lowered(tuple(part.drops.tolist()))
        with one_blas_thread():
            curves.append(np.array([reduced.pressed(model, float(force))[1] for force in forces]))
    return np.asarray(curves[0] + part.sticks * (curves[-1] - curves[0]))


@cache
def ends_of(number: int) -> tuple[Array, Array]:
    """Return forces `(k,)` N and by what factor free ends change a face's approach; 1 of a round one."""
    design, largest = design_of("faces", number), largest_of("faces", number)
    force = largest * np.array([0.15, 0.4, 1.0, 2.0])
    if design.skin.round:
        return force, np.ones(force.size)
    plain = corrected.plain_pad(design)
    both = [corrected.free_ends(plain, float(f), {}, FINE_ENDS) for f in force]
    return force, np.array([b.after.approach / b.before.approach for b in both])


@cache
def face_friction(number: int) -> float:
    """Return by how much a plate on which nothing slips changes a face's approach, as the judge has it."""
    return model_of("faces", number, False).friction


def face_approach(part: Part, kind: str, number: int, forces: Array) -> Array:
    """Return the approach `(n,)` mm of a face at forces `(n,)` N of the design's modulus."""
    design = design_of(kind, number)
    if part.shot:
        design = design.with_(shot=[part.shot])
    solution = section_of(focused(pad_of(design), largest_of(kind, number) / 2), largest_of(kind, number))
    ridges, unit = solution.ridges.lowered(part.drops / solution.unit), solution.unit
    with one_blas_thread():
        states = [press(ridges.flexibility, ridges.gap, float(f) / solution.scale) for f in forces]
    small = np.array([state.approach for state in states]) * unit
    known, ratio = own_strain(kind, number)
    stuck = 1 + part.sticks * face_friction(number)
    return np.asarray(small * along(known, ratio, forces) * np.interp(forces, *ends_of(number)) * stuck)


APPROACHES: dict[str, Callable[[Part, str, int, Array], Array]] = {
    "pins": pins_approach,
    "faces": face_approach,
}
MODEL_ERROR = {"pins": reduced.PIN_ERRORS.approach, "faces": 0.0}


def judged(case: str) -> dict[str, list[Any]]:
    """Return the calls of a seed's two parts: setting, fault and call."""
    kind, _, digits = case.partition(" ")
    seed = int(digits)
    number, causes, calls = seed % len(DESIGNS[kind]), faults(kind), []
    for fault in ("", list(causes)[seed // len(DESIGNS[kind]) % len(causes)]):
        rng = np.random.default_rng([seed, ["", *CAUSES].index(fault)])
        part = part_of(rng, kind, number, fault)
        force = largest_of(kind, number) * np.arange(1, ROWS + 1) / ROWS
        approach = part.off * APPROACHES[kind](part, kind, number, force / part.scale) + part.holder * force
        for setting in ONE_PRESS:
            if CAUSES.get(fault) not in setting.ruled_out:
                answer = called(kind, number, seed, setting, force, approach)
                calls.append([setting.name, fault, Call(answer.verdict, answer.cause, bool(answer.alone))])
    return {"calls": calls}


def called(kind: str, number: int, seed: int, setting: Setting, force: Array, approach: Array) -> Acceptance:
    """Return what the judge says of a press, read with a setting's errors."""
    rng, (force_error, approach_error) = np.random.default_rng([seed, 7]), setting.errors
    near = model_of(kind, number, False)
    far = float(np.interp(approach[-1], near.good, near.force)) > 1.2 * force[-1]
    read = force + force_error * rng.standard_normal(ROWS)
    gone = approach + approach_error * (rng.standard_normal(ROWS) + rng.standard_normal())
    curve = PressCurve("", gone, read, force_error, approach_error)
    return judge("", [(model_of(kind, number, far), curve)], setting.ruled_out, setting.good_share)


def main() -> None:
    parser = runner.parser(__doc__)
    parser.add_argument("kind", choices=[*DESIGNS])
    parser.add_argument("first", type=int)
    parser.add_argument("stop", type=int)
    options = parser.parse_args()
    seeds = range(options.first, options.stop)
    rows = runner.rows(
        f"accept-{options.kind}", judged, [f"{options.kind} {seed}" for seed in seeds], options
    )
    for setting in ONE_PRESS:
        force, approach = setting.errors
        print(f"\n{setting.name}; {force:g} N, {approach:g} mm; seeds {options.first} to {options.stop - 1}")
        calls = [
            (fault, Call(*call)) for row in rows for name, fault, call in row["calls"] if name == setting.name
        ]
        print("\n".join(table(calls, CAUSES)))


if __name__ == "__main__":
    main()
