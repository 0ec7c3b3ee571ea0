"""Dear results that many tests ask for: computed once a process and run, kept by their arguments."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

import pytest

from skincad.inputs import Design

# Where a function is, and how many of its results are kept. It must not change or depend on anything else.
KEPT = {
    "skincad.solids.mold:mold": 512,
    "skincad.solids.occ:solid": 512,
    "skincad.mechanics.film.response:film_response": 16,
    "skincad.outputs.simulators.package:package": 16,
}


class Switch:
    """Whether results are taken from what is kept."""

    on = True


def pytest_collection() -> None:
    """Replace the functions of KEPT before tests import others that take them by name.

    Where tests run in workers, pytest-xdist keeps this from the process that only waits for them.
    """
    for home, most in KEPT.items():
        name, _, function = home.partition(":")
        module = import_module(name)
        setattr(module, function, kept(getattr(module, function), most))


def kept(function: Callable[..., Any], most: int) -> Callable[..., Any]:
    """Return the function with a memory of its last results.

    Arguments that can't be hashed bypass it, and designs on a bone: its file may change.
    """
    memory = functools.lru_cache(maxsize=most)(function)

    @functools.wraps(function)
    def call(*arguments: Any, **named: Any) -> Any:
        try:
            hash((arguments, tuple(named.values())))
        except TypeError:
            return function(*arguments, **named)
        if any(isinstance(value, Design) and value.mold.bone for value in arguments):
            return function(*arguments, **named)
        return (memory if Switch.on else function)(*arguments, **named)

    return call


@pytest.fixture(autouse=True)
def nothing_kept_of_patched_programs(request: pytest.FixtureRequest) -> Iterator[None]:
    """A test that patches the program gets and leaves nothing."""
    Switch.on = "monkeypatch" not in request.fixturenames
    yield
    Switch.on = True
