"""Skins in layers: their plugs, which keep a later layer's room, and what a mold can't do."""

from __future__ import annotations

import math
from typing import Any

import pytest

import skincad
from skincad import InputError
from skincad.fabrication import mesh
from skincad.inputs import Design
from skincad.solids import CutRole, PartRole, behind, room, skin_part
from skincad.solids.mold import mold
from skincad.solids.skin import cast_skin
from tests.solids.kinds import ARC, LEVEL, STIFF

CHORD = 1e-3  # mm


def layered(name: str, *shots: dict[str, Any], **tables: Any) -> Design:
    return skincad.load(name).with_(shot=shots, **tables)


@pytest.mark.parametrize(
    ("name", "shot", "pegs"),
    [
        ("yamada-2002", LEVEL, 0),
        ("yamada-2002", {**STIFF, "depth": 1.2, "bond": "rivets"}, 4),
        ("rings-5", {**STIFF, "thickness": 1.5, "bond": "rivets"}, 20),
        ("rings-5", {**STIFF, "depth": 2.5}, 0),
        ("flat-magnet", {**STIFF, "depth": 1.5}, 0),
        ("pillars-9", {**STIFF, "thickness": 1.0, "bond": "rivets"}, 8),
        ("nibs-fine", {**STIFF, "depth": 1.0}, 0),
    ],
)
def test_a_plug_fills_the_room_of_its_shot(name: str, shot: dict[str, Any], pegs: int) -> None:
    """Under its plate it is what lies behind the face, less a clearance all round: at most that thin a
    rim of it."""
    design = layered(name, shot)
    closed = mold(design)
    (stage,) = closed.earlier
    (plug,) = stage.of(PartRole.PLUG)
    assert len(plug.adds) - design.skin.round == pegs
    plate = closed.first(PartRole.CARRIER).body.volume
    whole, gap = behind(design, 1).volume, design.mold.clearance
    around = 2 * (design.skin.width + design.skin.length) * design.skin.thickness
    under = plug.volume - plate + math.fsum(cut.volume for cut in plug.cuts)
    assert whole - gap * around - 1.0 < under < whole * 1.01 + pegs * 2.0


def test_layers_fill_the_skin() -> None:
    """The chords of a round and of a straight skin: what is behind the last face, and the layer in front."""
    for name in ("yamada-2002", "rings-5"):
        design = layered(name, LEVEL, {**STIFF, "depth": 0.6})
        one, two = behind(design, 1).volume, behind(design, 2).volume
        skin = design.skin
        area = math.pi * skin.width**2 / 4 if skin.round else skin.width * skin.length
        assert one == pytest.approx(area * 1.0, rel=1e-12)
        assert one < two < skin_part(design).volume < cast_skin(design).volume * 1.01


@pytest.mark.parametrize(
    ("shot", "deep"),
    [({"thickness": 1.6}, 1.0), ({"depth": 1.2}, 4.4), ({"thickness": 2.6}, 4.4), ({"depth": 3.0}, 1.0)],
)
def test_what_lies_behind_a_face_is_without_its_pockets(shot: dict[str, float], deep: float) -> None:
    """A pocket ends in the shot, or goes through its face, which may be curved: the mesh says so too,
    within the chord's 1e-3 mm on 2 mm."""
    pocket = {"diameter": 2.1, "depth": deep}
    design = layered("flat-magnet", {**STIFF, **shot}, flat={"pocket": pocket})
    part = room(design, 1)
    assert mesh(part, CHORD).volume == pytest.approx(part.volume, rel=6e-4)
    assert part.volume < behind(design, 1).volume


def test_core_pins_stand_in_a_plug_whose_shot_their_pockets_go_through() -> None:
    """pillars-9's pockets are 3 mm deep: through the faces at 1 and 2 mm, so through both plugs."""
    closed = mold(layered("pillars-9", LEVEL, {**STIFF, "thickness": 2.0}))
    for stage in closed.earlier:
        (plug,) = stage.of(PartRole.PLUG)
        pins = stage.of(PartRole.CORE_PIN)
        assert len(pins) == 9
        assert len([cut for cut in plug.cuts if cut.role is CutRole.CORE]) == 9
        assert stage.opening[-1].parts == (plug.name,)  # the pins stay in the layer
        assert mesh(plug, CHORD).euler_number == 2 - 2 * (9 + 1)  # with the vent: no film closes a hole
    shallow = {"pocket": {"diameter": 1.6, "depth": 1.0}}
    (stage,) = mold(layered("pillars-9", {**STIFF, "thickness": 2.0}, pin=shallow)).earlier
    assert not stage.of(PartRole.CORE_PIN)


def test_plugs_are_used_from_the_front_and_rivets_let_go() -> None:
    """The layer in front is poured first; a shot that is laid on wet needs none."""
    shots = (LEVEL, {**STIFF, "thickness": 2.0, "bond": "wet"}, {**STIFF, "depth": 1.0})
    closed = mold(layered("lab-bench", *shots, mold={"gate": None}))
    assert [part.name for part in closed.plugs] == ["plug-3", "plug-1"]
    assert all(part.made == "made" for part in closed.plugs)
    first, last = closed.plugs
    assert first.volume > last.volume
    for stage in closed.earlier:
        assert not stage.of(PartRole.SKIN, PartRole.CARRIER)
    # rivets hold behind a neck that the silicone lets go
    (plug,) = mold(layered("rings-5", {**STIFF, "thickness": 1.5, "bond": "rivets"})).plugs
    _core, *pegs = plug.adds
    (head,) = {max(s.end.x for s in peg.outline) for peg in pegs}
    (neck,) = {min(s.end.x for s in peg.outline if s.end.x) for peg in pegs}
    assert neck == 0.5
    assert head == pytest.approx(1.25 * neck)  # a stretch of 25 %; dragon-skin-20 breaks at 620 %


@pytest.mark.parametrize(
    ("name", "shot", "more", "refusal"),
    [
        ("lab-bench", LEVEL, {}, "mold.gate: must not be given with"),
        ("yamada-2002", LEVEL, {"mold": {"pour": "syringe"}}, "mold.pour: must not be given with"),
        ("yamada-2002", {**STIFF, "thickness": 0.3}, {}, "shot.thickness: leaves shot 1 less than 0.5 mm"),
        ("yamada-2002", {**STIFF, "thickness": 3.2, "bond": "rivets"}, {}, "'rivets' need 0.9 mm"),
        ("flat-magnet", {**STIFF, "thickness": 2.2}, {}, "flat.pocket.depth: must end 0.5 mm before"),
        ("pins-dome", LEVEL, {}, "skin.thickness: leaves 0.401 mm for the gate of shot 1, which needs 0.7"),
        (
            "pins-dome",
            {**STIFF, "thickness": 2.0, "bond": "wet"},
            {},
            "shot.bond: must not be 'wet' in a dou",
        ),
        ("pins-dome", LEVEL, {"mold": {"pour": "open"}}, "mold.pour: must be 'syringe' in a doubly curved"),
        # a face that follows the base is not laid on wet
        ("yamada-2002", {**ARC, "bond": "wet"}, {}, r"shot\.1?\.?bond|bond: must not be 'wet'"),
    ],
)
def test_what_a_mold_of_layers_cannot_be(name: str, shot: Any, more: Any, refusal: str) -> None:
    with pytest.raises(InputError, match=refusal):
        mold(layered(name, shot, **more))
