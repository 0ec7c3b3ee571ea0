"""Jobs that run in processes of their own: the verdict, a scene's signals, the files."""

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
    """Signals of a simulated scene: a differential stress by monitored ridge, MPa, over `time` s, all `(n,)`.

    `rough` signals are of a single coarse mesh, of unknown error; `lines` are what `simulate` prints.
    """

    time: Array
    normal: Array  # N
    tangential: Array  # N
    stress: dict[int, Array]
    slip_steps: tuple[int | None, ...]
    rough: bool
    lines: tuple[str, ...]


def check_design(design: Design, tell: Tell) -> None:
    """Tell each tier's verdict, then the last one as `skincad check` has it, its advice as it is found."""
    from skincad.mechanics.check import check
    from skincad.studies.advice import advising, seconds_for_advice

    def stage(what: str, left: float | None = None, /) -> None:
        tell("stage", (what, left))

    contact_check = check(design, progress=stage, on_verdict=lambda verdict: tell("tier", verdict))
    tell("verdict", contact_check)
    for more in advising(design, contact_check, stage, seconds_for_advice(contact_check)):
        tell("verdict", more)


def run_scene(scene: Scene, tell: Tell) -> None:
    """Tell a scene's signals on the coarsest mesh, then those of `skincad simulate`."""
    from skincad.scenes.levels import LEVELS
    from skincad.scenes.simulation import at_level, simulate

    def tick(stage: str, step: int, left: float | None = None, /) -> None:
        tell("stage", (f"{stage}, step {step} of {scene.history.step_count}", left))

    tell("signals", _signals(at_level(scene, LEVELS[0], tick), rough=True))
    tell("signals", _signals(simulate(scene, tick=tick), rough=False))


def make_files(request: tuple[Design, Path], tell: Tell) -> None:
    """Make a design's files as `skincad make` does; tell what it prints."""
    from skincad.fabrication.making import make
    from skincad.outputs.delivery import ready, write
    from skincad.outputs.makes import COMMAND, names

    design, folder = request

    def stage(what: str, left: float | None = None, /) -> None:
        tell("stage", (what, left))

    ready(folder, COMMAND, names(design))
    result = make(design, progress=stage)
    written = write(result, folder, progress=stage)
    tell("made", (result.summary, str(result), str(written)))


def preload() -> None:
    """Import what the first move of a slider needs."""
    import skincad.fabrication.filling
    import skincad.fabrication.findings
    import skincad.fabrication.strip_rules
    import skincad.mechanics.models.winkler
    import skincad.outputs.checks  # noqa: F401


def _signals(simulation: Simulation, *, rough: bool) -> Signals:
    march = simulation.march
    return Signals(
        march.time,
        march.column("normal"),
        march.column("tangential"),
        {ridge: signal.value for ridge, signal in simulation.signals.items()},
        tuple(simulation.slip_steps),
        rough,
        tuple(str(simulation).split("\n")),
    )
