"""One bad design or force, given to all that press a skin: each refuses it or says that it is beyond."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import skincad
from skincad.base import InputError, RefusedError, Stopwatch
from skincad.inputs import Design
from skincad.material import small_strain_curve
from skincad.mechanics import film_stresses
from skincad.scenes import LEVELS, at_level, load_scene
from skincad.studies import scene_on
from tests.mechanics.designs import yamada


def small(**change: dict[str, object]) -> Design:
    """One ridge, slots full of silicone."""
    tables = {"skin": {}, "ridge": {}, **change}
    tables["skin"] = {"width": 3.0, **tables["skin"]}
    tables["ridge"] = {"count": 1, **tables["ridge"]}
    return yamada().with_(film=None, contact={"film": "ignored"}, **tables)


def by_check(design: Design, force: float, folder: Path) -> str:
    return skincad.check(design, force=force, model="linear", tol=0.05).out_of_range


def by_scene(design: Design, force: float, folder: Path) -> str:
    """Pressed within eight steps."""
    (folder / "skin.toml").write_text(design.to_toml())
    settings = [
        f"skin={(folder / 'skin.toml').as_posix()!r}",
        f"history.normal_force_N=[0.0, {force}]",
        *("history.steps=8", "effects.film=none", "readout.ridges=[]"),
    ]
    march = at_level(load_scene("yamada-2002-press", settings), LEVELS[0]).march
    return march.stopped or "" if march.failed else ""


def by_film(design: Design, force: float, folder: Path) -> str:
    film_stresses(design, force, tol=0.5)
    return ""


def by_fit(design: Design, force: float, folder: Path) -> str:
    """A pad's curve ends before the force."""
    last = float(small_strain_curve(design, 0.8, Stopwatch(None)).force[-1])
    return f"ends at {last:g} N" if last < force else ""


def by_ladder(design: Design, force: float, folder: Path) -> str:
    """The scene that `accuracy` marches, with the design's own force."""
    march = at_level(scene_on(design.with_(contact={"force": force}), "history.steps=40"), LEVELS[0]).march
    return march.stopped or "" if march.failed else ""


WAYS: dict[str, Callable[[Design, float, Path], str]] = {
    "check": by_check,
    "simulate": by_scene,
    "film stress": by_film,
    "fit-material": by_fit,
    "accuracy": by_ladder,
}
BAD: dict[str, tuple[dict[str, dict[str, object]], float]] = {
    "pressed flat": ({}, 1e4),
    "strained": ({"skin": {"curvature_radius": 4.0, "thickness": 5.0}}, 20.0),
    "buckled": ({"ridge": {"height": 4.0}, "skin": {"curvature_radius": 6.0}}, 10.0),
    "more force than there is": ({}, 1e300),
}
SLOW = {"fit-material"}  # solves a solid


@pytest.mark.parametrize("case", BAD)
@pytest.mark.parametrize("way", [pytest.param(w, marks=[pytest.mark.slow] * (w in SLOW)) for w in WAYS])
def test_each_way_refuses_or_says_that_it_is_beyond(way: str, case: str, tmp_path: Path) -> None:
    change, force = BAD[case]
    try:
        answer = WAYS[way](small(**change), force, tmp_path)
    except (InputError, RefusedError) as refusal:
        answer = str(refusal)
    assert answer, f"{way} takes it"


@pytest.mark.parametrize("way", ["check", "simulate", "film stress"])
def test_a_good_one_is_taken(way: str, tmp_path: Path) -> None:
    assert WAYS[way](small(), 0.4, tmp_path) == ""


@pytest.mark.parametrize("table", ["material", "film"])
def test_no_stuff_is_taken_as_incompressible_or_beyond(table: str) -> None:
    """At 0.5 a bulk modulus has no bound, above it is negative."""
    for ratio in (0.0, 0.3, 0.49):
        assert yamada().with_(**{table: {"poisson_ratio": ratio}})
    for wrong in (-0.01, 0.5, 0.51, 1.0):
        with pytest.raises(InputError, match=rf"^{table}\.poisson_ratio: must be"):
            yamada().with_(**{table: {"poisson_ratio": wrong}})
