"""The table of seconds names files and tests that are there."""

from __future__ import annotations

import tomllib
from pathlib import Path

TESTS = Path(__file__).parent


def test_every_entry_is_a_test() -> None:
    known = tomllib.loads((TESTS / "seconds.toml").read_text())
    for name in (*known["fast"], *known["slow"]):
        file, _, function = name.partition("::")
        assert f"def {function}(" in (TESTS / file).read_text() if function else (TESTS / file).is_file(), (
            name
        )
