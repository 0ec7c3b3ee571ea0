"""The split cavity: parted where a ridge is locked, drawn piece by piece, and the same shape as the whole."""

import math

import pytest

import skincad
from skincad.base import InputError
from skincad.fabrication import Job, design_findings, interference, manifold
from skincad.inputs import Design
from skincad.shape import skin_of
from skincad.solids import ClosedMold, Move, safe_strain, solid, split_ridges
from skincad.solids.mold import mold

STEEP = "steep-fingertip"


def errors(design: Design) -> list[str]:
    return [f.rule for f in design_findings(Job(design)) if f.severity == "error"]


def many() -> Design:
    """Seven locked ridges on a radius of 8 mm: pieces between on both sides of the middle one."""
    return skincad.load(STEEP).with_(
        skin={"curvature_radius": 8.0, "width": 10.5, "thickness": 4.0},
        ridge={"count": 7, "height": 1.2, "pitch": 1.3, "root_width": 0.5, "tip_width": 0.5},
        slot=None,
        mold={"floor": 14.0},
    )


def test_the_steep_fingertip_is_locked_in_a_whole_cavity_and_free_in_a_split_one() -> None:
    steep = skincad.load(STEEP)
    assert errors(steep.with_(mold={"split": "none"})) == ["undercut", "undercut"]
    assert errors(steep) == []
    assert split_ridges(steep) == [1, 3]
    assert skin_of(steep).undercuts[1].strain > safe_strain(steep) > skin_of(steep).undercuts[2].strain


@pytest.mark.parametrize("design", [skincad.load(STEEP), many()], ids=["template", "seven ridges"])
def test_pieces_leave_one_by_one_without_touching_skin_or_each_other(design: Design) -> None:
    closed = mold(design)
    names = [p.name for p in closed.parts if p.name.startswith("cavity")]
    assert len(names) == 2 + len(split_ridges(design))
    assert [name for step in closed.opening for name in step.parts if name in names] != []
    assert interference(closed, 1e-3) == []  # the skin against the pieces too


def test_a_piece_pulled_along_its_neighbours_ridge_is_seen_to_interfere() -> None:
    closed = mold(many())
    ways = {step.parts[0]: step.axis for step in closed.opening}
    wrong = tuple(
        Move(step.parts, ways["cavity-left"], step.travel) if step.parts == ("cavity-5",) else step
        for step in closed.opening
    )
    findings = interference(ClosedMold(closed.parts, wrong), 1e-3)
    assert any("cavity-5 against skin" in f.where for f in findings)


def test_pulled_straight_the_outer_pieces_would_catch_the_outer_ridges() -> None:
    closed = mold(skincad.load(STEEP))
    straight = tuple(
        Move(s.parts, (0.0, -1.0), s.travel) if s.parts == ("cavity-right",) else s for s in closed.opening
    )
    assert any(
        "cavity-right against skin" in f.where for f in interference(ClosedMold(closed.parts, straight), 1e-3)
    )


@pytest.mark.parametrize("design", [skincad.load(STEEP), many()], ids=["template", "seven ridges"])
def test_pieces_are_solids_of_their_volume_and_fill_the_whole_cavity(design: Design) -> None:
    """Less their bores: by formula against the kernel, and as one block against the unsplit one."""
    closed, whole = mold(design), mold(design.with_(mold={"split": "none"}))
    pieces = [p for p in closed.parts if p.name.startswith("cavity")]
    for part in pieces:
        assert solid(part).Volume() == pytest.approx(part.volume, rel=1e-9)
    bodies = math.fsum(part.body.volume for part in pieces)
    assert bodies == pytest.approx(whole.part("cavity").body.volume, rel=1e-12)
    assert closed.part("skin").volume == pytest.approx(whole.part("skin").volume, rel=1e-12)


def test_holes_of_the_pieces_go_through_where_they_should() -> None:
    """Genus counts through holes: a y bolt a lane, and z bolts, which end in threads through the base."""
    closed = mold(skincad.load(STEEP))
    genus = {p.name: manifold(p, 1e-3).genus() for p in closed.parts if p.name.startswith("cavity")}
    assert genus == {"cavity-base": 4, "cavity-left": 2, "cavity-1": 0, "cavity-right": 2}


def test_a_cavity_without_a_locked_ridge_stays_whole(yamada: Design) -> None:
    assert mold(yamada.with_(mold={"split": "auto"})) == mold(yamada)


@pytest.mark.parametrize(
    ("change", "key"),
    [({"floor": 9.0, "carrier_thickness": 3.0}, "mold.floor"), ({"cavities": 2}, "mold.cavities")],
)
def test_a_split_cavity_without_room_is_refused(change: dict, key: str) -> None:
    with pytest.raises(InputError) as refused:
        mold(skincad.load(STEEP).with_(mold=change))
    assert refused.value.key == key
