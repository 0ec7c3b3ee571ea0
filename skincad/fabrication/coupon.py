"""The calibration kit: its parts, its sheet and its forms, and what the filled-in forms say of a machine.

Properties of a process from a measured coupon: growth, narrowest gap, scatter and offset of crests. Each
number has the half-width of its 95 % interval.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import tomlkit
from numpy.typing import NDArray
from scipy.special import ndtr
from scipy.stats import chi2, t

from skincad.base.arrays import Array
from skincad.base.errors import InputError, did_you_mean
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress, Stopwatch
from skincad.base.reading import text_of
from skincad.base.result import Result, item, record, reported, reported_from
from skincad.fabrication import pouring
from skincad.fabrication.papers import paper
from skincad.inputs import measurements as forms
from skincad.inputs.catalog import LARGEST_FILE, Own, load_design
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.measurements import (
    CREST_COLUMNS,
    CREST_FORM,
    NOTCH_COLUMNS,
    NOTCH_FORM,
    PRESSED,
    STRETCHED,
    CrestForm,
    NotchForm,
    form,
    read_crests,
    read_notches,
)
from skincad.inputs.process import Process, processes
from skincad.inputs.silicone import Silicone, silicones
from skincad.solids import coupon as solids
from skincad.solids.coupon import BAR, coupon_parts, drawn_notches, drawn_steps, poured_volumes
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
CONFIDENCE = 0.95
SCATTERS = np.geomspace(0.001, 0.05, 24)  # mm, of one notch's width; assumption: no process is outside
LOSS_RANGE, LOSS_STEP = 0.15, 0.0005  # mm, of the losses of width that are weighed, about a first guess
FEWEST_OPEN = 3  # notches; assumption: fewer leave growth and scatter unknown
# mm, by which a notch is wider or narrower than the blade that just slides in it; assumption: half of a
# blade's own tolerance. The same for all notches, so that their number does not lessen it
BLADE_TOLERANCE = 0.002
LEAST_LIKELIHOOD = 1e-300  # a likelihood


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

    _silicone = reported_from("silicone.name", meaning="what is cast", key="silicone")

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
    """Return the sheet as Markdown. Its words are templates/papers/coupon-sheet.md."""
    return paper(
        "coupon-sheet.md",
        kit=kit,
        process=kit.process,
        material=kit.silicone,
        drawn=solids,
        forms=forms,
        BAR_FORM=BAR_FORM,
        PAD_FORM=PAD_FORM,
        PAD_RATE=PAD_RATE,
        pouring=pouring,
        resolved=max(kit.process.crest_sigma / GAUGE_SHARE, FINEST_GAUGE),
        command=read_command(kit),
    )


class NotchResult(NamedTuple):
    """What a ladder says, mm: material's growth a side, one notch's scatter, the narrowest gap that works.

    Growth is None where too few notches are open, the gap where none is. `worst` is a side's largest error.
    """

    growth: Estimate | None
    scatter: float
    gap: Estimate | None
    worst: float


@dataclass(frozen=True)
class CrestResult:
    """What steps say, mm: a crest's standard deviation, how much all are too high, and the largest error."""

    sigma: Estimate
    offset: Estimate
    worst: float


def notch_result(form: NotchForm) -> NotchResult:
    """Return growth, scatter and narrowest gap by the blades that go into the notches or stop."""
    open_ = form.goes > 0
    middle = (form.goes + form.stops) / 2
    sides = np.abs(form.drawn - middle)[open_] / 2
    worst, gap = float(sides.max(initial=0.0)), _gap(form)
    if np.count_nonzero(open_) < FEWEST_OPEN:
        return NotchResult(None, 0.0, gap, worst)
    lost, half, scatter = _loss(form, float(np.median((form.drawn - middle)[open_])))
    return NotchResult(Estimate(lost / 2, (half + BLADE_TOLERANCE) / 2, "mm"), scatter, gap, worst)


def _loss(form: NotchForm, guess: float) -> tuple[float, float, float]:
    """How much narrower than drawn notches are, its half-width, and their scatter: means of the posterior.

    A notch is as wide as drawn, less the loss, plus its own normal error; a blade says between which two
    thicknesses it lies, and no blade at all says below which. Loss and the logarithm of the scatter have flat
    priors. Censored observations in a likelihood: Gelman et al., Bayesian Data Analysis, 3rd ed. 2013, 8.1.
    """
    losses = np.arange(guess - LOSS_RANGE, guess + LOSS_RANGE, LOSS_STEP)
    low = np.where(form.goes > 0, form.goes, -np.inf) - form.drawn
    high = form.stops - form.drawn
    width = SCATTERS[:, None, None]
    inside = ndtr((high + losses[:, None]) / width) - ndtr((low + losses[:, None]) / width)
    logs = np.log(np.maximum(inside, LEAST_LIKELIHOOD)).sum(axis=2)
    weight = np.exp(logs - logs.max())
    weight /= weight.sum()
    loss_weight, scatters = weight.sum(axis=0), weight.sum(axis=1)
    mean = float(loss_weight @ losses)
    tail = (1 - CONFIDENCE) / 2
    ends = np.interp([tail, 1 - tail], np.cumsum(loss_weight), losses)
    return mean, float(max(mean - ends[0], ends[1] - mean)), float(scatters @ SCATTERS)


def _gap(form: NotchForm) -> Estimate | None:
    """The narrowest notch that is open as all wider ones are; the next one may be the limit as well."""
    order = np.argsort(form.drawn)
    drawn, shut = form.drawn[order], np.flatnonzero(form.goes[order] <= 0)
    first = int(shut[-1]) + 1 if shut.size else 0
    if first == drawn.size:
        return None
    step = float(drawn[first] - drawn[first - 1]) if first else float(np.diff(drawn).max())
    return Estimate(float(drawn[first]), step, "mm")


def crest_result(form: CrestForm) -> CrestResult:
    """Return scatter and offset of crests; a tilt of the block, which lay askew, is taken out first.

    Crests of one height share what layers make of it: variance between heights and within them is by one-way
    analysis of variance, the degrees of freedom of their sum by Satterthwaite, Biometrics Bulletin 2 (1946)
    110.
    """
    heights, group = np.unique(form.drawn, return_inverse=True)
    off = form.measured - form.drawn
    level = off - _tilt(form.place, off, group) * (form.place - form.place.mean())
    counts = np.bincount(group)
    means = np.bincount(group, level) / counts
    repeats = float(heights.size / np.sum(1 / counts))  # harmonic mean; all alike where nothing is missing
    inner = off.size - heights.size - 1  # degrees of freedom, one less for the tilt
    within = float(np.sum((level - means[group]) ** 2)) / inner
    between = float(means.var(ddof=1)) * repeats
    shares = np.array([between / repeats, within * (1 - 1 / repeats)])
    variance, outer = float(shares.sum()), heights.size - 1
    free = variance**2 / float(np.sum(shares**2 / [outer, inner])) if variance else float(inner)
    sigma = float(np.sqrt(variance))
    upper = sigma * float(np.sqrt(free / chi2.ppf((1 - CONFIDENCE) / 2, free)))
    spread = np.sqrt(max(between, within) / (repeats * heights.size))
    half = float(t.ppf((1 + CONFIDENCE) / 2, outer) * spread)
    return CrestResult(
        Estimate(sigma, upper - sigma, "mm"),
        Estimate(float(means.mean()), half, "mm"),
        float(np.abs(level).max()),
    )


def _tilt(place: Array, off: Array, group: NDArray[np.signedinteger[Any]]) -> float:
    """How fast heights change along the block, mm a step, by least squares within each height."""
    counts = np.bincount(group)
    x = place - (np.bincount(group, place) / counts)[group]
    y = off - (np.bincount(group, off) / counts)[group]
    return float(x @ y / (x @ x)) if x.any() else 0.0


@record()
class CouponReading(Result):
    """What the forms in `folder` say of the process `name`, which was `before`.

    `own` is the text of one's own printer.toml, or "". `notches` and `crests` are None where their form is
    not there.
    """

    shown_by = "skincad.outputs.measurements:READING"
    name: str = item(meaning="of the process")
    folder: Path
    before: Process
    printer_text: str
    notches: NotchResult | None
    crests: CrestResult | None
    seconds: dict[str, float] = item(meaning="wall time by stage, s", compare=False)

    @reported(meaning="that the forms were read")
    def passed(self) -> bool:
        """Whether the forms were read: bad ones are refused."""
        return True

    @reported("mm", "by which a wall grows")
    def growth(self) -> Estimate:
        """By how much a wall grows, mm."""
        return _or_none(self.notches.growth if self.notches else None)

    @reported("mm", "the narrowest that is open")
    def gap(self) -> Estimate:
        """The narrowest gap that is open, mm."""
        return _or_none(self.notches.gap if self.notches else None)

    @reported("mm", "scatter of the crests")
    def crest_sigma(self) -> Estimate:
        """Scatter of the crests, mm."""
        return _or_none(self.crests.sigma if self.crests else None)

    @reported("mm", "mean height of the crests over the drawn one")
    def crest_offset(self) -> Estimate:
        """Mean height of the crests over the drawn one, mm."""
        return _or_none(self.crests.offset if self.crests else None)

    @reported(meaning="the process's keys that are known now", key="keys")
    def _keys(self) -> dict[str, float]:
        return {key: value for key, (value, _) in self.keys.items()}

    @property
    def keys(self) -> dict[str, tuple[float, str]]:
        """The process's keys that are known now, mm, with what their lines say of where they are from."""
        return {key: (value, f"measured on a coupon: {comment}") for key, value, comment in _keys(self)}

    def to_toml(self) -> str:
        """Return one's own printer.toml with the process's keys as they are known now."""
        document = tomlkit.parse(self.printer_text)
        if self.name not in document:
            document[self.name] = tomlkit.table()
        table: Any = document[self.name]
        for key, (value, comment) in self.keys.items():
            item = tomlkit.item(value)
            item.comment(comment)
            table[key] = item
        text = tomlkit.dumps(document).lstrip("\n")
        load_design("plain-ridges", printer=tomllib.loads(text))  # what is written can be read
        return text


def _or_none(estimate: Estimate | None) -> Estimate:
    return estimate or Estimate(None, None, "mm")


def _keys(reading: CouponReading) -> Iterator[tuple[str, float, str]]:
    notches, crests = reading.notches, reading.crests
    if notches is not None and notches.gap:
        yield "gap", float(notches.gap), "the narrowest notch that is open, of the ladder's"
    for key in ("growth", "crest_sigma", "crest_offset"):
        estimate = getattr(reading, key)
        if estimate.value is not None:
            yield key, round(float(estimate), 4), f"± {estimate.error:.4f} (95 %)"
    worst = max((result.worst for result in (notches, crests) if result), default=0.0)
    if worst > reading.before.tolerance:
        yield "tolerance", round(worst, 4), "the largest error of a side or a crest"


def read_coupon(
    process: str, folder: Path, *, printer: Path | None = None, progress: Progress | None = None
) -> CouponReading:
    """Return what the filled-in forms in a folder say of a process that ships or is one of `printer`'s.

    Raises InputError for an unknown process, forms that are not filled in or whose rows are not those of the
    process's coupon, and a folder without any.
    """
    clock = Stopwatch(progress)
    with clock.stage("read"):
        known = processes(load_design("plain-ridges", printer=printer).printer)
        if process not in known:
            raise InputError("process", "unknown process", process, did_you_mean(process, known))
        printer_text = text_of(printer, str(printer), LARGEST_FILE, "TOML") if printer else ""
        widths = drawn_notches(known[process])
        if not widths and (folder / NOTCH_FORM).exists():
            rule = f"must not be there: the tool of {process!r} cuts no ladder of notches"
            remedy = "name the process that made the ladder, or remove the file"
            raise InputError(str(folder / NOTCH_FORM), rule, remedy=remedy)
        notches, crests = read_notches(folder, widths), read_crests(folder, drawn_steps())
    if notches is None and crests is None:
        rule = f"must hold {NOTCH_FORM} or {CREST_FORM}, filled in"
        raise InputError("measured", rule, str(folder), "name the folder of the coupon's forms")
    with clock.stage("fit"):
        ladder = notch_result(notches) if notches else None
        steps = crest_result(crests) if crests else None
    return CouponReading(
        name=process,
        folder=folder,
        before=known[process],
        printer_text=printer_text,
        notches=ladder,
        crests=steps,
        seconds=clock.seconds(),
    )
