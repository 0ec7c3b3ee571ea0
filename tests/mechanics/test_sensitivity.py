"""What moves the force: exponents by hand, an error that holds the meshed models', the largest first."""

from __future__ import annotations

from itertools import pairwise

import pytest

import skincad
from skincad.mechanics import KEYS, sensitivities
from skincad.mechanics.manufacture import MODULUS
from tests.families import RIDGED


def test_the_modulus_counts_in_proportion_and_the_pitch_as_its_square() -> None:
    """The last crest's fall goes with the square of its arm; what the base adds is within the error."""
    changes = {row.key: row.change for row in sensitivities(skincad.load("plain-ridges"), 100.0)}
    assert changes[MODULUS].value == 1.0
    pitch = changes["ridge.pitch"]
    assert pitch.lower == pytest.approx(2.0 - 0.1, rel=5e-3)
    assert (pitch.upper or 0.0) > 2.0
    assert changes["skin.length"].value == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("name", RIDGED)
def test_the_largest_comes_first_and_each_has_its_error(name: str) -> None:
    rows = sensitivities(skincad.load(name), 2.0)
    sizes = [abs(row.change.value or 0.0) for row in rows]
    rises = [later - first for first, later in pairwise(sizes)]
    assert max(rises) <= 1e-3 * sizes[0]  # those that round to the same stand by name
    assert {row.key for row in rows} == {*KEYS, MODULUS}
    assert all((row.change.error or 0.0) > 0 for row in rows)


def test_a_single_ridge_and_heights_of_ones_own() -> None:
    one = skincad.load("plain-ridges").with_(ridge={"count": 1})
    assert sensitivities(one, 1.0) == ()
    level = skincad.load("plain-ridges").with_(ridge={"levelling": 1.0})
    assert sensitivities(level, 1.0) == ()  # its force is rounding
    heights = {"count": 3, "heights": [0.5, 0.5, 0.5]}
    uneven = skincad.load("plain-ridges").with_(ridge=heights, skin={"width": 5.0})
    assert "ridge.height" not in {row.key for row in sensitivities(uneven, 1.0)}


@pytest.mark.slow
@pytest.mark.parametrize(("key", "by"), [("skin.curvature_radius", 0.02), ("ridge.pitch", 0.02)])
def test_the_error_holds_what_the_linear_model_finds(key: str, by: float) -> None:
    """Differences of 2 % are far above the mesh's own. On another pad: bench/sensitivities.py."""
    design = skincad.load("milled-pad").with_(ridge={"count": 7}, skin={"thickness": 3.0})
    table, _, name = key.partition(".")
    now = getattr(getattr(design, table), name)
    low, high = (
        skincad.check(design.with_(**{table: {name: now * (1 + sign * by)}}), model="linear").all_touch_force
        for sign in (-1, 1)
    )
    middle = skincad.check(design, model="linear").all_touch_force.value
    assert low.value is not None
    assert high.value is not None
    assert middle is not None
    change = {row.key: row.change for row in sensitivities(design, middle)}[key]
    slope = (high.value - low.value) / (2 * 100 * by)
    assert abs(slope - (change.value or 0.0)) <= (change.error or 0.0)
