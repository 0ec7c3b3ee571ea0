"""The effect finite_strain in a scene: what it refuses, tells and stops at."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError
from skincad.effects import FiniteStrain, Step
from skincad.inputs import template_text
from skincad.mechanics import ContactError, Drive, default_sizes, filled_pad, piece_of, triangles
from skincad.scenes import load_scene
from skincad.scenes.march import march
from tests.mechanics.designs import yamada


def model(films: bool = True, creases: str = "stop") -> Any:
    """Three ridges with silicone in the slots, coarse."""
    design = yamada().with_(ridge={"count": 3}, skin={"width": 5.0}, contact={"film": "ignored"})
    piece = piece_of(*filled_pad(design), halved=FiniteStrain.halves)
    mesh = triangles(piece.pad, default_sizes(piece.pad, 0.35))
    return FiniteStrain(creases=creases).marched(piece, mesh, 2, films, [])


def friction(mu: float) -> Any:
    from skincad.effects import Friction

    return Friction(coefficient=mu)


@pytest.mark.slow
def test_a_march_tells_films_energy_and_gross_slip() -> None:
    what = model()
    drives = [Drive(0.3 * min(i, 4), 0.15 * max(0, i - 4)) for i in range(9)]
    run = march(what, np.arange(9.0), drives, [friction(0.4)])
    assert run.stopped == "gross slip"
    assert run.column("normal")[1:] == pytest.approx([d.normal for d in drives[1:]], rel=1e-9)
    assert run.column("tangential")[-1] == pytest.approx(0.48, rel=1e-9)
    assert run.readings[-1].slips[run.readings[-1].touches].all()
    assert run.column("residual").max() <= 1e-9
    assert (run.column("dissipated") >= -1e-12).all()
    films = run.column("films")
    assert films.shape == (9, 6, 3)
    # pressed, the middle ridge's strips are mirror images of each other to the mesh; pulled, they are not
    press, pull = films[4, 2:4, 0], films[-1, 2:4, 0]
    assert press[0] == pytest.approx(press[1], rel=0.03)
    assert abs(pull[0] - pull[1]) > 0.5 * np.abs(pull).max()
    # what the plate does is stored or dissipated, to the trapezoids' error
    normal, along = run.column("normal"), run.column("tangential")
    work = (normal[1:] + normal[:-1]) / 2 @ np.diff(run.column("approach"))
    work += (along[1:] + along[:-1]) / 2 @ np.diff(run.column("travel"))
    energy = run.readings[-1].elastic + run.column("dissipated").sum()
    assert energy == pytest.approx(work, rel=0.02)


def test_without_readout_no_film_is_looked_at() -> None:
    what = model(films=False)
    assert what.strips is None
    assert what.reading(what.start(), what.start()).films.shape == (0, 3)


def test_where_the_surface_folds_the_march_stops_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    from skincad.mechanics.contact import press_path

    monkeypatch.setattr(press_path, "WRINKLES", 0.99)  # a light load's stretch
    drives = [Drive(0.0, 0.0), Drive(0.3, 0.0), Drive(0.6, 0.0)]
    run = march(model(False), np.arange(3.0), drives, [friction(1.0)])
    assert run.failed
    assert run.stopped is not None
    assert "the surface folds onto itself at ridge " in run.stopped
    passed = march(model(False, "pass"), np.arange(3.0), drives, [friction(1.0)])
    assert passed.stopped is None


def test_a_tilting_plate_is_refused() -> None:
    what, step = model(False), Step(0.0, 1.0, Drive(0.0, 0.0), Drive(0.3, 0.0, angle=1e-3))
    with pytest.raises(ContactError, match="keeps its angle"):
        what.advanced(what.start(), step, [])


@pytest.mark.parametrize("term", ["inertia", "viscosity"])
def test_terms_that_ask_for_more_than_friction_are_refused(term: str, tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text(template_text("yamada-2002-slip", "scenes"))
    with pytest.raises(InputError, match=rf"effects\.{term}"):
        load_scene(tmp_path / "scene.toml", [f"effects.{term}={{}}", "effects.finite_strain={}"])


def test_it_is_the_only_law_and_has_no_unknown_key() -> None:
    with pytest.raises(InputError, match="must name one law at most"):
        load_scene("yamada-2002-slip", ["effects.finite_strain={}", "effects.small_strain={}"])
    with pytest.raises(InputError, match=r"effects\.finite_strain\.crease"):
        load_scene("yamada-2002-slip", ["effects.finite_strain.crease=stop"])


@pytest.mark.parametrize(("normal", "mu"), [pytest.param(0.15, 0.5, marks=pytest.mark.slow), (0.6, 0.2)])
def test_what_leaving_it_out_is_said_to_change_is_what_it_changes(
    normal: float, mu: float, tmp_path: Path
) -> None:
    """Of the largest differential stress, within a factor of 2: the spread of the calibration's scenes."""
    from skincad.effects import SmallStrain
    from skincad.scenes import left_out_effects

    drives = [Drive(normal * min(i, 3) / 3, 0.3 * mu * normal * max(0, i - 3)) for i in range(7)]
    design = yamada().with_(ridge={"count": 3}, skin={"width": 5.0}, contact={"film": "ignored"})
    piece = piece_of(*filled_pad(design), halved=False)
    mesh = triangles(piece.pad, default_sizes(piece.pad, 0.35))
    laws = SmallStrain(), FiniteStrain()
    runs = [
        march(law.marched(piece, mesh, 2, True, []), np.arange(7.0), drives, [friction(mu)]) for law in laws
    ]
    small, large = (run.column("films")[:, ::2, 0] - run.column("films")[:, 1::2, 0] for run in runs)
    changed = np.abs(large - small).max() / np.abs(small).max()
    text = (
        template_text("yamada-2002")
        .replace("count = 9 ", "count = 3 ")
        .replace("width = 11.0", "width = 5.0")
    )
    (tmp_path / "small.toml").write_text(text)
    (tmp_path / "scene.toml").write_text(template_text("yamada-2002-slip", "scenes"))
    scene = load_scene(tmp_path / "scene.toml", ["skin=small.toml", "effects.film=none"])
    said = next(entry for entry in left_out_effects(scene, runs[0]) if entry.effect == "finite_strain")
    assert said.calibrated
    assert 0.5 < said.change / changed < 2.0
