"""The coupon of a process: what to print or cut, cast and measure once, before a mold is made."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from skincad.base.errors import InputError, did_you_mean
from skincad.base.progress import Progress, Stopwatch
from skincad.base.result import Result
from skincad.inputs.catalog import Own, load_design
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.process import Process, processes
from skincad.inputs.silicone import Silicone, silicones
from skincad.solids.coupon import coupon_parts, drawn_notches, poured_volumes
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


@dataclass(frozen=True, repr=False)
class CouponKit(Result):
    """The parts of a coupon, the last one the mold of `pad`; `name` is that of the process."""

    shown_by = "skincad.outputs.coupons"
    name: str
    pad: Design
    parts: tuple[Part, ...]
    seconds: dict[str, float] = field(compare=False)

    @property
    def process(self) -> Process:
        """What makes the parts."""
        return processes(self.pad.printer)[self.name]

    @property
    def silicone(self) -> Silicone:
        """What is cast in the molds."""
        return silicone(self.pad)

    @property
    def notches(self) -> tuple[float, ...]:
        """Width of each notch as drawn, mm; none where the tool passes too few."""
        return drawn_notches(self.process)

    @property
    def grams(self) -> dict[str, float]:
        """What each mold takes of the silicone, g, by the mold's name."""
        density = self.silicone.density * 1e-6
        return {name: volume * density for name, volume in poured_volumes(self.parts).items()}

    def as_json(self) -> dict[str, Any]:
        """Return the `coupon` object of `--json`; the unit is the key's suffix."""
        return {
            "name": self.name,
            "passed": True,
            "silicone": self.silicone.name,
            "parts": [{"name": part.name, "volume_mm3": part.volume} for part in self.parts],
            "poured_g": self.grams,
            "notches_mm": list(self.notches),
            "seconds": dict(self.seconds),
        }


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
    return CouponKit(process, pad, parts, clock.seconds())


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
