"""The mold of a skin that is curved along y too: a bowl that turns about an axis above it."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
import trimesh
from manifold3d import Manifold

import skincad
from skincad.base import InputError
from skincad.fabrication import interference, manifold
from skincad.inputs import Design
from skincad.shape import heights, section, skin_of
from skincad.solids import (
    Bore,
    ClosedMold,
    CutRole,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    RotatedBody,
    gap_beside,
    notch_rise,
    room,
    scaled_for_shrinkage,
    solid,
    unturned,
    volume,
)
from skincad.solids.mold import mold
from tests.conftest import files_into
from tests.designs import bent, three_ridges
from tests.solids.kinds import FEW, KINDS, STIFF, bowl_of_layers, few_ridges

RADII = (60.0, 25.0)
CROWNS = pytest.mark.evidence(subject="seeds: flat crowns")
TEMPLATES = ["yamada-2002", "plain-ridges", "lab-bench", "gripper-pad", "nozzle-04", "milled-pad"]
FINE = 5e-4  # mm: a tenth of the template's slit clearance


@pytest.fixture(scope="module")
def design() -> Design:
    return three_ridges()


@pytest.fixture(scope="module")
def closed(design: Design) -> ClosedMold:
    return mold(design)


@pytest.fixture(scope="module")
def meshes(closed: ClosedMold) -> dict[str, Manifold]:
    return {part.name: manifold(part, FINE) for part in closed.parts}


def axis(closed: ClosedMold) -> float:
    body = closed.part("skin").body
    return body.centre


@pytest.mark.slow
def test_every_solid_of_a_nearly_straight_bowl_is_valid_and_of_its_volume() -> None:
    for part in mold(bent("yamada-2002", 1e4, "ridge.count=3")).parts:
        # `solid` asks for validity and 1e-9; 1e-10 is what bores into the carrier's arc reach
        assert volume(part, solid(part)) == pytest.approx(part.volume, rel=1e-10), part.name


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("radius", RADII)
@pytest.mark.parametrize("name", ["yamada-2002", "lab-bench", "plain-ridges", "gripper-pad", "nozzle-04"])
def test_templates_have_a_doubly_curved_mold(name: str, radius: float) -> None:
    design = bent(name, radius if name != "nozzle-04" else 2 * radius)
    closed = mold(design)
    for part in closed.parts:
        if part.made == "made":
            assert volume(part, solid(part)) == pytest.approx(part.volume, rel=1e-9), part.name
    assert interference(closed, min(design.mold.clearance, design.mold.slit_clearance) / 10) == []


@cache
def level_crowned(seed: int) -> tuple[Design, ClosedMold]:
    """A random doubly curved design whose crowns are flat, with its mold; its fillets, flanks, ridges and
    radii too are drawn, until a design has a mold."""
    draw = random.Random(seed)
    while True:
        base = skincad.load(draw.choice(TEMPLATES))
        tip = base.ridge.tip_width
        skin = {"curvature_radius_y": 10 ** draw.uniform(1.4, 3.5)}
        ridge = {
            "crown": 0.0,
            "tip_fillet": tip * draw.choice([0.0, 0.05, 0.1, 0.2, 0.3]),
            "height": base.ridge.height * draw.uniform(0.7, 1.3),
            "count": draw.randint(1, base.ridge.count),
        }
        if draw.random() < 0.5:
            skin["curvature_radius"] = 10 ** draw.uniform(1.5, 4)
        if draw.random() < 0.5:  # flanks that are upright, or nearly so
            ridge["root_width"] = tip * draw.choice([1.0, 1.001, 1.02, 1.1])
        try:
            design = base.with_(skin=skin, ridge=ridge, mold={"split": "none"})
            return design, mold(design)
        except InputError:
            continue


def assert_exact(closed: ClosedMold, rel: float) -> None:
    for name in ("skin", "cavity"):
        part = closed.part(name)
        assert volume(part, solid(part)) == pytest.approx(part.volume, rel=rel), name


# of 60, 9 and 22 had crowns that rounding bent, 2, 4 and 39 crowns along which the kernel walked in steps
@pytest.mark.parametrize("seed", [pytest.param(i, marks=[] if i in (4, 22) else CROWNS) for i in range(60)])
def test_flat_crowns_make_an_exact_mold(seed: int) -> None:
    """The kernel's edges are the section's: volumes agree to rounding, of some 1e3 terms. Edges that it finds
    by steps within its tolerance are off by up to 1e-6."""
    assert_exact(level_crowned(seed)[1], 1e-11)


@CROWNS
def test_nearly_flat_crowns_make_a_mold() -> None:
    """Crowns from rounding to 0.1 um high: the kernel takes those below 1e-7 mm for flat, which is 1e-8 of
    a skin that is 5 mm thick."""
    draw = random.Random(15)
    for seed in range(12):
        design = level_crowned(seed)[0].with_(ridge={"crown": 10 ** draw.uniform(-17, -4)})
        assert_exact(mold(design), 3e-8)


@CROWNS
def test_files_of_a_mold_with_flat_crowns_read_back(tmp_path: Path) -> None:
    design = bent("gripper-pad", 100.0, "ridge.crown=0", "ridge.count=9", "skin.width=16")
    result = files_into(design, tmp_path / "out", ["step", "stl", "3mf"])
    closed = mold(design)
    for part in result.parts:
        assert part.valid
        assert part.watertight
        assert part.self_intersections == 0
        assert part.deviation <= part.asked_deviation
        again = cq.importers.importStep(str(result.folder / f"solids/{part.name}.step")).val()
        assert again.isValid()
        assert volume(closed.part(part.name), again) == pytest.approx(part.volume, rel=1e-9)  # STEP's digits
        assert trimesh.load_mesh(result.folder / f"solids/{part.name}.stl").is_watertight


def test_it_tends_to_the_straight_mold(yamada: Design) -> None:
    straight = mold(yamada)
    for part in mold(yamada.with_(skin={"curvature_radius_y": 1e4})).parts:
        if part.name in ("skin", "carrier") or part.name.startswith("shim"):
            # the carrier's middle is 2 um thicker and its holes are; all else is relative 1e-3 and less
            assert part.volume == pytest.approx(straight.part(part.name).volume, rel=3e-3), part.name
    bore = Bore((0.0, 2.0, -0.5), "z", 4.5, 1.0, 1.2, within=(1e9, 1e9))
    foot = 1.0 + 0.2 * 0.5 / 4.5
    assert bore.volume == pytest.approx(math.pi * 4 * (1.44 + 1.2 * foot + foot**2) / 3, rel=1e-8)  # 4 / 1e9


def test_a_plug_tends_to_the_straight_one() -> None:
    """Its core ends 0.02 mm before its plate does at either end, 1e-3 of it; what the back falls away under
    it is as much as its face does."""
    shot = {**STIFF, "thickness": 1.5}
    far = mold(bent("yamada-2002", 1e4, *FEW).with_(shot=(shot,))).part("plug-1")
    straight = mold(few_ridges(shot=(shot,))).part("plug-1")
    assert far.volume == pytest.approx(straight.volume, rel=2e-3)
    cast, gap = scaled_for_shrinkage(few_ridges(shot=(shot,))), few_ridges().mold.clearance
    box = (cast.skin.width - 2 * gap) * (cast.skin.length - 2 * gap - 0.04) * cast.shot[0].thickness
    assert far.adds[0].volume == pytest.approx(box, rel=1e-3)  # an arc of 12 mm about 10 m


@pytest.mark.evidence(subject="layers in a bowl: files")
def test_files_of_layers_in_a_bowl_read_back(tmp_path: Path) -> None:
    """STEP keeps 1e-9 of a volume; each mesh is closed and within its chord."""
    design = bowl_of_layers({**STIFF, "thickness": 1.5})
    result = files_into(design, tmp_path / "out", ["step", "stl", "3mf"])
    closed = mold(design)
    assert "plug-1" in [part.name for part in result.parts]
    for part in result.parts:
        assert part.valid
        assert part.watertight
        assert part.self_intersections == 0
        assert part.deviation <= part.asked_deviation
        again = cq.importers.importStep(str(result.folder / f"solids/{part.name}.step")).val()
        assert again.isValid()
        assert volume(closed.part(part.name), again) == pytest.approx(part.volume, rel=1e-9)


@pytest.mark.slow
def test_nothing_interferes_by_sampled_positions(closed: ClosedMold, meshes: dict[str, Manifold]) -> None:
    """Independent of the swept shapes: each part moved a little, and on, against all that is still there."""
    there = dict(meshes)
    for step in closed.opening:
        moving = {name: there.pop(name) for name in step.parts}
        for share in (1e-3, 0.02, 0.1, 0.3, 0.7, 1.0):
            for name, shape in moving.items():
                placed = _moved(closed, name, shape, step.axis, share * step.travel)
                for other, still in there.items():
                    if name.startswith("shim") and other == "skin":
                        continue  # chords of an arc that is turned by less than their length; told elsewhere
                    # chords that slide along others by a part of their length; 0.05 mm2 a shim's section
                    assert (placed ^ still).volume() < 1e-7, (name, other, share)


@pytest.mark.parametrize("name", ["layers in a bowl", "layers with rivets in a bowl"])
def test_plugs_lift_off_their_layers_and_keepers_off_their_combs(name: str, tmp_path: Path) -> None:
    """By sampled positions, against the layer in front too, as cast: less rivets, over which it stretches."""
    design = KINDS[name](tmp_path)
    for stage in mold(design).earlier:
        there = {part.name: manifold(replace(part, adds=_cores(part)), FINE) for part in stage.parts}
        (plug,) = (part.name for part in stage.of(PartRole.PLUG))
        cast = scaled_for_shrinkage(design)
        skin = manifold(mold(design).part("skin"), FINE)
        there["layer"] = skin - manifold(room(cast, int(plug[-1])), FINE).rotate((180.0, 0.0, 0.0))
        for step in stage.opening:
            moving = {part: there.pop(part) for part in step.parts}
            for share in (1e-3, 0.02, 0.1, 0.3, 1.0):
                for part, shape in moving.items():
                    placed = _moved(stage, part, shape, step.axis, share * step.travel)
                    for other, still in there.items():
                        if {"layer", part, other} - {"layer", plug}:
                            assert (placed ^ still).volume() < 1e-7, (part, other, share)
                        else:  # chords of its face, within FINE of 60 to 280 mm2
                            assert (placed ^ still).volume() < 280 * FINE, share
        assert there.keys() >= {"cavity", "layer"}


def _cores(part: Part) -> tuple[RevolvedBody, ...]:
    return tuple(body for body in part.adds if isinstance(body, RevolvedBody))


def test_each_layer_has_its_gate(tmp_path: Path) -> None:
    """In the planes of the ends they open between the faces of their layer, each by 0.3 mm of it."""
    for name in ("layers in a bowl", "layers with rivets in a bowl"):
        design = scaled_for_shrinkage(KINDS[name](tmp_path))
        shots = len(design.shot)
        plates = [
            part for part in mold(KINDS[name](tmp_path)).parts if part.name in ("end-a", "end-a-keeper")
        ]
        gates = [cut.body for cut in plates[0].cuts if cut.role is CutRole.GATE]
        assert len(gates) == shots + 1
        faces = [0.0, *(float(heights(design, n, np.zeros(1), np.zeros(1))[0]) for n in range(1, shots + 1))]
        for gate, back, front in zip(gates, faces, [*faces[1:], design.skin.thickness], strict=True):
            assert back + 0.3 - 1e-9 <= -gate.start[2] - gate.radius
            assert -gate.start[2] + gate.radius <= front - 0.3 + 1e-9


def _moved(closed: ClosedMold, name: str, shape: Manifold, way: object, travel: float) -> Manifold:
    if way == "turn":
        angle, centre = math.degrees(travel), axis(closed)
        return shape.translate((0, 0, -centre)).rotate((angle, 0, 0)).translate((0, 0, centre))
    body = closed.part(name).body
    if isinstance(body, RotatedBody):
        along, up = (travel, 0.0) if way == "y" else (0.0, travel)
        c, s = math.cos(body.angle), math.sin(body.angle)
        return shape.translate((0.0, along * c - up * s, along * s + up * c))
    assert way == "z"
    return shape.translate((0.0, 0.0, travel))


def test_the_skin_leaves_its_bowl_upward_only(design: Design, meshes: dict[str, Manifold]) -> None:
    assert max(u.width for u in skin_of(design).undercuts.values()) == 0.0
    skin, cavity = meshes["skin"], meshes["cavity"]
    for up in (1e-3, 0.1, 0.5, 2.0, 8.0):
        assert (skin.translate((0, 0, up)) ^ cavity).volume() < 1e-7  # rounding of the sides, which slide
    assert (skin.translate((0, 0.5, 0)) ^ cavity).volume() > 0.1
    steep = bent("yamada-2002", 60.0, "skin.curvature_radius=15.0", "ridge.tip_width=0.7", "slot=none")
    caught = {part.name: manifold(part, 1e-3) for part in mold(steep).parts}
    assert (caught["skin"].translate((0, 0, 0.1)) ^ caught["cavity"]).volume() > 1e-3


@pytest.mark.slow
def test_interference_sees_a_plate_that_does_not_lean_and_a_straight_shim(closed: ClosedMold) -> None:
    upright = unturned(closed.part("end-b-comb"))
    shim = closed.part("shim-2-S1")
    straight = replace(shim, body=Prism(shim.body.outline, "y", -10.0, 16.0))
    for wrong in (upright, straight):
        parts = tuple(wrong if part.name == wrong.name else part for part in closed.parts)
        findings = interference(ClosedMold(parts, ()), FINE)
        assert any(wrong.name in finding.where for finding in findings)


def test_parts_have_the_holes_they_need(meshes: dict[str, Manifold], closed: ClosedMold) -> None:
    """Genus counts through holes: no bore ends in a film, and what is blind in a leaning face is blind."""
    genus = {name: mesh.genus() for name, mesh in meshes.items() if not name.startswith(("shim", "pin"))}
    ends = {"end-a-comb": 4, "end-a-keeper": 3, "end-b-comb": 4, "end-b-keeper": 2}
    # all bores of the cavity are blind; vent and two rivets; cup and two bleeds
    assert genus == {"skin": 6, "cavity": 0, **ends, "carrier": 3, "cover": 7, "seal": 3}
    # gate and vent open on the skin
    gate = closed.part("end-a-keeper").cuts
    (bore,) = (cut for cut in gate if cut.role is CutRole.GATE)
    into = RotatedBody(replace(bore.body, length=bore.body.length + 1e-2), bore.centre, bore.angle, bore.base)
    plug = manifold(Part("plug", PartRole.COVER, into), 1e-3)
    assert (plug ^ meshes["skin"]).volume() == pytest.approx(math.pi * bore.body.radius**2 * 1e-2, rel=0.01)
    vent = closed.part("carrier").cuts[0]
    assert (manifold(Part("plug", PartRole.COVER, vent), 1e-3) ^ meshes["skin"]).volume() > 0.05
    # walls between bores, trough and seat are thick enough
    cavity = closed.part("cavity")
    cuts = [manifold(Part("cut", PartRole.COVER, cut), 1e-2) for cut in cavity.cuts]
    for (i, a), (j, b) in combinations(enumerate(cuts), 2):
        if {i, j} != {0, 1}:  # trough and seat are one opening
            assert a.min_gap(b, 2.0) > 0.75 - 2e-2, (cavity.cuts[i], cavity.cuts[j])  # chords
    # what reaches out of a part takes away what it counts
    cavity = closed.part("cavity")
    body = manifold(replace(cavity, cuts=()), 1e-3)
    for cut in cavity.cuts[2:]:
        built = manifold(Part("cut", PartRole.COVER, cut), 1e-3) ^ body
        assert built.volume() == pytest.approx(cut.volume, rel=3e-3)  # chords of a bore


def test_the_cover_lies_on_walls_and_a_seal(
    design: Design, meshes: dict[str, Manifold], closed: ClosedMold
) -> None:
    for end in ("a", "b"):
        gap = meshes["carrier"].min_gap(meshes[f"end-{end}-keeper"], 1.0)
        assert gap == pytest.approx(design.mold.clearance, abs=1e-6)  # its foot lies on a chord
    # Carrier and beveled end plates stand under the seal without a step; it is 0.7 of its sheet's 1 mm
    low = meshes["cover"].bounding_box()[2]
    assert meshes["cavity"].bounding_box()[5] == pytest.approx(low, abs=1e-12)  # rounding of a turn
    for name in ("carrier", "end-a-keeper", "end-b-keeper"):
        assert meshes[name].bounding_box()[5] == pytest.approx(low - 0.7, abs=1e-11)
    assert meshes["seal"].bounding_box()[2::3] == pytest.approx((low - 0.7, low), abs=1e-11)
    over = meshes["cover"].bounding_box()[4] - meshes["end-b-keeper"].bounding_box()[4]
    assert over > 0  # what it is lifted by, past the keeper; the comb below reaches further


def test_a_shim_has_its_clearance(design: Design, closed: ClosedMold, meshes: dict[str, Manifold]) -> None:
    """An arc touches a notch below at the plate's inner face and above at its outer one: its datum stays."""
    play = design.mold.slit_clearance
    shim, comb, keeper = (meshes[name] for name in ("shim-2-S1", "end-b-comb", "end-b-keeper"))
    body = closed.part("end-b-comb").body
    up = np.array([0.0, -math.sin(body.angle), math.cos(body.angle)])

    def shared(x: float, rise: float) -> float:
        moved = shim.translate(tuple(rise * up + [x, 0.0, 0.0]))
        return float((moved ^ comb).volume() + (moved ^ keeper).volume())

    rise = notch_rise(design, section(scaled_for_shrinkage(design)).slots)
    assert rise > 50 * play  # the notch is that much higher than the shim, and still
    for sign in (-1, 1):
        assert shared(0.9 * sign * play, 0.0) < 1e-9
        assert shared(1.1 * sign * play, 0.0) > 1e-9
        assert shared(0.0, 0.8 * sign * play) < 1e-9  # a tenth of the play is the arc's chords
    assert shared(0.0, -1.2 * play) > 1e-9
    assert shared(0.0, 4 * play) > 1e-9  # above, the split circle falls to the outer slots


def test_opening_takes_shims_first_and_a_gap_ends_on_the_molds_back(closed: ClosedMold) -> None:
    steps = [(s.axis, s.parts[0].split("-")[0]) for s in closed.opening]
    assert steps == [("turn", "shim"), ("z", "cover"), ("y", "end"), ("y", "end"), ("z", "skin")]
    carrier = closed.part("carrier").body
    arcs = [s for piece in gap_beside(carrier, 0.3) for s in piece.outline if s.bulge]
    assert len(arcs) == 4  # both sides' whole backs, and what is left beside each end
    for arc in arcs:
        assert arc.radius == pytest.approx(carrier.grid.centre, rel=1e-9)
        assert math.hypot(arc.point(0.5).x, arc.point(0.5).z - carrier.grid.centre) == pytest.approx(
            carrier.grid.centre, rel=1e-9
        )


@pytest.mark.parametrize(
    ("settings", "key"),
    [
        (["mold.cavities=2"], "mold.cavities"),
        (['mold.pour="open"'], "mold.pour"),
        (["skin.curvature_radius_y=20000"], "skin.curvature_radius_y"),
        (["skin.curvature_radius_y=9.9"], "mold.end_plate"),
        (["skin.curvature_radius_y=18", 'mold.process="sla"'], "skin.curvature_radius_y"),
        (["mold.end_plate=10", "skin.curvature_radius_y=25"], "mold.end_plate"),
    ],
)
def test_what_a_bent_mold_cannot_be_is_refused(settings: list[str], key: str) -> None:
    with pytest.raises(InputError) as refused:
        mold(bent("yamada-2002", 60.0, *settings))
    assert refused.value.key == key
    assert refused.value.remedy


def test_a_split_cavity_is_refused_where_ridges_need_it_only() -> None:
    with pytest.raises(InputError, match=r"mold.split: must be 'none'"):
        mold(bent("steep-fingertip", 25.0))
    assert mold(bent("plain-ridges", 60.0, 'mold.split="auto"')).part("cavity")


@pytest.mark.parametrize("radius", RADII)
def test_what_is_moved_off_a_bent_mold_comes_clear_of_all_that_stays(radius: float) -> None:
    closed = mold(bent("yamada-2002", radius, "ridge.count=3", "skin.length=20.0"))
    heights = {part.name: manifold(part, 0.05).bounding_box()[2::3] for part in closed.parts}
    left = set(heights)
    for move in closed.opening:
        left -= set(move.parts)
        if move.axis == "z" and move.travel > 0 and left:
            lowest = min(heights[name][0] for name in move.parts) + move.travel
            assert lowest > max(heights[name][1] for name in left)
    (turned,) = [move for move in closed.opening if move.axis == "turn"]  # shims, by their arcs at least
    arcs = [closed.part(name).body for name in turned.parts]
    assert max(arc.high - arc.low for arc in arcs) < abs(turned.travel) < 2 * math.pi
