"""The command `package`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import skincad
from skincad.base.progress import stage_bar
from skincad.cli import options
from skincad.cli.options import option
from skincad.cli.printing import deliver, out_folder

STAGES = 26  # of its bar, about: those of the springs' checks among them


def package(
    source: options.DesignSource,
    settings: options.Settings = [],  # noqa: B006
    kinds: Annotated[
        list[str], option("--for KIND", "mujoco, urdf, taxels or mesh; repeat for several; default: all.")
    ] = [],  # noqa: B006
    model: options.Model = "auto",
    mesh_prefix: Annotated[
        str,
        option(
            "--mesh-prefix URI",
            "What URDF's meshes begin with, as package://my_robot/meshes/; default: beside the file.",
        ),
    ] = "",
    *,
    workshop: options.Workshop,
    folder: Annotated[
        Path | None, option("-o --out DIR", "The folder to write to; default: out/<name>/package.")
    ] = None,
    as_json: options.Json = False,
) -> None:
    """Export the skin for other people's simulators.

    MuJoCo model and scene, URDF, taxels with the films' response, meshes, and a model card that says what
    each number rests on appear in the output folder.
    """
    design = skincad.load(source, settings, **vars(workshop))
    target = out_folder(folder, Path(design.name, "package"), "package", ())
    with stage_bar(STAGES) as progress:
        result = skincad.package(design, kinds, model=model, mesh_prefix=mesh_prefix, progress=progress)
        written = skincad.write(result, target, progress=progress)
    deliver(result, written, options.Display(as_json=as_json))
