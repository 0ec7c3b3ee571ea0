"""Shots, layers of other silicones behind the skin's own: against springs in series, and CalculiX."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench import calculix
from bench import pins as pin_bench
from bench.calculix import own
from skincad import InputError, check, load, load_scene, simulate
from skincad.inputs import Design
from skincad.inputs.material import silicone
from skincad.live import start_session
from skincad.mechanics import Request, pad_of, plane_piece
from skincad.mechanics.models import linear, reduced
from skincad.shape import skin_of
from tests.mechanics.designs import THREE, filleted, plane

FINGER = Path(__file__).parent.parent.parent / "examples" / "human-finger.toml"
SOFT_BACK = ({"thickness": 2.0, "young_modulus": 0.2},)
SANDWICH = (
    {"thickness": 1.0, "young_modulus": 3.0},
    {"depth": 1.0, "young_modulus": 0.2, "poisson_ratio": 0.45},
)
STIFF_BACK = ({"depth": 0.6, "young_modulus": 4.0},)


def flat(*shots: dict[str, Any]) -> Design:
    """A flat skin 3 mm thick that does not widen as it is pressed."""
    return Design(
        name="layers", flat={},
        skin={"curvature_radius": 1e6, "thickness": 3.0, "width": 10.0, "length": 8.0},
        material={"young_modulus": 0.5, "poisson_ratio": 0.0}, shot=shots or None, contact={"force": 2.0},
    )  # fmt: skip


@pytest.mark.parametrize(
    "model", ["linear", *(pytest.param(m, marks=pytest.mark.slow) for m in ("corrected", "finite-strain"))]
)
def test_layers_that_do_not_widen_are_springs_one_behind_the_other(model: str) -> None:
    """The approach is F / A times the sum of thickness over modulus; the base circle falls by 1e-5 mm."""
    shots = (
        {"thickness": 1.0, "young_modulus": 2.0, "poisson_ratio": 0.0},
        {"depth": 1.2, "young_modulus": 0.1, "poisson_ratio": 0.0},
    )
    pad, give = pad_of(flat(*shots)), 1.0 / 2.0 + 0.8 / 0.1 + 1.2 / 0.5
    assert [layer.young_modulus for layer in pad.layers] == [2.0, 0.1]
    force = 0.02  # N: 1e-3 of strain, where finite strain is small
    answer = check(flat(*shots), force=force, model=model).approach
    assert answer.value == pytest.approx(force / 80 * give, rel=2e-3)


@pytest.mark.slow
def test_layers_of_the_skins_own_silicone_change_nothing() -> None:
    """Another mesh of the same pad: 1e-3 of the approach, 1e-3 N of shares of 0.44."""
    same = {"young_modulus": 0.8, "poisson_ratio": filleted().material.poisson_ratio}
    plain, layered = (
        linear.level(plane_piece(pad_of(filleted().with_(shot=shot)), 0.5), 3, 4.0, ())
        for shot in (None, ({"thickness": 1.5, **same}, {"depth": 0.7, **same}))
    )
    assert layered.approach == pytest.approx(plain.approach, rel=1e-3)
    assert np.abs(layered.ridge_force - plain.ridge_force).max() < 1e-3


@pytest.mark.evidence(subject="calculix: layers")
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
@pytest.mark.parametrize(("shots", "force"), [(SOFT_BACK, 1.0), (SANDWICH, 4.0), (STIFF_BACK, 4.0)])
def test_calculix_presses_layers_alike(
    shots: tuple[dict[str, Any], ...], force: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """0.3 % of the approach and 1 % of a mean share; without layers 0.1 and 0.2 % are seen."""
    monkeypatch.setattr("bench.calculix.FORCE", force)
    monkeypatch.setattr("bench.calculix.REPEATS", 1)
    pad = pad_of(filleted().with_(shot=shots))
    theirs, ours = calculix.press(pad, 0.5, force), own(pad, "linear", 0.5, 3)
    assert theirs.approach == pytest.approx(ours.approach, rel=3e-3)
    assert np.abs(theirs.shares - ours.shares).max() < 0.01 * force / len(pad.ridges)
    plain = own(pad_of(filleted()), "linear", 0.5, 3)
    assert abs(plain.approach / ours.approach - 1) > 0.2  # the layers count


@pytest.mark.parametrize("shots", [SOFT_BACK, SANDWICH, STIFF_BACK])
def test_the_closed_form_holds_within_its_error(shots: tuple[dict[str, Any], ...]) -> None:
    plain = load("plain-ridges").with_(**THREE)
    design = plain.with_(shot=shots)
    springs, pad = check(design, model="winkler").all_touch_force, plane(design, tol=0.05).all_touch_force
    assert springs.lower < (pad.value or 0.0) < springs.upper
    assert springs.value != check(plain, model="winkler").all_touch_force.value


@pytest.mark.parametrize(
    ("shots", "words"),
    [
        ([{"young_modulus": 1.0}], "needs either a thickness or a depth"),
        ([{"young_modulus": 1.0, "depth": 1.0, "thickness": 1.0}], "needs either a thickness or a depth"),
        ([{"thickness": 1.0}], "needs a name, a young_modulus or a law"),
        ([{"name": "nobody", "thickness": 1.0}], "shot.name: unknown silicone"),
        ([{"young_modulus": 1.0, "thickness": 3.98}], "shot 1's face must be from 0.05 to 3.95 mm"),
        ([{"young_modulus": 1.0, "thickness": 2.0}, {"young_modulus": 1.0, "depth": 3.0}], "shot 2's face"),
        ([{"young_modulus": 2000.0, "thickness": 2.0}], "must be from 0.001 to 100 MPa"),
        ([], "must have at least 1 item"),
    ],
)
def test_shots_that_cannot_be_are_refused(shots: list[dict[str, Any]], words: str) -> None:
    with pytest.raises(InputError, match=words):
        load("plain-ridges").with_(shot=shots)


def test_what_takes_no_layers_says_so() -> None:
    design = load("yamada-2002")
    assert design.slot
    deep = design.with_(slot={"elevation": -0.3}, shot=[{"young_modulus": 1.0, "depth": 0.3}])
    with pytest.raises(InputError, match=r"shot\.depth: shot 1's face must keep 0\.05 mm from the slots"):
        check(deep, model="linear")
    # on a back an eighth as stiff the outermost share is off by a quarter of the mean
    with pytest.raises(InputError, match=r"shot: must not be given with \[ridge\] for the reduced model"):
        check(load(FINGER), model="reduced")
    with pytest.raises(InputError, match="takes a skin of one silicone"):
        start_session(load(FINGER))


def pins(*shots: dict[str, Any], **tables: Any) -> Design:
    """Nine pins, the outer ones lower, on 2 mm of a silicone that gives a little in volume."""
    skin = {"curvature_radius": 1e8, "thickness": 2.0, "width": 12.0, "length": 12.0, **tables}
    pin = {"columns": 3, "rows": 3, "pitch": 4.0, "root_diameter": 2.2, "tip_diameter": 1.8, "crown": 0.3}
    return Design(
        name="pins", skin=skin, pin={**pin, "heights": [2.5, 2.4]}, mold={"process": "sla"},
        material={"young_modulus": 0.5, "poisson_ratio": 0.49}, shot=shots or None, contact={"force": 0.3},
    )  # fmt: skip


@pytest.mark.slow
def test_pins_on_layers_of_their_own_silicone_are_pins_without() -> None:
    """Another mesh of each cell: 1e-3."""
    same = {"young_modulus": 0.5, "poisson_ratio": 0.49}
    one, other = check(pins()), check(pins({**same, "thickness": 0.7}, {**same, "depth": 0.6}))
    assert one.model == other.model == "reduced"
    for a, b in ((one.all_touch_force, other.all_touch_force), (one.approach, other.approach)):
        assert b.value == pytest.approx(a.value, rel=1e-3)
        assert b.error == pytest.approx(a.error, rel=0.05)


@pytest.mark.slow
def test_pins_sink_deeper_into_a_softer_back_and_their_errors_grow() -> None:
    """By the fourth root of 10; on a stiffer back they are those without layers."""
    plain, soft, stiff = (
        reduced.answer(pins(*shots), Request(0.3)).approach
        for shots in (
            (),
            ({"thickness": 1.0, "young_modulus": 0.05},),
            ({"depth": 1.0, "young_modulus": 5.0},),
        )
    )
    assert stiff.value < plain.value < soft.value  # type: ignore[operator]
    relative = [(of.error or 0.0) / (of.value or 1.0) for of in (plain, soft, stiff)]
    assert relative[1] / relative[0] == pytest.approx(10**0.25, rel=1e-9)
    assert relative[2] == pytest.approx(relative[0], rel=1e-9)


@pytest.mark.evidence(subject="calculix: pins on layers")
@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
@pytest.mark.parametrize(
    ("shot", "bent"),
    [
        ({"thickness": 1.0, "young_modulus": 0.05, "poisson_ratio": 0.49}, {}),
        ({"depth": 1.0, "young_modulus": 4.0, "poisson_ratio": 0.49}, {}),
        (
            {"depth": 0.8, "young_modulus": 0.1, "poisson_ratio": 0.49},
            {"curvature_radius": 60.0, "curvature_radius_y": 60.0, "thickness": 2.6},
        ),
    ],
)
def test_calculix_presses_pins_on_layers_alike(
    shot: dict[str, Any], bent: dict[str, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Within both errors: the reduced model's, and 2 % of CalculiX's mesh, which one pin shows."""
    monkeypatch.setattr(pin_bench, "FINENESS", 5)
    design = pins(shot, **bent)
    _, first, approach, share = pin_bench.compared(design)
    errors, further = reduced.PIN_ERRORS, reduced.further(design)
    assert abs(first) <= further * errors.threshold + 0.02
    assert abs(approach) <= further * errors.approach + 0.02
    assert share <= further * errors.share + 0.02
    plain, layered = (reduced.pressed(reduced.pin_model(of), 0.3)[1] for of in (pins(**bent), design))
    assert abs(layered / plain - 1) > 0.01  # the layer counts


def test_a_file_with_shots_is_read_as_it_was_written(tmp_path: Path) -> None:
    design = load(FINGER)
    path = tmp_path / "finger.toml"
    path.write_text(design.to_toml())
    assert load(path) == design
    assert json.loads(json.dumps(design.model_dump()))["shot"][1]["depth"] == 0.6


@pytest.mark.evidence(subject="examples/human-finger-pull.toml")
def test_a_fingers_ridges_slip_from_the_edges_to_the_middle() -> None:
    """As Delhaye, Lefevre and Thonnard (2014) and Barrea et al. (2018) saw on glass: an annulus of slip that
    closes about a middle that sticks. The ridges of either side slip in order, the middle one last."""
    answer = simulate(load_scene(FINGER.with_name("human-finger-pull.toml")), model="small_strain")
    ridge, pressed = answer.march.ridge, answer.march.readings[150].touches
    touching = sorted({int(number) for number in ridge[pressed]})
    first = {r: int(np.argmax(answer.slipping[150:, r - 1])) for r in touching}
    assert len(touching) >= 9
    middle = (skin_of(answer.scene.design).count + 1) / 2
    last = max(first, key=lambda r: first[r])
    assert abs(last - middle) <= 2
    for side in (range(touching[0], last + 1), range(touching[-1], last - 1, -1)):
        steps = [first[r] for r in side]
        assert steps == sorted(steps), first
    assert answer.gross_slip_step is not None


def bowl(radius: float | None, *shots: dict[str, Any]) -> Design:
    """One ridge without slots on a skin in layers, curved along y by `radius`."""
    lone = load("plain-ridges", ["ridge.count=1"])
    skin = {"curvature_radius_y": radius, "width": 3.0, "thickness": 2.0, "length": 6.0}
    return lone.with_(skin=skin, shot=shots or None, contact={"force": 0.05})


@pytest.mark.parametrize("model", ["winkler", pytest.param("solid", marks=pytest.mark.slow)])
def test_layers_count_in_a_doubly_curved_skin_as_in_a_straight_one(model: str) -> None:
    """Layers of its own silicone are another mesh of the same pad, 2e-3; at a radius of 1e5 mm the ends are
    4e-5 mm low, and of an approach of 0.1 mm that is 1e-3."""
    own = silicone(bowl(None))
    same = {"young_modulus": own.young_modulus.value, "poisson_ratio": own.poisson_ratio, "thickness": 1.0}
    soft = {**same, "young_modulus": own.young_modulus.value / 5}
    plain, alike, bent, far, straight = (
        check(design, model=model).approach
        for design in (bowl(40.0), bowl(40.0, same), bowl(40.0, soft), bowl(1e5, soft), bowl(None, soft))
    )
    assert alike.value == pytest.approx(plain.value, rel=2e-3)
    assert bent.value > 1.2 * plain.value
    assert far.value == pytest.approx(straight.value, rel=1e-3)
