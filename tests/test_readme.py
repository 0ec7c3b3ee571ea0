"""The README names every command and every file, and its picture is the program's; test_shown.py runs it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image

from skincad.cli.app import app
from tests.conftest import Made

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text()


def test_every_file_of_a_make_is_explained(made: Made) -> None:
    table = README.split("## What you get")[1].split("\n## ")[0]
    written = [name for name, _ in made.written.files]
    for name in written:
        stem, _, kind = name.rpartition(".")
        of_part = f"solids/{Path(stem).name}.step" in written  # not each part is named
        assert f"`{name}`" in table or (of_part and f".{kind}`" in table), name


def test_every_command_is_shown() -> None:
    for command in app.registered_commands:
        assert f"skincad {command.name or command.callback.__name__}" in README


def test_the_picture_is_what_the_program_draws(made: Made) -> None:
    shown, drawn = (
        np.asarray(Image.open(p).convert("L").resize((363, 203)), dtype=float)
        for p in (ROOT / "README.png", made.folder / "picture.png")
    )
    # other fonts move letters by a pixel or two: 0.3; tilted strips already make 1.1, a lower ridge 1.9
    assert np.abs(shown - drawn).mean() < 0.6


def test_it_is_short() -> None:
    assert len(README.splitlines()) <= 110
