"""A day plan: when a person works on a cast, and when they wait, from its own times of curing and drying."""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.fabrication.job import Job
from skincad.fabrication.papers import listed
from skincad.fabrication.pouring import (
    STIR_MIN,
    USUAL_CURE_H,
    LayerPour,
    in_two_pucks,
    layer_name,
    pours,
    timeline,
    wet_with,
)
from skincad.fabrication.strips import lap, strip_count, strip_seconds, strips_per_mix
from skincad.solids.plan import PartRole

BEGIN, END = 9.0, 17.0  # h of a working day, assumption
# min of hands, assumption: to open a mold, to lay a shim, to make a strip ready, to glue one, to test and
# wire one, to put a magnet in, to prepare parts and to inspect a skin; those of a pour are the clock's
OPENING, LAYING, READYING, GLUING, WIRING, MAGNET, PREPARING, INSPECTING = 20, 0.5, 3, 2, 5, 1, 60, 45
# assumption, as resin makers' guides have it: two baths, drying, ultraviolet light, baking; data sheets count
BATHS, BATH_MIN, DRYING_MIN, LIGHT_MIN, BAKING_H, BAKING_C = 2, 5, 30, 30, 4, 60
PRIMER_MIN, PRIMER_H = 60, 8  # assumption: makers ask for 30 to 120 min to dry, and to use it the same day
GLUE_MIN = 10  # min, assumption: thin cyanoacrylate between metal and film, to full grip


def primed(job: Job) -> bool:
    """Whether a primer binds the skin to its carrier or bone."""
    return job.design.mold.bone_bond != "rivets" if job.bone else not job.riveted


class Task(NamedTuple):
    """What is done, for how many minutes by hand, how many minutes nobody touches it afterwards, and how many
    minutes of what follows must end on the same day: primer is good for hours. Some begin a day after the
    last cure. A plan sets the day and the hour at which it begins; a task alone has neither."""

    what: str
    hands: float
    wait: float = 0.0
    then: float = 0.0
    a_day_after: bool = False
    day: int = 0
    hour: float = 0.0

    @property
    def clock(self) -> str:
        """The hour as a clock shows it."""
        minutes = 5 * math.ceil(12 * self.hour - 1e-9)
        return f"{minutes // 60}:{minutes % 60:02d}"


def tasks(job: Job) -> list[Task]:
    """Return what is done for a cast, in order."""
    material, strips, film = job.silicone, strip_count(job), job.design.film
    cure, made_pours = 60 * (material.cure_h or USUAL_CURE_H), pours(job)
    made = job.closed.made
    resin = material.platinum_cure and any(job.process(part).inhibits_platinum for part in made)
    rows = list[Task]()
    if resin:
        wait = DRYING_MIN + LIGHT_MIN + 60 * BAKING_H
        rows.append(Task("wash, light and bake the printed parts", BATHS * BATH_MIN, wait))
        slowest = max(pour.silicone.cure_h or USUAL_CURE_H for pour in made_pours)
        drops = "drops" if len(made_pours) > 1 else "drop"
        rows.append(Task(f"cast the trial {drops}", 15, 60 * slowest))
    if in_two_pucks(job):
        cures = math.fsum(pour.cure_h for pour in made_pours if pour.plug or pour == made_pours[-1])
        rows.append(Task("cast a puck on a puck, and peel them", 15, 60 * cures))
    rows.append(Task("prepare the parts, try them dry", PREPARING))
    drawn_in = lap(job) is not None
    # strips lie in the mold from the first pour on
    laying, layers = LAYING * strips, _layers(job, made_pours)
    pour = _hands(job, made_pours[-1])
    if film is not None and not drawn_in:
        first = layers[0].hands if layers else pour
        rows.append(Task("make the strips ready", READYING * strips, PRIMER_MIN, laying + first))
    if layers:
        layers[0] = layers[0]._replace(hands=layers[0].hands + laying)
    rows += layers
    if primed(job):
        rows.append(Task(f"prime the {'bone' if job.bone else 'carrier'}", 5, PRIMER_MIN))
    hands = pour if layers else laying + pour
    rows.append(Task("close the mold, mix and fill it", hands, 60 * made_pours[-1].cure_h))
    if drawn_in:
        mixes = math.ceil(strips / max(strips_per_mix(job) or strips, 1))
        drawing = strips * strip_seconds(job) / 60 + mixes * STIR_MIN
        gluing = OPENING / 2 + GLUING * strips
        rows.append(Task("make the strips ready", READYING * strips, PRIMER_MIN, gluing + GLUE_MIN + drawing))
        rows.append(Task("take the end plates off, glue the strips", gluing, GLUE_MIN))
        rows.append(Task("draw the strips in", drawing, cure))
    rows.append(Task("open the mold, take the skin out", OPENING))
    if job.magnet is not None:
        many = len(job.closed.of(PartRole.CORE_PIN))
        rows.append(Task("put the magnets in, and cap them", 5 + MAGNET * many, 60 * made_pours[-1].cure_h))
    if film is not None:
        rows.append(Task("test the strips, lead them to the board", WIRING * strips))
    return [*rows, Task("inspect the skin, a day after the last cure", INSPECTING, a_day_after=True)]


def _hands(job: Job, pour: LayerPour) -> float:
    """How long hands are at a pour, and at those that are wet with it, min."""
    return math.fsum(task.minutes for task in timeline(job, pour))


def _layers(job: Job, made: list[LayerPour]) -> list[Task]:
    """What is done for the layers before the last, and those that are wet with it."""
    rows = list[Task]()
    for pour in made[:-1]:
        if pour.plug:
            names = listed([layer_name(each) for each in wet_with(made, pour)])
            rows.append(Task(f"cast {names}", _hands(job, pour), 60 * pour.cure_h))
            rows.append(Task(f"pull {pour.plug}, make the layer's back ready", OPENING))
    return rows


def day_plan(job: Job) -> list[Task]:
    """Return when each task begins: hands work from `BEGIN` to `END`, what cures goes on by night. A task
    longer than a day begins in the morning."""
    plan, now, cured = list[Task](), BEGIN, 0.0  # h from the first day's midnight
    for task in tasks(job):
        begin = _working(max(now, cured + 24.0) if task.a_day_after else now, task)
        plan.append(task._replace(day=1 + int(begin // 24), hour=begin % 24))
        now = begin + (task.hands + task.wait) / 60
        cured = now if task.wait else cured
    return plan


def _working(earliest: float, task: Task) -> float:
    """When a task begins: not by night, nor so late in the day that it would not end on it. In h."""
    midnight, hour = 24 * (earliest // 24), max(earliest % 24, BEGIN)
    needs = task.hands + (task.wait + task.then if task.then else 0.0)
    late = hour > END or (hour + needs / 60 > END and hour > BEGIN)
    return midnight + (24 + BEGIN if late else hour)
