"""Whether errors of faces, round faces, rings, pins and magnets hold on random designs: of checks and scenes.

`python -m bench.families 30 --seed 6200`: designs of these three kinds by turns, without friction pressed by
`linear` and by `finite-strain`, judged by the latter on a finer mesh; and pulled to gross slip in small
strain, judged on the finest mesh with half the steps. No constant was set on a random one.

`python -m bench.families 12 --seed 6400 --pins`: pins, and rows of three pins on magnets, by turns. CalculiX
judges checks of pins (bench/pins.py), and fields and told forces of magnets where it has put them; the fields
are magpylib's there, and components below FAINT of the largest are left out, as meshes are not symmetric.
Scenes in small and at finite strain are judged by cells of twice the mesh, tables of half their steps and
half the scene's: when pins slip, and the forces that the coarse map tells of the finer one's fields.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import skincad
from bench import pins, runner
from skincad.base import Estimate, RefusedError
from skincad.effects import pin_pad
from skincad.effects.magnet import force_estimates
from skincad.inputs import Design
from skincad.mechanics import ContactCheck, magnetic_pins
from skincad.mechanics.models import pin_body, pin_cell
from skincad.scenes import LEVELS, Scene, at_level
from skincad.shape import skin_of

KINDS, OF_PINS = ("face", "round face", "rings"), ("pins", "magnets")
FAINT = 0.05
RATIO, FINE = 0.4, 9  # Poisson's, as CalculiX has no hybrid elements, and its elements over a tip
FINER = 2e-3  # relative, of the judge's mesh
STEPS = 60


@dataclass(frozen=True)
class Held:
    """Of a seed: its kind, and by what is judged how many numbers lie within their errors, of how many."""

    seed: int
    kind: str
    held: dict[str, list[int]]


def drawn(seed: int) -> tuple[str, Design, float]:
    """Return a seed's kind, design and coefficient of friction."""
    rng, kind = np.random.default_rng([seed, 62]), KINDS[seed % len(KINDS)]
    thickness, width, radius = rng.uniform(2.0, 7.0), rng.uniform(14.0, 26.0), rng.uniform(40.0, 200.0)
    modulus, pitch = rng.uniform(0.1, 0.8), width / 8
    skin: dict[str, Any] = {"curvature_radius": radius, "thickness": thickness, "width": width}
    skin |= {"length": rng.uniform(12.0, 30.0)} if kind == "face" else {"outline": "round"}
    ring = {"count": 3, "pitch": pitch, "height": rng.uniform(0.4, 1.2), "crown": 0.05}
    ring |= {"root_width": 0.7 * pitch, "tip_width": 0.5 * pitch, "tip_fillet": 0.08, "root_fillet": 0.1}
    design = Design(
        name="drawn",
        skin=skin,
        material={"young_modulus": modulus, "poisson_ratio": 0.495},
        mold={"process": "sla"},
        contact={"force": modulus * rng.uniform(2.0, 9.0), "friction": 0.0},
        **({"ring": ring} if kind == "rings" else {"flat": {}}),
    )
    return kind, design, rng.uniform(0.2, 0.9)


def judged(seed: int) -> Held:
    """Return what holds of a seed; InputError where its design is refused."""
    kind, design, friction = drawn(seed)
    best = skincad.check(design, model="finite-strain", tol=FINER)
    held = {model: _within(skincad.check(design, model=model), best) for model in ("linear", "finite-strain")}
    force = design.contact.force

    def scene(steps: int) -> Scene:
        return Scene(
            name="drawn",
            skin=design,
            history={
                "steps": steps,
                "time_s": [0.0, 0.2, 1.0],
                "normal_force_N": [0.0, force, force],
                "tangential_force_N": [0.0, 0.0, 1.05 * friction * force],
            },
            effects={"friction": {"coefficient": friction}},
        )

    told, true = skincad.simulate(scene(STEPS), model="small_strain"), at_level(scene(2 * STEPS), LEVELS[-1])
    both = zip(told.slip_steps, true.slip_steps, told.slip_step_errors, strict=True)
    near = [abs(a - b / 2) <= e.numerical + 0.5 for a, b, e in both if a and b and e]
    steps = min(told.slip_share.size, true.slip_share[::2].size)
    off = float(np.abs(told.slip_share[:steps] - true.slip_share[::2][:steps]).mean())
    held |= {
        "slip steps": [sum(near), len(near)],
        "slip share": [int(off <= (told.slip_share_error or 0.0)), 1],
    }
    return Held(seed, kind, held)


def _within(told: ContactCheck, best: ContactCheck) -> list[int]:
    """How many of a check's numbers lie within their errors, and the best's, of how many."""
    pairs: list[tuple[Estimate, Estimate]] = [(told.approach, best.approach)]
    if told.ridges > 1:
        pairs += [
            (told.all_touch_force, best.all_touch_force),
            *zip(told.ridge_force, best.ridge_force, strict=True),
        ]
    near = [
        abs((a.value or 0.0) - (b.value or 0.0)) <= (a.error or 0.0) + (b.error or 0.0)
        for a, b in pairs
        if a.value is not None and b.value is not None
    ]
    return [sum(near), len(near)]


def pins_judged(seed: int) -> Held:
    """Return what holds of a seed's pins; InputError where its design is refused."""
    if seed % 2:
        return Held(seed, OF_PINS[1], _magnets(*magnetic(seed)))
    design = pins.random_pins(seed).with_(material={"poisson_ratio": RATIO})
    try:
        true, first, approach, share = pins.compared(design)
    except RuntimeError as failure:
        raise RefusedError(str(failure).splitlines()[0]) from None
    told = skincad.check(design, model="reduced")
    off = (abs(first) * true, told.all_touch_force), (abs(approach) * told.approach.value, told.approach)
    near = [difference <= (estimate.error or 0.0) for difference, estimate in off]
    near.append(share * told.force / told.ridges <= max(force.error or 0.0 for force in told.ridge_force))
    return Held(seed, OF_PINS[0], {"CalculiX's check": [sum(near), len(near)]})


def magnetic(seed: int) -> tuple[Design, float]:
    """Return a row of three pins on magnets, the middle one highest, and a coefficient of friction."""
    draw = np.random.default_rng([seed, 63]).uniform
    tip, thickness, modulus = draw(1.5, 3.5), draw(1.5, 4.0), draw(0.1, 0.8)
    root, height, wide, long = (
        tip * draw(1.05, 1.3),
        tip * draw(1.0, 1.7),
        tip * draw(0.3, 0.5),
        draw(0.8, 1.4),
    )
    pitch, grade = root * draw(1.4, 2.2), ("N35", "N42", "N52")[int(draw(0, 3))]
    magnet = {"diameter": wide, "length": long, "grade": grade}
    depth = max(thickness + height * draw(0.05, 0.35), long + 0.3)
    design = Design(
        name="drawn",
        skin={"curvature_radius": 1e8, "thickness": thickness, "width": 4 * pitch, "length": 2.2 * pitch},
        pin={
            "columns": 3,
            "rows": 1,
            "pitch": pitch,
            "heights": [height * part for part in (0.97, 1.0, 0.98)],
            "root_diameter": root,
            "tip_diameter": tip,
            "crown": tip * draw(0.08, 0.25),
            "root_fillet": 0.1 * tip,
            "pocket": {"diameter": wide - 0.1, "depth": depth, "magnet": magnet},
        },
        material={"young_modulus": modulus, "poisson_ratio": RATIO},
        mold={"process": "sla", "pour": "open"},
        contact={"force": modulus * tip**2 * draw(0.08, 0.16), "friction": 0.0},
        magnetometer={"below": draw(0.5, 2.0), "range": 1000.0, "noise": 0.0, "rate": 1e4},
    )
    return design, draw(0.2, 0.9)


@contextmanager
def finer() -> Iterator[None]:
    """Cells of pins of twice the mesh, and tables of half the steps."""
    halves = ("AT_TIP", "ON_FLANK", "IN_BASE", "SWAY", "STRAIN", "OF_BUCKLING")
    usual = [(pin_cell, "FINENESS", 1.0), *((pin_body, name, getattr(pin_body, name)) for name in halves)]
    caches = pin_cell.pin_cell, pin_cell.pin_curve, pin_body.pin_body, pin_body.bent_pin
    for factor in (0.5, 1.0):
        for module, name, value in usual:
            setattr(module, name, value / factor if module is pin_cell else value * factor)
        for cached in (*caches, magnetic_pins, pin_pad._sticking):
            cached.cache_clear()
        if factor < 1.0:
            yield


def _field(design: Design, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """magpylib's field `(s, 3)` mT at the sensors, of magnets that have gone and turned by `poses`."""
    import magpylib

    every, field = magnetic_pins(design), 0.0
    north, size = every.remanence * np.array(every.north), (2 * every.radius, every.length)
    for middle, pose in zip(every.middle, poses, strict=True):
        magnet = magpylib.magnet.Cylinder(polarization=north, dimension=size)
        turned = magnet.rotate(Rotation.from_rotvec(pose[3:]))
        field = field + turned.move(middle + pose[:3]).getB(every.place)
    return np.asarray(field)


def _read(
    design: Design,
    seen: NDArray[np.float64],
    further: list[Callable[[NDArray[np.float64]], NDArray[np.float64]]],
    tips: NDArray[np.float64],
) -> list[bool]:
    """Whether each component of the forces that fields `(steps, s, 3)` mT tell is within its error."""
    sensors = design.magnetometer
    assert sensors is not None
    inside = np.ones(len(seen[0]), dtype=bool)
    told = force_estimates(
        seen, further, magnetic_pins(design), lambda load, more: more(load), sensors, inside
    )
    assert told is not None
    return [bool(off <= told.error) for off in np.abs(told.forces - tips).max(axis=0).ravel()]


def _share(near: list[bool]) -> list[int]:
    return [sum(map(bool, near)), len(near)]


def _magnets(design: Design, friction: float) -> dict[str, list[int]]:
    """What holds of pins on magnets."""
    check, every = skincad.check(design), magnetic_pins(design)
    count, force = len(every.middle), design.contact.force
    loads = [(pin + 1, axis) for pin in range(count) for axis in range(3)]
    theirs, _ = pins.magnet_moves(design, loads, skin_of(design).profile.tip_width / FINE)
    goes = np.moveaxis(theirs.reshape(count, 3, count, 6), (2, 3), (0, 1))
    tips = np.array([[0.0, 0.0, -(one.value or 0.0)] for one in check.ridge_force])
    change = _field(design, np.einsum("ncmd,md->nc", goes, tips)) - _field(design, np.zeros((count, 6)))
    largest = float(np.abs(change).max())
    told = [b for sensor in check.magnet.sensors for b in sensor.change] if check.magnet else []
    both = [(b, true) for b, true in zip(told, change.ravel(), strict=True) if abs(true) > FAINT * largest]
    held = {"CalculiX's fields": _share([abs(b.value - true) <= b.error for b, true in both])}
    rng, forces = np.random.default_rng(1), list[bool]()
    for _ in range(4):
        tips[:, :2] = 0.3 * tips[:, 2:] * rng.uniform(-1, 1, (count, 2))
        seen = _field(design, np.einsum("ncmd,md->nc", goes, tips))[None]
        forces += _read(design, seen, [lambda load: np.zeros((len(load), 6))], tips[None])
    held["CalculiX's forces"] = _share(forces)

    def swaying(load: NDArray[np.float64]) -> NDArray[np.float64]:
        sway = 1 - np.minimum(pin_pad.pin_pad(design).tips.sway(-load[:, 2]), 0.9)
        return every.poses(load / np.stack([sway, sway, np.ones_like(sway)], axis=1) - load)

    for name, model, law in (("small", "small_strain", {}), ("finite", "auto", {"steps": "chosen"})):
        history = {"time_s": [0.0, 0.2, 1.0], "normal_force_N": [0.0, force, force]}
        history |= {"tangential_force_N": [0.0, 0.0, 1.05 * friction * force]}
        effects = {"friction": {"coefficient": friction}, "magnet": {}}
        effects |= {"finite_strain": law} if law else {}
        scenes = [
            Scene(name="drawn", skin=design, history={"steps": steps, **history}, effects=effects)
            for steps in (STEPS, 2 * STEPS)
        ]
        told = skincad.simulate(scenes[0], model=model)
        with finer():
            true = at_level(scenes[1], LEVELS[-1])
        both = zip(told.slip_steps, true.slip_steps, told.slip_step_errors, strict=True)
        near = [abs(a - b / 2) <= e.numerical + 0.5 for a, b, e in both if a and b and e]
        held[f"slip steps, {name} strain"] = _share(near)
        steps = min(len(told.march.readings), (len(true.march.readings) + 1) // 2)
        further = [reading.magnets or swaying for reading in told.march.readings[:steps]]
        fields = [[axes[axis] for axis in "xyz"] for axes in true.read["field_mT"].values()]
        seen = np.moveaxis(np.array(fields), 2, 0)[: 2 * steps : 2]
        tips = np.array([reading.tips for reading in true.march.readings])[: 2 * steps : 2]
        held[f"forces read, {name} strain"] = _share(_read(design, seen, further, tips))
    return held


def summary(cases: list[Held], kinds: tuple[str, ...] = KINDS) -> list[str]:
    """Return the table: what is judged, by kind."""
    lines = []
    for what in dict.fromkeys(what for case in cases for what in case.held):
        of_kinds = [[case.held.get(what, [0, 0]) for case in cases if case.kind == kind] for kind in kinds]
        sums = [np.sum([[0, 0], *rows], axis=0).tolist() for rows in of_kinds]
        lines.append((what, *(runner.share(*both) if both[1] else "" for both in sums)))
    return runner.table(("within their errors", *kinds), lines)


def main() -> None:
    """Print the table."""
    parser = runner.parser(__doc__, "count", seed=6200)
    parser.add_argument("--pins", action="store_true", help="pins and magnets in the place of the others")
    options = parser.parse_args()
    seeds = range(options.seed, options.seed + options.count)
    name, judge, kinds = ("pins", pins_judged, OF_PINS) if options.pins else ("families", judged, KINDS)
    print("\n".join(summary(runner.rows(name, judge, seeds, options, kind=Held), kinds)))


if __name__ == "__main__":
    main()
