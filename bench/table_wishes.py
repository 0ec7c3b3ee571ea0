"""Random wishes: how many are met, whether those said to be met really are, and feasible ones missed.

    python -m bench.table_wishes 9000 9200

Each seed is a wish. A design that is said to meet it is judged again by the model JUDGE, and by the findings
of its mold. Of a wish that is said not to be met, random designs of three ridges or more are tried: one that
passes shows that it was feasible.
"""

from __future__ import annotations

import json
import random
from time import perf_counter
from typing import Any

import skincad
from bench import runner
from skincad.base import InputError, RefusedError
from skincad.fabrication import Job, design_findings
from skincad.inputs import PROCESSES, Design, grippers, silicones
from skincad.studies import FILM_ROOM, LEAST_RIDGES, SLOT, SLOT_SHARE, WIRE_SLIT, film_of, meets, room

JUDGE = "corrected-finite-strain"  # whose yield is known to some percent, whatever the clock says
TRIALS, CHECKS = 400, 4  # random designs for a wish that is not met; of them checked
Given = dict[str, Any]


def wish_of(seed: int) -> Given:
    """Return a random wish; each part but the size and the touch is left out now and then."""
    chance = random.Random(seed)
    given: Given = {
        "size": (round(chance.uniform(8, 50), 1), round(chance.uniform(8, 50), 1)),
        "touch": float(f"{10 ** chance.uniform(-1, 1.3):.2g}"),
        "film": chance.choice(("none", "pvdf-9um", "pvdf-28um", "pvdf-28um", "pvdf-52um", "pvdf-110um")),
    }
    if chance.random() < 0.6:
        given["silicone"] = chance.choice(list(silicones(None)))
    if chance.random() < 0.7:
        given["process"] = chance.choice(PROCESSES)
    if chance.random() < 0.3:
        given["gripper"] = chance.choice(list(grippers()))
    return given


def castable(design: Design) -> bool:
    """Whether no rule of the mold is broken by more than a note."""
    return all(finding.severity == "note" for finding in design_findings(Job(design)))


def feasible(given: Given, found: Design, seed: int) -> bool:
    """Whether a random design near the found one meets the wish: same silicone, process, film and holes."""
    chance, tried = random.Random(seed), []
    width, length = given["size"]
    touch = float(given["touch"])
    for _ in range(TRIALS):
        pitch = chance.uniform(1.0, 8.0)
        high = chance.uniform(0.3, 1.0) * pitch
        tables: dict[str, dict[str, Any]] = {
            "skin": {
                "width": width,
                "length": length,
                "thickness": chance.uniform(2.0, 20.0),
                "curvature_radius": width * 10 ** chance.uniform(0.4, 2),
            },
            "ridge": {
                "pitch": pitch,
                "count": max(LEAST_RIDGES, int(width / pitch)),
                "height": high,
                "levelling": 1.0,
                "root_width": chance.uniform(0.55, 0.8) * pitch,
                "tip_width": chance.uniform(0.25, 0.5) * pitch,
                "crown": chance.uniform(0.02, 0.1) * pitch,
                "tip_fillet": max(found.ridge.tip_fillet, 0.05 * pitch),
                "root_fillet": 0.08 * pitch,
            },
            "contact": {"force": touch},
        }
        if "gripper" in given:
            tables["mold"] = {"mount": given["gripper"]}
        if film := film_of(str(given["film"])):
            shares = {"thickness": max(film + FILM_ROOM, SLOT_SHARE * pitch), "tilt": 0.0}
            tables["slot"] = shares | {key: share * pitch for key, share in SLOT.items()}
            tables["film"] = {"thickness": film}
            if found.slot is None:
                wire = {"end_plate_process": "edm", "slit_clearance": WIRE_SLIT}
                tables["mold"] = tables.get("mold", {}) | wire
        try:
            design = found.with_(**tables)
            size = room(design)
        except (InputError, RefusedError):
            continue
        if size:
            tried.append((size, design))
    checked = 0
    for _, design in sorted(tried, key=lambda one: -one[0]):
        try:
            if not castable(design):
                continue
            checked += 1
            if meets(skincad.check(design, model=JUDGE)):
                return True
        except (InputError, RefusedError):
            continue
        if checked == CHECKS:
            break
    return False


def judged(seed: int) -> dict[str, Any]:
    """Return a row of the table: the wish, the answer, and what the second judge says."""
    given, began = wish_of(seed), perf_counter()
    row: dict[str, Any] = {"seed": seed, "wish": given}
    try:
        answer = skincad.design_for(**given)
    except (InputError, RefusedError) as refused:
        return row | {"refused": str(refused), "seconds": perf_counter() - began}
    row |= {"seconds": perf_counter() - began, "met": answer.passed}
    row["broken"] = [broken.wish for broken in answer.broken]
    design, verdict = answer.design, answer.check
    row["design"] = {"pitch": design.ridge.pitch, "count": design.ridge.count, "height": design.ridge.height}
    row["design"] |= {"levelling": design.ridge.levelling, "force": design.contact.force}
    row["needed"], row["model"] = verdict.all_touch_force.value, verdict.model
    row["parts"] = verdict.manufacture and verdict.manufacture.passing.value
    row["silicone"] = design.material.name
    row["again"] = castable(design) and meets(skincad.check(design, model=JUDGE))
    if not answer.passed:
        row["feasible"] = feasible(given, design, seed)
    return row


def main() -> None:
    options = runner.parser(__doc__, "first", "stop").parse_args()
    rows = runner.rows("wishes", judged, range(options.first, options.stop), options, json.dumps)
    met = [row for row in rows if row.get("met")]
    missed = [row for row in rows if row.get("feasible")]
    false = [row["seed"] for row in met if not row["again"]]
    seconds = sorted(float(row["seconds"]) for row in rows)
    share = len(met) / max(1, len(met) + len(missed))
    print(f"{len(rows)} wishes: {len(met)} met, {len(false)} of them falsely {false}; refused or not met")
    print(f"{len(rows) - len(met)}, of which {len(missed)} are feasible; met of the feasible {share:.1%}")
    print(f"seconds: median {seconds[len(seconds) // 2]:.1f}, largest {seconds[-1]:.1f}")


if __name__ == "__main__":
    main()
