"""Pads of very many features: ridges against the full models, pins against beams, Hertz and CalculiX."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy import interpolate, sparse

import skincad
from bench import calculix, pins
from skincad import InputError, check, load
from skincad.effects.pin_pad import pin_pad
from skincad.inputs import Design
from skincad.inputs.material import silicone
from skincad.mechanics import Drive, Request, advance, crown_radius, hertz, lone, pad_of, pressed
from skincad.mechanics import check as checking
from skincad.mechanics.contact import tips as tip_contact
from skincad.mechanics.models import corrected, linear, reduced
from skincad.mechanics.models import pin_cell as cells_of
from skincad.shape import skin_of
from tests.designs import dome, pillars


def pad(count: int, **ridge: float) -> Design:
    """Short and thin, so that the cell is short too: its crests lie as far apart as nine of plain-ridges."""
    skin = {
        "width": count + 2.0,
        "curvature_radius": 60.0 * (count / 9) ** 2,
        "length": 4.0,
        "thickness": 1.5,
    }
    contact = {"force": 0.25 * count, "friction": 0.0}
    return load("plain-ridges").with_(ridge={"count": count, **ridge}, skin=skin, contact=contact)


MORE = pytest.mark.evidence(subject="reduced: {count}")


@pytest.mark.slow
@pytest.mark.parametrize("count", [25, pytest.param(45, marks=MORE), pytest.param(101, marks=MORE)])
def test_many_features_are_those_of_the_full_model(count: int) -> None:
    design = pad(count)
    assert skin_of(reduced.cell_of(design)).count < 20
    request = Request(design.contact.force)
    quick, full = reduced.answer(design, request), corrected.answer(design, request)
    first, last = quick.all_touch_force.value, full.all_touch_force.value
    assert first == pytest.approx(last, rel=reduced.ERRORS.threshold)
    assert quick.approach.value == pytest.approx(full.approach.value, rel=reduced.ERRORS.approach)
    shares = [np.array([f.value for f in answer.ridge_force]) for answer in (quick, full)]
    assert np.abs(shares[0] - shares[1]).max() <= reduced.ERRORS.share * shares[1].mean()
    assert shares[0].sum() == pytest.approx(shares[1].sum(), rel=1e-8)  # the root's


def springs(count: int, reach: int = 3) -> reduced.FeatureModel:
    """Features that stiffen, each felt by its neighbours."""
    indentation = np.linspace(0.0, 1.0, 40)
    offsets = [*range(-reach, reach + 1)]
    coupling = sparse.diags([0.1 * 0.5 ** abs(k) for k in offsets], offsets, (count, count), format="csr")
    gap = 0.2 * np.linspace(-1.0, 1.0, count) ** 2
    return reduced.FeatureModel(gap, 2 * indentation**1.5, indentation, coupling)


def test_each_touching_feature_bears_what_its_indentation_asks_for() -> None:
    model = springs(31)
    forces, approach = pressed(model, 0.3)
    indentation = approach - model.gap - model.coupling @ forces
    touching = indentation > 0
    assert 0 < touching.sum() < 31
    assert forces.sum() == pytest.approx(0.3, rel=1e-8)
    asked = interpolate.PchipInterpolator(model.indentation, model.force)(indentation[touching])
    np.testing.assert_allclose(forces[touching], asked, rtol=1e-8)
    assert not forces[~touching].any()


def test_all_touch_where_the_last_gap_closes() -> None:
    model = springs(31)
    first = reduced.all_touch_force(model)
    fewer, all_of_them = (pressed(model, share * first)[0] for share in (0.999, 1.001))
    assert (fewer > 0).sum() == 29
    assert (all_of_them > 0).all()
    one = replace(model, gap=model.gap[:1], coupling=model.coupling[:1, :1])
    assert reduced.all_touch_force(one) == 0.0


def test_two_thousand_features_are_a_sparse_system() -> None:
    """What a pad of pins has: the time is not asserted, but a dense system would not end."""
    model = springs(2000)
    forces, indentation = reduced.at_approach(model, 0.25)
    assert (indentation > 0).any()
    assert (indentation < 0).any() == (forces == 0).any()
    assert pressed(model, float(forces.sum()))[1] == pytest.approx(0.25, rel=1e-7)


@pytest.mark.slow
def test_without_free_ends_it_is_plane_strain() -> None:
    """A pad no longer than its cell: what is reduced alone differs."""
    design = pad(15)
    model = reduced.feature_model(design, design.contact.force, {}, ends=False)
    full = linear.solve(pad_of(design), Request(design.contact.force))
    assert reduced.all_touch_force(model) == pytest.approx(full.all_touch_force.value, rel=0.02)
    assert pressed(model, design.contact.force)[1] == pytest.approx(full.approach.value, rel=0.01)


@pytest.mark.slow
def test_auto_takes_it_of_many_features_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first where there are more than 60, and where no time is left for a better one the last."""
    monkeypatch.setattr(checking, "DEFAULT_BUDGET", 0.0)
    monkeypatch.setattr(checking, "SHARP_SECONDS", 0.0)
    many = check(pad(61))
    assert (many.model, many.models_tried, many.manufacture) == ("reduced", (), None)
    assert many.next_model.model == "corrected"
    assert check(pad(5)).model == "linear"


def test_unlike_features_are_none_of_its() -> None:
    with pytest.raises(InputError, match="must be alike for the reduced model"):
        check(pad(9, levelling=0.5), model="reduced")


@pytest.mark.slow
def test_slim_pins_bend_as_beams() -> None:
    """What a pin of 8 mm turns and goes more than one of 6 mm: base and crown drop out."""
    slim = {"root_fillet": None, "tip_diameter": 2.0, "root_diameter": 2.0, "crown": 0.0}
    design = pillars().with_(pin={"heights": [8.0, 6.0], **slim})
    tall, low = (cells_of.pin_cell(lone(design, height, 4.0)) for height in (8.0, 6.0))
    bending = silicone(design).young_modulus.value * math.pi * 2.0**4 / 64
    area = math.pi * silicone(design).young_modulus.value
    # 1 %: the load on the tip is no beam's, which a diameter further down is forgotten
    assert (tall.across - low.across)[1, 1] == pytest.approx(2.0 / bending, rel=0.01)
    assert tall.axial - low.axial == pytest.approx(2.0 / area, rel=0.01)
    turns = [-cell.across[0, 1] for cell in (low, tall)]  # the base turns by the moment at the foot
    root = low.across[1, 1] - 6.0 / bending
    assert turns[1] - turns[0] == pytest.approx((64 - 36) / 2 / bending + 2.0 * root, rel=0.02)
    assert tall.across[0, 1] == pytest.approx(tall.across[1, 0], rel=1e-6)  # Betti's theorem


def test_light_pins_press_as_spheres() -> None:
    """Where hardly anything touches, Hertz's approach and the pin's own."""
    cell = cells_of.pin_cell(lone(pillars(), 6.0, 4.0))
    material = silicone(pillars())
    modulus = material.young_modulus.value / (1 - material.poisson_ratio**2)
    force, indentation = (column[1:6] for column in cells_of.pin_curve(cell.design))
    closed = hertz(force, crown_radius(pillars()), modulus) + cell.axial * force
    assert indentation == pytest.approx(closed, rel=0.02)  # a rim at finite distance


@pytest.mark.evidence(subject="pins: compliance")
def test_the_tips_compliance_is_that_of_pressing() -> None:
    design = dome()
    cells, model = reduced.pin_cells(design), reduced.pin_model(design)
    n = cells.axial.size
    whole = reduced.tip_compliance(design, cells)
    down = whole[2 * n :, 2 * n :] - cells.stiffest.axial * np.eye(n)
    # 3 % of the largest: a mean over points of the root, from two sides, against one by distance
    assert np.abs(down - model.coupling.toarray()).max() <= 0.03 * np.abs(down).max()
    assert whole == pytest.approx(whole.T)
    assert np.linalg.eigvalsh(whole)[0] > 0


@pytest.mark.slow
def test_a_row_of_pins_moves_the_base_as_a_ridge() -> None:
    """The sum of a row's pins along y, by their distance, is what a line of the same force does in plane
    strain. 6 % of the effect one thickness away: the cell ends six thicknesses away."""
    thick, width, step = 3.0, 1.0, 0.75
    ridge = {"count": 9, "pitch": thick, "height": 1.0, "root_width": width, "tip_width": 0.8, "crown": 0.05}
    rest = {"material": {"name": "dragon-skin-20"}, "mold": {"process": "sla"}, "contact": {"force": 1.0}}
    skin = {"curvature_radius": 1e8, "thickness": thick, "width": 40.0, "length": 60.0}
    ridges = skincad.Design(name="ridges", skin=skin, ridge=ridge, **rest)
    plane = reduced.feature_model(ridges, 1.0, {}, ends=False).coupling.toarray()[4, 5:8] * 60.0
    slim = {"root_diameter": width, "tip_diameter": 0.8, "crown": 0.05, "height": 1.0, "heights": None}
    cell = cells_of.pin_cell(lone(pillars().with_(pin={**slim, "root_fillet": None}), 1.0, thick))
    along = step * np.arange(-80, 81)
    row = [cell.sinking(np.hypot(thick * k, along), width / 2).sum() * step for k in (1, 2, 3)]
    assert row == pytest.approx(plane, abs=0.06 * abs(plane[0]))


@pytest.mark.slow
def test_friction_of_pins_lies_between_tips_that_slide_and_stick() -> None:
    """Upright pins feel none along y or x; on a dome slim pins that lean would slide."""
    flat = {part.effect: part for part in skincad.check(pillars(), force=0.3).left_out}
    assert set(flat) == {"finite strain", "friction"}
    assert flat["friction"].threshold <= 0.011
    bent = dome().with_(
        pin={"height": 1.4},
        skin={"width": 12.0, "length": 12.0, "curvature_radius": 15.0, "curvature_radius_y": 15.0},
    )
    force, tips = 0.05, pin_pad(bent).tips  # at 0.15 the middle pin is beyond its buckling force
    rough = advance(tips, tip_contact.unloaded(tips), Drive(force, travel=0.0), 100.0).approach
    free, stuck = (
        reduced.pressed(reduced.pin_model(bent, stuck=sticks), force)[1] for sticks in (False, True)
    )
    assert free - stuck > 0.005 * free
    assert stuck < rough < free
    bound = {part.effect: part for part in skincad.check(bent, force=force).left_out}["friction"].approach
    assert abs(rough / free - 1) <= bound


@pytest.mark.slow
def test_one_pin_on_a_round_skin_is_judged_as_one_body() -> None:
    skin = {"outline": "round", "curvature_radius": 1e8, "thickness": 2.0, "width": 12.0}
    pin = {"columns": 1, "rows": 1, "heights": None, "height": 1.8, "root_diameter": 2.2, "pitch": 6.0}
    pin |= {"tip_diameter": 1.8, "crown": 0.3, "root_fillet": None}
    design = pillars().with_(skin={**skin, "length": None}, pin=pin)
    result = skincad.check(design, force=0.05, model="auto")
    assert result.model in ("linear", "finite-strain")
    by_cell = skincad.check(design, force=0.05, model="reduced").approach
    # 1 %: the cell's rim is further away, held as a symmetric one
    assert skincad.check(design, force=0.05, model="linear").approach.value == pytest.approx(
        by_cell.value, rel=0.01
    )


def graded(count: int) -> Design:
    """Pins of heights that fall outwards, on a base of twice a root's margin."""
    pin = {"pattern": "square", "columns": count, "rows": count, "pitch": 4.0, "root_diameter": 2.2}
    pin |= {
        "tip_diameter": 1.8,
        "crown": 0.3,
        "heights": [2.5 - 0.1 * ring for ring in range(count // 2 + 1)],
    }
    width = 4.0 * count
    return skincad.Design(
        name=f"graded-{count}",
        skin={"curvature_radius": 1e8, "thickness": 2.0, "width": width, "length": width},
        pin=pin,
        material={"name": "dragon-skin-20", "poisson_ratio": 0.49},
        mold={"process": "sla"},
        contact={"force": 1.0, "friction": 0.0},
    )


@pytest.mark.evidence(subject="calculix: {count} by {count} pins")
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
@pytest.mark.parametrize("count", [3, 5])
def test_calculix_gives_graded_pins_the_same_forces(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Within both errors: the reduced model's, and 2 % of CalculiX's mesh, which one pin shows."""
    monkeypatch.setattr(pins, "FINENESS", 5)
    _, first, approach, share = pins.compared(graded(count))
    errors = reduced.PIN_ERRORS
    assert abs(first) <= errors.threshold + 0.02
    assert abs(approach) <= errors.approach + 0.02
    assert share <= errors.share + 0.02


@pytest.mark.evidence(subject="calculix: one pin")
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
def test_calculix_agrees_with_the_axisymmetric_pin() -> None:
    """3 %: at a sixth of the tip its mesh is 1.2 % stiff on a pin alone, and Poisson's ratio is 0.49."""
    design = graded(3).with_(
        skin={"outline": "round", "width": 12.0, "length": None},
        pin={"columns": 1, "rows": 1, "heights": None, "height": 1.8},
    )
    forces, _ = pins.press(design, 0.3, [0.12])
    force = float(forces[0, 0, 1])
    ours = skincad.check(design, force=force, model="linear").approach
    assert ours.value == pytest.approx(0.12, rel=0.03)


@pytest.mark.evidence(subject="pins: compliance")
def test_tips_feel_each_other_alike_along_x_and_y() -> None:
    """Nine pins turned by a right angle are the same nine."""
    design = pillars()
    whole = reduced.tip_compliance(design, reduced.pin_cells(design))
    n = len(whole) // 3
    turned = [3 * (i % 3) + 2 - i // 3 for i in range(n)]  # column and row of pin i, a quarter further
    by_x, by_y = whole[:n, :n], whole[n : 2 * n, n : 2 * n]
    # 10 % of the largest between two pins: the 24 points of a root don't turn with it
    largest = np.abs(by_x - np.diag(np.diag(by_x))).max()
    assert np.abs(by_y[np.ix_(turned, turned)] - by_x).max() <= 0.1 * largest


@pytest.mark.evidence(subject="pins: compliance")
def test_a_pressed_pin_tilts_its_neighbour_as_a_pulled_one_presses_it() -> None:
    """Betti's theorem: how a tip goes aside as its neighbour is pressed, from the harmonic of that alone,
    against the mean with how the neighbour rises as the tip is pulled, from the other harmonic."""
    design = pillars().with_(pin={"heights": None, "height": 3.0})
    whole, n = reduced.tip_compliance(design, reduced.pin_cells(design)), 9
    cell = cells_of.pin_cell(lone(design, 3.0, 4.0))
    out, up = (np.interp([4.9, 5.0, 5.1], cell.radius, row) for row in cell.by_push)
    aside = -out[1] + 3.0 * (up[2] - up[0]) / 0.2  # of the pin at -x, as the other is pulled up
    # 20 %: a root that does not bend takes the mean over it, and stiffens the base
    assert -whole[0, 2 * n + 1] == pytest.approx(aside, rel=0.2)
    assert -whole[2 * n + 1, 0] == pytest.approx(aside, rel=0.2)


def test_on_a_base_of_one_root_the_error_is_wider() -> None:
    """A pin on a base of 2.0 roots, and on one of 2.2."""
    pin = {"columns": 1, "rows": 1, "heights": None, "height": 4.0, "pocket": None}
    relative = []
    for roots in (2.0, 2.2):
        skin = {"width": 3.4 * roots, "length": 3.4 * roots}
        answer = skincad.check(skincad.load("pillars-9").with_(pin=pin, skin=skin), model="reduced").approach
        relative.append(answer.error / answer.value)
    wider = (reduced.NARROWER - 1) * reduced.PIN_ERRORS.approach
    assert relative[0] - relative[1] == pytest.approx(wider, rel=0.01)  # what is left out is the same
