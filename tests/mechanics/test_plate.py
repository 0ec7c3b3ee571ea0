"""Plates that are not flat: limits that must fall back on the flat one, symmetry, and hand calculations."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from skincad import load
from skincad.inputs import Plate
from skincad.mechanics import Answer, Request, plane_piece, problem, run
from skincad.mechanics.models import linear
from tests.mechanics.designs import linear_check, plane
from tests.refusals import refused_by

PLAIN = load("plain-ridges", ["ridge.count=5", "skin.width=7.0", "contact.force=2.2"])


def on(**plate: object) -> Answer:
    return plane(PLAIN.with_(contact={"plate": plate}), tol=0.01)


@cache
def flat() -> Answer:
    """On the mesh of a shaped plate's pad, which is not halved."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(linear, "plane_piece", lambda *a, **_: plane_piece(*a, whole=True))
        return plane(PLAIN, tol=0.01)


def shares(verdict) -> np.ndarray:
    return np.array([f.value for f in verdict.ridge_force])


@pytest.mark.evidence(subject="shaped plates")
def test_a_plate_that_is_hardly_shaped_is_flat() -> None:
    for plate in (
        {"shape": "tilted", "tilt": 0.0},
        {"shape": "cylinder", "radius": 1e8},
        {"shape": "step", "height": 0.0},
    ):
        verdict = on(**plate)
        # the first touch is a sample here, the exact summit there: 1e-6 mm
        assert verdict.all_touch_force.value == pytest.approx(flat().all_touch_force.value, rel=1e-4)
        assert shares(verdict) == pytest.approx(shares(flat()), abs=1e-4)


@pytest.mark.slow
def test_tilting_the_other_way_mirrors_the_shares() -> None:
    left, right = on(shape="tilted", tilt=-0.3), on(shape="tilted", tilt=0.3)
    assert shares(left) == pytest.approx(shares(right)[::-1], abs=2e-3)  # the mesh is not a mirror's
    assert shares(right)[0] > shares(right)[-1]  # it rises towards +x: the last ridge is farther


def test_a_tilt_is_the_base_circle_rolled_aside() -> None:
    """On an arc, tilting by a moves the lowest point by R a: a hand calculation for the gaps."""
    x = np.linspace(-4, 4, 9)
    arc = 60.5 * (1 - np.cos(x / 60))
    gap = arc + problem.rise(Plate(shape="tilted", tilt=1.0), 60.5 * np.sin(x / 60))
    assert x[np.argmin(gap)] == -1.0  # R a = 60 x 0.01745


@pytest.mark.slow
def test_a_cylinder_of_the_skins_own_radius_doubles_the_gaps() -> None:
    x = np.array([-4.0, 0.0, 4.0])
    height = problem.rise(Plate(shape="cylinder", radius=60.5), x)
    assert height == pytest.approx(60.5 - np.sqrt(60.5**2 - x**2), rel=1e-9)  # closed form, cancelling
    assert on(shape="cylinder", radius=60.5).all_touch_force.value > 1.9 * flat().all_touch_force.value
    assert np.isinf(problem.rise(Plate(shape="cylinder", radius=2.0), x)[0])


@pytest.mark.parametrize("model", ["winkler", "linear"])
def test_a_plate_that_is_higher_everywhere_is_the_flat_one(model: str) -> None:
    raised = PLAIN.with_(contact={"plate": {"shape": "step", "height": 0.3, "position": -100.0}})
    answer, same = (run(model, design, Request(2.2, 0.9), {}, None) for design in (raised, PLAIN))
    assert answer.approach.value == pytest.approx(same.approach.value, rel=1e-4)  # first touch is sampled
    assert shares(answer) == pytest.approx(shares(same), abs=1e-4)


def test_a_step_unloads_the_ridges_under_it() -> None:
    verdict = on(shape="step", height=0.05, position=0.5)
    assert (shares(verdict)[3:] < shares(flat())[3:]).all()
    assert shares(verdict)[:3].sum() > shares(flat())[:3].sum()


@pytest.mark.parametrize(
    ("plate", "words"),
    [
        ({"shape": "cylinder"}, "contact.plate.radius: is missing"),
        ({"shape": "flat", "tilt": 1.0}, "contact.plate.shape: must be 'tilted' where tilt is given"),
        ({"shape": "cylinder", "radius": 6.0}, "contact.plate: must not slope by more than 0.35"),
        ({"shape": "tilted", "tilt": 30.0}, "contact.plate.tilt: must be less than or equal to 5"),
        ({"shape": "wedge"}, "contact.plate.shape: must be 'flat', 'tilted', 'cylinder' or 'step'"),
    ],
)
def test_a_plate_out_of_range_is_refused(plate: dict, words: str) -> None:
    with refused_by(words):
        linear_check(PLAIN.with_(contact={"plate": plate}))
