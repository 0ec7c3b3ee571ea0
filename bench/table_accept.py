"""What `accept` calls of parts with hidden faults: `python -m bench.table_accept 21000 21200`.

A seed is two parts of a template, a good one and one with one of `FAULTS`, each pressed ten times up to twice
the design's force, or as far as the model goes. A good part's modulus is uniform in the material's range, its
crests scatter by the mold's process. Rows and zero have normal errors. Parts are made otherwise than the
judge's curves: on a mesh twice as fine and of a higher order, with free ends of finer layers; a soft back is
a layer of another material, voids are holes in the mesh, a dry plate is pressed by the marching contact with
friction; of parts with other crests finite strain is solved for the part itself.

Each part is judged in each of `SETTINGS`. Thresholds were set on the seeds 20000 to 20199.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import interp1d

import skincad
from bench import runner
from skincad.base import Array, InputError, RefusedError, Stopwatch, one_blas_thread
from skincad.inputs import Design, Plate, PressCurve
from skincad.inputs.material import silicone
from skincad.material import (
    FORCE_ERROR,
    GOOD_SHARE,
    Acceptance,
    PadCurve,
    PressModel,
    good_curve,
    judge,
    small_strain_curve,
)
from skincad.material.acceptance import APPROACH_ERROR
from skincad.material.press_model import press_model
from skincad.mechanics import Layers, Pad, PadLayer, pad_of, plane_piece, press, spread_of
from skincad.mechanics.models import corrected, finite_strain, friction, linear
from skincad.shape import Point, Segment, skin_of

TEMPLATES = ("yamada-2002", "lab-bench", "fingertip-soft", "plain-ridges", "steep-fingertip", "home-printer")
FAULTS = {  # kind -> the cause that is right
    "softer": "modulus", "stiffer": "modulus", "crests bent": "crests", "crests tilted": "crests",
    "ridge partly filled": "ridge", "ridge not filled": "ridge", "two ridges not filled": "ridge",
    "soft back": "back", "voids": "back", "dry plate": "friction",
}  # fmt: skip
ROWS, PRESS, RANGE = 10, 2.0, 0.8  # times the design's force, at most so much of the model's range
FINENESS, ORDER, FINE_ENDS = 1.0, 3, Layers(0.6, 2.0, 6)
STRAINED_AT = (0.15, 0.4, 0.7, 1.0, 1.7, 2.6)  # of the largest force, as far as the model goes
FAR = 3.0  # times the largest force
TILT = Plate(shape="tilted", tilt=3.0)
UNDECIDED = "can't tell"
FINE = (0.01, 0.002)  # N, mm: a laboratory's scale and a dial gauge


@dataclass(frozen=True)
class Setting:
    """How parts are read: by which presses, with what errors in N and mm, and what causes are ruled out."""

    name: str
    presses: tuple[str, ...] = ("",)
    errors: tuple[float, float] = (FORCE_ERROR, APPROACH_ERROR)
    ruled_out: tuple[str, ...] = ()
    good_share: float = GOOD_SHARE


LOOKED_AT = ("crests", "ridge", "friction")
SETTINGS = (
    Setting("one press"),
    Setting("and a plate tilted by 3 degrees", ("", "tilted")),
    Setting("and a bar on the middle ridge", ("", "ridge")),
    Setting("one press, 95 % of parts taken as good", good_share=0.95),
    Setting("crests, ridges and friction ruled out", ruled_out=LOOKED_AT),
    Setting("one press, finer", errors=FINE),
    Setting("and a plate tilted by 3 degrees, finer", ("", "tilted"), FINE),
    Setting("and a bar on the middle ridge, finer", ("", "ridge"), FINE),
    Setting("crests, ridges and friction ruled out, finer", errors=FINE, ruled_out=LOOKED_AT),
)


@dataclass(frozen=True, eq=False)
class Bench:
    """A template with its largest force N, and at `force` `(k,)` N the factors `(k,)` by which free ends and
    finite strain change the approach of a plane press in small strain."""

    design: Design
    largest: float
    force: Array
    ends: Array
    strained: Array


@cache
def bench_of(name: str) -> Bench:
    design = skincad.load_design(name)
    pad, plain, finite = pad_of(design), corrected.plain_pad(design), None
    first = small_strain_curve(design, silicone(design).young_modulus.value, Stopwatch(None))
    largest = min(PRESS * design.contact.force, RANGE * float(first.force[-1]))
    meshed, rows = plane_piece(pad, 0.5), [(0.0, math.nan, 1.0)]
    for share in STRAINED_AT:
        force = share * largest
        try:
            finite = finite_strain.level(meshed, 3, force, before=finite)
        except (InputError, RefusedError):
            break
        both = corrected.free_ends(plain, force, {}, FINE_ENDS)
        rows.append(
            (
                force,
                both.after.approach / both.before.approach,
                finite.approach / linear.level(meshed, 3, force).approach,
            )
        )
    force, ends, strained = np.array(rows).T
    ends[0] = ends[1]
    return Bench(design, min(largest, float(force[-1])), force, ends, strained)


@cache
def curve_of(name: str, far: bool) -> PadCurve:
    """Return the judge's curve of a template's good part."""
    bench = bench_of(name)
    return good_curve(bench.design, (FAR if far else 1.3) * bench.largest, Stopwatch(None))


@cache
def models_of(name: str, press: str, far: bool) -> PressModel:
    """Return the judge's model of a template for one press; `far` goes on for parts much softer."""
    bench = bench_of(name)
    pad, plate = pad_of(bench.design), TILT if press == "tilted" else None
    only = pad.ridges[len(pad.ridges) // 2] if press == "ridge" else None
    return press_model(bench.design, curve_of(name, far), Stopwatch(None), plate, only)


def along(force: Array, values: Array, at: Array) -> Array:
    """Return values `(k,)` at forces `(k,)` N at others `(n,)`, straight on beyond the last."""
    return np.asarray(interp1d(force, values, fill_value="extrapolate")(at))


@dataclass(frozen=True, eq=False)
class Part:
    """A part: its fault ("" of a good one), modulus by the design's, crests' drops `(ridges,)` mm, its pad of
    the design's modulus, and the change of the approach by a dry plate."""

    template: str
    fault: str
    scale: float
    drops: Array
    pad: Pad
    stuck: float = 0.0


def part_of(rng: np.random.Generator, template: str, fault: str) -> Part:
    bench = bench_of(template)
    design = bench.design
    pad, spread, height = pad_of(design), spread_of(design), float(skin_of(design).profile.height)
    low, value, high = spread.modulus
    scale, ridges = rng.uniform(low, high) / value, len(pad.ridges)
    drops = spread.crest_sigma * rng.standard_normal(ridges)
    along, stuck = np.linspace(-1.0, 1.0, ridges), 0.0
    if fault == "softer":
        scale = low / value / rng.uniform(1.15, 2.5)
    elif fault == "stiffer":
        scale = high / value * rng.uniform(1.15, 2.5)
    elif fault == "crests bent":
        drops = drops + rng.choice([-1, 1]) * rng.uniform(0.08, 0.4) * height * along**2
    elif fault == "crests tilted":
        drops = drops + rng.choice([-1, 1]) * rng.uniform(0.08, 0.4) * height * along
    elif fault == "ridge partly filled":
        drops[rng.integers(ridges)] += rng.uniform(0.2, 0.6) * height
    elif fault == "ridge not filled":
        drops[rng.integers(ridges)] += height
    elif fault == "two ridges not filled":
        drops[rng.choice(ridges, 2, replace=False)] += height
    elif fault == "soft back":
        pad = with_soft_back(pad, rng.uniform(0.1, 0.3), rng.uniform(0.1, 0.4))
    elif fault == "voids":
        pad = with_voids(pad, int(rng.integers(2, 5)), rng.uniform(0.2, 0.35))
    elif fault == "dry plate":
        stuck = dry(template, float(rng.choice([0.3, 0.5, 1.0])))
    return Part(template, fault, float(scale), drops, pad, stuck)


def side_of(pad: Pad) -> tuple[float, float, float]:
    """Return x, mm, of the pad's side, and z of its lower and upper end."""
    starts = [s.start for s in pad.section.outline]
    x = max(abs(p.x) for p in starts)
    return x, min(p.z for p in starts), max(p.z for p in starts if abs(abs(p.x) - x) < 1e-6)


def with_soft_back(pad: Pad, share: float, modulus: float) -> Pad:
    """Return a pad whose lowest `share` is of a softer, compressible stuff of `modulus` times its own."""
    x, low, side = side_of(pad)
    z = low + share * (side - low)
    face = Segment(Point(x, z), Point(-x, z))
    layer = PadLayer(face, modulus * pad.young_modulus, 0.4, pad.density, None)
    return replace(pad, layers=(layer,))


def with_voids(pad: Pad, count: int, size: float) -> Pad:
    """Return a pad with `count` round holes near its back, of `size` times the thickness of its side."""
    x, low, side = side_of(pad)
    radius, z = size * (side - low) / 2, low + 0.35 * (side - low)
    holes = []
    for place in (np.arange(count) - (count - 1) / 2) / count * 1.4 * x:
        left, right = Point(place - radius, z), Point(place + radius, z)
        holes.append((Segment(left, right, 1.0), Segment(right, left, 1.0)))
    return replace(pad, voids=(*pad.voids, *holes))


@cache
def dry(template: str, coefficient: float) -> float:
    """Return the change of a template's approach by friction, on a finer solid than the judge's."""
    bench = bench_of(template)
    plain = corrected.plain_pad(bench.design)
    both = friction.solve_solid(plain, coefficient, bench.largest / 2, (), Layers(0.6, 2.0, 4), 1.0, 2, 12)
    return both.after.approach / both.before.approach - 1


@cache
def solved(template: str, plate: str) -> linear.PlaneSolution:
    """Return a template's fine section, condensed."""
    bench = bench_of(template)
    pad = pad_of(bench.design)
    return section_of(replace(pad, plate=TILT) if plate == "tilted" else pad, bench.largest)


def section_of(pad: Pad, force: float) -> linear.PlaneSolution:
    """Return a pad's whole section, condensed."""
    return linear.level(plane_piece(pad, FINENESS, whole=True), ORDER, force / 2)


def approach_of(part: Part, forces: Array, second: str, strain: float) -> Array:
    """Return a part's approach `(n,)` mm at forces `(n,)` N under a flat plate, or by the second press;
    finite strain changes `strain` times what it changes of the design."""
    bench = bench_of(part.template)
    if part.fault in ("soft back", "voids"):
        pad = replace(part.pad, plate=TILT) if second == "tilted" else part.pad
        solution = section_of(pad, bench.largest)
    else:
        solution = solved(part.template, second)
    ridges, unit, scale = solution.ridges, solution.unit, solution.scale * part.scale
    lowered = ridges.lowered(part.drops / unit)
    may = None
    if second == "ridge":
        may = lowered.of_point == part.pad.ridges[len(part.pad.ridges) // 2]
    with one_blas_thread():
        states = [press(lowered.flexibility, lowered.gap, float(f) / scale, may=may) for f in forces]
    first = 0.0 if may is None else float(lowered.gap[may].min())
    small = (np.array([state.approach for state in states]) - first) * unit
    at = forces / part.scale
    strained = along(bench.force, bench.strained, at) - 1
    ends = np.interp(at, bench.force, bench.ends)
    return np.asarray(small * ends * (1 + strain * strained) * (1 + part.stuck))


def own_strain(part: Part, bench: Bench) -> float:
    """Return what finite strain changes of a part with other crests, by that of the design; 1 of others."""
    if FAULTS.get(part.fault) not in ("crests", "ridge"):
        return 1.0
    force, drops = bench.largest, tuple(part.drops.tolist())
    meshed = plane_piece(pad_of(bench.design), 0.5, whole=True)
    try:
        ratio = (
            finite_strain.level(meshed, 2, force, drops).approach
            / linear.level(meshed, 2, force, drops).approach
        )
    except (InputError, RefusedError):
        return 1.0
    usual = float(np.interp(force, bench.force, bench.strained)) - 1
    return (ratio - 1) / usual if usual else 1.0


@dataclass(frozen=True, eq=False)
class Trial:
    """A part's seed and exact curves: forces `(n,)` N, approach `(n,)` mm, by press."""

    seed: int
    part: Part
    curves: dict[str, tuple[Array, Array]]


def trial(seed: int, fault: str) -> Trial:
    """Return the part of a seed, pressed without errors of reading: alone, tilted and on one ridge."""
    rng = np.random.default_rng([seed, [*FAULTS, ""].index(fault)])
    template = TEMPLATES[seed % len(TEMPLATES)]
    part = part_of(rng, template, fault)
    largest, strain, curves = bench_of(template).largest, own_strain(part, bench_of(template)), {}
    for name in ("", "tilted", "ridge"):
        top = largest / len(part.pad.ridges) * 2 if name == "ridge" else largest
        forces = top * np.arange(1, ROWS + 1) / ROWS
        curves[name] = forces, approach_of(part, forces, name, strain)
    return Trial(seed, part, curves)


def called(of: Trial, setting: Setting) -> Acceptance:
    """Return what the judge says of a trial, read with a setting's errors."""
    rng, rows = np.random.default_rng([of.seed, 7]), []
    force_error, approach_error = setting.errors
    force, approach = of.curves[""]
    near = models_of(of.part.template, "", False)
    far = float(np.interp(approach[-1], near.good, near.force)) > 1.2 * force[-1]
    for name in setting.presses:
        force, approach = of.curves[name]
        read = force + force_error * rng.standard_normal(ROWS)
        gone = approach + approach_error * (rng.standard_normal(ROWS) + rng.standard_normal())
        model = models_of(of.part.template, name, far)
        rows.append((model, PressCurve("", gone, read, force_error, approach_error)))
    return judge(of.part.template, rows, setting.ruled_out, setting.good_share)


class Call(NamedTuple):
    verdict: str
    cause: str | None
    alone: bool


def judged(seed: int) -> dict[str, list[Any]]:
    """Return the calls of a seed's two parts: setting, fault and call."""
    calls = []
    for fault in ("", list(FAULTS)[seed // len(TEMPLATES) % len(FAULTS)]):
        of = trial(seed, fault)
        for setting in SETTINGS:
            if FAULTS.get(fault) not in setting.ruled_out:
                answer = called(of, setting)
                calls.append([setting.name, fault, Call(answer.verdict, answer.cause, bool(answer.alone))])
    return {"calls": calls}


def table(results: list[tuple[str, Call]], causes: dict[str, str] = FAULTS) -> list[str]:
    lines = list[tuple[object, ...]]()
    right = calls = cause = alone = alone_right = 0
    for kind in ("", *causes):
        rows = [verdict for name, verdict in results if name == kind]
        if not rows:
            continue
        count = Counter(row.verdict for row in rows)
        outs = [row for row in rows if row.verdict == "out"] if kind else []
        hits = sum(row.cause == causes[kind] for row in outs)
        single = [row for row in outs if row.alone]
        hits_alone = sum(row.cause == causes[kind] for row in single)
        named = [f"{hits}/{len(outs)}", f"{hits_alone}/{len(single)}"] if kind else ["", ""]
        lines.append((kind or "good", count["in"], count["out"], count[UNDECIDED], *named))
        right += count["out"] if kind else count["in"]
        calls += count["out"] + count["in"]
        cause, alone, alone_right = cause + hits, alone + len(single), alone_right + hits_alone
    good = [row for name, row in results if not name]
    outs = sum(row.verdict == "out" for name, row in results if name)
    return [
        *runner.table(("part", "in", "out", "?", "cause right", "named alone, right"), lines),
        f"called                  {runner.share(calls, len(results))}",
        f"right of those called   {runner.share(right, calls)}",
        f"good parts called out   {runner.share(sum(row.verdict == 'out' for row in good), len(good))}",
        f"faulty parts called out {runner.share(outs, len(results) - len(good))}",
        f"cause right, if out     {runner.share(cause, outs)}",
        f"named alone, right      {runner.share(alone_right, alone)}",
    ]


def main() -> None:
    options = runner.parser(__doc__, "first", "stop").parse_args()
    rows = runner.rows("accept", judged, range(options.first, options.stop), options)
    for setting in SETTINGS:
        force, approach = setting.errors
        print(f"\n{setting.name}; {force:g} N, {approach:g} mm; seeds {options.first} to {options.stop - 1}")
        calls = [
            (fault, Call(*call)) for row in rows for name, fault, call in row["calls"] if name == setting.name
        ]
        print("\n".join(table([(fault, Call(*call)) for fault, call in calls])))


if __name__ == "__main__":
    main()
