"""The table of fits: its page, its designs drawn again, and what is said of designs unlike them."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest

import skincad
from bench import docs_reference, pins, table_fits
from bench.campaign import random_designs
from bench.random_scenes import random_scene
from bench.verdicts import drawn
from skincad import check
from skincad.inputs import Design
from skincad.mechanics import DESIGNS, FITS, MODELS, NUMBERS, unlike
from skincad.mechanics import fits as table
from tests.designs import RIDGED
from tests.mechanics.designs import reference

DOCS = Path(__file__).parents[2] / "docs"


def test_the_page_shows_the_tables() -> None:
    page = docs_reference.with_tables((DOCS / "evidence" / "fits.md").read_text("utf-8"))
    for rows in (table_fits.fits(), table_fits.designs()):
        assert "\n".join(rows) in page


def hull(designs: Iterable[Design]) -> dict[str, tuple[float, float]]:
    """Between what the numbers of designs lie."""
    shapes = [table.shape_of(design) for design in designs]
    return {key: (min(s[key] for s in shapes), max(s[key] for s in shapes)) for key in NUMBERS}


def of_templates() -> Iterable[Design]:
    return map(skincad.load, RIDGED)


def of_verdicts() -> Iterable[Design]:
    return map(drawn, [*range(1000, 1161), *range(5000, 5045)])


def of_campaign() -> Iterable[Design]:
    return (random_designs.drawn(seed).design for seed in range(150))


def of_scenes() -> Iterable[Design]:
    return (random_scene(np.random.default_rng(seed)).design for seed in range(60))


def of_pins() -> Iterable[Design]:
    designs = [pins.random_pins(seed) for seed in (*range(12), *range(100, 112))]
    return [*designs, designs[2].with_(material={"poisson_ratio": 0.499})]


def of_layered_pins() -> Iterable[Design]:
    return map(pins.layered, [*range(300, 313), *range(320, 335)])


@pytest.mark.evidence(subject="seeds: fits")
@pytest.mark.parametrize(
    "draw", [of_templates, of_verdicts, of_campaign, of_scenes, of_pins, of_layered_pins]
)
def test_designs_drawn_again_fill_their_ranges(draw: Callable[[], Iterable[Design]]) -> None:
    """To 0.5 %: the table has four digits."""
    ranges = DESIGNS[draw.__name__.removeprefix("of_").replace("_", " ")][1]
    for key, drawn_range in hull(draw()).items():
        assert drawn_range == pytest.approx(ranges[key], rel=5e-3, abs=1e-3), key


def test_every_models_errors_have_designs() -> None:
    """But the reduced model's, which are held against the full model at 45 and 101 ridges and go beyond."""
    named = {model for fit in FITS for model in fit.models if fit.family == "ridge"}
    assert named == set(MODELS) - {"reduced"}


def test_templates_and_their_neighbours_are_like_what_was_seen() -> None:
    assert not any(unlike(skincad.load(t), model=m) for t in RIDGED for m in MODELS)


@pytest.mark.slow
def test_a_verdict_on_an_unlike_design_says_so() -> None:
    soft = reference().with_(material={"name": None, "young_modulus": 0.4, "poisson_ratio": 0.2})
    assert unlike(soft, model="linear") == "Poisson's ratio 0.2 (seen: 0.3 to 0.49999)"
    layered = reference().with_(shot=({"thickness": 1.0, "young_modulus": 2.0},))
    assert unlike(layered, model="linear") == "layers of other silicones (seen: none)"
    for model in ("winkler", "linear"):
        said = [w for w in check(soft, model=model, tol=0.5).warnings if w.startswith("no design on which")]
        assert said == [
            f"no design on which the {model} model's errors were set is like this one: "
            "Poisson's ratio 0.2 (seen: 0.3 to 0.49999)"
        ]
    assert not any("no design" in w for w in check(reference(), model="linear", tol=0.5).warnings)
