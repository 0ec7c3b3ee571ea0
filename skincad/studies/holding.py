"""What a skin does in a gripper's hand: a check with a slow lift's signal, and with the lifts that it holds.

A slow lift has no slip to hear: its signal is that of a pull that rises while all ridges stick. The lifts are
drawn: friction, how the load comes, its bumps and jerks, and the first grip (`history`, `drawn_lift`; all
ranges are assumptions). Each is marched as `simulate` marches a lift on its coarsest mesh: all films wired,
behind AMPLIFIER, and the gripper grips harder at each alarm. The same lifts are drawn each time, so that two
skins are compared by the same ones.
"""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError, require_number, resource_guard
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.inputs.gripper import Gripper, gripper_named, grippers
from skincad.mechanics import check as contact
from skincad.mechanics.models.table import MODELS
from skincad.mechanics.verdict import ContactCheck, Holding, LiftSignal
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.scenes.carrying import Carrier
    from skincad.scenes.lift import LiftRun
    from skincad.scenes.scene import Scene

AMPLIFIER = "single-supply"  # what `export --detector` takes where none is named
RATE, BAND = 2000.0, 800.0  # Hz, of the samples and of the low-pass before them
PULL, SLOW = 0.5, 0.3  # N on a finger, s in which it is reached: a slow lift; assumption
# fineness and order of its mesh; dB: on the templates it differs by 1.1 from the finest mesh of film_stress
COARSE, LEVEL_ERROR = (0.5, 3), 1.5
SIGNAL_SECONDS = 2.0  # of a budget that is left, for that mesh
LIFTS = 20  # without a budget: some 20 s, and a share to a fifth or better
MOST_LIFTS = 1000
SMALL_SLIDE = 1.0  # mm; an object that slides further does not count as held, as in bench/lifts
# g; a light object swings fast on the skin, which takes finer steps: on gripper-pad, the worst template, 20 g
# take 2.1 times as long as 100 g, 15 g 2.2, 10 g 3.3 and 2 g 12 times
LIGHTEST, HEAVIEST = 15.0, 2e4
SEED = 64
# what loses an object
NO_ALARM, TOO_LATE, TOO_WEAK = "no alarm", "an alarm too late", "the gripper's largest force"
OVERLOADED, NOT_CONVERGED = "a grip that the skin does not bear", "a march that does not converge"

FRICTION = 0.2, 1.0
RISE = 0.05, 0.8  # s, in which the load comes
FIRST = 0.4, 1.1  # of the least grip: the first one
ACCELERATION = 0.5, 5.0  # m/s2
LIFT = 0.1, 0.3  # s
HOLD = 0.3  # s, at the end
RETARDATION = 5e-4  # s; a loss factor of 0.1 at 30 Hz, as soft silicones have
CLOSE = 0.1  # s
KINDS = ("lift", "smooth", "bump", "jerk", "stages", "sink")
POINTS = 24  # of a bend


def check(
    design: Design,
    *,
    force: float | None = None,
    tol: float | None = None,
    budget: float | None = None,
    model: str = "auto",
    measured: Path | str | None = None,
    hold: str | float | None = None,
    gripper: str | None = None,
    signal: bool = False,
    progress: Progress | None = None,
    on_verdict: contact.OnVerdict | None = None,
) -> ContactCheck:
    """Return whether all ridges touch a rigid plate at `force` N (the design's own if None).

    `model` names a model; `auto` starts with the cheapest that may do and takes better ones until the whole
    relative error of the all-touch force is `tol`; without `tol` until the verdict is clear and the error
    that a better model removes is 3 %, if that ends within 15 s, but no further where the force is less than
    half of what is needed; with a `budget` in seconds, no further than it may last. If a model refuses, the
    verdict of the one before stands. With a model named, `tol` and `budget` are asked of its mesh. `measured`
    is a CSV of a cast part's crest heights (columns ridge, crest_mm), to judge that part. `on_verdict` is
    called with each model's verdict as soon as it is known. Passed means: all touch, and the all-touch force
    with its error still lies at or below the force.

    `hold` is an object's mass, as "0.3kg", "300g" or 300 (g): `holding` then says how many of 20 drawn lifts
    are held by a `gripper` of that name, mold.mount if None, that hears the skin's films. Held is what stays
    and slides by less than 1 mm. That takes some 20 s, and for light objects up to three times as long; with
    a `budget` as many lifts as fit in what is left of it. `signal` asks how far a slow lift's
    signal stands over the noise, `lift_signal`, which takes some 0.5 s and is left out without films, with
    the closed form and where the budget is used up.

    Raises InputError for a force, tolerance, budget, model, mass or gripper out of range, and for `hold` of a
    skin without films in ridges; RefusedError for an object too light for this skin.
    """
    began = perf_counter()
    if hold is None and gripper is not None:
        raise InputError("gripper", "needs a mass to hold", gripper, "give hold, as 0.3kg")
    if hold is not None and not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    grams, hand = (None, "") if hold is None else asked_lifts(design, hold, gripper)
    verdict = contact.check(
        design,
        force=force,
        tol=tol,
        budget=budget,
        model=model,
        measured=measured,
        progress=progress,
        on_verdict=on_verdict,
    )

    def left() -> float:
        return math.inf if budget is None else max(0.0, budget - (perf_counter() - began))

    if signal and MODELS[verdict.model].meshed and left() > SIGNAL_SECONDS:
        if progress:
            progress("signal of a slow lift")
        verdict = with_signal(verdict, design)
    if grams is not None:
        seconds = None if budget is None else left()
        verdict = replace(
            verdict, holding=holding_of(design, grams, hand, seconds=seconds, progress=progress)
        )
    return verdict


def with_signal(verdict: ContactCheck, design: Design) -> ContactCheck:
    """Return a check with a slow lift's signal, on the skin pressed by the check's force; of a skin without
    films as it is. Where the signal can't be computed a warning says why."""
    if not hears(design):
        return verdict
    try:
        with resource_guard("the signal of a slow lift"):
            signal = lift_signal(design.with_(contact={"force": verdict.force}))
    except (InputError, RefusedError) as failure:
        return replace(verdict, warnings=(*verdict.warnings, f"no signal of a slow lift: {failure}"))
    return replace(verdict, lift_signal=signal)


def mass_of(hold: str | float) -> float:
    """Return an object's mass, g, of a number of g or a text as "0.3kg"; raises InputError for none."""
    mass = hold
    if isinstance(hold, str):
        match = re.fullmatch(r"\s*([-+]?(?:\d+(?:\.\d*)?|\.\d+))\s*(kg|g)?\s*", hold)
        if match is None:
            raise InputError("hold", "must be a mass", hold, "as in 0.3kg, 300g or 300")
        mass = float(match[1]) * (1e3 if match[2] == "kg" else 1.0)
    rule = f"must be {LIGHTEST:g} to {HEAVIEST:g} g"
    require_number("hold", mass, lambda value: LIGHTEST <= value <= HEAVIEST, rule)
    return float(mass)


def asked_lifts(design: Design, hold: str | float, gripper: str | None = None) -> tuple[float, str]:
    """Return the mass, g, and the gripper of lifts, mold.mount if None.

    Raises InputError for a mass out of range, a skin without films in ridges, a gripper that is missing,
    unknown or whose delay and forces nobody knows, and a mass that it can't hold at any friction.
    """
    mass_of(hold)
    if not hears(design):
        rule = f"needs films in straight ridges, and {design.name} has none"
        raise InputError("hold", rule, hold, "add [slot] and [film], or leave it out")
    name = gripper or design.mold.mount
    if name is None:
        remedy = "name one, or give mold.mount in the design"
        raise InputError("gripper", f"is missing, and {design.name} has no mold.mount", remedy=remedy)
    return asked_mass(hold, name, design.grippers or {}), name


def asked_mass(hold: str | float, name: str, own: Mapping[str, Gripper]) -> float:
    """Return the mass, g, that a gripper of a name is to hold; raises InputError as `asked_lifts` does."""
    from skincad.scenes.grip import FINGERS, GRAVITY

    grams, hand = mass_of(hold), known_gripper(name, own)
    most = FRICTION[1] * FINGERS * (hand.force_max or 0.0) / GRAVITY * 1e3
    if grams > most:
        by = f"{name} holds with {hand.force_max:g} N at a friction of {FRICTION[1]:g}"
        rule = f"must be at most {most / 1e3:.3g} kg, which {by}"
        raise InputError("hold", rule, hold, "take a lighter object or a stronger gripper")
    return grams


def known_gripper(name: str, own: Mapping[str, Gripper]) -> Gripper:
    """Return a gripper whose delay and forces are known; raises InputError for any other."""
    try:
        hand = gripper_named(name, own)
    except InputError as failure:
        raise InputError("gripper", failure.rule, failure.value, failure.remedy) from None
    if missing := [key for key in ("delay", "force_rate", "force_max") if getattr(hand, key) is None]:
        able = [key for key, row in grippers(own).items() if None not in (row.delay, row.force_rate)]
        remedy = "give it in a grippers.toml" + (f", or take {' or '.join(able)}" if able else "")
        raise InputError("gripper", f"has no {', no '.join(missing)}", name, remedy)
    return hand


def hears(design: Design) -> bool:
    """Return whether a design has films in straight ridges, which stress crosses."""
    ridges = skin_of(design).family == "ridge" and skin_of(design).body == "straight"
    there = skin_of(design).slot is not None and design.film is not None and design.film_state == "bonded"
    return ridges and there


@lru_cache(maxsize=64)
def lift_signal(design: Design) -> LiftSignal:
    """Return how far the films' signal of a slow lift stands over the noise of film and amplifier.

    The pull rises to PULL within SLOW along a straight line, on a skin pressed by the design's own force, all
    of whose touching points stick: small strain, plane strain (stick.py). The charge then goes through
    AMPLIFIER, sampled at RATE, from rest. All films are wired: the loudest pair counts.
    """
    from skincad.circuit.model import circuit_network, fitted, load_circuit
    from skincad.circuit.state import rms_behind
    from skincad.detector.detector import SLOWEST
    from skincad.effects.piezo import Chain, strip_charges

    circuit = fitted(load_circuit(AMPLIFIER), design)
    network = circuit_network(circuit)
    time = np.arange(round(SLOW * RATE) + 1) / RATE
    charges = strip_charges(circuit, design, time[:, None, None] / SLOW * PULL * pull_stress(design))
    chain = Chain.of(network, time, BAND)
    outputs = np.array([chain.output(row) for row in charges.T])
    pairs = outputs[::2] - outputs[1::2]
    rms = np.sqrt(np.mean(pairs**2, axis=1))
    loudest = int(rms.argmax())
    noise = math.sqrt(2) * rms_behind(network, BAND, SLOWEST, RATE / 2)
    return LiftSignal(
        pull=PULL,
        rise=SLOW,
        circuit=circuit.name,
        rate=RATE,
        ridge=loudest + 1,
        signal=float(rms[loudest]),
        noise=noise,
        level=20 * math.log10(float(rms[loudest]) / noise),
        level_error=LEVEL_ERROR,
    )


def pull_stress(design: Design) -> Array:
    """Return the stresses `(strips, 3)` MPa by 1 N of pull, on a mesh without fine corners at the films."""
    from skincad.mechanics.bodies.mesh import default_sizes, piece_of, triangles
    from skincad.mechanics.film.stick import level
    from skincad.mechanics.film.stress import filled_pad

    piece = piece_of(*filled_pad(design), halved=True)
    mesh = triangles(piece.pad, default_sizes(piece.pad, COARSE[0]))
    state = level(piece, mesh, COARSE[1], design.contact.force, True).pull_state
    assert state is not None  # it was asked for
    return state.strips


@dataclass(frozen=True, eq=False)
class DrawnLift:
    """A lift by chance: the `friction` that nobody knows, N of the `least` grip that holds, how the load
    comes, and the [grip] table's keys that say so."""

    kind: str
    friction: float
    least: float
    grip: dict[str, Any]


def drawn_lift(draw: np.random.Generator, mass: float, name: str, hand: Gripper) -> DrawnLift:
    """Return a drawn lift of an object of `mass` g with a gripper of a name, whose first grip its forces
    bound."""
    from skincad.scenes.grip import FINGERS, GRAVITY

    friction, first = float(draw.uniform(*FRICTION)), float(draw.uniform(*FIRST))
    rise, kind = float(np.exp(draw.uniform(*np.log(RISE)))), str(draw.choice(KINDS))
    acceleration, up = float(draw.uniform(*ACCELERATION)), float(draw.uniform(*LIFT))
    time, load = history(draw, kind, rise)
    still = 1e-3 * mass / FINGERS * GRAVITY
    if kind == "lift":
        least = still * (1 + acceleration / GRAVITY) / friction
        how = {"rise": rise, "acceleration": acceleration, "lift": up, "hold": HOLD}
    else:
        least = still * float(load.max()) / friction
        how = {"load_time_s": time.tolist(), "load_N": (still * load).tolist()}
    force = min(max(first * least, hand.force_min or 0.0), hand.force_max or math.inf)
    acts = {key: getattr(hand, key) for key in ("delay", "force_rate", "force_max")}
    grip = {"gripper": name, **acts, "mass": mass, "force": force, "close": CLOSE, **how}
    return DrawnLift(kind, friction, least, grip)


def history(draw: np.random.Generator, kind: str, rise: float) -> tuple[Array, Array]:
    """Return times, s since the fingers closed, and loads, of the object's weight, of one of KINDS of lift
    whose load comes in `rise` s.

    Straight, or smooth as a hand's reach (minimum jerk: Flash and Hogan, J. Neurosci. 5 (1985) 1688).
    """
    straight = bool(draw.random() < 0.4)
    path = [(float(draw.uniform(0.0, 0.1)), 0.0)]  # to a time, a load

    def to(seconds: float, load: float, *, even: bool = straight) -> None:
        (begun, before), s = path[-1], np.linspace(0, 1, 2 if even else POINTS)[1:]
        share = s if even else 10 * s**3 - 15 * s**4 + 6 * s**5
        times, loads = begun + seconds * s, before + (load - before) * share
        path.extend(zip(times.tolist(), loads.tolist(), strict=True))

    if kind == "stages":  # it stops half way, or sinks back
        to(rise / 2, float(draw.uniform(0.3, 0.7)))
        to(float(draw.uniform(0.05, 0.3)), path[-1][1] * float(draw.uniform(0.5, 1.0)))
        to(rise / 2, 1.0)
    elif kind == "sink":  # what is poured in
        to(rise, float(draw.uniform(0.5, 0.8)))
        to(float(draw.uniform(0.2, 0.6)), 1.0, even=True)
    else:
        to(rise, 1.0)
    if kind == "bump":  # it hits something, which pulls at it
        to(float(draw.uniform(0.05, 0.2)), 1.0, even=True)
        half, more = float(draw.uniform(0.01, 0.05)), float(draw.uniform(0.1, 0.5))
        to(half, 1.0 + more, even=False)
        to(half, 1.0, even=False)
    elif kind == "jerk":  # an arm that rings when it starts
        for size in float(draw.uniform(0.1, 0.4)) * np.array([1.0, -0.7, 0.5, -0.35, 0.25]):
            to(float(draw.uniform(0.03, 0.08)), 1.0 + float(size), even=False)
        to(0.05, 1.0, even=False)
    elif kind == "smooth":  # up, then down again
        more = float(draw.uniform(0.05, 0.5))
        for load in (1.0 + more, 1.0 - more, 1.0):
            to(float(draw.uniform(0.05, 0.15)), load, even=False)
    to(HOLD, 1.0, even=True)
    times, loads = np.array(path).T
    if times[0] > 0.0:
        times, loads = np.append(0.0, times), np.append(0.0, loads)
    return times, loads


def first_grips(mass: float, gripper: str, own: Mapping[str, Gripper]) -> list[float]:
    """Return the first grips of the drawn lifts, N."""
    hand = known_gripper(gripper, own)
    lifts = (drawn_lift(_random(seed), mass, gripper, hand) for seed in range(LIFTS))
    return [float(one.grip["force"]) for one in lifts]


def bearing(design: Design) -> float:
    """Return the largest force on a skin, N, in small strain, if all ridges bear alike."""
    from skincad.mechanics.validity import limits

    return limits(design).largest * skin_of(design).count


def _random(seed: int) -> np.random.Generator:
    return np.random.default_rng((SEED, seed))


def holding_of(
    design: Design,
    mass: float,
    gripper: str,
    *,
    lifts: int | None = None,
    seconds: float | None = None,
    progress: Progress | None = None,
) -> Holding:
    """Return which of the first drawn `lifts`, LIFTS if None, of `mass` g are held with a gripper.

    Held is what stays and slides by less than SMALL_SLIDE. With `seconds` as many lifts as fit, one at
    least. A lift that does not converge, and one whose forces leave small strain's range, counts as not held.
    A gripper whose least force is more than the skin bears lifts nothing here: the result's reason says so.
    """
    hand, began = known_gripper(gripper, design.grippers or {}), perf_counter()
    bears = bearing(design)
    least, outcomes = hand.force_min or 0.0, list[LiftOutcome]()
    reason = ""
    if least > bears:
        reason = f"{gripper} grips with {least:g} N at least, and this skin bears {bears:.2g} N"
    most = 0 if reason else (lifts or LIFTS) if seconds is None else MOST_LIFTS
    for seed in range(most):
        spent = perf_counter() - began
        if seconds is not None and outcomes and spent * (1 + 1 / seed) > seconds:
            break
        if progress:
            progress(f"lift {seed + 1}" + (f" of {most}" if seconds is None else ""))
        outcomes.append(lifted(design, mass, gripper, seed))
    return summed(outcomes, gripper, mass, bears, reason, perf_counter() - began)


@dataclass(frozen=True)
class LiftOutcome:
    """What became of a lift: whether the object `stayed`, its `slide` mm, the mean grip over the least (None
    if it was not marched to its end), the cause if it isn't `held`, and whether forces leave small strain's
    range."""

    stayed: bool
    slide: float
    ratio: float | None
    lost_by: str
    beyond: bool = False

    @property
    def held(self) -> bool:
        """Whether the object stayed with a small slide."""
        return self.stayed and self.slide < SMALL_SLIDE


def summed(
    outcomes: list[LiftOutcome], gripper: str, mass: float, bears: float, reason: str, seconds: float
) -> Holding:
    """Return the numbers of some lifts."""
    held, ratios = sum(one.held for one in outcomes), [one.ratio for one in outcomes if one.ratio is not None]
    count, low, high = len(outcomes), None, None
    if outcomes:
        from scipy.stats import binomtest

        low, high = map(float, binomtest(held, count).proportion_ci(method="wilson"))
    return Holding(
        gripper=gripper,
        mass=mass,
        lifts=count,
        held=held,
        small_slides=held,
        stayed=sum(one.stayed for one in outcomes),
        not_converged=sum(one.lost_by == NOT_CONVERGED for one in outcomes),
        share=held / count if count else None,
        low=low,
        high=high,
        mean_grip_ratio=math.fsum(ratios) / len(ratios) if ratios else None,
        dropped_by=dict(Counter(one.lost_by for one in outcomes if not one.held)),
        beyond=sum(one.beyond for one in outcomes),
        bears=bears,
        circuit=AMPLIFIER,
        rate=RATE,
        reason=reason,
        seconds=seconds,
    )


@lru_cache(maxsize=2000)
def lifted(design: Design, mass: float, gripper: str, seed: int) -> LiftOutcome:
    """Return what becomes of the drawn lift of a seed."""
    from skincad.mechanics.problem import ContactError
    from skincad.mechanics.validity import limits
    from skincad.scenes.carrying import TONNE
    from skincad.scenes.grip import FINGERS
    from skincad.scenes.lift import carried

    hand = known_gripper(gripper, design.grippers or {})
    one = drawn_lift(_random(seed), mass, gripper, hand)
    ends = limits(design)
    if one.grip["force"] > bearing(design):
        return LiftOutcome(stayed=False, slide=math.inf, ratio=None, lost_by=OVERLOADED, beyond=True)
    scene = scene_of(design, one, seed)
    assert scene.cone is not None
    finger = replace(_carrier(design), mass=TONNE * mass / FINGERS, cone=scene.cone)
    try:
        run = carried(scene, finger, rate=RATE, seed=seed)
    except ContactError:
        return LiftOutcome(stayed=False, slide=math.inf, ratio=None, lost_by=NOT_CONVERGED)
    beyond = ends.overload_reason(float(run.loads[:, 0].max()), float(np.abs(run.loads[:, 1]).max()))
    stayed, slide = run.held and not beyond, float(np.abs(run.slide).max())
    return LiftOutcome(
        stayed=stayed,
        slide=slide,
        ratio=float(run.grip[run.time >= CLOSE].mean()) / one.least,
        lost_by="" if stayed and slide < SMALL_SLIDE else _lost_by(run, one, beyond),
        beyond=bool(beyond),
    )


def _lost_by(run: LiftRun, one: DrawnLift, beyond: str) -> str:
    """What loses an object, or lets it slide: the first link that fails."""
    if run.held and beyond:
        return OVERLOADED
    if one.grip["force_max"] < one.least:
        return TOO_WEAK
    return TOO_LATE if run.alarms else NO_ALARM


def scene_of(design: Design, one: DrawnLift, seed: int) -> Scene:
    """Return the scene of a drawn lift, as `simulate` takes it: all films wired, behind AMPLIFIER."""
    from skincad.scenes.scene import Scene

    tables: dict[str, Any] = {
        "name": f"{design.name}-lift-{seed}",
        "skin": design,
        "grip": {"policy": "detector", **one.grip},
        "effects": {
            "friction": {"coefficient": one.friction},
            "film": {},
            "viscosity": {"retardation_time": RETARDATION},
            "piezo": {"circuit": AMPLIFIER, "noise_seed": seed, "sampling_Hz": RATE},
        },
        "readout": {"ridges": list(range(1, skin_of(design).count + 1)), "bandwidth_Hz": BAND},
    }
    return Scene(**tables)


@lru_cache(maxsize=2)
def _carrier(design: Design) -> Carrier:
    """The skin's mesh and compliance, made once; the object and its friction are each lift's own."""
    from skincad.scenes.carrying import carrier
    from skincad.scenes.march import LEVELS
    from skincad.scenes.runs import MarchSetup, piece_for

    hand = Gripper(delay=0.04, force_rate=100.0, force_max=bearing(design))  # any at all
    one = drawn_lift(_random(0), 1.0, "plain-plate", hand)  # g: any at all
    scene = scene_of(design, one, 0)
    return carrier(scene, MarchSetup(scene, piece_for(scene, {})), LEVELS[0])
