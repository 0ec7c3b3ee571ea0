"""The models of a check: what each leaves out, which designs it takes, on which others it builds and what it
costs beside them.

A model's time is expected from the last one solved on the same design: both have a price, in the time that
the linear model takes. Nothing is assumed of the machine.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from importlib import import_module
from time import perf_counter

from skincad.base.errors import InputError, did_you_mean, resource_guard
from skincad.base.progress import Progress
from skincad.inputs.design import Design
from skincad.inputs.skin_tables import RADIUS_Y
from skincad.mechanics.left_out import FINITE_STRAIN, FREE_ENDS
from skincad.mechanics.problem import Answer, Request
from skincad.shape.skin import Body, skin_of


@dataclass(frozen=True)
class ContactModel:
    """`where` is the module of models/ and the function in it, which takes design, request, progress and the
    answers that it builds on.

    `price` is the time of its own part, without the models in `builds_on`, in that of the linear model: of
    yamada-2002, whose strips ask for a fine section. It judges skins of `families` and `bodies` and, beside
    flat plates, what it `takes`. Only if the pad itself is `meshed` friction is computed, and its time tells
    that of others.
    """

    where: str
    price: float
    leaves_out: tuple[str, ...] = ()
    builds_on: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    meshed: bool = True
    families: tuple[str, ...] = ("ridge", "flat")
    bodies: tuple[Body, ...] = ("straight",)


SHAPED, MEASURED = "shaped plates", "measured crests"
SMALL, ALL = (FINITE_STRAIN,), ("ridge", "flat", "ring", "pin")
WITH_BENT: tuple[Body, ...] = ("straight", "bent")
WITH_TURNED: tuple[Body, ...] = ("straight", "turned")
MODELS = {
    "winkler": ContactModel(
        "winkler:answer", 2e-3, takes=(SHAPED,), meshed=False, families=("ridge",), bodies=WITH_BENT
    ),
    "reduced": ContactModel(
        "reduced:answer",
        5.0,
        SMALL,
        takes=(MEASURED,),
        meshed=False,
        families=("ridge", "pin"),
        bodies=("straight", "turned", "pins"),
    ),
    "linear": ContactModel(
        "linear:answer", 1.0, (FREE_ENDS, *SMALL), takes=(SHAPED, MEASURED), families=ALL, bodies=WITH_TURNED
    ),
    "corrected": ContactModel("corrected:answer", 2.0, SMALL, ("linear",), (SHAPED, MEASURED)),
    "finite-strain": ContactModel(
        "finite_strain:answer", 3.0, (FREE_ENDS,), takes=(MEASURED,), families=ALL, bodies=WITH_TURNED
    ),
    "corrected-finite-strain": ContactModel(
        "solid_finite_strain:on_corrected", 5.0, builds_on=("corrected",), takes=(MEASURED,)
    ),
    "solid": ContactModel("solid:answer", 15.0, SMALL, takes=(SHAPED,), bodies=WITH_BENT),
    "solid-finite-strain": ContactModel(
        "solid_finite_strain:answer", 10.0, builds_on=("solid",), bodies=WITH_BENT
    ),
}
AUTO = tuple(MODELS)  # cheapest first
MANY = 60  # features; of more `auto` takes the reduced model first, of fewer never
# Models of `auto` that are for some designs only
AUTO_IF: dict[str, Callable[[Design], bool]] = {
    "reduced": lambda design: skin_of(design).count > MANY or skin_of(design).body == "pins",
    "finite-strain": lambda design: skin_of(design).body == "turned",
    "solid": lambda design: skin_of(design).body == "bent",
}


def model_named(name: str) -> ContactModel:
    """Return a model by name; raises InputError for an unknown one."""
    if name not in MODELS:
        raise InputError("model", "unknown model", name, did_you_mean(name, [*MODELS, "auto"]))
    return MODELS[name]


def is_small_strain(name: str) -> bool:
    """Return whether a model takes strains as small."""
    return name == "winkler" or FINITE_STRAIN in MODELS[name].leaves_out


def left_out_by(name: str, design: Design) -> tuple[str, ...]:
    """Return what a model leaves out of a design: a disc has no free ends."""
    effects = MODELS[name].leaves_out
    turned = skin_of(design).body == "turned"
    return tuple(effect for effect in effects if not (turned and effect == FREE_ENDS))


def unsupported_reason(name: str, design: Design, measured: bool) -> str:
    """Return why a model cannot judge this design (or a measured part of it), or ""."""
    return next(_unsupported(name, design, measured), "")


def _unsupported(name: str, design: Design, measured: bool) -> Iterator[str]:
    model, shape, skin = model_named(name), design.contact.plate.shape, skin_of(design)
    missing = skin.body if skin.body not in model.bodies else ""
    if skin.family not in model.families or missing == "turned":
        disc = "" if "turned" in model.bodies else " on a rectangular skin"
        takes = " or ".join(model.families)
        yield f"{skin.family}: is not judged by the {name} model, which takes {takes}{disc}"
    if missing == "pins":
        yield f"pin: must be one, on a round skin, for the {name} model"
    if shape != "flat" and (skin.body == "turned" or SHAPED not in model.takes):
        what = "a round skin" if skin.body == "turned" else f"the {name} model"
        yield f"contact.plate.shape: must be 'flat' for {what}"
    if missing == "bent":
        words = f"must not be given for the {name} model, which takes the skin as straight along y"
        yield f"{RADIUS_Y}: {words}"
    one_section = name == "reduced" and skin.family == "ridge"
    if one_section and skin.uneven:
        yield "ridge.heights: must be alike for the reduced model"
    if one_section and design.shot:
        yield "shot: must not be given with [ridge] for the reduced model, which takes one silicone there"
    if measured and (one_section or MEASURED not in model.takes):
        yield f"measured: is not judged by the {name} model"


def prerequisites(name: str) -> list[str]:
    """Return all models that a model builds on, in the order in which they must be solved."""
    return list(
        dict.fromkeys(base for other in MODELS[name].builds_on for base in (*prerequisites(other), other))
    )


def whole_price(name: str) -> float:
    """Return the price of a model with all that it builds on."""
    return math.fsum(MODELS[model].price for model in (*prerequisites(name), name))


FIRST_GUESS = 0.1  # s a ridge, of the linear model; until that is solved, nothing tells better


def expected_seconds(name: str, design: Design, solved: Mapping[str, Answer]) -> float:
    """Return the seconds of a model and its prerequisites, without those in `solved`, by the time of the last
    that is."""
    unit = FIRST_GUESS * skin_of(design).count
    for model, row in MODELS.items():
        if model in solved and row.meshed:
            unit = solved[model].own_seconds / row.price
    missing = {*prerequisites(name), name} - set(solved)
    return unit * math.fsum(MODELS[model].price for model in missing)


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
    answer: Callable[..., Answer] = getattr(import_module(f"skincad.mechanics.models.{module}"), function)
    return answer
