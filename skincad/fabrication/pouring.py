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
from dataclasses import dataclass

from skincad.fabrication.filling import void
from skincad.fabrication.job import Job
from skincad.fabrication.rules import Finding, warning
from skincad.fabrication.strips import pour
from skincad.inputs.silicone import Silicone
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

DEAD_VOLUME = 8.0  # g, assumption: stays in cup and syringe; less can't be weighed or degassed well
SCALE = 0.01  # g, assumption: what the scale shows
LEAST_PORTION = 0.5  # g, assumption: of A or B; the scale knows it to 2 %
LEAST_MIX = 2.0  # g, assumption: of both together; less is not stirred well
STIR_MIN = 3.0  # min, source: makers' data sheets
DEGAS_MIN, DEGAS_MBAR = 3.0, 50.0  # source: makers' data sheets, 2 to 3 min at 29 inHg of vacuum
USUAL_C, COLD_C = 23.0, 18.0  # C, source: data sheets state pot life at 23; assumption: a cool workshop
DOUBLING_K = 10.0  # K, assumption: by which a platinum cure gets twice as fast
LAG = 0.1  # assumption: of the skin's length, by which a groove's front may stay behind
MOST_MINUTES = 5.0  # assumption: longer than that nobody waits for a groove


def poured_volume(job: Job) -> float:
    """Return the volume that the silicone fills, mm3: skin, gate, vent and reservoir, the carrier's holes and
    their bleeds, and the flash in the gap round the carrier; for all skins of a gang, whose cover and seal
    are thicker than those of one."""
    spaces = void(job).spaces
    below = math.fsum(space.body.volume for space in spaces if space.beside is not PartRole.COVER)
    lids = job.closed.of(PartRole.COVER, PartRole.SEAL)
    over = [bore.volume for part in lids for bore in bores(part, CutRole.RESERVOIR, CutRole.BLEED)]
    return job.design.mold.cavities * below + math.fsum(over)


def batch(job: Job) -> float:
    """Return what is mixed for the pour, g: what fills the mold, and what stays in cup and syringe."""
    return poured_volume(job) * job.silicone.density * 1e-6 + DEAD_VOLUME


def small_batch(material: Silicone) -> float:
    """Return the least that is mixed, g: the smaller portion is still weighed to 2 %."""
    least = 0.0 if material.mix is None else LEAST_PORTION * sum(material.mix) / min(material.mix)
    return float(math.ceil(max(LEAST_MIX, least)))


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
    left, pot = minutes_left(job), job.silicone.pot_life_min
    if left is None or pot is None or left >= 0:
        return []
    remedy = "a thinner silicone or one with a longer pot life, a wider mold.gate, or a thicker skin"
    return [warning("pot life", "stirring, degassing and filling", pot - left, pot, "min", remedy)]


def _rounded(seconds: float) -> float:
    """Two digits, upward, as a clock is read; 10 s at least."""
    seconds = max(seconds, 10.0)
    step = 10.0 ** (math.floor(math.log10(seconds)) - 1)
    return math.ceil(seconds / step - 1e-9) * step
