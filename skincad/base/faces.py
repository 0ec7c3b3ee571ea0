"""A room's face: the names that other rooms, tests and benches use, each imported when it is first used."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any


def face(room: str, table: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return a package's `__getattr__` and `__dir__` from a table of its modules and their names.

    A row is `module: name name ...`, and goes on in lines without a colon.
    """
    homes: dict[str, str] = {}
    module = ""
    for word in table.split():
        if word.endswith(":"):
            module = f"{room}.{word[:-1]}"
        else:
            homes[word] = module

    def get(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module '{room}' has no attribute '{name}'")
        return getattr(import_module(homes[name]), name)

    return get, lambda: sorted(homes)
