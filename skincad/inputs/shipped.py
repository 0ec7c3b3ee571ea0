"""Where what ships with skincad lies."""

from __future__ import annotations

from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Literal


def templates_folder() -> Traversable:
    """Return the folder of templates: in the wheel beside this file, in a checkout above it."""
    inside = files("skincad") / "templates"
    return inside if inside.is_dir() else files("skincad").joinpath("..") / "templates"


def table_text(name: Literal["silicones", "processes"]) -> str:
    """Return the TOML of the shipped silicones or processes, with where their values are from."""
    return (templates_folder() / f"{name}.toml").read_text("utf-8")
