"""The models of a check: what each leaves out, which designs it takes, and what it costs.

Measured times of models on this machine: `skincad accuracy` writes them, the cost model reads them. They
stand in one JSON file, `cost-law.json`, in the user's cache folder. A person can read it and may delete it at
any time. Times of another machine or of other versions are not used. A file that cannot be read is ignored
with a warning.

Cost model: predicted times, and the size of a problem that they depend on. The models' laws stand in
table.py, those of the yield and of friction here. They were fitted to the templates (`skincad accuracy`,
ladder contact) on one core of an idle AMD EPYC. Measurements on this machine scale them. A check also scales
them by the time of its linear model."""

from __future__ import annotations

import math
import os
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, lru_cache
from importlib import import_module
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

from pydantic import BaseModel, ConfigDict, PositiveFloat, ValidationError

from skincad.base.errors import InputError, did_you_mean, resource_guard
from skincad.base.machine import machine
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.mechanics.left_out import FINITE_STRAIN, FREE_ENDS
from skincad.mechanics.problem import Answer, Pad, Request, pad_of
from skincad.shape.skin import skin_of

FOLDER_VARIABLE = "SKINCAD_CACHE"  # the environment variable that moves the cache
FILE_NAME = "cost-law.json"


class ModelTiming(BaseModel):
    """Time of a model's own part on a design: the size for its cost model, and seconds."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)
    size: PositiveFloat
    seconds: PositiveFloat


class _File(BaseModel):
    """The file: `measured` by model and design."""

    what: str = "seconds of check's models on this machine, by model and design; may be deleted at any time"
    machine: dict[str, Any]
    measured: dict[str, dict[str, ModelTiming]]


@dataclass(frozen=True)
class TimingCache:
    """Timings by model and design; `trouble` says why the file is ignored, "" if it is read or missing."""

    timings: Mapping[str, Mapping[str, ModelTiming]] = field(default_factory=dict)
    trouble: str = ""


def cache_file() -> Path:
    """Return the path of the cache file, which may not exist; raises RuntimeError without a home folder."""
    if chosen_folder := os.environ.get(FOLDER_VARIABLE):
        return Path(chosen_folder).absolute() / FILE_NAME
    cache_home = os.environ.get("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME", "")
    folder = Path(cache_home) if Path(cache_home).is_absolute() else Path.home() / ".cache"
    return folder / "skincad" / FILE_NAME


def without_home(path: Path) -> str:
    """Return a path without the user's name in it."""
    try:
        home = Path.home()
    except RuntimeError:
        return str(path)
    return str("~" / path.relative_to(home)) if path.is_relative_to(home) else str(path)


def timing_cache() -> TimingCache:
    """Return the timings measured on this machine."""
    try:
        path = cache_file()
        stamp = path.stat()
    except (OSError, RuntimeError):
        return TimingCache()
    return _read(path, stamp.st_mtime_ns, stamp.st_size)


def save_timings(design: str, timings: Mapping[str, ModelTiming]) -> Path:
    """Write the timings of models on a design to the cache file, replacing earlier ones; return its path.

    Raises OSError or RuntimeError if the file cannot be written.
    """
    path = cache_file()
    measured = {model: dict(by_design) for model, by_design in timing_cache().timings.items()}
    for model, one in timings.items():
        measured.setdefault(model, {})[design] = one
    text = _File(machine=_here(), measured=measured).model_dump_json(indent=1)
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = path.with_name(
        f".{FILE_NAME}-{secrets.token_hex(4)}"
    )  # written beside it, then moved into its place
    try:
        whole.write_text(text + "\n", "utf-8")
        whole.replace(path)
    finally:
        whole.unlink(missing_ok=True)
    return path


@lru_cache(maxsize=1)
def _read(path: Path, _stamp: int, _size: int) -> TimingCache:
    """The file's contents; read again only once it has changed."""
    try:
        contents = _File.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return TimingCache(
            trouble=f"{without_home(path)} is no cost law that can be read, and is ignored: delete it"
        )
    return TimingCache(contents.measured if contents.machine == _here() else {})


@cache
def _here() -> dict[str, Any]:
    """Processor, cores and versions, without the load."""
    return {key: value for key, value in machine().items() if key != "load"}


@dataclass(frozen=True)
class CostModel:
    """`seconds` at a `size`, and its exponent; s of one core of the machine it was fitted on."""

    size: float
    seconds: float
    exponent: float

    def at(self, size: float) -> float:
        """Return the expected time, s."""
        return float(self.seconds * (size / self.size) ** self.exponent)


# Beside the models, by ridges. Yield: 0.17 s with 3, 0.4 to 0.7 with 9, 1.0 to 1.3 with 20, 4.9 with 40;
# within a factor of 1.6, but 2.6 too low on fingertip-soft. Friction: 0.3, 3.8 and 15 s with 9, 33 and 60
OVERHEAD = {"yield": CostModel(9, 0.47, 1.3), "friction": CostModel(9, 0.3, 2.06)}


def any_size(_: Design) -> float:
    """Return the size where the time does not depend on the design."""
    return 1.0


def plane_unknowns(design: Design) -> float:
    """Return about how many unknowns the plane has, order 3: within 30 % on the templates.

    Of a mirror-symmetric pad half is solved.
    """
    skin = skin_of(design)
    slots = skin.slot is not None and design.film_state != "ignored"
    mirrored = design.contact.plate.shape == "flat" and skin.heights == skin.heights[::-1]
    half = 0.5 if mirrored else 1.0
    return half * (3000 + skin.count * (3000 if slots else 1900))


def coarse_solid_unknowns(design: Design) -> float:
    """Return the unknowns of the coarse solid that corrects the plane, its section of order 2."""
    from skincad.mechanics.models.corrected import plain_pad

    return _solid_unknowns(plain_pad(design), 2)


def solid_unknowns(design: Design) -> float:
    """Return the unknowns of the solid on its first refinement, its section of order 3."""
    return _solid_unknowns(pad_of(design), 3)


def _solid_unknowns(pad: Pad, order: int) -> float:
    """Unknowns of the coarse solid at an order in the section, by its mesh: a few hundredths of its price."""
    from skincad.mechanics.bodies import elements, prisms
    from skincad.mechanics.bodies.mesh import meshed_piece
    from skincad.mechanics.models.corrected import LAYERS
    from skincad.mechanics.models.solid import coarse_sizes

    meshed = meshed_piece(pad, coarse_sizes(pad, 1.0))
    mesh = elements.curved(meshed.mesh, 1)
    functions = mesh.nv + (order - 1) * mesh.nedge + (mesh.ne if order > 2 else 0)
    height, half = meshed.height / meshed.unit, meshed.whole.length / 2 / meshed.unit
    borders = prisms.graded(half, LAYERS.last * height, LAYERS.growth)
    return float(3 * functions * prisms.line(borders, LAYERS.order).at.size)


@dataclass(frozen=True)
class ContactModel:
    """`where` is module and function of its `answer(design, request, progress, *answers it builds on)`.

    `law` is the time of its own part, without the models in `builds_on`, by its `size` of a design. Flags say
    whether it supports `shaped_plates`, `measured` crests and `doubly_curved` skins.
    """

    where: str
    law: CostModel
    size: Callable[[Design], float]
    leaves_out: tuple[str, ...] = ()
    builds_on: tuple[str, ...] = ()
    shaped_plates: bool = False
    measured: bool = False
    doubly_curved: bool = False


_ROOM = "skincad.mechanics.models."
MODELS = {
    "winkler": ContactModel(
        f"{_ROOM}winkler:answer", CostModel(1.0, 4e-4, 0.0), any_size, shaped_plates=True, doubly_curved=True
    ),
    "linear": ContactModel(
        f"{_ROOM}linear:answer",
        CostModel(9_800, 0.45, 1.05),
        plane_unknowns,
        (FREE_ENDS, FINITE_STRAIN),
        shaped_plates=True,
        measured=True,
    ),
    "corrected": ContactModel(
        f"{_ROOM}corrected:answer",
        CostModel(8_700, 0.27, 1.25),
        coarse_solid_unknowns,
        (FINITE_STRAIN,),
        ("linear",),
        shaped_plates=True,
        measured=True,
    ),
    "finite-strain": ContactModel(
        f"{_ROOM}finite_strain:answer",
        CostModel(9_800, 1.8, 1.3),
        plane_unknowns,
        (FREE_ENDS,),
        measured=True,
    ),
    "corrected-finite-strain": ContactModel(
        f"{_ROOM}corrected_finite_strain:answer",
        CostModel(1.0, 1e-3, 0.0),
        any_size,
        builds_on=("linear", "corrected", "finite-strain"),
        measured=True,
    ),
    "solid": ContactModel(
        f"{_ROOM}solid:answer",
        CostModel(75_000, 8.0, 1.65),
        solid_unknowns,
        (FINITE_STRAIN,),
        shaped_plates=True,
    ),
    "solid-finite-strain": ContactModel(
        f"{_ROOM}solid_finite_strain:answer",
        CostModel(8_700, 0.9, 1.6),
        coarse_solid_unknowns,
        builds_on=("solid",),
    ),
}
AUTO = ("winkler", "linear", "corrected", "corrected-finite-strain", "solid-finite-strain")


def model_named(name: str) -> ContactModel:
    """Return a model by name; raises InputError for an unknown one."""
    if name not in MODELS:
        raise InputError("model", "unknown model", name, did_you_mean(name, [*MODELS, "auto"]))
    return MODELS[name]


def is_small_strain(name: str) -> bool:
    """Return whether a model takes strains as small."""
    return name == "winkler" or FINITE_STRAIN in MODELS[name].leaves_out


def unsupported_reason(name: str, design: Design, measured: bool) -> str:
    """Return why a model cannot judge this design (or a measured part of it), or ""."""
    model, shape = model_named(name), design.contact.plate.shape
    if shape != "flat" and not model.shaped_plates:
        return f"contact.plate.shape: must be 'flat' for the {name} model"
    if design.skin.curvature_radius_y is not None and not model.doubly_curved:
        return f"skin.curvature_radius_y: must not be given for the {name} model, which takes y as straight"
    if measured and not model.measured:
        return f"measured: is not judged by the {name} model"
    return ""


def prerequisites(name: str) -> list[str]:
    """Return all models that a model builds on, in the order in which they must be solved."""
    return list(
        dict.fromkeys(base for other in MODELS[name].builds_on for base in (*prerequisites(other), other))
    )


def seconds_at_size(name: str, size: float) -> float:
    """Return the seconds of a model's own part at a size."""
    return MODELS[name].law.at(size) * machine_factor(name)


def machine_factor(name: str = "") -> float:
    """Return measured over predicted seconds on this machine: the model's median, or if it was not measured
    that of all models; 1 if none was.

    The exponent stays the law's: it is the method's, and a few designs say little about it.
    """
    ratios_by_model = {
        model: [timing.seconds / MODELS[model].law.at(timing.size) for timing in by_design.values()]
        for model, by_design in timing_cache().timings.items()
        if model in MODELS
    }
    every = [ratio for ratios in ratios_by_model.values() for ratio in ratios]
    return median(ratios_by_model.get(name) or every or [1.0])


def own_seconds(name: str, design: Design) -> float:
    """Return the seconds of a model's own part."""
    return seconds_at_size(name, MODELS[name].size(design))


def expected_seconds(name: str, design: Design, solved: set[str]) -> float:
    """Return the seconds of a model and its prerequisites, without those in `solved`."""
    return math.fsum(own_seconds(model, design) for model in {*prerequisites(name), name} - solved)


def overhead_seconds(what: str, design: Design) -> float:
    """Return the predicted seconds of a check's `yield`, or of its plate's `friction`."""
    return OVERHEAD[what].at(skin_of(design).count) * machine_factor()


def run(
    name: str, design: Design, request: Request, solved: dict[str, Answer], progress: Progress | None
) -> Answer:
    """Return a model's answer; it and its prerequisites are stored in `solved` and never solved twice.

    Raises ExhaustedError where memory or another resource does not suffice.
    """
    if name not in solved:
        model = MODELS[name]
        on = [run(other, design, request, solved, progress) for other in model.builds_on]
        with resource_guard(f"the {name} model"):
            answer, began = load(name), perf_counter()
            result = answer(design, request, progress, *on)
            solved[name] = replace(result, own_seconds=perf_counter() - began)
    return solved[name]


def load(name: str) -> Callable[..., Answer]:
    """Import and return a model's function."""
    module, _, function = MODELS[name].where.partition(":")
    answer: Callable[..., Answer] = getattr(import_module(module), function)
    return answer
