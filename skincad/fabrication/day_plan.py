"""A day plan: when a person works on a cast, and when they wait, from its own times of curing and drying."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

from skincad.fabrication.job import Job
from skincad.fabrication.pouring import DEGAS_MIN, STIR_MIN, filling, layer_name, pours
from skincad.fabrication.strips import lap, strip_count, strip_seconds, strips_per_mix

BEGIN, END = 9.0, 17.0  # h of a working day, assumption
# min of hands, assumption: to close and to open a mold, to lay a shim, to make a strip ready, to glue one, to
# test and wire one, to prepare parts and to inspect a skin
CLOSING, OPENING, LAYING, READYING, GLUING, WIRING, PREPARING, INSPECTING = 30, 20, 0.5, 3, 2, 5, 60, 45
# assumption, as resin makers' guides have it: two baths, drying, ultraviolet light, baking; data sheets count
BATHS, BATH_MIN, DRYING_MIN, LIGHT_MIN, BAKING_H, BAKING_C = 2, 5, 30, 30, 4, 60
PRIMER_MIN, PRIMER_H = 60, 8  # assumption: makers ask for 30 to 120 min to dry, and to use it the same day
GLUE_MIN = 10  # min, assumption: thin cyanoacrylate between metal and film, to full grip


class Task(NamedTuple):
    """What is done, for how many minutes by hand, how many minutes nobody touches it afterwards, and how many
    minutes of what follows must end on the same day: primer is good for hours. Some begin a day after the
    last cure."""

    what: str
    hands: float
    wait: float = 0.0
    then: float = 0.0
    a_day_after: bool = False


class Entry(NamedTuple):
    """A task in the plan: on which day and at which hour it begins."""

    day: int
    hour: float
    task: Task

    @property
    def clock(self) -> str:
        """The hour as a clock shows it."""
        minutes = 5 * math.ceil(12 * self.hour - 1e-9)
        return f"{minutes // 60}:{minutes % 60:02d}"


def tasks(job: Job) -> list[Task]:
    """Return what is done for a cast, in order."""
    material, strips, film = job.silicone, strip_count(job), job.design.film
    cure = 60 * (material.cure_h or 24.0)
    made = job.closed.made
    resin = material.platinum_cure and any(job.process(part).inhibits_platinum for part in made)
    rows = list[Task]()
    if resin:
        wait = DRYING_MIN + LIGHT_MIN + 60 * BAKING_H
        rows.append(Task("wash, light and bake the printed parts", BATHS * BATH_MIN, wait))
        rows.append(Task("cast the trial drop", 15, cure))
    rows.append(Task("prepare the parts, try them dry", PREPARING))
    drawn_in = lap(job) is not None
    pour = CLOSING + LAYING * strips + STIR_MIN + DEGAS_MIN + filling(job).seconds / 60
    if film is not None and not drawn_in:
        rows.append(Task("make the strips ready", READYING * strips, PRIMER_MIN, pour))
    rows += _layers(job)
    last = pours(job)[-1].silicone
    rows.append(Task("close the mold, mix and fill it", pour, 60 * (last.cure_h or 24.0)))
    if drawn_in:
        mixes = math.ceil(strips / max(strips_per_mix(job) or strips, 1))
        drawing = strips * strip_seconds(job) / 60 + mixes * STIR_MIN
        gluing = OPENING / 2 + GLUING * strips
        rows.append(Task("make the strips ready", READYING * strips, PRIMER_MIN, gluing + GLUE_MIN + drawing))
        rows.append(Task("take the end plates off, glue the strips", gluing, GLUE_MIN))
        rows.append(Task("draw the strips in", drawing, cure))
    rows.append(Task("open the mold, take the skin out", OPENING))
    if film is not None:
        rows.append(Task("test the strips, lead them to the board", WIRING * strips))
    return [*rows, Task("inspect the skin, a day after the last cure", INSPECTING, a_day_after=True)]


def _layers(job: Job) -> list[Task]:
    """What is done for the layers before the last; one that is laid on wet cures with the one behind it."""
    rows, made = list[Task](), pours(job)
    for front, back in pairwise(made):
        hands = CLOSING + STIR_MIN + DEGAS_MIN + filling(job).seconds / 60
        cure = 60 * (front.silicone.cure_h or 24.0) if front.plug else 0.0
        rows.append(Task(f"cast {layer_name(front)}", hands, cure))
        if front.plug:
            wait = PRIMER_MIN if back.bond == "primer" else 0.0
            rows.append(Task(f"pull {front.plug}, make the layer's back ready", OPENING, wait))
    return rows


def day_plan(job: Job) -> list[Entry]:
    """Return when each task begins: hands work from `BEGIN` to `END`, what cures goes on by night. A task
    longer than a day begins in the morning."""
    entries, now, cured = list[Entry](), BEGIN, 0.0  # h from the first day's midnight
    for task in tasks(job):
        begin = _working(max(now, cured + 24.0) if task.a_day_after else now, task)
        entries.append(Entry(1 + int(begin // 24), begin % 24, task))
        now = begin + (task.hands + task.wait) / 60
        cured = now if task.wait else cured
    return entries


def _working(earliest: float, task: Task) -> float:
    """When a task begins: not by night, nor so late in the day that it would not end on it. In h."""
    midnight, hour = 24 * (earliest // 24), max(earliest % 24, BEGIN)
    needs = task.hands + (task.wait + task.then if task.then else 0.0)
    late = hour > END or (hour + needs / 60 > END and hour > BEGIN)
    return midnight + (24 + BEGIN if late else hour)
