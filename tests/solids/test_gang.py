"""Several skins in one block: each as if alone, between common plates."""

from __future__ import annotations

import pytest

import skincad
from skincad.fabrication import Job, interference, manifold, poured_volume
from skincad.fabrication.filling import pockets
from skincad.inputs import Design
from skincad.solids import solid
from skincad.solids.mold import mold


def gang(name: str, count: int) -> Design:
    return skincad.load(name).with_(mold={"cavities": count})


@pytest.mark.parametrize(
    ("name", "count"),
    [("yamada-2002", 2), ("plain-ridges", 4), pytest.param("lab-bench", 2, marks=pytest.mark.slow)],
)
def test_a_gang_opens_freely_and_holds_as_many_skins(name: str, count: int) -> None:
    closed = mold(gang(name, count))
    skins = [p for p in closed.parts if p.made == "cast"]
    assert len(skins) == len([p for p in closed.parts if p.name.startswith("carrier")]) == count
    assert interference(closed, 1e-3) == []


@pytest.mark.parametrize(
    ("name", "count"), [("yamada-2002", 2), pytest.param("plain-ridges", 4, marks=pytest.mark.slow)]
)
def test_parts_of_a_gang_are_solids_of_their_volume(name: str, count: int) -> None:
    for part in mold(gang(name, count)).parts:
        assert solid(part).Volume() == pytest.approx(part.volume, rel=1e-9)


def test_every_skin_of_a_gang_is_the_single_one_moved(yamada: Design) -> None:
    one = mold(yamada).part("skin")
    centres = []
    for part in mold(gang("yamada-2002", 3)).parts:
        if part.made == "cast":
            assert part.volume == pytest.approx(one.volume, rel=1e-12)  # moments about each one's own corner
            centres.append(manifold(part, 1e-3).bounding_box()[0] - manifold(one, 1e-3).bounding_box()[0])
    assert centres[1] == pytest.approx(0.0, abs=1e-12)
    assert centres[2] == pytest.approx(-centres[0], abs=1e-12)
    assert centres[2] > 11.0 + 2 * 2.0 + 2 * 1.7  # skin, ledges, a bolt between


def test_gates_reservoirs_and_bolts_are_one_for_each_and_one_between() -> None:
    """Genus counts through holes: bolts in count + 1 lanes, a gate for each skin."""
    closed = mold(gang("yamada-2002", 4))
    genus = {p.name: manifold(p, 1e-3).genus() for p in closed.parts if p.made == "made"}
    assert genus["cavity"] == 2 * 5
    assert genus["end-a-comb"] == 5 + 2
    assert genus["end-a-keeper"] == 5 + 4
    assert genus["cover"] == 2 + 5 + 4 * 5  # pins, a bolt a row; reservoir and four bleeds each


def test_grams_and_air_are_those_of_the_single_mold_times_the_skins(yamada: Design) -> None:
    single, many = mold(yamada), gang("yamada-2002", 4)
    assert poured_volume(Job(many)) == pytest.approx(4 * poured_volume(Job(yamada, single)), rel=1e-12)
    assert pockets(Job(many), 1.0) == pockets(Job(yamada, single), 1.0)
