"""How silicone is mixed and brought into the mold: amounts, a clock against its pot life, time and force.

A front of silicone that is pressed faster than its slope (solids/gate.py) piles up and runs over grooves
before these fill. A groove d deep fills through its narrowest passage b, from h of silicone over it, in
6 mu d^2 / (rho g h b^2): Poiseuille's flow between plates, Washburn's integral. Its air leaves along it,
towards the raised end, until the front arrives there. By then a groove may lag behind by LAG of the length;
where that takes longer than anyone waits, grooves are brushed full before the carrier goes on. Range:
Newtonian, a mix that is fresh.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

from skincad.fabrication.fasteners import cover_screws, end_screws
from skincad.fabrication.filling import void
from skincad.fabrication.job import Job
from skincad.fabrication.rules import Finding, error, note, warning
from skincad.fabrication.strips import pour
from skincad.inputs.guards import face_heights
from skincad.inputs.material import layers
from skincad.inputs.silicone import Silicone
from skincad.shape.shots import face
from skincad.solids.gate import (
    GRAVITY,
    LUER,
    SYRINGES,
    THUMB,
    TIP_LENGTH,
    TIP_PLAY,
    TIPS,
    filling_time,
    press,
    tip,
)
from skincad.solids.plan import CutRole, PartRole, bores
from skincad.solids.shots import bond_of, room

USUAL_CURE_H = 24.0  # h, assumption: of a silicone whose cure is not known
DEAD_VOLUME = 8.0  # g, assumption: stays in cup and syringe; less can't be weighed or degassed well
SCALE = 0.01  # g, assumption: what the scale shows
LEAST_PORTION = 0.5  # g, assumption: of A or B; the scale knows it to 2 %
LEAST_MIX = 2.0  # g, assumption: of both together; less is not stirred well
STIR_MIN = 3.0  # min, source: makers' data sheets
DEGAS_MIN, DEGAS_MBAR = 3.0, 50.0  # source: makers' data sheets, 2 to 3 min at 29 inHg of vacuum
USUAL_C, COLD_C = 23.0, 18.0  # C, source: data sheets state pot life at 23; assumption: a cool workshop
RISE = 4.0  # of its height, to which a mix rises as it is degassed, source: makers' data sheets, 3 to 4
DOUBLING_K = 10.0  # K, assumption: by which a platinum cure gets twice as fast
SLOWER = 2 ** ((USUAL_C - COLD_C) / DOUBLING_K)
LAG = 0.1  # assumption: of the skin's length, by which a groove's front may stay behind
MOST_MINUTES = 5.0  # assumption: longer than that nobody waits for a groove
# min of the clock, assumption: to pump a chamber down, to load a brush, to draw up a syringe, to lay on a
# carrier or a plug, foam and cover, and an end plate, and for each screw
PUMP_MIN, LOAD_MIN, SYRINGE_MIN, LAY_MIN, LID_MIN, END_MIN, SCREW_MIN = 2, 1, 1, 1, 1, 1, 0.1
BRUSH, STROKE = 2.0, 60.0  # mm and mm/min, assumption: width of a brush, and how fast it fills what it passes
FRESH_H = 24  # h, assumption: within which silicone still bonds well to cured platinum silicone


def poured_volume(job: Job) -> float:
    """Return the volume that the silicone fills, mm3: skin, gate, vent and reservoir, the carrier's holes and
    their bleeds, and the flash in the gap round the carrier; for all skins of a gang, whose cover and seal
    are thicker than those of one."""
    beside = (space for space in void(job).spaces if space.beside not in (PartRole.COVER, PartRole.SKIN))
    below = job.poured_part.volume + math.fsum(space.body.volume for space in beside)
    lids = job.closed.of(PartRole.COVER, PartRole.SEAL)
    over = [bore.volume for part in lids for bore in bores(part, CutRole.RESERVOIR, CutRole.BLEED)]
    return job.design.mold.cavities * below + math.fsum(over)


@dataclass(frozen=True)
class LayerPour:
    """A pour: of a skin's only silicone, or of one of its layers. `number` is its shot's, 0 for the layer in
    front; `volume` the layer's and `filled` all that it fills, mm3, of all skins; `plug` what lies over it
    while it cures, "" where the next is laid on it wet or the carrier closes it; `bond` that to the layer in
    front, "" without one; `level` how far under the ledge it ends, mm, where that is poured by eye; `cored`
    whether core pins stand in the plug; `wet` the silicones that are wet together, its own too."""

    number: int
    silicone: Silicone
    volume: float
    filled: float
    plug: str = ""
    bond: str = ""
    level: float | None = None
    cored: bool = False
    wet: tuple[Silicone, ...] = ()

    @property
    def mass(self) -> float:
        """What it fills, g."""
        return self.filled * self.silicone.density * 1e-6

    @property
    def batch(self) -> float:
        """What is mixed for it, g: what stays in cup and syringe too."""
        return self.mass + DEAD_VOLUME

    @property
    def cup(self) -> int:
        """The mixing cup that it takes, ml: a mix rises to four times its height."""
        return math.ceil(RISE * self.batch / self.silicone.density * 1000 / 10) * 10

    @property
    def weights(self) -> str:
        """What is weighed for it, as words."""
        return weights(self.silicone, self.batch)

    @property
    def cure(self) -> str:
        """How long it cures with what is wet with it, and how warm, as words: at one temperature the longest
        time counts, and what needs warmth has it at last."""
        return ", then ".join(map(cure_words, self._slowest))

    @property
    def cure_h(self) -> float:
        """The same in h; `USUAL_CURE_H` for each that is not known."""
        by: dict[float, float] = {}
        for material in self.wet:
            warm = material.cure_c or 0.0
            by[warm] = max(by.get(warm, 0.0), material.cure_h or USUAL_CURE_H)
        return math.fsum(by.values())

    @property
    def _slowest(self) -> list[Silicone]:
        """The slowest silicone at each temperature, the coolest first; one whose data sheet has to be asked
        counts as slowest."""
        by: dict[float, Silicone] = {}
        for material in sorted(self.wet, key=lambda each: each.cure_h or math.inf):
            by[material.cure_c or 0.0] = material
        return [by[warm] for warm in sorted(by)]


def layer_name(layer: LayerPour) -> str:
    """Return what a pour's layer is called."""
    return "the layer in front" if layer.number == 0 else f"shot {layer.number}"


def pours(job: Job) -> list[LayerPour]:
    """Return the pours in their order: the layer in front first, at last the one at the back, which fills
    what the carrier has too."""
    design, skins = job.cast, job.design.mold.cavities
    stuffs, shots = layers(design), design.shot or ()
    count, whole = len(shots), job.closed.first(PartRole.SKIN).volume
    below = [0.0, *(room(design, number).volume for number in range(1, count + 1)), whole]
    taken, found = poured_volume(job), list[LayerPour]()
    gates = [space.body for space in void(job).spaces if space.name == "gate"]  # each pour's own is as large
    for front in range(count, -1, -1):  # the layer between the faces of the shots `front` and `front + 1`
        number = 0 if front == count else front + 1
        volume = skins * (below[front + 1] - below[front])
        bond = "" if front == count else bond_of(shots[front])
        wet = front > 0 and bond_of(shots[front - 1]) == "wet"
        plug = "" if front == 0 or wet else f"plug-{front}"
        filled = volume
        if front == 0:
            filled += taken - skins * whole
        elif plug:
            vents, lid = bores(job.closed.part(plug), CutRole.VENT), job.closed.first(PartRole.COVER)
            filled += skins * math.fsum(bore.volume for bore in (*vents, *gates))
            filled += math.fsum(bore.volume for bore in bores(lid, CutRole.RESERVOIR))
        level = face(design, front, design.skin.width / 2)[0].start.z if wet else None
        stuff = job.silicone if number == 0 else stuffs[number - 1]
        with_plug = (stage for stage in job.closed.earlier if plug in [p.name for p in stage.parts])
        cored = any(stage.of(PartRole.CORE_PIN) for stage in with_plug)
        found.append(LayerPour(number, stuff, volume, filled, plug, bond, level, cored))
    return [replace(one, wet=tuple(each.silicone for each in wet_with(found, one))) for one in found]


def wet_with(made: list[LayerPour], layer: LayerPour) -> list[LayerPour]:
    """Return the pours that are wet together with one of them, which is among them."""
    first = last = made.index(layer)
    while made[first].bond == "wet":
        first -= 1
    while last + 1 < len(made) and made[last + 1].bond == "wet":
        last += 1
    return made[first : last + 1]


def small_batch(material: Silicone) -> float:
    """Return the least that is mixed, g: the smaller portion is still weighed to 2 %."""
    least = 0.0 if material.mix is None else LEAST_PORTION * sum(material.mix) / min(material.mix)
    return float(math.ceil(max(LEAST_MIX, least)))


# source: silicone makers' technical bulletins have 80 and 100 C. A printed carrier stays on the skin: source:
# makers' data sheets, heat deflection of PETG at 65 to 75 C, of resins at 46 to 62; assumption: 60 C, no load
HOT_CURE, MILD_CURE = "2 h at 80 °C and 1 h at 100 °C", "8 h at 60 °C, no more"
STIFFER = 5  # %, assumption: by which a post-cure raises E


def post_cure(job: Job) -> str:
    """Return a post-cure, as words: a mild one where print or magnets would suffer by more."""
    mild = job.lid_process.layer or job.magnet is not None or job.bone is not None
    return MILD_CURE if mild else HOT_CURE


def in_two_pucks(job: Job) -> bool:
    """Whether layers hold on each other without a lock, which a trial of two pucks shows."""
    return any(front.plug and back.bond == "primer" for front, back in pairwise(pours(job)))


def veiled(job: Job) -> list[str]:
    """Return the printed plugs whose face gets parting film and no release agent: a layer has to hold on
    what they leave, without a lock."""
    made = pours(job)
    if not job.lid_process.layer:
        return []
    bonded = (front.plug for front, back in pairwise(made) if front.plug and back.bond == "primer")
    return [name for plug in bonded for name in plug_names(job, plug)]


def plug_names(job: Job, plug: str) -> list[str]:
    """Return the names of a pour's plugs: one for each skin of a gang, the first of which is `plug`."""
    return [part.name for part in job.closed.plugs if part.name == plug or part.name.startswith(f"{plug}-")]


@dataclass(frozen=True)
class Filling:
    """How a mold is filled: s; the syringe's ml and the thumb's force, N, 0 without a gate; whether the
    grooves are brushed full before the carrier goes on."""

    seconds: float
    syringe: int
    fills: int
    force: float
    brushed: bool


def filling(job: Job) -> Filling:
    """Return how long filling takes, and how hard it is."""
    level, groove = front_time(job), groove_time(job)
    brushed = job.skin.form.closed or groove / LAG > max(level, 60 * MOST_MINUTES)
    seconds = max(level, 0.0 if brushed else groove / LAG, job.design.mold.fill_time)
    if job.gate is None:
        return Filling(_rounded(seconds), 0, 0, 0.0, brushed)
    made = pours(job)
    volume = max(one.filled for one in made) / 1000
    size = next((ml for ml in SYRINGES if ml >= volume), max(SYRINGES))
    # N s, the thumb's force times the time of filling: the force falls as the time grows
    work = max(press(one.silicone.viscosity, one.filled, job.gate, SYRINGES[size]) for one in made)
    seconds = _rounded(max(seconds, work / THUMB))
    return Filling(seconds, size, math.ceil(volume / size), work / seconds, brushed)


def front_time(job: Job) -> float:
    """Return the least time in which a front keeps its slope along the skin, s."""
    return filling_time(job.design) * (job.design.skin.thickness / _depth(job)) ** 2


def _depth(job: Job) -> float:
    """How deep the silicone is that comes over the features first, mm: of layers that are pressed in through
    gates it is the layer in front."""
    skin, shots = job.design.skin, job.design.shot
    return skin.thickness - (face_heights(skin, shots[-1])[0] if shots and job.gate else 0.0)


def groove_time(job: Job) -> float:
    """Return the time in which the deepest groove fills through its narrowest passage, s."""
    flow, skin = pour(job), job.skin
    narrow = skin.profile.mean_width if flow is None else min(flow.beside, skin.profile.mean_width)
    head = job.silicone.density * GRAVITY * 1e-3 * _depth(job)
    return 6 * job.silicone.viscosity * (max(skin.heights) / narrow) ** 2 / head


def outlet_words(gate: float) -> str:
    """Return what goes into the gate: the luer slip itself where it seats, or the widest blunt tip."""
    if LUER[0] <= gate <= LUER[1]:
        return "whose luer slip seats in the gate"
    if (gauge := tip(gate)) is not None:
        return (
            f"with a blunt tip of {gauge} gauge ({TIPS[gauge][0]:g} mm), {TIP_LENGTH:g} mm long, for the gate"
        )
    return f"with a tube of {gate - TIP_PLAY:g} mm for the gate"


def weights(material: Silicone, total: float) -> str:
    """Return as words what to weigh for `total` g of a silicone, on a scale of SCALE."""
    if not material.mix:
        return f"mix {total:.2f} g by its data sheet"
    a, b = (total * share / sum(material.mix) for share in material.mix)
    return f"weigh {a:.2f} g of A and {b:.2f} g of B, {total:.2f} g"


def mixing(material: Silicone, total: float) -> tuple[str, str]:
    """Return as words what to weigh for `total` g of a silicone, and its pot life and cure."""
    pot = f"{material.pot_life_min:g} min" if material.pot_life_min else "by its data sheet"
    return weights(material, total), f"Pot life {pot}; cure {cure_words(material)}."


def cure_words(material: Silicone) -> str:
    """Return as words how long a silicone cures, and how warm."""
    cure = f"{material.cure_h:g} h" if material.cure_h else "as long as its data sheet says"
    warm = f"room temperature ({USUAL_C:g} °C)" if material.cure_c is None else f"{material.cure_c:g} °C"
    return f"{cure} at {warm}"


class TimedStep(NamedTuple):
    """What is done at the mold, as the sheet names its step, for how many min, and for which pour."""

    step: str
    minutes: float
    number: int


def timeline(job: Job, layer: LayerPour) -> list[TimedStep]:
    """Return in order what is done for a pour and those that are wet with it, until their mold is closed and
    full. What is poured last is mixed first: it waits, and the one in front does not."""
    made, how = pours(job), filling(job)
    group = wet_with(made, layer)
    number, first, by_gate = group[0].number, group[0] == made[0], job.gate is not None

    def task(step: str, minutes: float, number: int = number) -> TimedStep:
        return TimedStep(step, minutes, number)

    screws = cover_screws(job)
    ends = [task("ends", 2 * END_MIN + SCREW_MIN * end_screws(job).pieces)] * (first or job.bent) * job.ends
    lid = task("lid", LID_MIN + SCREW_MIN * (screws.pieces if screws else 2))
    hold = [task("hold", LAY_MIN)] * bool(job.bone and job.bone.printed and group[-1] == made[-1])
    closing = [task("carrier", LAY_MIN), lid, *hold]
    mixes = [task("mix", STIR_MIN + PUMP_MIN + DEGAS_MIN, each.number) for each in reversed(group)]
    brushing = _brushing(job) if first and how.brushed else 0.0
    brushing += LOAD_MIN * any(brushed_holes(job, each) for each in group)
    front = [task("brush", brushing)] * bool(brushing)
    front += [task("vacuum", PUMP_MIN + DEGAS_MIN)] * (first and open_back(job))
    usual = job.design.mold.fill_time
    timed = [how.seconds if by_gate or each == made[0] else usual for each in group]
    fills = [task("pour", seconds / 60, each.number) for each, seconds in zip(group, timed, strict=True)]
    if not by_gate:
        return [*ends, *mixes, *front, *fills, *closing]
    fills = [task("syringe", SYRINGE_MIN * how.fills), *fills]
    if not mixed_first(job, group[0]):
        return [*ends, *closing, *mixes, *front, *fills]
    return [*([] if job.bent else ends), *mixes, *front, *(ends if job.bent else []), *closing, *fills]


def mixed_first(job: Job, layer: LayerPour) -> bool:
    """Whether silicone is mixed before a mold with a gate is closed, to be brushed in where no front goes."""
    return (filling(job).brushed and layer == pours(job)[0]) or brushed_holes(job, layer)


def brushed_holes(job: Job, layer: LayerPour) -> bool:
    """Whether rivets' holes are brushed full before a pour: of the layer in front, or of a bone."""
    of_bone = job.bone is not None and job.design.mold.bone_bond == "rivets" and layer == pours(job)[-1]
    return of_bone or layer.bond == "rivets"


def open_back(job: Job) -> bool:
    """Whether the trough stands open when the first mix comes in, or its holes or rings are brushed full, so
    that a vacuum draws their air."""
    return job.gate is None or job.skin.form.closed


def _brushing(job: Job) -> float:
    """How long all features are brushed full, min."""
    return LOAD_MIN + job.design.skin.area * job.design.mold.cavities / BRUSH / STROKE


def clock(job: Job, layer: LayerPour) -> float:
    """Return how many min after A meets B a pour's mold is closed and full, or the next is laid on it."""
    tasks, group = timeline(job, layer), wet_with(pours(job), layer)
    begin = tasks.index(next(task for task in tasks if (task.step, task.number) == ("mix", layer.number)))
    end, place = len(tasks), group.index(layer)
    if place + 1 < len(group):
        after = ("pour", group[place + 1].number)
        end = 1 + tasks.index(next(task for task in tasks if (task.step, task.number) == after))
    return math.fsum(task.minutes for task in tasks[begin:end])


def minutes_left(job: Job, layer: LayerPour | None = None) -> float | None:
    """Return what is left of a pour's pot life, the last one's if none is given, when its mold is closed and
    full, min; None where it is not known."""
    layer = layer or pours(job)[-1]
    pot = layer.silicone.pot_life_min
    return None if pot is None else pot - clock(job, layer)


def time_words(seconds: float) -> str:
    """Return s up to two minutes, then min."""
    return f"{seconds:.2g} s" if seconds < 120 else f"{seconds / 60:.2g} min"


def pouring_findings(job: Job) -> list[Finding]:
    """Return the rule `pot life`, that the mold is full before a mix thickens, and those of layers: `cure
    inhibition`, `wet layers` and `layer bond`."""
    findings, made = list[Finding](), pours(job)
    for one in made:
        left, pot = minutes_left(job, one), one.silicone.pot_life_min
        if left is None or pot is None or left >= 0:
            continue
        remedy = "a thinner silicone or one with a longer pot life, a wider mold.gate, or a thicker skin"
        where, fails = "mixing, filling and closing", warning
        if len(made) > 1:
            where = f"{layer_name(one)}: {where}"
        if one.level is not None:  # else it is no longer wet as the next comes on it
            remedy, fails = "a silicone with a longer pot life in front, or shot.bond = 'primer'", error
            where = f"{layer_name(one)}, on which the next is laid wet"
        findings.append(fails("pot life", where, pot - left, pot, "min", remedy))
    return [*findings, *_between_layers(job)]


def _between_layers(job: Job) -> Iterator[Finding]:
    """Yield what keeps a layer from holding on the one in front of it, or from staying behind it: cures that
    don't go together, a denser silicone on a lighter one that still flows, and a face without a lock."""
    made = pours(job)
    for front, back in pairwise(made):
        mixed = back.bond == "wet" and front.silicone.platinum_cure != back.silicone.platinum_cure
        if mixed or (not front.silicone.platinum_cure and back.silicone.platinum_cure):
            where = f"shot {back.number}, {back.silicone.name}, poured on {front.silicone.name}"
            remedy = "a tin cure keeps a platinum silicone sticky; take silicones of one cure"
            yield error("cure inhibition", where, 1.0, 0.0, "", remedy)
        below, above = front.silicone.density, back.silicone.density
        if back.bond == "wet" and above > below:
            where = f"shot {back.number}, {back.silicone.name}, wet on the lighter {front.silicone.name}"
            remedy = "the layers turn over while both flow; let the front one cure: shot.bond = 'primer'"
            yield warning("wet layers", where, above, below, "kg/m3", remedy)
        if front.plug and back.bond == "primer":
            where = f"shot {back.number}, which nothing locks to the layer in front"
            remedy = "pour it within a day and test the peel, as the sheet says; or shot.bond = 'rivets'"
            yield note("layer bond", where, 1.0, 0.0, "", remedy)


def _rounded(seconds: float) -> float:
    """Two digits, upward, as a clock is read; 10 s at least."""
    seconds = max(seconds, 10.0)
    step = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.ceil(seconds / step - 1e-9) * step
