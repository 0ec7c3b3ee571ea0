"""The section under its force, as it is drawn: closed, held at its back, and loaded by the force."""

from __future__ import annotations

import numpy as np
import pytest

import skincad
from skincad.mechanics import ContactCheck

FEW = ["ridge.count=3", "skin.width=5.0", "contact.force=1.0"]


@pytest.fixture(scope="module", params=["bonded", "loose"])
def verdict(request: pytest.FixtureRequest) -> ContactCheck:
    design = skincad.load("yamada-2002", [*FEW, f"contact.film={request.param}"])
    return skincad.check(design, model="linear")


def test_the_pressure_carries_the_force(verdict: ContactCheck) -> None:
    length = skincad.load("yamada-2002").skin.length
    carried = 0.0
    for piece in verdict.deformed:
        for loop in piece:
            run = np.roll(loop.moved[:, 0], -1) - loop.moved[:, 0]  # to -x along the crests
            carried -= length * float(run @ (loop.pressure + np.roll(loop.pressure, -1)) / 2)
    # straight between contact points: where a crown's contact ends it is half an element too wide
    assert carried == pytest.approx(verdict.force, rel=0.1)


def test_every_loop_has_the_silicone_to_its_left(verdict: ContactCheck) -> None:
    whole = 0.0
    for piece in verdict.deformed:
        areas = []
        for loop in piece:
            x, z = loop.rest.T
            areas.append(float(x @ np.roll(z, -1) - z @ np.roll(x, -1)) / 2)
        assert sum(area > 0 for area in areas) == 1
        whole += sum(areas)
    slots = 0.05 * 0.25 * 6 if any(len(piece) > 1 for piece in verdict.deformed) else 0.0
    plain = skincad.load("yamada-2002", [*FEW, "slot=none", "film=none", "contact.film=none"])
    assert whole == pytest.approx(skincad.section(plain).area - slots, rel=1e-4)  # chords of its arcs


def test_the_back_stays_and_the_crests_come_down(verdict: ContactCheck) -> None:
    loops = [loop for piece in verdict.deformed for loop in piece]
    moves = [loop.moved - loop.rest for loop in loops]
    for loop, move in zip(loops, moves, strict=True):
        clamped = loop.rest[:, 1] == 0
        assert np.abs(move[clamped]).max(initial=0) == 0
    # 5e-3: at points of the mesh
    assert max(-move[:, 1].min() for move in moves) == pytest.approx(verdict.approach.value, rel=5e-3)


def test_a_closed_form_draws_none() -> None:
    assert skincad.check(skincad.load("yamada-2002"), model="winkler").deformed == ()
