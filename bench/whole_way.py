"""The whole way once, from a wish to slip, every number printed: `python -m bench.whole_way FOLDER`, 4 min.

A soft face on a harder back, cast on a bone of our own that a franka-hand's two screws hold; the files are in
FOLDER. What is measured is made up: the coupon's pad says how stiff the silicone is, to 10 %; the cast part
is one whose front was mixed wrongly and is 60 % softer, pressed with a kitchen scale and a screw, ten points
with their noise, seed 1. docs/evidence/whole-way.md shows what it prints.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

import skincad
from skincad.fabrication import Job, layer_name, pours
from skincad.fabrication.coupon import coupon
from skincad.fabrication.day_plan import day_plan
from skincad.inputs import Design
from skincad.scenes import Scene

SIZE, TOUCH, FACE, PROCESS = (22, 24), 2.0, "dragon-skin-10", "sla"
BACK = {"name": "dragon-skin-30", "thickness": 4.5, "bond": "primer"}
BONE = (14.0, 16.0, 2.5)  # mm
MEASURED = {"value": 0.2, "low": 0.18, "high": 0.22}  # MPa, by the coupon's pad
SOFTER, POINTS = 0.4, 10  # what came out, and how often it was pressed
FORCE_ERROR, APPROACH_ERROR = 0.05, 0.02  # N and mm, standard deviations


def bone(path: Path) -> Path:
    """Write a plate with a gripper's two M2 threads, drilled, and two holes that silicone fills."""
    import cadquery as cq

    plate = cq.Workplane("XY").box(*BONE, centered=(True, True, False))
    plate = plate.faces(">Z").workplane().pushPoints([(-5.0, 0.0), (5.0, 0.0)]).hole(1.6)
    plate = plate.faces(">Z").workplane().pushPoints([(0.0, -4.5), (0.0, 4.5)]).hole(3.0)
    cq.exporters.export(plate, str(path))
    return path


def wished() -> Design:
    """The skin by its wish alone."""
    wish = skincad.design_for(size=SIZE, touch=TOUCH, silicone=FACE, process=PROCESS, film="pvdf-28um")
    print(f"wish: {wish.passed}, {wish.design.skin.thickness:g} mm thick, {wish.design.count} ridges")
    kit = coupon(PROCESS, FACE)
    print(f"coupon: {len(kit.parts)} parts, {sum(kit.grams.values()):.1f} g of {FACE}; E is {MEASURED} MPa")
    return wish.design.with_(material={"young_modulus": MEASURED})


def layered(design: Design, step: Path) -> Design:
    """That on a harder back, on the bone."""
    mold = {"mount": None, "gate": None, "bone": str(step), "bone_bond": "rivets"}
    whole = design.with_(name="whole-way", shot=(BACK,), mold=mold)
    for name, one in (("one silicone", design), ("two, flat back", whole)):
        verdict = skincad.check(one)
        print(f"check, {name}: {verdict.verdict}, all touch at {verdict.all_touch_force}")
    return whole


def made(design: Design, folder: Path) -> None:
    result, job = skincad.make(design, checked=True), Job(design)
    skincad.write(result, folder / "mold")
    print(f"make: {result.summary}")
    for finding in result.findings:
        print(f"  {finding.severity}: {finding.rule}, {finding.where}; {finding.remedy}")
    for layer in pours(job):
        print(f"  {layer_name(layer)}: {layer.mass:.2f} g of {layer.silicone.name}; {layer.cure}")
    print(f"  {len(job.closed.made)} parts to make, {day_plan(job)[-1].day} days")


def pressed(design: Design, path: Path) -> Path:
    """Write ten points of a part that came out softer, with the noise of a scale and a screw."""
    from skincad.inputs.material import silicone

    rng = np.random.default_rng(1)
    soft = {"young_modulus": SOFTER * silicone(design).young_modulus.value}
    forces = np.linspace(0.1, 1.0, POINTS) * 2 * design.contact.force
    part = design.with_(material=soft)
    down = [float(skincad.check(part, force=float(f), model="finite-strain").approach) for f in forces]
    rows = zip(
        down + rng.normal(0, APPROACH_ERROR, POINTS) + rng.normal(0, APPROACH_ERROR),
        forces + rng.normal(0, FORCE_ERROR, POINTS),
        strict=True,
    )
    lines = [f"{a:.3f},{f:.2f}" for a, f in rows]
    path.write_text("\n".join(["approach_mm,force_N", *lines, ""]), encoding="utf-8")
    return path


def packed(design: Design, folder: Path) -> None:
    """The package, pressed in MuJoCo."""
    import mujoco

    package = skincad.package(design, ["mujoco", "taxels"])
    skincad.write(package, folder / "package")
    scene = mujoco.MjModel.from_xml_path(str(folder / "package" / "scene.xml"))
    data = mujoco.MjData(scene)
    mujoco.mj_resetDataKeyframe(scene, data, 0)
    for _ in range(1500):
        mujoco.mj_step(scene, data)
    touched = data.sensordata[: design.count]
    print(f"package: {package.weighs.mass:.3g} g; MuJoCo presses {touched.sum():.3f} N")
    print(f"  ridges {np.round(touched, 3).tolist()} N")


def pull(design: Design) -> Scene:
    force = design.contact.force
    settings = [
        f"readout.ridges={list(range(1, design.count + 1))}",
        f"history.normal_force_N=[0.0, {force}, {force}]",
        f"history.tangential_force_N=[0.0, 0.0, {1.2 * force}]",
        "history.time_s=[0.0, 0.02, 0.08]",
        "history.steps=200",
        "readout.alarms=early",
    ]
    return skincad.load_scene("steady-pull", settings, skin=design)


def slips(design: Design) -> None:
    """When ridges slip, and when the films warn of it."""
    answer = skincad.simulate(pull(design))
    told, end = answer.as_json(), answer.gross_slip_step
    print(f"slip: gross slip at {1e3 * answer.march.time[end]:.1f} ms" if end else "slip: none")
    for ridge, lead in told["lead_ms"].items():
        if lead["value"] is not None:
            print(f"  ridge {ridge} slips {lead['value']:.1f} ± {lead['error']:.1f} ms before all do")
    warned = told["warning_lead_time_s"]
    print(
        "  the films raise no warning" if warned is None else f"  the films warn {1e3 * warned:.1f} ms ahead"
    )


def main() -> None:
    folder = Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    design = layered(wished(), bone(folder / "bone.step"))
    made(design, folder)
    verdict = skincad.accept(design, pressed(design, folder / "press.csv"))
    print(f"acceptance of a part {1 - SOFTER:.0%} too soft:\n{verdict}")
    packed(design, folder)
    slips(design)


if __name__ == "__main__":
    main()
