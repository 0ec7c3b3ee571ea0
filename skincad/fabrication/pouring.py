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
from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

from skincad.fabrication.filling import void
from skincad.fabrication.job import Job
from skincad.fabrication.rules import Finding, error, warning
from skincad.fabrication.strips import pour
from skincad.inputs.material import layers
from skincad.inputs.silicone import Silicone
from skincad.shape.shots import face
from skincad.solids.bone import bone_of
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


def poured_volume(job: Job) -> float:
    """Return the volume that the silicone fills, mm3: skin, gate, vent and reservoir, the carrier's holes and
    their bleeds, and the flash in the gap round the carrier; for all skins of a gang, whose cover and seal
    are thicker than those of one."""
    spaces, bone = void(job).spaces, bone_of(job.cast)
    below = -(bone.inside if bone else 0.0)
    below += math.fsum(space.body.volume for space in spaces if space.beside is not PartRole.COVER)
    lids = job.closed.of(PartRole.COVER, PartRole.SEAL)
    over = [bore.volume for part in lids for bore in bores(part, CutRole.RESERVOIR, CutRole.BLEED)]
    return job.design.mold.cavities * below + math.fsum(over)


@dataclass(frozen=True)
class LayerPour:
    """A pour: of a skin's only silicone, or of one of its layers. `number` is its shot's, 0 for the layer in
    front; `volume` the layer's and `filled` all that it fills, mm3, of all skins; `plug` what lies over it
    while it cures, "" where the next is laid on it wet or the carrier closes it; `bond` that to the layer in
    front, "" without one; `level` how far under the ledge it ends, mm, where that is poured by eye; `cored`
    whether core pins stand in the plug."""

    number: int
    silicone: Silicone
    volume: float
    filled: float
    plug: str = ""
    bond: str = ""
    level: float | None = None
    cored: bool = False

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
        """How long it cures, and how warm, as words."""
        return cure_words(self.silicone)


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
            filled += skins * math.fsum(bore.volume for bore in vents)
            filled += math.fsum(bore.volume for bore in bores(lid, CutRole.RESERVOIR))
        level = face(design, front, design.skin.width / 2)[0].start.z if wet else None
        stuff = job.silicone if number == 0 else stuffs[number - 1]
        with_plug = (stage for stage in job.closed.earlier if plug in [p.name for p in stage.parts])
        cored = any(stage.of(PartRole.CORE_PIN) for stage in with_plug)
        found.append(LayerPour(number, stuff, volume, filled, plug, bond, level, cored))
    return found


def small_batch(material: Silicone) -> float:
    """Return the least that is mixed, g: the smaller portion is still weighed to 2 %."""
    least = 0.0 if material.mix is None else LEAST_PORTION * sum(material.mix) / min(material.mix)
    return float(math.ceil(max(LEAST_MIX, least)))


class PostCure(NamedTuple):
    """A post-cure: C and h, first and second; by how many percent E rises."""

    warm: int
    hours: int
    hot: int
    more: int
    percent: int


# source: silicone makers' technical bulletins have 80 and 100 C; assumption: by how much E rises
POST_CURE = PostCure(80, 2, 100, 1, 5)


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
    blind = job.skin.symmetry == "revolved"  # a pin's hole keeps its air under a rising front
    brushed = blind or groove / LAG > max(level, 60 * MOST_MINUTES)
    seconds = max(level, 0.0 if brushed else groove / LAG, job.design.mold.fill_time)
    if job.gate is None:
        return Filling(_rounded(seconds), 0, 0, 0.0, brushed)
    volume = poured_volume(job) / 1000
    size = next((ml for ml in SYRINGES if ml >= volume), max(SYRINGES))
    work = thumb_work(job, job.gate, size)  # N s
    seconds = _rounded(max(seconds, work / THUMB))
    return Filling(seconds, size, math.ceil(volume / size), work / seconds, brushed)


def front_time(job: Job) -> float:
    """Return the least time in which a front keeps its slope along the skin, s."""
    return filling_time(job.design)


def groove_time(job: Job) -> float:
    """Return the time in which the deepest groove fills through its narrowest passage, s."""
    flow, skin = pour(job), job.skin
    narrow = skin.profile.mean_width if flow is None else min(flow.beside, skin.profile.mean_width)
    head = job.silicone.density * GRAVITY * 1e-3 * job.design.skin.thickness
    return 6 * job.silicone.viscosity * (max(skin.heights) / narrow) ** 2 / head


def thumb_work(job: Job, gate: float, syringe: int) -> float:
    """Return the thumb's force times the time of filling, N s: it falls as the time grows."""
    return press(job.silicone.viscosity, poured_volume(job), gate, SYRINGES[syringe])


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
    cure = f"{material.cure_h:g} h" if material.cure_h else "by its data sheet"
    warm = f"room temperature ({USUAL_C:g} °C)" if material.cure_c is None else f"{material.cure_c:g} °C"
    return f"{cure} at {warm}"


def minutes_left(job: Job) -> float | None:
    """Return what is left of the pot life when the mold is full, min; None where it is not known."""
    pot = job.silicone.pot_life_min
    return None if pot is None else pot - STIR_MIN - DEGAS_MIN - filling(job).seconds / 60


def time_words(seconds: float) -> str:
    """Return s up to two minutes, then min."""
    return f"{seconds:.2g} s" if seconds < 120 else f"{seconds / 60:.2g} min"


def pouring_findings(job: Job) -> list[Finding]:
    """Return the rule `pot life`: that the mold is full before the mix thickens."""
    left, pot, findings = minutes_left(job), job.silicone.pot_life_min, list[Finding]()
    if left is not None and pot is not None and left < 0:
        remedy = "a thinner silicone or one with a longer pot life, a wider mold.gate, or a thicker skin"
        where = "stirring, degassing and filling"
        findings.append(warning("pot life", where, pot - left, pot, "min", remedy))
    return [*findings, *_between_layers(job)]


def _between_layers(job: Job) -> Iterator[Finding]:
    """Yield what keeps a layer from holding on the one in front of it: that one's pot life, where it is laid
    on wet, and a tin cure, which keeps platinum silicone from curing."""
    made = pours(job)
    for front, back in pairwise(made):
        needed = minutes_to_lay_on(job, front)
        pot = front.silicone.pot_life_min
        if back.bond == "wet" and pot is not None and needed > pot:
            where = f"shot {back.number}, laid wet on {front.silicone.name}"
            remedy = "a silicone with a longer pot life in front, or shot.bond = 'primer'"
            yield error("pot life", where, needed, pot, "min", remedy)
        if not front.silicone.platinum_cure and back.silicone.platinum_cure:
            where = f"shot {back.number}, {back.silicone.name}, poured on {front.silicone.name}"
            remedy = "a tin cure keeps a platinum silicone sticky; take silicones of one cure"
            yield error("cure inhibition", where, 1.0, 0.0, "", remedy)


def minutes_to_lay_on(job: Job, front: LayerPour) -> float:
    """Return when the next layer is on one that is still wet, min from when that was mixed: both are stirred,
    degassed and poured, one after the other."""
    first = filling(job).seconds if front.number == 0 else job.design.mold.fill_time
    return 2 * (STIR_MIN + DEGAS_MIN) + (first + job.design.mold.fill_time) / 60


def _rounded(seconds: float) -> float:
    """Two digits, upward, as a clock is read; 10 s at least."""
    seconds = max(seconds, 10.0)
    step = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.ceil(seconds / step - 1e-9) * step
