"""Where what ships with skincad lies, and how a table of one's own may be named."""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib.resources import files
from importlib.resources.abc import Traversable
from typing import Literal

from skincad.base.errors import InputError

Table = Literal["silicones", "processes", "grippers"]
TABLES: tuple[Table, ...] = ("silicones", "processes", "grippers")
NAME = r"^[a-z][a-z0-9-]{2,31}$"


def templates_folder() -> Traversable:
    """Return the folder of templates: in the wheel beside this file, in a checkout above it."""
    inside = files("skincad") / "templates"
    return inside if inside.is_dir() else files("skincad").joinpath("..") / "templates"


def table_text(name: Table | Literal["films"]) -> str:
    """Return the TOML of a shipped table, with where its values are from."""
    return (templates_folder() / f"{name}.toml").read_text("utf-8")


def check_names(table: str, names: Iterable[str], example: str) -> None:
    """Raise InputError for a name that a table within `[table]` must not have."""
    for name in names:
        if not re.fullmatch(NAME, name):
            rule = "the name must be 3 to 32 lower-case letters, digits and -"
            raise InputError(table, rule, name, f"as in [{table}.{example}]")
