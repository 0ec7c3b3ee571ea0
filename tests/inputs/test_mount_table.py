"""The table of a mount: what goes together, and what is refused in one line."""

from __future__ import annotations

import pytest

import skincad
from skincad.inputs import Mount, load
from tests.refusals import refused_by

GOOD = [
    {"thread": "M3", "diameter": 20.0},
    {"thread": "M2", "diameter": 20.0, "count": 6, "angle": 0.0, "pin": 1.5},
    {"thread": "M4", "pattern": "rectangle", "pitch_x": 8.0},
    {"thread": "M2.5", "pattern": "rectangle", "pitch_y": 8.0, "pitch_x": 3.0, "fiducials": 4},
    {"fiducials": 3, "fiducial_diameter": 2.0, "fiducial_depth": 0.3},
]
BAD = [
    ({}, "mount: needs a thread or fiducials"),
    ({"thread": "M5", "diameter": 9.0}, "mount.thread: must be 'M2', 'M2.5', 'M3' or 'M4'"),
    ({"diameter": 9.0}, "mount.thread: is missing where diameter is given"),
    ({"pin": 2.0, "fiducials": 3}, "mount.thread: is missing where pin is given"),
    ({"thread": "M3"}, "mount.diameter: is missing for a circle"),
    ({"thread": "M3", "pattern": "rectangle"}, "mount.pitch_x: is missing for a rectangle"),
    ({"thread": "M3", "pitch_x": 4.0}, "mount.pattern: must be 'rectangle' where pitch_x is given"),
    (
        {"thread": "M3", "pattern": "rectangle", "pitch_x": 4.0, "angle": 0.0},
        "mount.pattern: must be 'circle' where angle is given",
    ),
    ({"fiducials": 2}, "mount.fiducials: must be 0, 3 or 4"),
    ({"fiducials": 5}, "mount.fiducials: must be less than or equal to 4"),
    ({"thread": "M3", "diameter": 9.0, "bolt": 4}, "mount.bolt: unknown key"),
    ({"thread": "M3", "diameter": 9.0, "count": 1}, "mount.count: must be greater than or equal to 2"),
    ({"thread": "M3", "diameter": 9.0, "pin": 4.0}, "mount.pin: must be less than or equal to 3"),
]


@pytest.mark.parametrize("given", GOOD)
def test_what_goes_together_is_kept_and_written(given: dict[str, object]) -> None:
    design = skincad.load("yamada-2002").with_(mount=given)
    assert design.mount == Mount(**given)
    assert "[mount]" in design.to_toml()
    assert design.with_(mount=None) == skincad.load("yamada-2002")


@pytest.mark.parametrize(("given", "words"), BAD)
def test_what_does_not_is_told_in_one_line(given: dict[str, object], words: str) -> None:
    with refused_by(words):
        skincad.load("yamada-2002").with_(mount=given)


def test_it_is_set_from_the_command_line_and_dropped() -> None:
    keys = ["mount.thread=M2", "mount.pattern=rectangle", "mount.pitch_x=8.0"]
    assert load("yamada-2002", keys).mount == Mount(thread="M2", pattern="rectangle", pitch_x=8.0)
    assert load("yamada-2002", [*keys, "mount=none"]).mount is None


def test_a_design_without_one_says_nothing_of_it() -> None:
    """Else every revision would change."""
    assert "mount" not in skincad.load("yamada-2002").to_toml()
