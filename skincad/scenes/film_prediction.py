"""What the films of a scene will give, with the scatter that tolerances of skin and plate bring.

The scene is marched at small strain on the coarsest mesh, as it is and with what nobody knows exactly drawn
anew. The modulus moves in time when ridges touch, which no linear change describes, so its range (20 % either
way without one) is simulated in steps. Friction is drawn within 20 %, each ridge's crest by the mold's
process. Draws are those of one seed, so the same scene gives the same prediction.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.base.progress import Tick
from skincad.effects.piezo import SIDES
from skincad.inputs.design import Design, with_heights
from skincad.mechanics.check import spread_of
from skincad.scenes.march import LEVELS
from skincad.scenes.scene import Scene
from skincad.scenes.simulation import Simulation, at_level

MODULI = 7  # of a silicone's range that are simulated; assumption: timing within 3 % of the next
MEMBERS = 12  # simulations with drawn crests and friction; assumption
FEWEST_MEMBERS = 0.5  # of them that must run to the end of the press
SEED = 5
ALMOST = 0.01  # relative: two moduli that are one
LOOSE = 0.2  # relative, of what has no range
Strip = tuple[int, str]  # ridge from 1, S1 or S2


@dataclass(frozen=True, eq=False)
class FilmPrediction:
    """Outputs V at `time` `(steps,)` s: `worlds` `(moduli, strips, steps)` of skins with other `moduli`
    `(moduli,)` MPa, and what drawn crests and friction change of the scene's own `(members, strips, steps)`.

    `noise` is that of an output, V rms; the press ends at `press_end` s.
    """

    strips: tuple[Strip, ...]
    time: Array
    moduli: Array
    worlds: Array
    changes: Array
    noise: float
    press_end: float


def predict_films(
    scene: Scene, members: int = MEMBERS, tick: Tick | None = None, *, moduli: int = MODULI
) -> FilmPrediction:
    """Return the outputs of a scene's films, for `moduli` of the silicone's range, and of `members` scenes
    within the other tolerances.

    Raises InputError for a scene without films, circuit or monitored ridges, RefusedError where too few of
    the simulations reach the end of the press.
    """
    scene = recorded_scene(scene)
    strips = monitored_strips(scene)
    draw, end = np.random.default_rng(SEED), press_end(scene)
    low, value, high = modulus_range(scene.design)
    nominal = at_level(scene, LEVELS[0], tick)
    if nominal.march.time[-1] < end:
        raise RefusedError(f"the scene stops before its press ends: {nominal.march.stopped}")
    others = [m for m in np.geomspace(low, high, moduli).tolist() if abs(m / value - 1) > ALMOST]
    runs = [(m, run) for m in others if (run := _run(with_modulus(scene, m), end, tick))]
    drawn = [run for _ in range(members) if (run := _run(varied(scene, draw), end, tick))]
    if len(drawn) < FEWEST_MEMBERS * members:
        raise RefusedError(f"only {len(drawn)} of {members} simulations reach the end of the press")
    worlds = [(value, nominal), *runs]
    steps = min(run.march.time.size for run in [*(run for _, run in worlds), *drawn])
    outputs = np.array([_outputs(run, strips)[:, :steps] for _, run in worlds])
    changed = [_outputs(run, strips)[:, :steps] - outputs[0] for run in drawn]
    return FilmPrediction(
        strips=strips,
        time=nominal.march.time[:steps],
        moduli=np.array([m for m, _ in worlds]),
        worlds=outputs,
        changes=np.array(changed).reshape(-1, *outputs.shape[1:]),
        noise=float(nominal.read["output_noise_V_rms"]),
        press_end=end,
    )


def _run(scene: Scene | None, end: float, tick: Tick | None) -> Simulation | None:
    """The simulation of a drawn scene, None where the model refuses it or it stops before `end` s: the
    caller counts those."""
    try:
        run = at_level(scene, LEVELS[0], tick) if scene else None
    except (InputError, RefusedError):
        return None
    return run if run and run.march.time[-1] >= end else None


def monitored_strips(scene: Scene) -> tuple[Strip, ...]:
    """Return the strips of the monitored ridges."""
    return tuple((ridge, side) for ridge in scene.readout.ridges for side in SIDES)


def recorded_scene(scene: Scene) -> Scene:
    """Return the scene as its films are predicted: without noise, at small strain."""
    if "piezo" not in scene.effects:
        remedy = 'add [effects.piezo] with your circuit, as circuit = "transimpedance"'
        raise InputError("effects.piezo", "is missing: a recording is compared with outputs", remedy=remedy)
    if not scene.readout.ridges:
        raise InputError("readout.ridges", "must name the recorded ridges", remedy="list them, as [2, 3]")
    effects: dict[str, Any] = {"piezo": {**scene.effects["piezo"], "noise_seed": None}}
    if "finite_strain" in scene.effects:
        effects["finite_strain"] = None
    return scene.with_(effects=effects)


def press_end(scene: Scene) -> float:
    """Return when the normal force first stops growing, s."""
    time, force = scene.history.time_s, scene.history.normal_force_N
    for i in range(len(time) - 1):
        if force[i] > 0 and force[i + 1] <= force[i]:
            return time[i]
    if force[-1] <= 0:
        raise InputError("history.normal_force_N", "must press: there is nothing to compare", max(force))
    return time[-1]


def varied(scene: Scene, draw: np.random.Generator) -> Scene:
    """Return the scene with friction and crests drawn within their tolerances."""
    effects: dict[str, Any] = {}
    if "friction" in scene.effects:
        friction, by = scene.effects["friction"], draw.uniform(1 - LOOSE, 1 + LOOSE)
        keys = (key for key in ("coefficient", "kinetic", "shear_stress") if friction.get(key) is not None)
        effects["friction"] = {**friction, **{key: friction[key] * by for key in keys}}
    heights = np.array(scene.design.heights)
    heights = heights + draw.normal(0.0, spread_of(scene.design).crest_sigma, heights.size)
    return scene.with_(skin=with_heights(scene.design, heights.tolist()), effects=effects)


def modulus_range(design: Design) -> tuple[float, float, float]:
    """Return the silicone's modulus, low, nominal and high, MPa; 20 % either way where it has no range."""
    low, value, high = spread_of(design).modulus
    return (low, value, high) if low < high else ((1 - LOOSE) * value, value, (1 + LOOSE) * value)


def with_modulus(scene: Scene, modulus: float) -> Scene:
    """Return the scene on a skin of another modulus, MPa."""
    return scene.with_(skin=scene.design.with_(material={"young_modulus": modulus, "law": None}))


def _outputs(run: Simulation, strips: tuple[Strip, ...]) -> Array:
    """Outputs `(strips, steps)` V of a simulation."""
    output = run.read["output_V"]
    return np.array([output[str(ridge)][side] for ridge, side in strips])
