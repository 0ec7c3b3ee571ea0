"""One run of a scene: its pad on a mesh, marched; and again with fewer steps or under a heavy plate.

A scene is marched with the slow modes of its masses where its steps show them (effects/modal.py). Which runs
are made is planned in plan.py; what they tell of a march's error is in errors.py.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.base.errors import resource_guard
from skincad.base.machine import one_blas_thread
from skincad.base.progress import Tick
from skincad.circuit.state import longest_step
from skincad.effects.kinds import MASS, MarchedPad, PadChange
from skincad.mechanics.dynamics.ringing import layer_period, skin_mass
from skincad.scenes.march import LEVELS, Level, March, expected, frames, march
from skincad.scenes.scene import Scene
from skincad.shape.skin import section, skin_of

if TYPE_CHECKING:
    from skincad.mechanics.bodies.mesh import PadPiece
    from skincad.mechanics.dynamics.modes import Modes


COARSE_STEP_FACTOR = 5  # steps of a march that are one of the march with fewer
LONGER = 2.0  # such a step's time, by that of one of these: 1.7 to 3.2, measured on four scenes
FEWER_STEPS, HEAVY_PLATE = "march with fewer steps", "heavy plate"  # stages


@dataclass(frozen=True, eq=False)
class MarchSetup:
    """What a scene's marches share: the piece that is meshed, None of pins, which have no section; who is
    told, whether a march that Ctrl-C ends is wanted (`partial`), the model's name where it is not the scene's
    own; the meshes made so far by fineness, the slow `modes` of the first mesh once known, and the `seconds`
    taken so far by stage."""

    scene: Scene
    piece: PadPiece | None
    tick: Tick | None = None
    partial: bool = False
    model: str = ""
    meshes: dict[float, object] = field(default_factory=dict)
    modes: list[Modes] = field(default_factory=list)
    seconds: dict[str, float] = field(default_factory=dict)

    def took(self, stage: str, seconds: float) -> None:
        """Count the seconds of a stage."""
        self.seconds[stage] = self.seconds.get(stage, 0.0) + seconds


@dataclass(frozen=True, eq=False)
class Runs:
    """A scene's marches: the one that counts, and those that tell its errors, None where there is none:
    `before` on the mesh before; `every` on the coarsest mesh, and `coarse` there with fewer steps; `after` on
    the finer mesh, where the march that counts is by another model; `heavy` under a plate as heavy as the
    skin, on the coarsest mesh; `fillets` with other fillets than the march that counts. `error` is the change
    from the mesh before, MPa by monitored ridge, None with one mesh; `notes` say what falls short."""

    march: March
    before: March | None = None
    after: March | None = None
    every: March | None = None
    coarse: March | None = None
    heavy: March | None = None
    fillets: March | None = None
    error: dict[int, float] | None = None
    notes: tuple[str, ...] = ()


@contextmanager
def spent(seconds: dict[str, float], name: str) -> Iterator[None]:
    """Count the block's seconds for an effect's own work."""
    began, key = perf_counter(), f"effect {name}"
    yield
    seconds[key] = seconds.get(key, 0.0) + perf_counter() - began


def piece_for(scene: Scene, seconds: dict[str, float]) -> PadPiece | None:
    """Return what is to be meshed: slots full of silicone, each effect that changes the pad changing that;
    None of pins."""
    if skin_of(scene.design).standing:
        return None
    from skincad.mechanics.bodies.mesh import piece_of
    from skincad.mechanics.film.stress import filled_pad
    from skincad.mechanics.problem import check_pad, focused, pad_of

    design = scene.design.with_(contact={"plate": {"shape": scene.plate.shape}})
    slot = skin_of(design).slot
    plain = design.with_(contact={"film": "ignored" if slot else None})
    pad, thickness = filled_pad(plain) if slot else (pad_of(plain), 0.0)
    for name, part in scene.parts.items():
        if isinstance(part, PadChange):
            with spent(seconds, name):
                pad = part.changed(pad, design)
    check_pad(pad)
    pad = focused(pad, max(scene.history.normal_force_N))
    return piece_of(pad, thickness, halved=scene.law.halves)


def march_on(level: Level, on: MarchSetup, following: Level | None = None, again: bool = False) -> March:
    """March on one mesh; the tick is told the time left, with that of a level `following` and of a march with
    fewer steps, where it is marched `again`. Pins have no mesh: the first level takes their contacts as
    softest, the others as stiffest."""
    model = f"{on.model.replace('_', ' ')}, " if on.model else ""
    stage, tick = f"{model}fineness {level.fineness:g}, order {level.order}", on.tick
    if tick:
        tick(stage, 0)
    with resource_guard(f"the mesh of {stage}"):
        pad, stages = _pad_on(level, on)
    for name, seconds in stages.items():
        on.took(name, seconds)
    count = on.scene.history.step_count
    fewer = LONGER * _fewer(on.scene).size / count if again else 0.0
    began = perf_counter()

    def at_step(step: int) -> None:
        if tick:
            whole = (perf_counter() - began) * count / step
            after = expected(following, level, {**stages, "march": whole}) if following else 0.0
            tick(stage, step, whole * (1 - step / count + fewer) + after)

    # to ask for one thread at each step takes longer than the step
    with resource_guard(f"the computation on the mesh of {stage}"):
        keep, mass = {*on.scene.readout.steps, *frames(on.scene)}, on.scene.plate.mass or 0.0
        result = _marched(on, pad, at_step=at_step, keep=keep, mass=mass)
    on.took("march", result.seconds["march"])
    return replace(result, seconds={**stages, **result.seconds})


def _pad_on(level: Level, on: MarchSetup) -> tuple[MarchedPad, dict[str, float]]:
    """The pad on one mesh, with slow modes where masses are marched; and the seconds of its stages."""
    marks, scene, films = [perf_counter()], on.scene, bool(on.scene.readout.ridges)
    if on.piece is None:
        from skincad.effects.pin_pad import SLIDING, STICKING, bent_pad, pin_pad

        marks.append(perf_counter())
        make = pin_pad if scene.law.condenses else bent_pad
        pad: MarchedPad = make(scene.design, SLIDING if level == LEVELS[0] else STICKING)
        marks.append(perf_counter())
    else:
        mesh = meshed_pad(on.piece, level, on.meshes)
        marks.append(perf_counter())
        pad = scene.law.marched(on.piece, mesh, level.order, films, scene.terms)
        marks.append(perf_counter())
        if marches_masses(scene):
            pad = _with_masses(pad, on, mesh, level, films)
            marks.append(perf_counter())
    return pad, dict(zip(("mesh", "condense", "modes"), np.diff(marks).tolist(), strict=False))


def _marched(
    on: MarchSetup,
    pad: MarchedPad,
    steps: Index | None = None,
    *,
    at_step: Callable[[int], None] | None = None,
    keep: Collection[int] = (),
    mass: float,
) -> March:
    """March a pad through the scene's steps, or some of them; states of the steps in `keep` are kept."""
    scene, history = on.scene, on.scene.history
    drives = history.drives()
    at = np.arange(history.step_count + 1) if steps is None else steps
    with one_blas_thread():
        return march(
            pad,
            history.times[at],
            [drives[i] for i in at],
            scene.terms,
            at_step,
            keep,
            mass,
            scene.law.limits(scene.design),
            on.partial,
        )


def march_coarse_steps(on: MarchSetup, whole: March, after: float = 0.0) -> March | None:
    """March the pad of a march again with fewer steps, to tell the steps' error; None where that fails. The
    tick is told the history's steps, and the time left with the s `after` it."""
    steps, tick = _fewer(on.scene), on.tick
    if whole.pad is None or steps.size > on.scene.history.step_count:
        return None
    began = perf_counter()
    if tick:
        tick(FEWER_STEPS, 0)

    def at_step(step: int) -> None:
        if tick:
            left = (perf_counter() - began) * ((steps.size - 1) / step - 1)
            tick(FEWER_STEPS, int(steps[step]), left + after)

    coarse = _marched(on, whole.pad, steps, at_step=at_step, mass=on.scene.plate.mass or 0.0)
    on.took(FEWER_STEPS, coarse.seconds["march"])
    return None if coarse.failed else coarse


def march_under_heavy_plate(on: MarchSetup, whole: March) -> March | None:
    """March the pad of a march again under a plate as heavy as the skin; None of a plate that is driven or
    has its own mass, of a skin without masses, and where that fails."""
    from skincad.effects.modal import ModalPad

    scene, pad = on.scene, whole.pad
    driven = scene.history.tangential_force_N is None
    if scene.plate.mass is not None or driven or not isinstance(pad, ModalPad):
        return None
    mass = skin_mass(scene.design)
    heavy = _marched(on, replace(pad, mass=mass, prepared={}), mass=mass)
    on.took(HEAVY_PLATE, heavy.seconds["march"])
    return None if heavy.failed or heavy.interrupted else heavy


def coarse_steps(steps: int, points: Index) -> Index:
    """Return the steps `(k,)` of a march with fewer steps: one in COARSE_STEP_FACTOR, those at the history's
    `points`, and the last."""
    return np.unique(np.concatenate([np.arange(0, steps + 1, COARSE_STEP_FACTOR), points, [steps]]))


def _fewer(scene: Scene) -> Index:
    """The steps that the march with fewer has."""
    return coarse_steps(scene.history.step_count, scene.history.points)


SWINGS = 2.0  # steps in the slowest mode's period from which on masses are marched


def marches_masses(scene: Scene) -> bool:
    """Whether the slow modes are marched: the scene names no effect with masses or a past of its own, the
    plate keeps its angle, and the steps are short enough to see the slowest mode, or the plate has a mass."""
    design, history = scene.design, scene.history
    if scene.moving or any(history.rotation_deg or []) or not (scene.law.swings and scene.swept):
        return False
    return scene.plate.mass is not None or longest_step(history.times) < layer_period(design) / SWINGS


def halts_of(scene: Scene) -> float:
    """Return how long a ridge that slips may halt while the skin swings, s: half of its slowest swing where
    masses count, else 0."""
    return layer_period(scene.design) / 2 if marches_masses(scene) or MASS in scene.asked else 0.0


def _with_masses(pad: MarchedPad, on: MarchSetup, mesh: object, level: Level, films: bool) -> MarchedPad:
    """The pad with the slow modes of the first mesh that is marched."""
    from skincad.effects.chosen_steps import ChosenPad
    from skincad.effects.modal import ModalPad
    from skincad.effects.small_strain import CondensedPad
    from skincad.mechanics.dynamics.modes import at_points, resolved, slow_modes

    assert isinstance(pad, CondensedPad | ChosenPad)
    assert on.piece is not None
    step, points = longest_step(on.scene.history.times), pad.pad
    if not on.modes:
        on.modes.append(slow_modes(on.piece, mesh, level.order, films, points.x, points.ridge, step))
    modes = at_points(on.modes[0], points.x, points.ridge)
    slow = resolved(modes, pad.compliance, step)
    # what the first differs from the next mesh by counts these modes too
    first = level == LEVELS[0] and not on.model
    return ModalPad(pad, slow.coarser if first else slow, on.scene.plate.mass or 0.0)


def meshed_pad(piece: PadPiece, level: Level, meshes: dict[float, object]) -> object:
    """Return the level's mesh, of those made already where it is among them."""
    from skincad.mechanics.bodies.mesh import default_sizes, triangles
    from skincad.mechanics.film.stress import REFINEMENTS

    if level.fineness not in meshes:
        fine = REFINEMENTS[int(level.fineness > REFINEMENTS[0].fineness)]
        sizes = fine.sizes(piece) if piece.pad.strips else default_sizes(piece.pad, level.fineness)
        meshes[level.fineness] = triangles(piece.pad, sizes)
    return meshes[level.fineness]


def _pairs(scene: Scene, films: Array) -> dict[int, tuple[Array, Array]]:
    """The first of the values `(n, films, k)` at S1 and at S2 by monitored ridge."""
    place = {(s.feature, s.side): i for i, s in enumerate(section(scene.design).slots)}
    return {r: (films[:, place[r, "S1"], 0], films[:, place[r, "S2"], 0]) for r in scene.readout.ridges}


def differential(scene: Scene, march: March) -> dict[int, Array]:
    """Return S1 - S2 across the films `(steps + 1,)` MPa by monitored ridge."""
    return {r: one - other for r, (one, other) in _pairs(scene, march.column("films")).items()}


def drifted(scene: Scene, march: March) -> dict[int, float]:
    """Return the largest drift of each monitored ridge's difference, MPa; nothing without chosen steps."""
    if march.readings[-1].drift is None:
        return {}
    films = np.array([reading.drift.films for reading in march.readings if reading.drift])
    return {r: float((one + other).max()) for r, (one, other) in _pairs(scene, films).items()}
