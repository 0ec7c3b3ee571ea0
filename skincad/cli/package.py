"""The command `package`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

import skincad
from skincad.base.progress import stage_bar
from skincad.cli.options import (
    DesignArgument,
    GrippersOption,
    JsonOption,
    ModelOption,
    PrinterOption,
    SetOption,
    SiliconesOption,
    deliver,
    out_folder,
)

STAGES = 26  # of its bar, about: those of the springs' checks among them


def package(
    source: DesignArgument,
    settings: SetOption = [],  # noqa: B006
    kinds: Annotated[
        list[str],
        typer.Option(
            "--for", metavar="KIND", help="mujoco, urdf, taxels or mesh; repeat for several; default: all."
        ),
    ] = [],  # noqa: B006
    model: ModelOption = "auto",
    mesh_prefix: Annotated[
        str,
        typer.Option(
            "--mesh-prefix",
            metavar="URI",
            help="What URDF's meshes begin with, as package://my_robot/meshes/; default: beside the file.",
        ),
    ] = "",
    printer: PrinterOption = None,
    silicones: SiliconesOption = None,
    grippers: GrippersOption = None,
    folder: Annotated[
        Path | None,
        typer.Option(
            "-o", "--out", metavar="DIR", help="The folder to write to; default: out/<name>/package."
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Export the skin for other people's simulators.

    MuJoCo model and scene, URDF, taxels with the films' response, meshes, and a model card that says what
    each number rests on appear in the output folder.
    """
    design = skincad.load(source, settings, printer=printer, silicones=silicones, grippers=grippers)
    target = out_folder(folder, Path(design.name, "package"), "package", ())
    with stage_bar(STAGES) as progress:
        result = skincad.package(design, kinds, model=model, mesh_prefix=mesh_prefix, progress=progress)
        written = skincad.write(result, target, progress=progress)
    deliver(result, as_json, written)
