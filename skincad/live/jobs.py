"""What the page has computed in processes of their own: the verdict, a scene's signals, the files."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.scenes.scene import Scene

if TYPE_CHECKING:
    from skincad.live.worker import Tell
    from skincad.scenes.simulation import Simulation


@dataclass(frozen=True, eq=False)
class Signals:
    """What a simulated scene shows: a differential stress by told ridge, MPa, over `time` s, all `(n,)`.

    `rough` is one of a single coarse mesh, whose error nobody knows; `lines` are what `simulate` prints.
    """

    time: Array
    normal: Array  # N
    tangential: Array  # N
    stress: dict[int, Array]
    slip_steps: tuple[int | None, ...]
    rough: bool
    lines: tuple[str, ...]


def judged(design: Design, tell: Tell) -> None:
    """Tell each tier's verdict, then the last one as `skincad check` has it, its advice as it is found."""
    from skincad.mechanics.touching import check
    from skincad.studies.advice import advising, patience

    def stage(what: str, left: float | None = None, /) -> None:
        tell("stage", (what, left))

    found = check(design, progress=stage, on_verdict=lambda verdict: tell("tier", verdict))
    tell("verdict", found)
    for more in advising(design, found, stage, patience(found)):
        tell("verdict", more)


def simulated(scene: Scene, tell: Tell) -> None:
    """Tell a scene's signals on the coarsest mesh, then those of `skincad simulate`."""
    from skincad.scenes.levels import LEVELS
    from skincad.scenes.simulation import at_level, simulate

    def tick(stage: str, step: int, left: float | None = None, /) -> None:
        tell("stage", (f"{stage}, step {step} of {scene.history.step_count}", left))

    tell("signals", _signals(at_level(scene, LEVELS[0], tick), rough=True))
    tell("signals", _signals(simulate(scene, tick=tick), rough=False))


def made(asked: tuple[Design, Path], tell: Tell) -> None:
    """Make a design's files as `skincad make` does; tell what it prints."""
    from skincad.fabrication.making import make
    from skincad.outputs.delivery import ready, write
    from skincad.outputs.makes import COMMAND, names

    design, folder = asked

    def stage(what: str, left: float | None = None, /) -> None:
        tell("stage", (what, left))

    ready(folder, COMMAND, names(design))
    found = make(design, progress=stage)
    written = write(found, folder, progress=stage)
    tell("made", (found.summary, str(found), str(written)))


def warmed() -> None:
    """Import what the page itself needs before it is moved for the first time."""
    import skincad.fabrication.filling
    import skincad.fabrication.findings
    import skincad.fabrication.strip_rules
    import skincad.mechanics.tiers.winkler
    import skincad.outputs.checks  # noqa: F401


def _signals(found: Simulation, *, rough: bool) -> Signals:
    march = found.march
    return Signals(
        march.time,
        march.column("normal"),
        march.column("tangential"),
        {ridge: signal.value for ridge, signal in found.signals.items()},
        tuple(found.slip_steps),
        rough,
        tuple(str(found).split("\n")),
    )
