"""Scenes on a skin of three ridges, for tests of seconds."""

from __future__ import annotations

import sys
from pathlib import Path
from types import ModuleType

import pytest

from skincad import effects
from skincad.inputs import template_text
from skincad.scenes import Scene, load_scene


def small_skin(text: str) -> str:
    """A design's TOML with three ridges, and a width for them."""
    return text.replace("count = 9 ", "count = 3 ").replace("width = 11.0", "width = 5.0")


def small_scene(folder: Path, name: str, *overrides: str) -> Scene:
    """A template's scene on the small skin, both written to `folder`."""
    (folder / "small.toml").write_text(small_skin(template_text("yamada-2002")))
    (folder / "scene.toml").write_text(template_text(name, "scenes"))
    return load_scene(folder / "scene.toml", last_of_each("skin=small.toml", *overrides))


def make_up_effects(patch: pytest.MonkeyPatch, *kinds: type) -> None:
    """List effects, as a file of theirs and a line each in the table do."""
    module = ModuleType("made_up")
    for kind in kinds:
        setattr(module, kind.__name__, kind)
        patch.setitem(effects.EFFECTS, kind.__name__.lower(), f"made_up:{kind.__name__}")
    patch.setitem(sys.modules, "made_up", module)


def last_of_each(*settings: str) -> list[str]:
    """Settings, of those of one key the last: skincad takes a key once."""
    return list({text.partition("=")[0]: text for text in settings}.values())


# a third of the ridges: about a third of the force
THIRD = "history.normal_force_N=[0.0, 1.3]"
