"""Pins, rings and flat skins: where features stand, what their outlines are, and what is refused."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.inputs import places
from skincad.shape import FAMILIES, Segment, Skin, area, drawn_section, section, skin_of
from tests.designs import OF_FAMILIES, dome, flat, pillars, rings, round_nibs
from tests.refusals import refused_by


def test_each_family_has_a_design_here_and_heights_by_ring() -> None:
    assert set(FAMILIES) == {"ridge", *(one().features.family for one in OF_FAMILIES.values())}
    assert skin_of(pillars()).heights == (*[5.5] * 4, 6.0, *[5.5] * 4)
    graded = dome().with_(pin={"heights": [1.0, 0.9, 0.8, 0.7]})
    assert skin_of(graded).heights == (1.0, *[0.9] * 6, *[0.8] * 12, *[0.7] * 18)


@pytest.mark.parametrize("name", OF_FAMILIES)
def test_a_design_comes_back_from_its_toml(name: str, tmp_path: Path) -> None:
    design = OF_FAMILIES[name]()
    path = tmp_path / "again.toml"
    path.write_text(design.to_toml())
    assert skincad.load(path) == design
    assert hash(skincad.load(path)) == hash(design)


def axes_and_tips(skin: Skin) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    feet, axes, tips = (np.array([getattr(p, of) for p in skin.placed]) for of in ("foot", "axis", "tip"))
    return feet, axes, tips


def test_pins_stand_on_the_torus_or_sphere_and_along_its_normals() -> None:
    """The base is a circle of 30 mm turned about an axis along x, 40 mm below its summit: a torus."""
    design = dome()
    skin, table = skin_of(design), design.skin
    feet, axes, tips = axes_and_tips(skin)
    top, across, along = table.thickness, table.curvature_radius, table.curvature_radius_y or 0.0
    tube = np.hypot(feet[:, 1], feet[:, 2] - (top - along)) - (along - across)  # from the tube's middle line
    assert np.hypot(tube, feet[:, 0]) == pytest.approx(across, rel=1e-12)
    assert np.linalg.norm(axes, axis=1) == pytest.approx(1.0, rel=1e-12)
    assert tips - feet == pytest.approx(axes * np.array(skin.heights)[:, None], abs=1e-12)
    out = np.hypot(tips[:, 1], tips[:, 2] - (top - along)) - (along - across)
    assert np.hypot(out, tips[:, 0]) == pytest.approx(across + 0.7, rel=1e-12)
    # those of a disc on a sphere
    skin = skin_of(round_nibs())
    _, _, tips = axes_and_tips(skin)
    centre = np.array([0.0, 0.0, 4.0 - 60.0])
    assert np.linalg.norm(tips - centre, axis=1) == pytest.approx(60.4, rel=1e-12)


@pytest.mark.parametrize("name", ["dome", "rings", "round-nibs"])
def test_levelled_features_have_level_crests(name: str) -> None:
    design = OF_FAMILIES[name]()
    level = skin_of(design.with_(**{design.features.family: {"levelling": 1.0}}))
    assert np.ptp(level.crests) < 1e-12
    assert max(level.crests) == pytest.approx(max(skin_of(design).crests), rel=1e-14)
    half = skin_of(design.with_(**{design.features.family: {"levelling": 0.5}}))
    assert np.ptp(half.crests) == pytest.approx(np.ptp(skin_of(design).crests) / 2, rel=1e-9)


@pytest.mark.parametrize(
    ("pattern", "inside", "counts"), [("square", 4, 25), ("hex", 6, 23), ("polar", 6, 19)], ids=str
)
def test_patterns_have_their_neighbours(pattern: str, inside: int, counts: int) -> None:
    size = {"rings": 2, "columns": None, "rows": None} if pattern == "polar" else {"columns": 5, "rows": 5}
    pin = {"pattern": pattern, "pitch": 3.9, "height": 5.0, "heights": None, **size}
    skin = skin_of(pillars().with_(pin=pin, skin={"width": 30.0, "length": 30.0}))
    middle = min(skin.placed, key=lambda p: math.hypot(p.foot[0], p.foot[1]))
    assert (skin.count, len(middle.neighbours)) == (counts, inside)
    feet = np.array([p.foot[:2] for p in skin.placed])
    apart = np.linalg.norm(feet[:, None] - feet[None], axis=2) + 1e9 * np.eye(len(feet))
    assert apart.min() == pytest.approx(3.9, rel=1e-6)  # chords are shorter than arcs
    assert np.abs(feet.mean(axis=0)).max() < 1e-9


@pytest.mark.parametrize("pattern", ["square", "hex"])
def test_a_margin_fills_the_skin(pattern: str) -> None:
    """No pin stands over the margin, and there is no room for one more."""
    pin = {"pattern": pattern, "pitch": 3.9, "height": 5.0, "heights": None, "margin": 1.0}
    design = pillars().with_(pin=pin, skin={"width": 31.0, "length": 27.0})
    at = np.array([(p.u, p.v) for p in places(design.skin, design.features)])
    room = np.array([31.0, 27.0]) / 2 - 1.0 - 1.8
    assert (np.abs(at).max(axis=0) <= room + 1e-9).all()
    assert (np.abs(at).max(axis=0) > room - 3.9).all()
    assert len(np.unique(at.round(9), axis=0)) == len(at)


def test_a_hemispherical_pin_has_the_volume_of_its_parts() -> None:
    """By the outline's area: a cylinder and a hemisphere, and beside the foot a fillet's corners."""
    radius, fillet, high = 1.5, 0.3, 5.5
    profile = skin_of(pillars()).profile
    outline = profile.outline
    crown = next(s for s in outline if s.kind == "crown")
    assert crown.radius == pytest.approx(radius, rel=1e-12)
    assert crown.sweep == pytest.approx(math.pi, rel=1e-12)
    corner = fillet**2 * (1 - math.pi / 4)
    assert (profile.feet[0][0], profile.height) == (pytest.approx(radius + fillet), high)
    closed = (*outline, Segment(outline[-1].end, outline[0].start))
    flat_area = 2 * radius * (high - radius) + math.pi * radius**2 / 2 + 2 * corner
    assert area(closed) == pytest.approx(flat_area, rel=1e-12)


def test_rings_cross_the_section_on_either_side() -> None:
    design = rings()
    outline, skin = section(design).outline, skin_of(design)
    crowns = [s for s in outline if s.kind == "crown"]
    crossings = sorted((s.point(0.5).x, s.feature or 0) for s in crowns)
    assert [number for _, number in crossings] == [3, 2, 1, 1, 2, 3]
    at = sorted(s.point(0.5).x for s in crowns)
    assert at == pytest.approx([-x for x in reversed(at)], abs=1e-12)
    radii = [80.0 * math.asin(p.summit.x / 81.0) for p in skin.placed]
    assert radii == pytest.approx([1.0, 3.0, 5.0], rel=1e-12)  # half a pitch, and a pitch each
    assert section(design).centroid.x == pytest.approx(0.0, abs=1e-9)


def test_a_flat_skin_touches_with_its_face_a_drawn_section_shows_pins() -> None:
    skin = skin_of(flat())
    touching = [s for s in section(flat()).outline if s.touches]
    assert (skin.count, skin.heights, skin.height) == (1, (0.0,), 4.0)
    assert [(s.kind, s.feature) for s in touching] == [("base", 1)]
    assert touching[0].radius == pytest.approx(60.0)
    design = pillars()
    drawn, plane = drawn_section(design), section(design)
    assert drawn.top == pytest.approx(design.skin.thickness + 6.0, abs=1e-4)  # chords' error
    assert drawn.area - plane.area > 2 * 3.0 * 4.0  # of three pins 3 mm wide and 5.5 to 6 mm high
    ridges = skincad.load("plain-ridges")
    assert drawn_section(ridges) == section(ridges)


REFUSED = {
    "two families": (pillars, {"ring": {"count": 1, "height": 1.0, "root_width": 1.0, "tip_width": 0.5,
                                        "crown": 0.1}}, "ring: are two families of features"),
    "no family": (pillars, {"pin": None}, "ridge: is missing"),
    "feet that overlap": (pillars, {"pin": {"pitch": 3.2}}, "pin.pitch: must be at least 3.6 mm"),
    "over the edge": (pillars, {"pin": {"pitch": 9.0}}, "pin.pitch: puts pins 0.8 mm over the skin's edge"),
    "rings of a square": (pillars, {"pin": {"rings": 2}}, "pin.rings: must not be given for a square"),
    "no count": (pillars, {"pin": {"rows": None}}, "pin.rows: is missing; give pin.rows, or pin.margin"),
    "too many": (pillars, {"pin": {"pitch": 0.05, "margin": 0.1, "root_diameter": 0.04, "tip_diameter": 0.04,
                                   "crown": 0.01, "root_fillet": 0.0}}, "pin.margin: must give from 1 to"),
    "none": (pillars, {"pin": {"margin": 9.0}}, "pin.margin: must give from 1 to 2000 pins, and gives 0"),
    "a list of another length": (pillars, {"pin": {"heights": [1.0, 2.0, 3.0]}}, "pin.heights: must be 9"),
    "a height of nothing": (pillars, {"pin": {"heights": [5.0, 0.0]}}, "pin.heights: pin 2 must be above 0"),
    "height beside heights": (pillars, {"pin": {"height": 5.0, "heights": [5.0, 5.0]}},
                              "pin.height: must not be given beside pin.heights"),
    "a tip over its root": (pillars, {"pin": {"tip_diameter": 3.4}}, "pin.tip_diameter: must be at most 3"),
    "a pocket through the tip": (pillars, {"pin": {"pocket": {"diameter": 1.0, "depth": 9.5}}},
                                 "pin.pocket.depth: must be at most 9.2 mm"),
    "a wide pocket in the base": (pillars, {"pin": {"pocket": {"diameter": 4.0, "depth": 3.9}}},
                                  "pin.pocket.depth: must be at most 3.7 mm"),
    "pockets that meet": (flat, {"flat": {"pitch": 2.2}}, "flat.pocket.diameter: must be at most 1.9 mm"),
    "a pocket over the edge": (flat, {"flat": {"pitch": 18.0}}, "flat.pocket.diameter: must leave 0.3 mm"),
    "pockets without a pitch": (flat, {"flat": {"pitch": None}}, "flat.pitch: is missing"),
    "rings on a rectangle": (rings, {"skin": {"outline": "rectangle"}}, "skin.outline: must be 'round' for"),
    "rings over the edge": (rings, {"ring": {"count": 5}}, "ring.count: at most 4 rings"),
    "a ring without a middle": (rings, {"ring": {"radius": 0.5}}, "ring.radius: must be at least 0.9 mm"),
    "a long disc": (rings, {"skin": {"length": 20.0}}, "skin.length: must be skin.width, 16 mm"),
    "a disc that is curved twice": (rings, {"skin": {"curvature_radius_y": 90.0}},
                                    "skin.curvature_radius_y: must not be given for a round skin"),
    "slots without ridges": (pillars, {"slot": {"thickness": 0.05, "depth": 0.2, "offset": 0.2,
                                                "elevation": 0.1, "tilt": 0.0}}, "slot: needs ridges"),
    "round ridges": (partial(skincad.load, "plain-ridges"), {"skin": {"outline": "round", "length": 11.0}},
                     "skin.outline: must be 'rectangle' for ridges"),
    "a key of ridges": (pillars, {"pin": {"root_width": 1.0}}, "pin.root_width: unknown key"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_is_refused(name: str) -> None:
    design, change, words = REFUSED[name]
    with refused_by(words):
        skin_of(design().with_(**change))


def test_a_setting_replaces_what_cannot_stand_beside_it(tmp_path: Path) -> None:
    path = tmp_path / "pad.toml"
    path.write_text(pillars().to_toml())
    filled = skincad.load(path, ["pin.margin=0.5", "pin.height=4.0"])
    assert (filled.features.margin, filled.features.columns, filled.features.heights) == (0.5, None, None)
    assert filled.with_(pin={"columns": 3, "rows": 3}).count == 9
