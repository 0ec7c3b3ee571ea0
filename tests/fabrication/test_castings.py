"""Papers of random castings: families by layers, bones and processes. Rules of a caster, as tests, and no
quantity with two values."""

from __future__ import annotations

import math
import random
import re
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.base import InputError
from skincad.fabrication import Finding, Job, casting_sheet, design_findings, pours, pull_off, sheet_steps
from skincad.fabrication.inspection import inspection
from skincad.fabrication.machine_rules import extent
from skincad.fabrication.orders import orders
from skincad.fabrication.parts_list import parts_list
from skincad.fabrication.pouring import LayerPour, filling, minutes_left, pouring_findings
from skincad.fabrication.printing import face_down
from skincad.inputs import Design
from skincad.solids import CutRole, PartRole, bores
from skincad.solids.mold import mold
from tests.solids.kinds import boned, plate, stem, wide_rings

SEEDS = range(8000, 8060)  # used by no other test
FAST = SEEDS[:6]
BASES = {
    "ridge": lambda: skincad.load("lab-bench", ["ridge.count=3"]),
    "bare ridge": lambda: skincad.load("plain-ridges", ["ridge.count=3"]),
    "pin": lambda: skincad.load("pillars-9"),
    "ring": lambda: skincad.load("rings-5", ["skin.width=24"]),
    "flat": lambda: skincad.load("flat-magnet"),
}
SILICONES = {
    "slow": {
        "young_modulus": 0.4,
        "cure_h": 16.0,
        "pot_life_min": 60.0,
        "density": 1070.0,
        "mix": [1.0, 1.0],
    },
    "light": {
        "young_modulus": 0.4,
        "cure_h": 5.0,
        "pot_life_min": 45.0,
        "density": 1030.0,
        "mix": [1.0, 1.0],
    },
    "tin": {"young_modulus": 0.4, "cure_h": 6.0, "pot_life_min": 30.0, "platinum_cure": False},
}


def draw(seed: int, folder: Path) -> Design:
    """A design of any family, in layers or not, on a bone or not, by any processes; the first that has a
    mold."""
    dice = random.Random(seed)
    for _ in range(200):
        try:
            design = _on_a_bone(dice, folder) if dice.random() < 0.25 else _draw(dice, folder)
            mold(design)
        except InputError:
            continue
        return design
    raise AssertionError(f"no design of seed {seed} has a mold")


def _draw(dice: random.Random, folder: Path) -> Design:
    base: Any = BASES[dice.choice([*BASES])]()
    makers: dict[str, Any] = {"process": dice.choice(["sla", "fdm", "cnc", "edm"])}
    makers["lid_process"] = dice.choice(["sla", "fdm", "cnc"])
    material = dice.choice(
        [None, {"name": "slow", "young_modulus": None}, {"name": "light", "young_modulus": None}]
    )
    base = base.with_(silicones=SILICONES, mold=makers, **({"material": material} if material else {}))
    layers = [
        {
            "name": dice.choice(["slow", "light", "dragon-skin-30", "tin"]),
            "thickness": round(dice.uniform(0.8, 1.4) + 1.2 * i, 1),
            "bond": dice.choice(["primer", "wet", "rivets", None]),
        }
        for i in range(dice.choice([0, 0, 1, 1, 2]))
    ]
    if layers:
        base = base.with_(shot=tuple(layers), mold={"gate": None, "pour": None})
    elif dice.random() < 0.4:
        base = base.with_(mold={"gate": None, "pour": "open"})
    return base


def _on_a_bone(dice: random.Random, folder: Path) -> Design:
    """Ridges or rings on a stem or a plate, in one silicone or with a layer behind which the bone stands."""
    base = dice.choice([BASES["ridge"](), wide_rings()])
    shape, bond = dice.choice([(stem(), "primer"), (plate(), "primer"), (plate(), "rivets"), (stem(), None)])
    bone = boned(folder, shape, base, bone_bond=bond, lid_process=dice.choice(["sla", "cnc"]))
    if dice.random() < 0.3:
        return bone.with_(silicones=SILICONES, shot=({"name": "slow", "thickness": 2.8, "bond": "primer"},))
    return bone.with_(mold={"pour": "open"}) if dice.random() < 0.5 else bone


def ruined(job: Job, findings: list[Finding]) -> Iterator[str]:
    """What would ruin a cast and is neither avoided on the sheet nor said by a finding."""
    made, steps = pours(job), sheet_steps(job)
    text, broken = " ".join(steps.values()), {finding.rule for finding in findings}
    for front, back in pairwise(made):
        known = [each.silicone.cure_h for each in (front, back)]
        if back.bond == "wet" and None not in known and back.cure_h < max(known):  # type: ignore[type-var]
            yield f"opened after {back.cure_h} h of {known}"
        if (
            back.bond == "wet"
            and back.silicone.density > front.silicone.density
            and "wet layers" not in broken
        ):
            yield "a denser layer on a lighter wet one"
        agent = re.search(r"release agent for silicone on ([^;.]*)", steps["release"])
        if front.plug and back.bond == "primer" and agent and "plug" in agent[1].replace("plugs", "plug"):
            names = [plug.name for plug in job.closed.plugs if plug.name in agent[1]]
            if front.plug in names or "plugs" in agent[1]:
                yield f"release agent on {front.plug}, behind which a layer has to hold"
        if front.plug and back.bond == "primer" and "layer bond" not in broken:
            yield "a bond without a lock is not told of"
    if len(made[-1].wet) > 1 and "Raise end b" in steps["carrier"]:
        yield "raised while two layers flow"
    if job.skin.standing and not re.search("every hole|down one side of every hole", text):
        yield "pins are not brushed"
    if job.skin.family == "ring" and "brush" not in steps:
        yield "closed grooves are not brushed"
    if (job.gate is None or job.skin.standing) and "vacuum" not in steps:
        yield "an open trough without a vacuum"
    if "Draw the core pins out of plug" in text:
        yield "core pins as pistons"
    yield from _bone(job, steps, broken)


def _bone(job: Job, steps: dict[str, str], broken: set[str]) -> Iterator[str]:
    bone = job.bone
    if bone is None:
        return
    if bone.printed and "hold" not in steps:
        yield "nothing holds the bone up"
    if not bone.printed and not job.closed.of(PartRole.BONE_SCREW):
        yield "no screws hold the bone"
    if job.design.mold.bone_bond == "rivets":
        if not bone.locks and ("bone rivets" not in broken or pull_off(job) != 0.0):
            yield "straight rivets promise something"
        order = [*steps]
        mixed = [i for i, name in enumerate(order) if name.startswith("mix") or name == "bone holes"]
        brushed = next(
            i for i, name in enumerate(order) if "the bone's holes" in steps[name] and "rush" in steps[name]
        )
        if min(mixed) > brushed:
            yield "the bone's holes are brushed before anything is mixed"
    if "Weigh the bone" not in steps["prepare"]:
        yield "the carrier is weighed, which comes off"
    if "tape each bleed" in " ".join(steps.values()):
        yield "bleeds to tape where there are none"


def two_values(job: Job) -> Iterator[str]:
    """Quantities that two papers say differently."""
    sheet, rows = casting_sheet(job, [], "", True), parts_list(job)
    made, steps = pours(job), sheet_steps(job)
    skin = math.fsum(pour.volume for pour in made) / job.design.mold.cavities
    if abs(skin / job.poured_part.volume - 1) > 1e-9:
        yield f"the layers' volumes and the skin's: {skin}, {job.poured_part.volume}"
    mixed: dict[str, float] = {}
    for pour in made:
        mixed[pour.silicone.name] = mixed.get(pour.silicone.name, 0.0) + pour.batch
        step = (
            "mix"
            if len(made) == 1
            else f"mix {'the layer in front' if pour.number == 0 else f'shot {pour.number}'}"
        )
        if pour.weights not in steps[step] or pour.weights not in sheet:
            yield f"{pour.weights} is not on the sheet twice"
    for name, mass in mixed.items():
        (row,) = (row for row in rows if row.what == "silicone" and row.designation == name)
        if abs(float(row.quantity) - mass) > 1e-3 * mass:
            yield f"{name}: {row.quantity} g, {mass} g"
    (mass,) = (row for row in inspection(job).measures if row.what.startswith("mass of the skin"))
    cast = math.fsum(pour.volume * pour.silicone.density for pour in made) * 1e-6 / job.design.mold.cavities
    if not 0.95 * cast < mass.nominal < 1.35 * cast:  # rivets, the vent's plug and films besides
        yield f"inspection {mass.nominal} g, poured {cast} g"
    for part in job.closed.made:
        size = " x ".join(f"{side:.2f}" for side in extent(part))
        if not any(row.what == part.name and row.designation == size for row in rows):
            yield f"{part.name}: no row of {size}"
        text = orders(job)[f"orders/order-{job.maker(part)}.md"]([], None)
        if job.process(part).layer and not re.search(
            rf"On the plate: the {face_down(job, part)} of [^.]*{re.escape(part.name)}", text
        ):
            yield f"{part.name}: no face on the plate in its order"
        for bore in bores(part, CutRole.CORE):
            magnet = job.magnet
            wide = magnet[0] + 0.1 if magnet else job.design.features.pocket.diameter
            narrower = wide - 2 * bore.radius
            if (narrower > 1e-9) != bool(job.process(part).layer):
                yield f"{part.name}: a core pin's hole of {2 * bore.radius} mm by {job.maker(part)}"
    yield from _clock(made, job, sheet)


def _clock(made: list[LayerPour], job: Job, sheet: str) -> Iterator[str]:
    for pour in made:
        left = minutes_left(job, pour)
        if left is not None and left < 0 and not any(f.rule == "pot life" for f in pouring_findings(job)):
            yield f"{left} min left, and no finding"
        said = f"{max(left or 0.0, 0.0):.2g} min are left"
        if left is not None and pour.level is None and said not in sheet:
            yield f"{said} is not on the sheet"
    if "brush" not in sheet_steps(job) and filling(job).brushed:
        yield "no brushing"


def out_of_place(job: Job) -> Iterator[str]:
    """Words of things that a design has not."""
    text = " ".join(sheet_steps(job).values())
    if job.skin.slot is None and re.search(r"\bstrips?\b|\bshims?\b|\bcombs?\b", text):
        yield "strips, shims or combs in a skin without slots"
    if job.skin.standing and "into all grooves" in text:
        yield "grooves of pins"
    if job.skin.bare and re.search(r"crest|grooves", text.replace("runs over the grooves", "")):
        yield "crests or grooves of a face"
    if not job.closed.of(PartRole.CORE_PIN) and "core pin" in text.lower():
        yield "core pins of a skin without pockets"
    if re.search(r"None|undefined|  |\.\.|\( |nan\b", text):
        yield f"holes in the text: {re.search(r'.{20}(None|undefined|  |[.][.]|[(] |nan).{20}', text)}"


def assert_castable(design: Design) -> None:
    job = Job(design)
    findings = [*design_findings(job), *pouring_findings(job)]
    assert [*ruined(job, findings), *two_values(job), *out_of_place(job)] == []


@pytest.mark.parametrize("seed", FAST)
def test_a_few_random_castings_keep_the_rules(seed: int, tmp_path: Path) -> None:
    assert_castable(draw(seed, tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("seed", SEEDS[len(FAST) :])
def test_random_castings_keep_the_rules(seed: int, tmp_path: Path) -> None:
    assert_castable(draw(seed, tmp_path))
