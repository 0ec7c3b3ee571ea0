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
from skincad.mechanics.left_out import FINITE_STRAIN, FREE_ENDS
from skincad.mechanics.problem import Answer, Request
from skincad.shape.skin import skin_of


@dataclass(frozen=True)
class ContactModel:
    """`where` is the module of models/ and the function in it, which takes design, request, progress and the
    answers that it builds on.

    `price` is the time of its own part, without the models in `builds_on`, in that of the linear model: of
    yamada-2002, whose strips ask for a fine section. It judges skins of `families` and, beside flat plates
    and straight rectangular skins, what it `takes`. Only if the pad itself is `meshed` there is a yield,
    friction is computed, and its time tells that of others.
    """

    where: str
    price: float
    leaves_out: tuple[str, ...] = ()
    builds_on: tuple[str, ...] = ()
    takes: tuple[str, ...] = ()
    meshed: bool = True
    families: tuple[str, ...] = ("ridge", "flat")


SHAPED, MEASURED, DOUBLY, ROUND = "shaped plates", "measured crests", "double curvature", "discs"
SMALL, ALL = (FINITE_STRAIN,), ("ridge", "flat", "ring", "pin")
MODELS = {
    "winkler": ContactModel(
        "winkler:answer", 2e-3, takes=(SHAPED, DOUBLY), meshed=False, families=("ridge",)
    ),
    "reduced": ContactModel(
        "reduced:answer", 5.0, SMALL, takes=(ROUND,), meshed=False, families=("ridge", "pin")
    ),
    "linear": ContactModel(
        "linear:answer", 1.0, (FREE_ENDS, *SMALL), takes=(SHAPED, MEASURED, ROUND), families=ALL
    ),
    "corrected": ContactModel("corrected:answer", 2.0, SMALL, ("linear",), (SHAPED, MEASURED)),
    "finite-strain": ContactModel(
        "finite_strain:answer", 3.0, (FREE_ENDS,), takes=(MEASURED, ROUND), families=ALL
    ),
    "corrected-finite-strain": ContactModel(
        "solid_finite_strain:on_corrected", 5.0, builds_on=("corrected",), takes=(MEASURED,)
    ),
    "solid": ContactModel("solid:answer", 15.0, SMALL, takes=(SHAPED, DOUBLY)),
    "solid-finite-strain": ContactModel("solid_finite_strain:answer", 10.0, (), ("solid",), (DOUBLY,)),
}
AUTO = tuple(MODELS)  # cheapest first
MANY = 60  # features; of more `auto` takes the reduced model first, of fewer never
# Models of `auto` that are for some designs only
AUTO_IF: dict[str, Callable[[Design], bool]] = {
    "reduced": lambda design: skin_of(design).count > MANY or _is_pins(design),
    "finite-strain": lambda design: design.skin.round,
    "solid": lambda design: design.skin.curvature_radius_y is not None,
}


def _is_pins(design: Design) -> bool:
    """Whether a design has pins that no section through the middle shows."""
    skin = skin_of(design)
    return skin.symmetry == "revolved" and (skin.count > 1 or not design.skin.round)


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
    return tuple(effect for effect in effects if effect != FREE_ENDS) if design.skin.round else effects


def unsupported_reason(name: str, design: Design, measured: bool) -> str:
    """Return why a model cannot judge this design (or a measured part of it), or ""."""
    return next(_unsupported(name, design, measured), "")


def _unsupported(name: str, design: Design, measured: bool) -> Iterator[str]:
    model, shape, skin = model_named(name), design.contact.plate.shape, skin_of(design)
    if skin.family not in model.families or (design.skin.round and ROUND not in model.takes):
        discs = ROUND in model.takes
        takes = [family for family in model.families if discs or family not in ("ring", "pin")]
        disc = "" if discs else " on a rectangular skin"
        yield f"{skin.family}: is not judged by the {name} model, which takes {' or '.join(takes)}{disc}"
    if name != "reduced" and _is_pins(design):
        yield f"pin: must be one, on a round skin, for the {name} model"
    if shape != "flat" and (design.skin.round or SHAPED not in model.takes):
        what = "a round skin" if design.skin.round else f"the {name} model"
        yield f"contact.plate.shape: must be 'flat' for {what}"
    doubly = design.skin.curvature_radius_y is not None and skin.symmetry != "revolved"
    if doubly and DOUBLY not in model.takes:
        words = f"must not be given for the {name} model, which takes the skin as straight along y"
        yield f"skin.curvature_radius_y: {words}"
    if name == "reduced" and skin.symmetry == "extruded" and skin.uneven:
        yield "ridge.heights: must be alike for the reduced model"
    if name == "reduced" and skin.symmetry == "extruded" and design.shot:
        yield "shot: must not be given with [ridge] for the reduced model, which takes one silicone there"
    if measured and MEASURED not in model.takes:
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
