"""The calibration kit: its parts, its sheet and its forms."""

from __future__ import annotations

from typing import Any

from skincad.base.errors import InputError, did_you_mean
from skincad.base.progress import Progress, Stopwatch
from skincad.base.reading import markdown_text
from skincad.base.result import Result, item, record, reported
from skincad.fabrication.pouring import DEAD_VOLUME, mixing
from skincad.inputs.catalog import Own, load_design
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.measurements import (
    CREST_COLUMNS,
    CREST_FORM,
    NOTCH_COLUMNS,
    NOTCH_FORM,
    PRESSED,
    STRETCHED,
    form,
)
from skincad.inputs.process import Process, processes
from skincad.inputs.silicone import Silicone, silicones
from skincad.solids.coupon import (
    BAR,
    BARS,
    END_LAND,
    HEIGHTS,
    NOTCH_LENGTH,
    REPEATS,
    coupon_parts,
    drawn_notches,
    drawn_steps,
    poured_volumes,
)
from skincad.solids.plan import Part

# of the pad, mm: assumptions. Three ridges, four times as large as those of plain-ridges, so that a nozzle of
# 0.4 mm draws them and a crest that is off by 0.05 mm matters little; level crests, which touch at once
PAD_SKIN = {"curvature_radius": 1000.0, "thickness": 6.0, "width": 16.0, "length": 24.0}
PAD_RIDGE = {
    "count": 3,
    "pitch": 4.0,
    "height": 2.0,
    "root_width": 3.0,
    "tip_width": 2.0,
    "crown": 0.12,
    "tip_fillet": 0.3,
    "root_fillet": 0.3,
}
SILICONE = "dragon-skin-20"  # assumption: in the middle of those that ship
BAR_FORM, PAD_FORM, PAD_DESIGN = "tensile.csv", "pad.csv", "pad.toml"
# mm; assumption: up to a strain of 0.3 for the modulus, in steps that a calliper tells, to 0.6 for the laws
EXTENSIONS = (*(0.5 * i for i in range(13)), *(6.0 + 0.75 * i for i in range(1, 9)))
APPROACHES = tuple(0.05 * i for i in range(1, 13))  # mm; the pad's model goes to 0.64 mm at 0.5 MPa
GAUGE_SHARE = 3  # assumption: a gauge that resolves a third of the scatter adds 0.5 % to it
FINEST_GAUGE = 0.001  # mm, of common gauges
PAD_RATE = 1.0  # mm/min, assumption: slow against the silicone's viscosity


@record()
class CouponKit(Result):
    """The parts of a coupon, the last one the mold of `pad`; `name` is that of the process."""

    shown_by = "skincad.outputs.measurements:KIT"
    name: str = item(meaning="of the process")
    pad: Design
    parts: tuple[Part, ...]
    seconds: dict[str, float] = item(meaning="wall time by stage, s", compare=False)

    @reported(meaning="that it was made")
    def passed(self) -> bool:
        """Whether it was made: a coupon that cannot be is refused."""
        return True

    @reported(meaning="what is cast", key="silicone")
    def _silicone(self) -> str:
        return self.silicone.name

    @reported(meaning="what is made, in mm3", key="parts")
    def _parts(self) -> list[dict[str, Any]]:
        return [{"name": part.name, "volume_mm3": part.volume} for part in self.parts]

    @property
    def process(self) -> Process:
        """What makes the parts."""
        return processes(self.pad.printer)[self.name]

    @property
    def silicone(self) -> Silicone:
        """What is cast in the molds."""
        return silicone(self.pad)

    @reported("mm", "width of each as drawn")
    def notches(self) -> tuple[float, ...]:
        """Width of each notch as drawn, mm; none where the tool passes too few."""
        return drawn_notches(self.process)

    @reported(meaning="what each mold takes of the silicone, g", key="poured_g")
    def grams(self) -> dict[str, float]:
        """What each mold takes of the silicone, g, by the mold's name."""
        density = self.silicone.density * 1e-6
        return {name: volume * density for name, volume in poured_volumes(self.parts).items()}


def coupon(
    process: str,
    silicone: str = SILICONE,
    *,
    printer: Own | None = None,
    silicones: Own | None = None,
    progress: Progress | None = None,
) -> CouponKit:
    """Return the coupon of a process that ships or is one of `printer`'s, to be cast in this silicone.

    Raises InputError for names that nobody knows.
    """
    clock = Stopwatch(progress)
    with clock.stage("plan"):
        pad = _pad(process, silicone, printer, silicones)
        parts = coupon_parts(processes(pad.printer)[process], pad)
    return CouponKit(name=process, pad=pad, parts=parts, seconds=clock.seconds())


def _pad(process: str, silicone: str, printer: Own | None, lab_tables: Own | None) -> Design:
    """The design of the pad, which carries the workshop's own tables with it."""
    base = load_design("plain-ridges", printer=printer, silicones=lab_tables)
    for key, name, known in (
        ("process", process, processes(base.printer)),
        ("silicone", silicone, silicones(base.silicones)),
    ):
        if name not in known:
            raise InputError(key, f"unknown {key}", name, did_you_mean(name, known))
    return base.with_(
        name="coupon-pad",
        skin=PAD_SKIN,
        ridge=PAD_RIDGE,
        material={"name": silicone},
        mold={"process": process},
    )


def coupon_forms(kit: CouponKit) -> dict[str, str]:
    """Return the forms by their names, as CSV; that of the notches only where there are any."""
    notches = [(str(i), f"{width:.2f}", "", "") for i, width in enumerate(kit.notches, 1)]
    steps = [(str(i), f"{height:.2f}", "") for i, height in enumerate(drawn_steps(), 1)]
    blades = ["goes_mm: the thickest blade that goes in by its own weight, 0 for none", "stops_mm: the next"]
    bars = [
        f"{fit_bar_command(BAR_FORM)}",
        f"area: {BAR.width:g} mm times {BAR.thickness:g} mm as drawn; give what you measured",
    ]
    pads = [fit_pad_command(PAD_FORM, PAD_DESIGN)]
    return {
        **({NOTCH_FORM: form(NOTCH_COLUMNS, notches, blades)} if notches else {}),
        CREST_FORM: form(CREST_COLUMNS, steps, ["measured_mm: height of the step's top over the land"]),
        BAR_FORM: form(STRETCHED, [(f"{e:g}", "") for e in EXTENSIONS], bars),
        PAD_FORM: form(PRESSED, [(f"{a:.2f}", "") for a in APPROACHES], pads),
    }


def fit_bar_command(file: str) -> str:
    """Return the command that reads a bar's form."""
    return f"skincad fit-material {file} --gauge-length {BAR.gauge_length:g} --area {BAR.area:g}"


def fit_pad_command(file: str, design: str) -> str:
    """Return the command that reads a pad's form."""
    return f"skincad fit-material {file} --design {design}"


def read_command(kit: CouponKit) -> str:
    """Return the command that reads the forms back."""
    option = " --printer FILE" if kit.pad.printer else ""
    return f"skincad coupon {kit.name}{option} --measured DIR"


def coupon_sheet(kit: CouponKit) -> str:
    """Return the sheet as Markdown."""
    lines = [
        f"# Coupon sheet: {kit.name}, {markdown_text(kit.silicone.name)}",
        "",
        "Make these parts once on your own machine, and measure them. What they say replaces the assumptions "
        "about the process and the silicone. Repeat it after a change of machine, resin, exposure or batch.",
        "",
        *_make(kit),
        *(_notches() if kit.notches else _no_notches(kit)),
        *_steps(kit.process),
        *_cast(kit),
        *_bar(),
        *_pad_section(),
        *_read(kit),
    ]
    return "\n".join(lines)


def _section(title: str, *paragraphs: str, steps: tuple[str, ...] = ()) -> list[str]:
    """A section of the sheet: its paragraphs, then its steps, numbered."""
    numbered = "\n".join(f"{i}. {step}" for i, step in enumerate(steps, 1))
    return [line for text in (f"## {title}", *paragraphs, numbered) if text for line in (text, "")]


def _make(kit: CouponKit) -> list[str]:
    rows = [f"| {part.name} | {part.volume / 1000:.4g} |" for part in kit.parts]
    place = ""
    if kit.process.layer:
        ladder = ", the ladder on its face as combs are," if kit.notches else ""
        place = f" Print them the way up that they have in coupon.3mf{ladder} in one run or in several."
    return _section(
        "Make the parts",
        "\n".join(["| part | cm³ |", "|---|---|", *rows]),
        f"Make them by {kit.name}, with the settings and the cleaning that molds get.{place} Do not sand, "
        "lap or file what will be measured.",
        "To have at hand: feeler gauges in steps of 0.01 mm (blades may be laid together), a dial gauge on a "
        "stand with a flat plate, or a microscope, a calliper, a straight edge, a scale to 0.01 g, and what "
        "pulls and presses: a testing machine, or weights and the dial gauge.",
    )


def _notches() -> list[str]:
    return _section(
        f"Notches: fill in {NOTCH_FORM}",
        steps=(
            "Hold the ladder with its notches up and the cut-off corner at the lower left. Notch 1, the "
            "narrowest, is above that corner. The nicks in the lower edge are under notches 5 and 10.",
            f"A blade goes in if it reaches the bottom along all {NOTCH_LENGTH:g} mm of the notch under its "
            "own weight. Do not push.",
            "For each notch write the thickest blade that goes in (goes_mm), and the next thicker one, which "
            "does not (stops_mm). Where none goes in: 0, and your thinnest blade.",
        ),
    )


def _no_notches(kit: CouponKit) -> list[str]:
    widest = 2 * kit.process.reach
    return _section(
        "Notches",
        f"None: the tool of {kit.name} cuts nothing narrower than {widest:g} mm. Combs need another process.",
    )


def _steps(process: Process) -> list[str]:
    resolved = max(process.crest_sigma / GAUGE_SHARE, FINEST_GAUGE)
    return _section(
        f"Steps: fill in {CREST_FORM}",
        f"There are {len(HEIGHTS)} heights from {HEIGHTS[0]:g} to {HEIGHTS[-1]:g} mm, each {REPEATS} times, "
        "not in order.",
        steps=(
            "Lay the block on a flat plate, steps up, the cut-off corner at the lower left: step 1 is there. "
            "The nicks in the lower edge are under steps 5, 10, 15 and 20.",
            f"Zero the dial gauge on the land at the left end, {END_LAND:g} mm long. The land at the right "
            "end should read 0 within 0.02 mm; if not, clean the plate and the block's foot.",
            "Read the top of each step in the middle of its length, and write it down (measured_mm). A gauge "
            f"that resolves {resolved:.2g} mm is fine enough; a microscope that focuses on top and land will "
            "do.",
        ),
    )


def _cast(kit: CouponKit) -> list[str]:
    material, grams_by_part = kit.silicone, kit.grams
    parts, times = mixing(material, sum(grams_by_part.values()) + DEAD_VOLUME)
    sealed = ""
    if kit.process.inhibits_platinum and material.platinum_cure:
        sealed = (
            f" Parts by {kit.name} may keep this silicone from curing: wash, cure and bake the molds first, "
            "and cast a trial drop on a plate of the same resin. Castings that stay sticky say nothing."
        )
    return _section(
        "Cast bars and pad",
        f"{markdown_text(material.name)}: "
        + ", ".join(f"{grams:.3g} g for {name}" for name, grams in grams_by_part.items())
        + ". "
        f"With {DEAD_VOLUME:g} g more for the cup: {parts}. {times}",
        steps=(
            f"Clean and dry both molds, put release agent on them and wipe it thin.{sealed}",
            "Mix, and degas the mix in its cup. Set both molds level, the open side up.",
            "Pour in a thin stream from one end until the silicone stands a little above the rim. Pierce "
            "bubbles.",
            "Lay the straight edge on the rim and draw it across once, slowly, along bars and ridges, so "
            "that the silicone is level with the rim.",
            "Let it cure in full. Lift a corner and peel the castings out. Wait 16 h before a test (ISO 37).",
        ),
    )


def _bar() -> list[str]:
    return _section(
        f"Bars: fill in {BAR_FORM}",
        f"The mold gives {BARS} bars of ISO 37, type 2. Test the best one; copy the form for the others.",
        steps=(
            "Measure width and thickness of the narrow part in three places, as drawn "
            f"{BAR.width:g} and {BAR.thickness:g} mm. Their product is the area.",
            f"Draw two fine lines {BAR.gauge_length:g} mm apart on the narrow part, in its middle.",
            "Clamp the wide ends and tare the force. Stretch twice to the form's last row and back.",
            "Stretch slowly. At each extension of the form, which is how far the two lines (not the clamps) "
            "have moved apart, write the force (force_N). With weights write both columns, the larger "
            "weights further down; 100 g are 0.981 N. Stop before it tears, and remove the rows that are "
            "left.",
        ),
    )


def _pad_section() -> list[str]:
    return _section(
        f"Pad: fill in {PAD_FORM}",
        steps=(
            "Glue the pad's flat back to a stiff plate, thinly. Powder its ridges, so that they slide.",
            "Bring a flat plate, parallel to the back, down until the first force shows. That is approach 0; "
            "the fit finds where it is exactly.",
            f"Press at {PAD_RATE:g} mm/min or slower. At each approach of the form write the force "
            "(force_N).",
        ),
    )


def _read(kit: CouponKit) -> list[str]:
    return _section(
        "Read it back",
        "Save the forms where they are, as CSV, and remove a form of notches or steps that you did not "
        "measure. Then, with the folder of the forms for DIR:",
        f"    {read_command(kit)}",
        "It writes printer.toml, to be given to --printer, and prints what it found and the two lines that "
        "read the bar and the pad.",
    )
