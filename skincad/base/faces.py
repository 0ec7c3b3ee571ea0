"""What is imported when it is first used, as a room's face: what other rooms, tests and benches use."""

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
        return imported(f"{homes[name]}:{name}")

    return get, lambda: sorted(homes)


def imported(home: str) -> Any:
    """Return what a module has, as "skincad.outputs.checks:CHECK", imported now."""
    module, _, name = home.partition(":")
    return getattr(import_module(module), name)
