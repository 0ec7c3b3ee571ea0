"""A scene's march on one mesh: what is meshed, how finely, and what each stage took."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from time import perf_counter
from typing import TYPE_CHECKING

import numpy as np

from skincad.base.arrays import Index
from skincad.base.blas import one_blas_thread
from skincad.base.errors import needing
from skincad.base.stopwatch import Tick
from skincad.effects.kinds import PadChange
from skincad.scenes.levels import Level, expected
from skincad.scenes.march import March, march
from skincad.scenes.moments import kept_steps
from skincad.scenes.refined import LONGER, thinned
from skincad.scenes.scene import Scene
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.mechanics.film.stick import PadPiece


@dataclass(frozen=True, eq=False)
class Marching:
    """What a scene's marches share: the piece that is meshed, who is told, whether a march that Ctrl-C ends
    is wanted (`partial`), the meshes made so far by fineness, and the model's name where it is not the
    scene's own."""

    scene: Scene
    piece: PadPiece
    tick: Tick | None = None
    partial: bool = False
    meshes: dict[float, object] = field(default_factory=dict)
    model: str = ""


@contextmanager
def spent(seconds: dict[str, float], name: str) -> Iterator[None]:
    """Count the block's seconds for an effect's own work."""
    began, key = perf_counter(), f"effect {name}"
    yield
    seconds[key] = seconds.get(key, 0.0) + perf_counter() - began


def piece_for(scene: Scene, seconds: dict[str, float]) -> PadPiece:
    """Return what is to be meshed: slots full of silicone, each effect that changes the pad changing that."""
    from skincad.mechanics.film.stick import piece_of
    from skincad.mechanics.film.stress import filled_pad
    from skincad.mechanics.problem import check_pad, pad_of

    design = scene.design.with_(contact={"plate": {"shape": scene.plate.shape}})
    plain = (
        design.with_(contact={"film": "ignored"})
        if skin_of(design).slot
        else design.with_(contact={"film": None})
    )
    pad, thickness = filled_pad(plain) if skin_of(design).slot else (pad_of(plain), 0.0)
    for name, effect in scene.parts.items():
        if isinstance(effect, PadChange):
            with spent(seconds, name):
                pad = effect.changed(pad, design)
    check_pad(pad)
    return piece_of(pad, thickness, halved=scene.law.halves)


def march_on(
    level: Level,
    on: Marching,
    seconds: dict[str, float],
    following: Level | None = None,
    again: bool = False,
) -> March:
    """March on one mesh; `seconds` get its stages, the tick the time left, with that of a level `following`
    and of a march with fewer steps, where it is marched `again`."""
    model = f"{on.model.replace('_', ' ')}, " if on.model else ""
    stage, scene, tick = f"{model}fineness {level.fineness:g}, order {level.order}", on.scene, on.tick
    if tick:
        tick(stage, 0)
    marks = [perf_counter()]
    with needing(f"the mesh of {stage}"):
        mesh = _meshed(on.piece, level, on.meshes)
        marks.append(perf_counter())
        films = bool(scene.readout.ridges)
        pad = scene.law.marched(on.piece, mesh, level.order, films, scene.terms)
        marks.append(perf_counter())
    history, mass = scene.history, scene.plate.mass or 0.0
    count = history.step_count
    fewer = LONGER * _fewer(scene).size / count if again else 0.0
    stages = dict(zip(("mesh", "condense"), np.diff(marks).tolist(), strict=True))

    def told(step: int) -> None:
        if tick:
            whole = (perf_counter() - marks[-1]) * count / step
            after = expected(following, level, {**stages, "march": whole}) if following else 0.0
            tick(stage, step, whole * (1 - step / count + fewer) + after)

    # to ask for one thread at each step takes longer than the step
    with needing(f"the computation on the mesh of {stage}"), one_blas_thread():
        times, drives, ends = history.times, history.drives(), scene.law.limits(scene.design)
        keep = kept_steps(scene)
        march_result = march(pad, times, drives, scene.terms, told, keep, mass, ends, on.partial)
    seconds |= {**stages, "march": march_result.seconds}
    return march_result


def march_thin(on: Marching, whole: March, seconds: dict[str, float], after: float = 0.0) -> March | None:
    """March the pad of a march again with fewer steps, to tell the steps' error; None where that fails.
    `seconds` have a stage of its own, for the price of the next mesh hangs on the march's alone. The tick is
    told the history's steps, and the time left with the s `after` it."""
    scene, history, tick = on.scene, on.scene.history, on.tick
    thinned = _fewer(scene)
    if whole.pad is None or thinned.size > history.step_count:
        return None
    stage, began, last = "march with fewer steps", perf_counter(), thinned.size - 1
    if tick:
        tick(stage, 0)

    def told(step: int) -> None:
        if tick:
            left = (perf_counter() - began) * (last / step - 1)
            tick(stage, int(thinned[step]), left + after)

    drives = history.drives()
    with one_blas_thread():
        ends = scene.law.limits(scene.design)
        times, mass = history.times[thinned], scene.plate.mass or 0.0
        fewer = [drives[i] for i in thinned]
        thin = march(whole.pad, times, fewer, scene.terms, told, (), mass, ends, on.partial)
    seconds[stage] = thin.seconds
    return None if thin.failed else thin


def _fewer(scene: Scene) -> Index:
    """The steps that the march with fewer has."""
    history = scene.history
    return thinned(history.step_count, history.points)


def _meshed(piece: PadPiece, level: Level, meshes: dict[float, object]) -> object:
    """Return the level's mesh, of those made already where it is among them."""
    from skincad.mechanics.bodies.mesh import default_sizes, triangles
    from skincad.mechanics.film.stress import RUNGS

    if level.fineness not in meshes:
        fine = RUNGS[int(level.fineness > RUNGS[0].fineness)]
        sizes = fine.sizes(piece) if piece.pad.strips else default_sizes(piece.pad, level.fineness)
        meshes[level.fineness] = triangles(piece.pad, sizes)
    return meshes[level.fineness]
