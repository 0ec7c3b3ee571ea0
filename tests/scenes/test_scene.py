"""Scenes that are read, and bad ones: each one line, with key, rule, value and remedy."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest

from skincad.base import InputError
from skincad.inputs import template_names, template_text
from skincad.scenes import load_scene
from tests.refusals import refused, refused_command

SLIP = "yamada-2002-slip"


@pytest.mark.parametrize("name", template_names("scenes"))
def test_templates_load_and_are_named_as_their_file(name: str) -> None:
    scene = load_scene(name)
    assert scene.name == name
    drives = scene.history.drives()
    corners = 0 if scene.grip is None else scene.history.step_count - scene.history.steps  # of a lift's plan
    assert len(drives) == scene.history.steps + 1 + corners
    assert drives[0].normal == 0.0


def test_the_slip_scene_is_the_papers() -> None:
    """550 steps of 1e-5 s; Ft/Fn near 1 in steps 200 to 300, well below from 300, 1 at 550."""
    history = load_scene(SLIP).history
    assert history.steps == 550
    assert history.times[1] == pytest.approx(1e-5)
    drives = history.drives()
    ratio = [d.tangential / d.normal if d.normal else 0.0 for d in drives]
    assert min(ratio[200:301]) > max(ratio[330:451])
    assert ratio[550] == pytest.approx(1.0)
    assert all(b > a for a, b in pairwise(ratio[450:]))
    assert not any(ratio[:101])


BAD = {
    "effects.fricton={coefficient=1.0}": "effects.fricton: unknown effect; did you mean 'friction'?",
    "effects.friction.muu=0.3": "effects.friction.muu: unknown key; known: coefficient, kinetic, law",
    "effects.friction.coeficient=1.0": "friction.coeficient: unknown key; did you mean 'coefficient'?",
    "effects.friction.coefficient=-0.3": "effects.friction.coefficient: must be greater than or equal to 0",
    "effects.friction.kinetic=1.5": "effects.friction.kinetic: must be at most coefficient, got 1.5",
    "skin=plain-ridges": "effects.film: needs a skin with a [film]",
    "skin=yamada-2003": "skin: no such template among designs, and no TOML file, got 'yamada-2003'",
    "histroy.steps=3": "histroy",
    "history.steps=0": "history.steps: must be greater than or equal to 1",
    "history.time_s=[0.0, 0.001, 0.002, 0.0015, 0.0033, 0.0045, 0.0055]": "history.time_s: must not go back",
    "history.time_s=[0.0, 1.0, 1.0000000005, 3.0, 4.0, 5.0, 6.0]": "at least 1e-09 s apart, got 5e-10",
    "history.time_s=[0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]": "history.time_s: must begin at 0",
    "history.normal_force_N=[0.0, 4.0, 4.0, 4.0, 4.0, -1.0, 4.0]": "history.normal_force_N: must not pull",
    "history.normal_force_N=[0.0, 4.0]": "history.normal_force_N: needs 7 values, as time_s has, got 2",
    "history.normal_force_N=[1.0, 4.0, 4.0, 4.0, 4.0, 4.0, 4.0]": "normal_force_N: must begin unloaded",
    "history.rotation_deg=[0.0, 1.0]": "history.rotation_deg: needs 7 values, as time_s has, got 2",
    "history.rotation_deg=[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0]": "history.rotation_deg: must begin at 0",
    "history.rotation_deg=[0.0, 6.0, 1.0, 1.0, 1.0, 1.0, 1.0]": "history.rotation_deg: must be from -5 to 5",
    "history.tangential_force_N=[0.0, nan, 3.4, 3.4, 2.6, 3.2, 4.0]": "tangential_force_N.1: must be a fini",
    "readout.steps=[551]": "readout.steps: must be from 0 to 550, got 551",
    "readout.steps=[-1]": "readout.steps.0: must be greater than or equal to 0",
    "readout.alarms=late": "readout.alarms: must be 'sure', 'early' or 'grip', got 'late'",
    "readout.frames=61": "readout.frames: must be less than or equal to 60, got 61",
    "effects.film.bond=glued": "effects.film.bond: must be 'bonded' or 'loose', got 'glued'",
    "effects.film.bond=loose": "readout.ridges: needs films' stresses, which effects.film does not",
    "history.tangential_force_N=none": "history: needs either tangential_force_N or displacement_mm",
    "plate.shape=cylinder": "plate.shape: must be 'flat'",
    "effects.inertia={}": "plate.mass: is missing; masses count here: give the plate's mass in g",
    "effects.inertia.spectral_radius=1.5": "effects.inertia.spectral_radius: must be less than or equal to 1",
    "effects.viscosity.prony=[[0.5]]": "effects.viscosity.prony.0",
    "effects.viscosity.prony=[[0.5, 0.0]]": "effects.viscosity.prony: needs a modulus and a time above 0",
    "effects.viscosity.retardation_time=0.0": "effects.viscosity.retardation_time: must be above 0 where",
    "readout.ridges=[10]": "readout.ridges: must be from 1 to 9, got 10",
    "readout.ridges=[3, 3]": "readout.ridges: names a ridge twice",
    "readout.bandwidth_Hz=0.0": "readout.bandwidth_Hz: must be greater than 0 (Hz), got 0",
}


@pytest.mark.parametrize("override", BAD)
def test_bad_scenes_are_one_line(override: str) -> None:
    with refused(BAD[override]):
        load_scene(SLIP, [override])


TURNS = "history.rotation_deg=[0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
FINITE, PAST = "effects.finite_strain={}", "effects.viscosity.retardation_time=1e-4"


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        (
            ["skin=plain-ridges", "effects.film=none"],
            "readout.ridges: needs films' stresses, but plain-ridges",
        ),
        (["effects.piezo.circuit=yamada-2002", "effects.film=none"], "effects.piezo: needs the effect film"),
        *(
            ([more, other], rf"{more.partition('=')[0]}: does not work together with .*{name}")
            for more in (TURNS, "readout.steps=[3]")
            for name, other in (("finite_strain", FINITE), ("viscosity", PAST))
        ),
        *(
            (["plate.mass=1.0", other], f"plate.mass: does not count beside {named}")
            for other, named in (
                (PAST, r"\[effects\.viscosity\]"),
                (FINITE, r"\[effects\.finite_strain\]"),
                ("effects.small_strain.masses=false", r"\[effects\.small_strain\]"),
                (TURNS, "a plate that turns"),
            )
        ),
    ],
)
def test_what_does_not_go_together_is_refused(settings: list[str], words: str) -> None:
    with pytest.raises(InputError, match=words):
        load_scene(SLIP, settings)
    assert load_scene(SLIP, ["plate.mass=1.0"]).plate.mass == 1.0


def test_a_skins_path_counts_from_the_scene(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text(template_text("yamada-2002"))
    scene = template_text(SLIP, "scenes").replace('skin = "yamada-2002"', 'skin = "mine.toml"')
    (tmp_path / "scene.toml").write_text(scene)
    assert load_scene(tmp_path / "scene.toml").design.name == "yamada-2002"


def test_a_bad_scene_exits_with_2_and_writes_nothing(tmp_path: Path) -> None:
    message = refused_command("simulate", SLIP, "--set", "effects.fricton.coefficient=1.0", cwd=tmp_path)
    assert message == "effects.fricton: unknown effect; did you mean 'friction'?"
