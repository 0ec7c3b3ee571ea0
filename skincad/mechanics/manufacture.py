"""The share of parts that pass, and what it depends on.

Sensitivities of the all-touch force to each dimension and the modulus, by the closed form's exponents. An
exponent is percent of force per percent of the key. The closed form alone misleads where a key acts on the
base that ridges share: it gives the base under a ridge to skin.width / ridge.count, where it is rather the
pitch, and knows no edges. So each key has an interval round the closed form's exponent (docs/evidence/fits.md
says how it was set). Of pins and rings, which the springs don't know, the exponents are differences of the
quickest model's force.

A part's crests differ from the design by independent normal errors of the mold's process. Its modulus is
uniform in the material's range, since a range says no more. Forces scale with the modulus exactly, so a part
passes when all its ridges touch at force x E / E_part in the model of E.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy import optimize, special

from skincad.base.arrays import Array, Mask
from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.machine import one_blas_thread
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.contact.ridge_model import BATCH, ridge_forces
from skincad.mechanics.models.table import MODELS, run, unsupported_reason
from skincad.mechanics.models.winkler import all_touch_force
from skincad.mechanics.problem import NEGLIGIBLE, Request, RidgeModel, Spread, Yield, focused, pad_of
from skincad.shape.crests import FACE
from skincad.shape.skin import skin_of

STEP = 1e-3  # relative, of each key, one way
KEYS = (
    *(f"skin.{key}" for key in ("curvature_radius", "thickness", "width", "length")),
    *(f"ridge.{key}" for key in ("pitch", "height", "root_width", "tip_width")),
)
MODULUS = "material.young_modulus"
LENGTHS = {key.partition(".")[2] for key in KEYS} | {
    "curvature_radius_y",
    "root_diameter",
    "tip_diameter",
    "crown",
}
# half-widths of the exponents of single ridges and of the base circle
EXPONENT_MARGINS = {
    "skin.curvature_radius": 0.2,
    "ridge.height": 0.35,
    "ridge.root_width": 0.3,
    "ridge.tip_width": 0.4,
}
FREE_ENDS = 0.3  # assumption, of the length's: what free ends add, which the plane does not know
PROPORTIONAL_MARGIN = 0.01  # of what is proportional: rounding, and the linear model's mesh
# by which a thicker base may count for more than its springs; at least it counts for nothing
CONFINEMENT_MARGIN = 0.4
EDGE_MARGIN = 0.009  # by the square of the number of ridges: what a margin that gets narrower may change
# of the pitch's exponent: below that of the gap alone, and above that of gap and base
PITCH_MARGIN_BELOW, PITCH_MARGIN_ABOVE = 0.1, 0.2
DIFFERENCE = 0.03  # relative, of each key either way, where a model of finite elements is asked
# Of such an exponent: what its two meshes leave (1e-3 of a force, measured on five templates), what it is off
# by with its model (of it, assumption), and below which the model does not know the key
MESH_NOISE, MODEL_SHARE, UNKNOWN = 0.03, 0.1, 1e-4
QUICK_TOLERANCE = 5e-3  # relative, of that model's mesh


@dataclass(frozen=True)
class Sensitivity:
    """A key's value `now`, and the change of the all-touch force by 1 % more of it, N."""

    key: str
    now: float
    unit: str
    change: Estimate


def sensitivities(design: Design, force: float) -> tuple[Sensitivity, ...]:
    """Return the change of an all-touch force of `force` N by 1 % of each dimension, the largest first.

    Empty for a single feature, and for a negligible all-touch force. A key that guards hold fixed, that its
    model does not know, or whose change adds a feature or takes one away is left out.
    """
    name = quick_model(design)
    own = (quick_force(design, name) or 0.0) if skin_of(design).count > 1 else 0.0
    if own <= NEGLIGIBLE * design.contact.force:
        return ()
    ends = intervals(design, own) if name == "winkler" else _by_differences(design, name, own)
    now = {MODULUS: silicone(design).young_modulus.value}
    for key in set(ends) - {MODULUS}:
        table, _, name = key.partition(".")
        now[key] = float(getattr(getattr(design, table), name))
    rows = [
        Sensitivity(
            key=key,
            now=now[key],
            unit="MPa" if key == MODULUS else "mm",
            change=Estimate((low + high) / 2 * force / 100, (high - low) / 2 * force / 100, "N"),
        )
        for key, (low, high) in ends.items()
    ]
    return tuple(sorted(rows, key=lambda row: (float(f"{-abs(row.change.value or 0.0):.3g}"), row.key)))


def quick_model(design: Design) -> str:
    """Return the quickest model that judges a design, the springs if they know it; "" where none does."""
    return next((name for name in MODELS if not unsupported_reason(name, design, measured=False)), "")


@lru_cache(maxsize=32)
def quick_force(design: Design, name: str) -> float | None:
    """Return the all-touch force by a model, N; None where it refuses the design, or where there is none."""
    try:
        request = Request(design.contact.force, QUICK_TOLERANCE, rough=True)
        return run(name, design, request, {}, None).all_touch_force.value if name else None
    except (InputError, RefusedError):
        return None


def _by_differences(design: Design, model: str, own: float) -> dict[str, tuple[float, float]]:
    """The interval of the exponent of each of LENGTHS by differences of a model's force, `own` N as
    designed."""
    result = {MODULUS: (1 - PROPORTIONAL_MARGIN, 1 + PROPORTIONAL_MARGIN)}
    for table in ("skin", skin_of(design).family):
        for name, now in ((key, now) for key, now in getattr(design, table) if key in LENGTHS and now):
            exponents = []
            for by in (1 - DIFFERENCE, 1 + DIFFERENCE):
                try:
                    changed = design.with_(**{table: {name: now * by}})
                    alike = skin_of(changed).count == skin_of(design).count
                except InputError:
                    continue
                if alike and (force := quick_force(changed, model)):
                    exponents.append(math.log(force / own) / math.log(by))
            if exponents and max(map(abs, exponents)) > UNKNOWN:
                middle = math.fsum(exponents) / len(exponents)
                bend = np.ptp(exponents) / 2 if len(exponents) > 1 else DIFFERENCE * middle**2
                off = float(bend) + MESH_NOISE + MODEL_SHARE * abs(middle)
                result[f"{table}.{name}"] = middle - off, middle + off
    return result


def intervals(design: Design, closed_force: float) -> dict[str, tuple[float, float]]:
    """Return the interval of each key's exponent; `closed_force` N is the closed form's."""
    closed = {key: exponent for key in KEYS if (exponent := _exponent(design, closed_force, key)) is not None}
    edge = EDGE_MARGIN * skin_of(design).count ** 2
    result = {
        key: (closed[key] - off, closed[key] + off) for key, off in EXPONENT_MARGINS.items() if key in closed
    }
    if "skin.thickness" in closed:
        result["skin.thickness"] = closed["skin.thickness"] - CONFINEMENT_MARGIN, 0.0
    if "skin.width" in closed:
        result["skin.width"] = -edge, PROPORTIONAL_MARGIN
    if "ridge.pitch" in closed:
        base = closed.get("skin.width", 1.0)  # 1 is the most that it may be
        result["ridge.pitch"] = (
            closed["ridge.pitch"] - PITCH_MARGIN_BELOW,
            closed["ridge.pitch"] + base + edge + PITCH_MARGIN_ABOVE,
        )
    result["skin.length"] = 1 - FREE_ENDS, 1 + FREE_ENDS
    result[MODULUS] = 1 - PROPORTIONAL_MARGIN, 1 + PROPORTIONAL_MARGIN
    return result


def _exponent(design: Design, closed_force: float, key: str) -> float | None:
    """The logarithmic derivative of the closed form's force, one-sided where a guard forbids the other; None
    for a key that is not given or not free."""
    table, _, name = key.partition(".")
    now, ends = getattr(getattr(design, table), name, None), []
    if now is None:  # heights, one a ridge, in the place of one; or another family's key
        return None
    for by in (1 - STEP, 1 + STEP):
        try:
            ends.append((math.log(by), all_touch_force(design.with_(**{table: {name: now * by}}))))
        except InputError:
            ends.append((0.0, closed_force))
    (low, first), (high, last) = ends
    return None if low == high or min(first, last) <= 0 else math.log(last / first) / (high - low)


BATCHES = 8  # Latin hypercubes, independent of each other: their spread is the sample's error
# Parts in a batch, of up to MANY ridges; of more so many fewer as pairs of ridges are more. On four templates
# 8 x 256 already come as near to the share of 100 000 parts as 10 000 drawn at random (rms 0.1 to 0.7 %, 0.03
# to 0.5 %); of two crests alone, that decide by their difference, as 4000 at random
BATCH_PARTS, FULL_BATCH_RIDGES = 512, 32
LEAST_BATCH = 16  # parts in a batch, of however many ridges
MOST_BY_DIFFERENCE = 100  # ridges whose crests are lowered one by one; of more the slopes are the tangent's
MOST_PARTS = 0.95  # share of the parts, of which the force is told that they need
FORCE_STEP, FARTHEST = 3e-3, 64.0  # of that force, relative: its precision, and how far it is looked for
STUDENT, NORMAL = 2.36, 1.96  # spreads that hold 95 %: of a mean of 8, and of a known spread
SEED = 20021  # fixed, so that the same design has the same yield
MODEL_MISCLASSIFIES = 0.02  # share, measured against the condensed model in test_manufacture.py
SCALED_MISCLASSIFIES = 0.06  # share, where a better model has scaled the force; by the condensed solid, there
SCALED_FROM = 0.05  # of the force; a larger change is a better model's
HALVINGS = 50
SECTIONS = 32  # of an interval at once, five halvings: up to 500 parts together take hardly longer than one
NUDGE = 0.02  # of the largest difference between crests; for the derivative by each crest


@one_blas_thread()
def manufacture(
    model: RidgeModel,
    force: float,
    threshold: float,
    spread: Spread,
    uncertainty: float = 0.0,
    stiffness_error: float = 0.0,
) -> Yield:
    """Return yield and sensitivities of a pad whose all-touch force is `threshold` N, at `force` N.

    The threshold is known to `uncertainty` N, and the error of the yield covers that; of a negligible one the
    pad's stiffness is known to `stiffness_error`, relative. The threshold may come from a better model than
    the model. That model's effects are then taken as a change of stiffness, so the force is scaled (measured
    in test_manufacture.py for free ends).
    """
    unit, scale, count = model.unit, model.scale, model.gap.size
    model_threshold = threshold / scale
    if threshold > NEGLIGIBLE * force or count <= MOST_BY_DIFFERENCE:
        model_threshold = float(all_touch(model, np.zeros((1, count)), model_threshold)[0])
    # the ratio of two negligible all-touch forces is rounding
    counts = min(model_threshold * scale, threshold) > NEGLIGIBLE * force
    softer = model_threshold * scale / threshold if counts else 1.0
    scaled_force = force / scale * softer
    crest_offsets, moduli = _parts(spread, unit, count)
    part_forces = scaled_force * spread.modulus[1] / moduli
    passing = _passing(model, crest_offsets, part_forces)
    both = float(passing.mean())
    crests = float(_passing(model, crest_offsets, np.full(moduli.size, scaled_force)).mean())
    material = float((part_forces >= model_threshold).mean())
    worst = best = passing
    # where the threshold is larger, and smaller
    if relative := (uncertainty and uncertainty / threshold) if counts else stiffness_error:
        worst = _passing(model, crest_offsets, part_forces / (1 + relative))
        best = np.ones_like(passing)
        if relative < 1:
            best = _passing(model, crest_offsets, part_forces / (1 - relative))
    wrong = MODEL_MISCLASSIFIES if abs(softer - 1) < SCALED_FROM else SCALED_MISCLASSIFIES
    low, high = _share_bound(worst, -wrong), _share_bound(best, wrong)
    per_unit = scale / softer  # N
    needed = _force_of_most(
        model, crest_offsets, moduli / spread.modulus[1], scaled_force, model_threshold, wrong
    )
    at = model_threshold if counts else needed.value or scaled_force
    if needed.value is not None:
        error = ((needed.error or 0.0) + relative * needed.value) * per_unit
        needed = Estimate(needed.value * per_unit, error, "N")
    if count > MOST_BY_DIFFERENCE:
        slopes = _tangent_slopes(model, at, counts)
    else:  # one-sided, of each crest alone
        nudge = NUDGE * (float(np.ptp(model.gap)) or 1.0) if counts else spread.crest_sigma / unit or NUDGE
        slopes = (all_touch(model, nudge * np.eye(count), model_threshold) - model_threshold) / nudge
    needs_more = (
        f"the design itself, which needs {threshold:.3g} N of {force:g} N: less curvature, a softer silicone "
        "or higher features"
    )
    return Yield(
        Estimate(both, max(both - low, high - both), "1"),
        (low, high),
        tuple(float(s) for s in slopes * per_unit / unit),
        threshold / spread.modulus[1],
        _largest(spread, both, crests, material) if threshold <= force else needs_more,
        needed,
    )


def _force_of_most(
    model: RidgeModel, crest_offsets: Array, stiffer: Array, guess: float, threshold: float, wrong: float
) -> Estimate:
    """The force from which on MOST_PARTS of the parts pass, with the sample's error and that of `wrong` as
    in `_share_bound`; no value where none up to FARTHEST times the guess, or the threshold, does.

    `stiffer` `(parts,)` is each part's modulus over the design's. The share is sought as a normal law's
    deviation over the force's logarithm, in which it is nearly straight.
    """
    shares, samples = dict[float, float](), dict[float, Mask]()
    wanted, most = float(special.ndtri(MOST_PARTS)), 0.5 / stiffer.size

    def missing(log_force: float) -> float:
        if log_force not in shares:
            samples[log_force] = _passing(model, crest_offsets, guess * math.exp(log_force) / stiffer)
            share = min(max(float(samples[log_force].mean()), most), 1 - most)
            shares[log_force] = float(special.ndtri(share)) - wanted
        return shares[log_force]

    farthest = math.log(FARTHEST * max(1.0, threshold / guess))
    end = math.copysign(math.log(2), -missing(0.0))
    while abs(end) < farthest and missing(end) * missing(0.0) > 0:
        end = math.copysign(min(2 * abs(end), farthest), end)
    if missing(end) * missing(0.0) > 0:  # even the lightest force is enough, or the largest is not
        return Estimate(0.0, guess * math.exp(end), "N") if end < 0 else Estimate(None, None, "N")
    at = float(optimize.brentq(missing, *sorted((0.0, end)), xtol=FORCE_STEP))
    passing = samples[min(shares, key=lambda log_force: abs(log_force - at))]
    bounds = special.ndtri([_share_bound(passing, sign * wrong) for sign in (-1, 1)]) - wanted
    known = sorted(shares)
    low, high = np.interp(bounds, [shares[log_force] for log_force in known], known)
    value = guess * math.exp(at)
    return Estimate(value, value * (FORCE_STEP + float(max(at - low, high - at, 0.0))), "N")


def _tangent_slopes(model: RidgeModel, force: float, counts: bool) -> Array:
    """The change of the all-touch force by each crest's drop `(n,)`, with every ridge as stiff as it is under
    `force`: the ridge that touches last there stays the last, or, of crests that are all alike, this one
    becomes it."""
    carried = ridge_forces(model, np.zeros((1, model.gap.size)), np.array([force]))[0]
    own = [
        np.interp(load, model.force, np.gradient(row, model.force))
        for load, row in zip(carried, model.indentation, strict=True)
    ]
    stiffness = np.linalg.inv(model.coupling + np.diag(own))
    by_one = stiffness.sum(axis=1)
    last = int(np.argmin(carried))
    stays = stiffness[last] / by_one[last] * by_one.sum() - by_one
    becomes = stiffness.diagonal() / by_one * by_one.sum() - by_one
    late = carried <= carried[last] + NEGLIGIBLE * force / carried.size
    return np.asarray(np.where(late, becomes, stays) if counts else becomes)


FACE_FINENESS, FACE_ORDER, FACE_BATCH = 0.5, 2, 32  # of the section, and parts in a batch
MIDDLE_95 = 0.025, 0.975


@one_blas_thread()
def face_yield(design: Design, approach: Estimate, width: Estimate, force: float, spread: Spread) -> Yield:
    """Return how parts of a flat skin differ at `force` N; `approach` and contact `width` are the design's.

    Each touches at any force, but gives way more or less by its modulus and by how far its face is out of
    true: by independent crest errors at FACE and the parabola through them, so that it tilts and bends. Of a
    round face both sides err alike. Each part is pressed on one coarse section in small strain, of which the
    ratios to the design count.
    """
    from skincad.mechanics.bodies.mesh import plane_piece
    from skincad.mechanics.contact.frictionless import Ridges, press
    from skincad.mechanics.models.linear import level, width_of

    meshed = plane_piece(focused(pad_of(design), force), FACE_FINENESS, whole=True)
    solution = level(meshed, FACE_ORDER, force)
    ridges, x = solution.ridges, solution.ridges.across * design.skin.width / 2
    drops, moduli = _parts(spread, solution.unit, len(FACE), FACE_BATCH)
    if design.skin.round:
        drops[:, [0, -1]] = drops[:, [0, -1]].mean(axis=1, keepdims=True)

    def pressed(part: Ridges, modulus: float) -> tuple[float, float]:
        state = press(part.flexibility, part.gap, force / solution.scale * spread.modulus[1] / modulus)
        return state.approach, width_of(x, state.force)[0]

    drawn = [pressed(ridges.lowered(drop), modulus) for drop, modulus in zip(drops, moduli, strict=True)]
    ratios = np.array(drawn) / pressed(ridges, spread.modulus[1])
    low, high = np.quantile(ratios, MIDDLE_95, axis=0) * [approach.value or 0.0, width.value or 0.0]
    low[1], high[1] = np.minimum([low[1], high[1]], design.skin.width)
    cause = f"errors of the face by the {spread.process} mold (sigma {spread.crest_sigma:g} mm)"
    if np.ptp(moduli) and np.corrcoef(moduli, ratios[:, 0])[0, 1] ** 2 > 0.5:
        cause = f"the modulus ({spread.modulus[0]:g} to {spread.modulus[2]:g} MPa)"
    return Yield(
        passing=Estimate(1.0, 0.0, "1"),
        interval=(1.0, 1.0),
        crest_sensitivity=(),
        modulus_sensitivity=0.0,
        largest=f"nothing: a face touches at any force. Its approach differs most by {cause}",
        needed=Estimate(0.0, 0.0, "N"),
        approaches=(float(low[0]), float(high[0])),
        widths=(float(low[1]), float(high[1])),
    )


def all_touch(model: RidgeModel, crest_offsets: Array, guess: float) -> Array:
    """Return the smallest force `(s,)` at which all ridges of each part touch, section by section."""
    low, high = np.zeros(len(crest_offsets)), np.full(len(crest_offsets), max(guess, 1e-12))
    for _ in range(HALVINGS):
        short = (ridge_forces(model, crest_offsets, high) <= 0).any(axis=1)
        if not short.any():
            break
        low, high = np.where(short, high, low), np.where(short, 2 * high, high)
    sections = max(2, min(SECTIONS, BATCH // len(crest_offsets)))
    shares, part = np.arange(sections + 1) / sections, np.arange(len(crest_offsets))
    same = np.repeat(crest_offsets, sections - 1, axis=0)
    for _ in range(math.ceil(HALVINGS / math.log2(sections))):
        force = low[:, None] + (high - low)[:, None] * shares
        carried = ridge_forces(model, same, force[:, 1:-1].ravel())
        short = (carried <= 0).any(axis=1).reshape(len(crest_offsets), -1).sum(axis=1)
        low, high = force[part, short], force[part, short + 1]
    return high


def _share_bound(passing: Mask, wrong: float) -> float:
    """An end of the interval of the share that passes: the upper one where `wrong` is positive.

    `wrong` is the share of parts that the model misjudges where half of them pass. The sample's part is
    Wilson's score interval (J. Am. Stat. Assoc. 22 (1927) 209), which ends at 0 and 1. It counts as many
    parts as, drawn at random, would scatter like these hypercubes.
    """
    share, parts = float(passing.mean()), float(passing.size)
    batches = passing.reshape(BATCHES, -1).mean(axis=1)
    variance = float(batches.var(ddof=1)) / BATCHES * (STUDENT / NORMAL) ** 2
    if variance:
        parts = max(parts, share * (1 - share) / variance)
    share += 4 * wrong * share * (1 - share)
    middle = share + NORMAL**2 / (2 * parts)
    half = NORMAL * math.sqrt(share * (1 - share) / parts + (NORMAL / (2 * parts)) ** 2)
    end = (middle + math.copysign(half, wrong)) / (1 + NORMAL**2 / parts)
    return min(max(end, 0.0), 1.0)  # against rounding alone


def _parts(spread: Spread, unit: float, count: int, batch: int = BATCH_PARTS) -> tuple[Array, Array]:
    """Crest offsets `(parts, count)`, lower where positive, in units, and moduli `(parts,)`, MPa, batch after
    batch.

    McKay, Beckman and Conover, Technometrics 21 (1979) 239: each number's distribution is hit evenly.
    """
    parts = int(batch * min(1.0, (FULL_BATCH_RIDGES / count) ** 2))
    size = BATCHES, max(LEAST_BATCH, parts), count + 1
    rng = np.random.default_rng(SEED)
    strata = rng.permuted(np.broadcast_to(np.arange(size[1])[:, None], size), axis=1)
    drawn = ((strata + rng.random(size)) / size[1]).reshape(-1, count + 1)
    low, _, high = spread.modulus
    crest_offsets = spread.crest_sigma / unit * special.ndtri(drawn[:, :count])
    return np.asarray(crest_offsets), low + (high - low) * drawn[:, count]


def _passing(model: RidgeModel, crest_offsets: Array, force: Array) -> Mask:
    """Whether all ridges of each part touch `(parts,)`, each under its own force."""
    return np.asarray((ridge_forces(model, crest_offsets, force) > 0).all(axis=1))


def _largest(spread: Spread, both: float, crests: float, material: float) -> str:
    if both >= 1.0:
        return ""
    if crests <= material:
        return (
            f"crest errors of the {spread.process} mold (sigma {spread.crest_sigma:g} mm): a finer process, "
            "or all lengths larger and E smaller by the square"
        )
    low, _, high = spread.modulus
    return f"the modulus ({low:g} to {high:g} MPa): test the batch (fit-material), or take a softer grade"
