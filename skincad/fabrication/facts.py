"""Facts of a job for its papers: each number and each choice that a text depends on, in one place.

Texts are templates/papers: they have the words, and ask here what holds for a design. Lengths are mm, masses
g, times as their names say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

from skincad.fabrication.day_plan import (
    BAKING_C,
    BAKING_H,
    BATH_MIN,
    BATHS,
    BEGIN,
    DRYING_MIN,
    END,
    GLUE_MIN,
    LIGHT_MIN,
    PRIMER_H,
    PRIMER_MIN,
    Entry,
    day_plan,
)
from skincad.fabrication.electrodes import Capacitance, FanOut, fan_out, past_tabs, strip_capacitance, tab
from skincad.fabrication.fasteners import (
    PINNED,
    THREADED,
    CarrierMount,
    is_pressed,
    mount_of,
    thread,
)
from skincad.fabrication.filling import perforated
from skincad.fabrication.job import Job
from skincad.fabrication.papers import listed
from skincad.fabrication.part_drawing import process_words
from skincad.fabrication.patterns import GLUED_LENGTH
from skincad.fabrication.pouring import (
    COLD_C,
    DEAD_VOLUME,
    DEGAS_MBAR,
    DEGAS_MIN,
    DOUBLING_K,
    LAG,
    SCALE,
    STIR_MIN,
    USUAL_C,
    Filling,
    LayerPour,
    filling,
    groove_time,
    layer_name,
    minutes_left,
    minutes_to_lay_on,
    poured_volume,
    pours,
    small_batch,
    time_words,
    weights,
)
from skincad.fabrication.printing import lapping_words, print_plates, print_settings
from skincad.fabrication.rules import Finding, coating
from skincad.fabrication.shopping import PRIMER, to_buy
from skincad.fabrication.strips import (
    BOND_STRENGTH,
    HIGHEST_FILM_TEMPERATURE,
    POT_SHARE,
    Lap,
    Pour,
    Pull,
    Strip,
    deflection,
    drawing_time,
    lap,
    placement_error,
    pour,
    pull_test,
    release_strain,
    strip,
    strip_count,
    strip_seconds,
    strips_per_mix,
    weight,
)
from skincad.inputs.catalog import display_name
from skincad.inputs.skin_tables import Film
from skincad.solids.bone import Bone, bone_of, pinned
from skincad.solids.cavity import parts_at_tips, split_ridges
from skincad.solids.gate import GRAVITY
from skincad.solids.inserts import GRIP, PITCH, drawing_end
from skincad.solids.layout import end_angle
from skincad.solids.plan import END_PLATES, Bore, CutRole, Part, PartRole, bores

RIVET_STRAIN = 0.5  # assumption: of a rivet's neck under the test, well below what breaks silicone
BOND_SHARE = 1 / 3  # assumption: of the least bond worth having, on a primed back


class MadePart(NamedTuple):
    """A made part: its name, how it is made, its volume, cm3."""

    name: str
    by: str
    cm3: float


class PrintFacts(NamedTuple):
    """Prints by one process: the slicer's settings, and the plates in words."""

    process: str
    settings: str
    plates: str


class ThreadFacts(NamedTuple):
    """A thread: its name, how its insert is set, "" where it is tapped, how deep, "" where that is all of its
    hole, and its parts."""

    name: str
    how: str
    deep: str
    parts: list[str]


class Portion(NamedTuple):
    """A portion to be weighed."""

    name: str
    grams: float


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
class Facts:
    """Facts of a job; `findings` are its mold's."""

    job: Job
    findings: tuple[Finding, ...] = ()

    # constants of the trade, as the texts name them
    baths, bath_min, drying_min, light_min = BATHS, BATH_MIN, DRYING_MIN, LIGHT_MIN
    baking_h, baking_c = BAKING_H, BAKING_C
    primer, primer_min, primer_h, glue_min, glued = PRIMER, PRIMER_MIN, PRIMER_H, GLUE_MIN, GLUED_LENGTH
    usual_c, cold_c, slower = USUAL_C, COLD_C, 2 ** ((USUAL_C - COLD_C) / DOUBLING_K)
    scale, stir_min, degas_min, degas_mbar, dead_g = SCALE, STIR_MIN, DEGAS_MIN, DEGAS_MBAR, DEAD_VOLUME
    film_hot_c, grip_mm, pitch, begin, end = HIGHEST_FILM_TEMPERATURE, GRIP, PITCH, BEGIN, END
    towards = "towards the higher numbers in every slot"  # +x

    def __getattr__(self, name: str) -> Any:
        """What the job itself knows by this name: bent, gate, inserts, clamped, lead, shrinkage."""
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self.job, name)

    @property
    def title(self) -> str:
        """The design's name."""
        return display_name(self.job.design)

    @property
    def revision(self) -> str:
        """The design's revision."""
        return self.job.design.revision

    @property
    def film(self) -> Film | None:
        """The film, if there is one."""
        return self.job.design.film

    @property
    def film_um(self) -> float:
        """The film's thickness, um; 0 without one."""
        return 1000 * self.film.thickness if self.film else 0.0

    @property
    def slot(self) -> bool:
        """Whether ridges have slots."""
        return self.job.skin.slot is not None

    @property
    def family(self) -> str:
        """The family of the skin's features."""
        return self.job.skin.family

    @cached_property
    def ends(self) -> bool:
        """Whether end plates close the cavity."""
        return bool(self.job.closed.of(*END_PLATES))

    @cached_property
    def disc(self) -> bool:
        """Whether the cavity is a disc in a block."""
        return bool(self.job.closed.of(PartRole.BLOCK))

    @property
    def blind(self) -> bool:
        """Whether the cavity has blind holes, pins', which a rising front would leave full of air."""
        return self.job.skin.symmetry == "revolved" and not self.tips

    @property
    def tips(self) -> bool:
        """Whether a base of cups closes pins' through holes."""
        return parts_at_tips(self.job.cast)

    @property
    def cores(self) -> int:
        """How many core pins keep pockets free."""
        return len(self.job.closed.of(PartRole.CORE_PIN)) - len(self.bone_pins)

    @cached_property
    def bone(self) -> Bone | None:
        """What the skin is cast on; None where that is its carrier."""
        return bone_of(self.job.cast)

    @property
    def holder(self) -> str:
        """What stays on the skin."""
        return "bone" if self.bone else "carrier"

    @property
    def bone_primed(self) -> bool:
        """Whether a primer bonds silicone to the bone."""
        return self.job.design.mold.bone_bond != "rivets"

    @cached_property
    def bone_pins(self) -> list[Bore]:
        """The rods on which a bone stands under the carrier."""
        return pinned(self.job.cast)

    @property
    def bone_pin(self) -> float:
        """Their diameter, mm."""
        return 2 * self.bone_pins[0].radius

    @property
    def core_diameter(self) -> float:
        """Their diameter, mm."""
        return 2 * self._core.radius

    @property
    def core_depth(self) -> float:
        """How far they stand out of the carrier, mm."""
        return -self._core.start[2]

    @property
    def _core(self) -> Bore:
        body = self.job.closed.first(PartRole.CORE_PIN).body
        if not isinstance(body, Bore):
            raise ValueError("a core pin is a rod")
        return body

    @property
    def by_shim(self) -> bool:
        """Whether slots are kept free by shims, if there are slots."""
        return self.job.design.mold.method == "shim"

    @property
    def cast_in(self) -> bool:
        """Whether strips are cast in."""
        return not self.by_shim

    @property
    def shims(self) -> bool:
        """Whether shims lie in the mold."""
        return self.slot and self.by_shim

    @property
    def insert(self) -> str:
        """What lies in a notch."""
        return "shim" if self.by_shim else "strip"

    @cached_property
    def lap(self) -> Lap | None:
        """The lap by which films are drawn in; None where none is."""
        return lap(self.job)

    @cached_property
    def seal(self) -> bool:
        """Whether foam seals the cover."""
        return bool(self.job.closed.of(PartRole.SEAL))

    @cached_property
    def riveted(self) -> bool:
        """Whether rivets of silicone hold the skin on its carrier."""
        return perforated(self.job.closed)

    @property
    def back(self) -> str:
        """What holds the skin on its carrier, in brackets."""
        if self.bone:
            return "the bone in it, and release agent on its lower face"
        return (
            "its holes widen upward and hold the skin like rivets" if self.riveted else "its primed face down"
        )

    @property
    def fasteners(self) -> str:
        """What holds the cover down."""
        return "clamps" if self.job.clamped else "bolts"

    @property
    def split(self) -> bool:
        """Whether the cavity is in pieces."""
        return bool(split_ridges(self.job.design))

    @property
    def tilt(self) -> float:
        """By how much end b is raised, deg."""
        return self.job.design.mold.pour_tilt

    @property
    def rise(self) -> float:
        """By how much the ends of a doubly curved mold lean, deg."""
        return math.degrees(end_angle(self.job.design))

    # parts

    @cached_property
    def parts_made(self) -> list[Part]:
        """The parts that are made."""
        return self.job.closed.made

    @property
    def made(self) -> list[MadePart]:
        """The parts that are made, for a table."""
        return [MadePart(p.name, process_words(self.job, p), p.volume / 1000) for p in self.parts_made]

    @property
    def bought(self) -> list[str]:
        """What is bought, as lines."""
        return to_buy(self.job)

    @property
    def prints(self) -> list[PrintFacts]:
        """How parts are printed, by process."""
        plates: dict[str, list[str]] = {}
        for plate in print_plates(self.job):
            parts = ", ".join(spot.name for spot in plate.spots)
            plates.setdefault(plate.process, []).append(f"{plate.file}: {parts}")
        return [
            PrintFacts(name, print_settings(self.job.processes[name], self.supported(name)), "; ".join(on))
            for name, on in plates.items()
        ]

    def supported(self, name: str) -> bool:
        """Whether parts by a process need supports."""
        return any(f.rule == "overhang" and f.where.endswith(f"by {name}") for f in self.findings)

    @property
    def printed(self) -> list[str]:
        """Which parts of the mold are printed, by what they are called."""
        job, ends = self.job, {"end plates": self.job.end_process} if self.ends else {}
        made = {"cavity": job.cavity_process, **ends, "cover": job.lid_process}
        made |= {"plugs": job.lid_process} if job.closed.plugs else {}
        return [name for name, process in made.items() if process.layer]

    @property
    def resin_or_filament(self) -> bool:
        """Whether any part is printed."""
        return any(self.job.process(part).layer for part in self.parts_made)

    @property
    def skin_cm3(self) -> float:
        """Volume of the cured skin."""
        return self.job.skin_part.volume / 1000

    @property
    def cavity_cm3(self) -> float:
        """Volume of what is poured for it."""
        return self.job.closed.first(PartRole.SKIN).volume / 1000

    @property
    def comb_printer(self) -> str:
        """The process that prints the combs; "" where none does."""
        combs = self.job.closed.of(PartRole.COMB)
        return self.job.maker(combs[0]) if combs and self.job.process(combs[0]).layer else ""

    @property
    def notch(self) -> float:
        """Width of a comb's notch."""
        return self.job.design.core_thickness + 2 * self.job.design.mold.slit_clearance

    @property
    def sealed(self) -> str:
        """Which parts are washed, cured and baked for the silicone's sake; "" where none."""
        if not self.job.silicone.platinum_cure:
            return ""
        names = [part.name for part in self.parts_made if self.job.process(part).inhibits_platinum]
        return "all parts" if len(names) == len(self.parts_made) else listed(names) if names else ""

    @property
    def coats(self) -> list[float]:
        """Thicknesses of the coats that seal them."""
        return sorted({coating(self.job, self.job.process(part)) for part in self.parts_made} - {0.0})

    @property
    def lapping(self) -> str:
        """How printed joints are made flat."""
        return lapping_words(self.job)

    @property
    def threads(self) -> list[ThreadFacts]:
        """Threads by what brings them."""
        where: dict[str, list[str]] = {}
        for part in self.parts_made:
            for role in sorted(THREADED, key=lambda role: role.name):
                if bores(part, role):
                    names = where.setdefault(thread(self.job, part, role), [])
                    names += [part.name] * (part.name not in names)
        rows = []
        for what, names in where.items():
            kind, _, how = what.partition(" insert, ")
            name, _, deep = what.partition(" x ")
            rows.append(ThreadFacts(kind if how else name, how, "" if how else deep, names))
        return rows

    @property
    def press_fits(self) -> list[str]:
        """Parts into which dowels are pressed."""
        roles = sorted(PINNED, key=lambda role: role.name)
        return [p.name for p in self.parts_made if any(is_pressed(p, r) and bores(p, r) for r in roles)]

    @cached_property
    def mount(self) -> CarrierMount | None:
        """The carrier's mount, if there is one."""
        return mount_of(self.job)

    @property
    def mount_holes(self) -> str:
        """What a mount has."""
        if self.mount is None or not self.mount.positions:
            return "fiducials"
        return "threads and fiducials" if self.mount.fiducials else "threads"

    @property
    def over(self) -> str:
        """What lies over the carrier."""
        return "foam" if self.seal else "cover"

    @property
    def agent_on(self) -> list[str]:
        """Where release agent goes."""
        names = [*self.printed, *(["the carrier's lower face and window"] if self.bone else [])]
        return [*names, "shims"] if self.shims and not self.film else names

    @property
    def grip(self) -> str:
        """How the skin is lifted out."""
        carrier = self.job.closed.first(PartRole.CARRIER)
        if bores(carrier, CutRole.PULL):
            return "by two M3 screws in its blind holes"
        mounted = bores(carrier, CutRole.MOUNT)
        return "by two screws in its mount's threads" if mounted else "from its two ends"

    @property
    def pull_off(self) -> float:
        """The pull, N, that shows that the carrier holds the skin: on rivets' necks or a primed face."""
        if self.bone is not None and self.bone_primed:
            return BOND_SHARE * BOND_STRENGTH * float(self.bone.shadow(2, 0.0).area)
        necks = bores(self.job.closed.first(PartRole.CARRIER), CutRole.RIVET)
        if self.bone is not None:
            necks = list(self.bone.rivets)
        if necks:
            area = math.fsum(math.pi * bore.radius**2 for bore in necks)
            return area * self.job.silicone.young_modulus.value * RIVET_STRAIN
        skin = self.job.design.skin
        bond = BOND_SHARE * BOND_STRENGTH * self.job.design.mold.cavities
        return bond * skin.width * skin.length * (math.pi / 4 if skin.round else 1)

    @property
    def pull_off_g(self) -> float:
        """The mass that pulls so."""
        return 1000 * self.pull_off / GRAVITY

    # silicone

    @cached_property
    def pours(self) -> list[LayerPour]:
        """The pours in their order; one, unless the skin is cast in layers."""
        return pours(self.job)

    @property
    def first_cored(self) -> str:
        """In what core pins stand first: a plug that has holes for them, or the carrier."""
        return next((of.plug for of in self.pours if of.cored), "the carrier")

    def next_holder(self, of: LayerPour) -> str:
        """In what core pins stand after the plug of a pour."""
        later = self.pours[self.pours.index(of) + 1 :]
        return next((other.plug for other in later if other.cored), "the carrier")

    @property
    def last(self) -> LayerPour:
        """The last, over which the carrier goes."""
        return self.pours[-1]

    @property
    def plugs(self) -> list[str]:
        """The plugs, by name."""
        return [part.name for part in self.job.closed.plugs]

    @property
    def layered(self) -> bool:
        """Whether the skin is cast in layers."""
        return len(self.pours) > 1

    def layer(self, of: LayerPour) -> str:
        """What a pour is called."""
        return layer_name(of)

    def next_within(self, of: LayerPour) -> float:
        """When the layer behind a wet one is on it, min from when that was mixed."""
        return minutes_to_lay_on(self.job, of)

    @property
    def silicone(self) -> str:
        """Its name."""
        return self.job.silicone.name

    @property
    def density(self) -> float:
        """Its density, kg/m3."""
        return self.job.silicone.density

    @property
    def pot_min(self) -> float | None:
        """Its pot life."""
        return self.job.silicone.pot_life_min

    @property
    def cure(self) -> str:
        """How long it cures, and how warm."""
        return self.last.cure

    @property
    def mold_cm3(self) -> float:
        """What the mold takes."""
        return poured_volume(self.job) / 1000

    @property
    def mold_g(self) -> float:
        """The same by mass."""
        return poured_volume(self.job) * self.density * 1e-6

    @property
    def batch_weights(self) -> str:
        """What is weighed for the pour."""
        return self.last.weights

    @property
    def portions(self) -> list[Portion]:
        """The same, one by one."""
        found = list[Portion]()
        for each in self.pours:
            of, mix = f" of {self.layer(each)}" if self.layered else "", each.silicone.mix
            if not mix:
                found.append(Portion(f"mixed{of}", each.batch))
            else:
                shares = zip("AB", mix, strict=True)
                found += [Portion(f"{n}{of}, g", each.batch * part / sum(mix)) for n, part in shares]
        return found

    @cached_property
    def filling(self) -> Filling:
        """How the mold is filled."""
        return filling(self.job)

    @property
    def fill_words(self) -> str:
        """In which time."""
        return time_words(self.filling.seconds)

    @property
    def groove_min(self) -> float:
        """How long a groove takes to fill by itself."""
        return groove_time(self.job) / LAG / 60

    @property
    def minutes_left(self) -> float | None:
        """What is left of the pot life when the mold is full."""
        left = minutes_left(self.job)
        return None if left is None else max(left, 0.0)

    @cached_property
    def flow(self) -> Pour | None:
        """How strips give way to it."""
        return pour(self.job)

    @property
    def drift(self) -> float:
        """By how much strips that are cast in give way: as the front's speed, so by less than in
        `mold.fill_time` where filling takes longer; 0 where none is cast in."""
        if self.flow is None or self.job.inserts != "strips":
            return 0.0
        return self.flow.drift * self.job.design.mold.fill_time / self.filling.seconds

    @property
    def settling(self) -> float:
        """Within how many s they come back."""
        return 5 * self.flow.settling if self.flow else 0.0

    @property
    def post_cure(self) -> PostCure | None:
        """A post-cure; None where film is in the mold, which would lose its charge."""
        return None if self.film and not self.lap else POST_CURE

    # strips

    @property
    def strips(self) -> int:
        """How many there are."""
        return strip_count(self.job)

    @cached_property
    def rod(self) -> Strip | None:
        """A strip or shim as a beam; None without slots."""
        return strip(self.job)

    @property
    def sag(self) -> float:
        """By how much a strip sags in silicone."""
        rod = self.rod
        return abs(deflection(rod, weight(rod, self.density))) if rod else 0.0

    @property
    def placement(self) -> float:
        """Within which a strip is in its place."""
        return placement_error(self.job)

    @property
    def masked(self) -> float:
        """How much of lead and tab is masked while a strip is drawn in: no mask passes a notch."""
        if self.film is None:
            return 0.0
        lead, plate = self.job.lead, self.job.design.mold.end_plate
        return tab(self.film)[1] + (max(0.0, lead - plate) if self.job.bent else lead)

    @property
    def shims_end(self) -> str:
        """The end towards which shims are drawn."""
        return drawing_end(self.job.design)

    @property
    def other_end(self) -> str:
        """The other end."""
        return "b" if self.shims_end == "a" else "a"

    @property
    def way_out(self) -> str:
        """How shims leave."""
        return f"{'along its arc' if self.job.bent else 'along the ridges'}, towards end {self.shims_end}"

    @property
    def small_g(self) -> float:
        """What is mixed to draw strips in."""
        return small_batch(self.job.silicone)

    @property
    def small_weights(self) -> str:
        """What is weighed for it."""
        return weights(self.job.silicone, self.small_g)

    @property
    def strip_s(self) -> float:
        """How long a strip takes."""
        return strip_seconds(self.job)

    @property
    def drawing_s(self) -> float:
        """How long it is drawn in."""
        return drawing_time(self.job)

    @property
    def strips_per_mix(self) -> int | None:
        """How many are drawn in with one mix; None where its pot life isn't known."""
        return strips_per_mix(self.job)

    @property
    def mixes(self) -> int:
        """How many mixes that takes."""
        most = self.strips_per_mix
        return 1 if most is None else math.ceil(self.strips / max(most, 1))

    @property
    def fresh_min(self) -> float:
        """How long a mix wets."""
        return POT_SHARE * (self.pot_min or 0.0)

    @property
    def film_cure(self) -> str:
        """How strips cure in."""
        material = self.job.silicone
        long = "as long as its data sheet asks" if material.cure_h is None else f"{material.cure_h:g} h"
        warm = "room temperature" if material.cure_c is None else f"{material.cure_c:g} °C"
        if material.cure_c is not None and material.cure_c > HIGHEST_FILM_TEMPERATURE:
            long, warm = "as long as its data sheet asks", f"{HIGHEST_FILM_TEMPERATURE:g} °C or less"
        return f"{long} at {warm}"

    @property
    def release_strain(self) -> float:
        """By which the skin shortens as strips are let go."""
        return release_strain(self.job)

    @property
    def past_tabs(self) -> str:
        """How end plates get past tabs."""
        return past_tabs(self.job.design)

    @cached_property
    def pull(self) -> Pull | None:
        """The test that a strip holds; None without film."""
        return pull_test(self.job)

    @property
    def pull_g(self) -> float:
        """The mass that it takes."""
        return 1000 * self.pull.force / GRAVITY if self.pull else 0.0

    @cached_property
    def pf(self) -> Capacitance:
        """What a capacitance meter reads."""
        return strip_capacitance(self.job)

    @cached_property
    def fan(self) -> FanOut | None:
        """How tabs come to a board; None without film."""
        return fan_out(self.job)

    @property
    def first_strip(self) -> str:
        """The first of them."""
        return f"{self.fan.strips[0].feature} {self.fan.strips[0].side}" if self.fan else ""

    @property
    def last_strip(self) -> str:
        """And the last."""
        return f"{self.fan.strips[-1].feature} {self.fan.strips[-1].side}" if self.fan else ""

    @property
    def days(self) -> list[Entry]:
        """The day plan."""
        return day_plan(self.job)
