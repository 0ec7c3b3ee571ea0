"""The pours of a skin in layers: masses, clocks, the sheet, and what it weighs."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.fabrication import DEAD_VOLUME, Job, casting_sheet, extent, poured_volume, pours, sheet_steps
from skincad.fabrication.day_plan import day_plan, tasks
from skincad.fabrication.inspection import inspection
from skincad.fabrication.orders import orders
from skincad.fabrication.part_drawing import notes
from skincad.fabrication.parts_list import parts_list
from skincad.fabrication.pouring import (
    clock,
    filling,
    minutes_left,
    pouring_findings,
    timeline,
)
from skincad.fabrication.strips import strip_count
from skincad.inputs import Design, silicones
from skincad.solids import CutRole, bores, skin_part
from tests.solids.kinds import bowl_of_layers

QUICK = {"name": "dragon-skin-10", "young_modulus": None}
CORE = {"name": "dragon-skin-30", "thickness": 1.0}


def layered(*shots: dict[str, Any], **tables: Any) -> Design:
    return skincad.load("yamada-2002").with_(shot=shots or (CORE,), **tables)


def test_pours_fill_the_mold_once() -> None:
    job = Job(layered(CORE, {"name": "dragon-skin-20", "thickness": 1.6, "bond": "wet"}))
    made = pours(job)
    assert [(pour.number, pour.bond, pour.plug) for pour in made] == [
        (0, "", ""), (2, "wet", "plug-1"), (1, "primer", ""),
    ]  # fmt: skip
    assert made[0].level == pytest.approx(1.6 / (1 - job.shrinkage), rel=1e-9)
    skin = job.closed.parts[0].volume
    assert math.fsum(pour.volume for pour in made) == pytest.approx(skin, rel=1e-12)
    rising = made[1].filled - made[1].volume  # in the plug's vent and the cup, of the pour before the last
    assert math.fsum(pour.filled for pour in made) - rising == pytest.approx(poured_volume(job), rel=1e-12)
    for pour in made:
        assert pour.mass == pytest.approx(pour.filled * pour.silicone.density * 1e-6)
        assert pour.batch == pour.mass + DEAD_VOLUME


def test_each_layer_of_a_bowl_is_pressed_in_through_its_gate() -> None:
    """What each pour fills besides its layer: the first a plug's vent, the cup and a gate. End plates are
    screwed on each time, over a plug that they lean over."""
    job = Job(bowl_of_layers({**CORE, "thickness": 1.5}))
    made = pours(job)
    skin, plate = job.closed.parts[0].volume, job.cast.mold.end_plate
    assert math.fsum(pour.volume for pour in made) == pytest.approx(skin, rel=1e-12)
    assert made[1].volume == pytest.approx(_turned_box(job, 1.5 / (1 - job.shrinkage)), rel=1e-12)
    (vent,) = bores(job.closed.part("plug-1"), CutRole.VENT)
    (cup,) = bores(job.closed.part("cover"), CutRole.RESERVOIR)
    gate = math.pi * job.gate**2 / 4 * plate
    assert made[0].filled - made[0].volume == pytest.approx(vent.volume + cup.volume + gate, rel=1e-12)
    assert made[1].filled == pytest.approx(made[1].volume + poured_volume(job) - skin, rel=1e-12)
    for pour in made:
        assert [task.step for task in timeline(job, pour)].count("ends") == 1
    steps = sheet_steps(job)
    assert "through gate 1 of 2 from below at end a" in steps["fill the layer in front"]
    assert "through gate 2 of 2 from below" in steps["fill shot 1"]
    assert "push them up off the combs" in steps["cure the layer in front"]
    order = ["combs", "brush", "ends the layer in front", "cure the layer in front", "ends shot 1", "cure"]
    assert [name for name in steps if name in order] == order
    assert filling(job).force <= 30.0


def _turned_box(job: Job, high: float) -> float:
    """What is `high` mm thick behind a level face: width times the sector between two arcs, mm3."""
    skin = job.cast.skin
    arm = skin.curvature_radius_y - skin.thickness
    return skin.width * skin.length / skin.curvature_radius_y * high * (arm + high / 2)


def test_one_silicone_is_one_pour() -> None:
    job = Job(skincad.load("yamada-2002"))
    (pour,) = pours(job)
    assert pour.filled == pytest.approx(poured_volume(job), rel=1e-12)
    assert not pour.plug
    assert pour.level is None


def test_each_pour_has_its_mass_and_clock_on_the_sheet() -> None:
    """Two silicones, held by rivets; tests/golden has another bond, the day's plan and the parts list."""
    job = Job(layered({**CORE, "bond": "rivets", "thickness": 0.9}, material=QUICK))
    steps = sheet_steps(job)
    front, core = pours(job)
    assert front.weights in steps["mix the layer in front"]
    assert core.weights in steps["mix shot 1"]
    assert f"{core.silicone.pot_life_min:g} min" in steps["mix shot 1"]
    assert "rivets' holes" in steps["bond the layer in front"]
    assert core.cure in steps["cure"]


def test_core_pins_stay_in_the_layer_from_which_a_plug_is_pulled() -> None:
    """pillars-9's pockets go through the shot's face; in the layer at the back alone they need no plug. Pins
    that are drawn and pushed in again would be pistons in blind pockets full of silicone."""
    job = Job(skincad.load("pillars-9").with_(shot=({**CORE, "thickness": 1.0}, {**CORE, "thickness": 2.0})))
    steps = sheet_steps(job)
    assert "Push them into plug-2 from above, until they stand 8.00 mm out above it" in steps["core pins"]
    assert "its holes slide over the core pins" in steps["pour shot 2"]
    assert "square over the core pins" in steps["carrier"]
    for cured in ("cure the layer in front", "cure shot 2"):
        assert "The core pins stay in the layer" in steps[cured]
    inside = Job(
        job.design.with_(shot=({**CORE, "thickness": 2.0},), pin={"pocket": {"diameter": 1.6, "depth": 1.0}})
    )
    assert "Push them into the carrier from above" in sheet_steps(inside)["core pins"]


def brushing(job: Job) -> float:
    skin = job.design.skin
    return 1 + skin.width * skin.length / 2 / 60 if filling(job).brushed else 0.0


def test_wet_on_wet_has_to_be_on_within_the_pot_life() -> None:
    """The front mix is good for 45 min. The next is mixed before it and waits, so on the clock in front are
    its own mix, brushing, a vacuum and two pours; on that of the next all of these, and closing the mold."""
    calm = Job(layered({**CORE, "bond": "wet"}))
    front, back = pours(calm)
    assert [task.number for task in timeline(calm, front) if task.step == "mix"] == [1, 0]
    assert clock(calm, front) == pytest.approx(8 + brushing(calm) + 5 + 2 * 1.0)
    assert clock(calm, back) == pytest.approx(8 + clock(calm, front) + 1 + 1.2)
    steps = [*sheet_steps(calm)]
    assert steps.index("mix shot 1") < steps.index("mix the layer in front") < steps.index("pour shot 1")
    assert not [f for f in pouring_findings(calm) if f.rule == "pot life"]
    quick = silicones()["dragon-skin-10"]
    assert quick.pot_life_min == 20
    slow = Job(layered({**CORE, "bond": "wet"}, material=QUICK, mold={"fill_time": 900.0}))
    (finding,) = [f for f in pouring_findings(slow) if f.where.startswith("the layer in front, on which")]
    assert finding.severity == "error"
    assert finding.measured == pytest.approx(8 + brushing(slow) + 5 + 30, rel=1e-6)


def test_platinum_silicone_does_not_cure_on_a_tin_cure() -> None:
    own = {"tin": {"young_modulus": 0.5, "platinum_cure": False}}
    design = layered(CORE, silicones=own, material={"name": "tin", "young_modulus": None})
    assert [f.severity for f in pouring_findings(Job(design)) if f.rule == "cure inhibition"] == ["error"]
    assert not [f for f in pouring_findings(Job(layered())) if f.rule == "cure inhibition"]


def test_a_layered_skin_weighs_what_its_layers_do() -> None:
    """The package's mass, from the kernel's moments, and the inspection's, less rivets and films."""
    heavy = {"young_modulus": 1.0, "density": 2000.0, "thickness": 1.0}
    bare = {"film": None, "slot": None, "contact": {"film": None}, "mold": {"carrier": "plain"}}
    plain, layered_skin = skincad.load("yamada-2002").with_(**bare), layered(heavy, **bare)
    (one,), (two,) = (
        [row for row in inspection(Job(design)).measures if row.what.startswith("mass of the skin")]
        for design in (plain, layered_skin)
    )
    skin = plain.skin
    extra = (2000.0 - Job(plain).silicone.density) * 1e-6 * skin.width * skin.length * 1.0
    assert two.nominal - one.nominal == pytest.approx(extra, rel=0.1)  # the vent's plug is of the core too
    masses = [skincad.package(design, "urdf").weighs for design in (plain, layered_skin)]
    assert masses[1].skin.mass - masses[0].skin.mass == pytest.approx(extra, rel=1e-9)
    assert masses[1].skin.centre[2] < masses[0].skin.centre[2]


@pytest.mark.slow
@pytest.mark.parametrize("depth", [1.0, 3.0])
def test_layers_weigh_what_is_left_beside_pockets(depth: float) -> None:
    """Pockets that end in the shot, and pockets that go through its face: pillars-9's layers weigh the sum of
    their volumes times their densities."""
    heavy = {"young_modulus": 1.0, "density": 2000.0, "thickness": 1.0 if depth > 2.0 else 2.0}
    design = skincad.load("pillars-9").with_(shot=(heavy,), pin={"pocket": {"diameter": 1.6, "depth": depth}})
    weighs = skincad.package(design, "urdf").weighs
    own = Job(design).silicone.density
    skin = design.skin
    behind = (skin.width * skin.length - 9 * math.pi * 0.8**2) * heavy["thickness"]
    behind += 9 * math.pi * 0.8**2 * max(0.0, heavy["thickness"] - depth)
    whole = skin_part(design).volume
    assert weighs.skin.mass == pytest.approx(1e-6 * (own * (whole - behind) + 2000.0 * behind), rel=1e-9)


@pytest.mark.parametrize(
    ("name", "few"),
    [
        pytest.param("yamada-2002", ["ridge.count=3"], marks=pytest.mark.slow),
        *(
            pytest.param(name, few, marks=pytest.mark.evidence(subject=name))
            for name, few in (
                ("rings-5", ["ring.count=2", "skin.width=16"]),
                ("pillars-9", ["pin.columns=2", "pin.rows=1"]),
            )
        ),
    ],
)
def test_a_layered_skin_is_made_whole(name: str, few: list[str], tmp_path: Path) -> None:
    design = skincad.load(name, few).with_(shot=({**CORE, "bond": "primer"},))
    made = skincad.make(design, checked=False)
    assert not [finding for finding in made.findings if finding.severity == "error"]
    skincad.write(made, tmp_path / "out")
    names = {path.name for path in (tmp_path / "out").rglob("*")}
    assert {"plug-1.step", "plug-1.stl"} <= names


OWN = {
    "slow": {"young_modulus": 0.5, "cure_h": 16.0, "pot_life_min": 60.0, "density": 1070.0},
    "light": {"young_modulus": 0.5, "cure_h": 5.0, "pot_life_min": 60.0, "density": 1040.0},
    "warm": {"young_modulus": 0.5, "cure_h": 2.0, "cure_c": 60.0, "pot_life_min": 60.0, "density": 1070.0},
}


def wet_on(front: str, back: str) -> Job:
    shot = {"name": back, "thickness": 1.5, "bond": "wet"}
    return Job(layered(shot, silicones=OWN, material={"name": front, "young_modulus": None}))


def test_layers_that_are_wet_together_cure_as_long_as_the_slowest_and_lie_level() -> None:
    """The mold was opened after the back's cure, and raised while the layer in front still flowed."""
    job = wet_on("slow", "light")
    front, back = pours(job)
    assert front.cure_h == back.cure_h == 16.0
    steps = sheet_steps(job)
    assert "cure, 16 h at room temperature" in steps["cure"]
    assert "puck, 5 mm thick, and mark each: slow and light" in steps["cure"]
    assert "Keep the mold level" in steps["carrier"]
    assert "Raise end b" not in " ".join(steps.values())
    assert pours(wet_on("warm", "light"))[1].cure == "5 h at room temperature (23 °C), then 2 h at 60 °C"
    apart = Job(layered({"name": "light", "thickness": 1.5}, silicones=OWN))
    assert [pour.cure_h for pour in pours(apart)] == [apart.silicone.cure_h, 5.0]
    assert "Raise end b by 10 degrees" in sheet_steps(apart)["carrier"]


def test_a_denser_layer_on_a_lighter_wet_one_is_warned_of() -> None:
    (finding,) = [f for f in pouring_findings(wet_on("light", "slow")) if f.rule == "wet layers"]
    assert (finding.severity, finding.measured, finding.limit) == ("warning", 1070.0, 1040.0)
    assert not [f for f in pouring_findings(wet_on("slow", "light")) if f.rule == "wet layers"]


def test_a_face_that_a_layer_has_to_hold_on_gets_no_release_agent() -> None:
    """A printed plug's lower face has parting film; a plug of rivets, whose pegs let go, has agent."""
    printed, rivets = {"lid_process": "sla"}, {"bond": "rivets", "thickness": 0.9}
    bonded = sheet_steps(Job(layered(CORE, mold=printed)))
    riveted = sheet_steps(Job(layered({**CORE, **rivets}, mold=printed)))
    assert "none on the lower face of plug-1" in bonded["release"]
    assert "Peel the parting film off its back" in bonded["bond the layer in front"]
    assert "primer" not in bonded["bond the layer in front"].replace("No primer", "")
    assert "parting film" not in riveted["release"]
    notes = [f.severity for f in pouring_findings(Job(layered(CORE))) if f.rule == "layer bond"]
    assert notes == ["note"]


def test_one_timeline_feeds_clock_and_day_plan() -> None:
    """Minutes of the day plan are the timeline's, and the sheet's clock is what of it runs after mixing."""
    for job in (Job(layered(CORE)), Job(skincad.load("pins-dome")), Job(skincad.load("yamada-2002"))):
        for pour in pours(job):
            tasks_of = timeline(job, pour)
            begin = [task.step for task in tasks_of].index("mix")
            assert clock(job, pour) == pytest.approx(math.fsum(t.minutes for t in tasks_of[begin:]))
            hands = {task.what: task.hands for task in tasks(job)}
            first = "close the mold, mix and fill it" if pour == pours(job)[-1] else "cast the layer in front"
            laid = 0.5 * strip_count(job) if pour == pours(job)[0] else 0.0  # strips lie there from the first
            assert hands[first] == pytest.approx(math.fsum(t.minutes for t in tasks_of) + laid)
    dome = Job(skincad.load("pins-dome"))
    assert 0 < minutes_left(dome) < 3  # of 25 min: brushing, a second vacuum and eight screws take most


def test_drawing_order_and_list_agree_on_a_plug() -> None:
    """Its size has its pegs, which the drawing dimensions; it is printed on its plate, pegs up; its row says
    what matters on it."""
    job = Job(layered({**CORE, "bond": "rivets", "thickness": 0.9}, mold={"lid_process": "sla"}))
    (plug,) = job.closed.plugs
    pegs = [s.end.z for body in plug.adds for s in body.outline]
    _, _, high = extent(plug)
    assert high == pytest.approx(job.place.back + 0.9 + max(pegs), abs=1e-3)
    rows = notes(job, plug)
    (told,) = [row for row in rows if row.startswith("Pegs: ")]
    assert f"{len(plug.adds)} x neck Ø1, head Ø1.25" in told
    assert told.count("(") == len(plug.adds)
    order = orders(job)["orders/order-sla.md"]([], None)
    assert "On the plate: the upper face of plug-1." in order
    assert "On the plate: the upper face." in rows
    assert "Accurate, ±0.05: lower face, the face on the ledge" in order
    assert f"{high:.2f}" in next(row.designation for row in parts_list(job) if row.what == "plug-1")


def test_the_sheet_begins_with_what_to_watch() -> None:
    text = casting_sheet(Job(layered(CORE)), [], "", True)
    assert text.index("## Watch") < text.index("## Parts")


def test_each_plug_of_a_gang_gets_parting_film() -> None:
    shot = {"name": "dragon-skin-30", "thickness": 1.5}
    gang = skincad.load("plain-ridges", ["ridge.count=3"]).with_(
        shot=(shot,), mold={"cavities": 2, "lid_process": "sla", "gate": None}
    )
    steps = sheet_steps(Job(gang))
    assert "none on the lower face of plug-1 and plug-1-2" in steps["release"]
    assert "plug-1-2" not in steps["release"].split("none on")[0]
    assert "Set plug-1 and plug-1-2 down" in steps["pour the layer in front"]


def test_a_primer_is_used_the_day_it_is_brushed_on() -> None:
    """In layers it is brushed on before the last pour, not before the first, whose cure outlasts it."""
    job = Job(layered(CORE, mold={"carrier": "plain"}))
    steps = [*sheet_steps(job)]
    assert steps.index("cure the layer in front") < steps.index("prime") < steps.index("carrier")
    days = {task.what: task.day for task in day_plan(job)}
    assert days["prime the carrier"] == days["close the mold, mix and fill it"]


def test_wet_layers_of_two_cures_do_not_mix_and_an_unknown_cure_is_no_shorter() -> None:
    own = {
        "tin": {"young_modulus": 0.5, "platinum_cure": False},
        "long": {"young_modulus": 0.5, "cure_h": 48.0},
    }
    tin = Job(layered({"name": "tin", "thickness": 1.5, "bond": "wet"}, silicones=own))
    assert "cure inhibition" in {f.rule for f in pouring_findings(tin)}
    own["unknown"] = {"young_modulus": 0.5}
    slow = Job(
        layered(
            {"name": "unknown", "thickness": 1.5, "bond": "wet"},
            silicones=own,
            material={"name": "long", "young_modulus": None},
        )
    )
    assert pours(slow)[1].cure_h == 48.0
