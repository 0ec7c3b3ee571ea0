"""Castable artificial robot skin, and what it will feel.

>>> design = skincad.load_design("yamada-2002")
>>> skincad.check(design).passed
True
>>> skincad.check("yamada-2002").passed
True
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from importlib import import_module
from inspect import isfunction, signature, unwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any, Concatenate, ParamSpec, TypeVar

from skincad.base.faces import face, imported
from skincad.base.version import __version__ as __version__

if TYPE_CHECKING:
    from skincad.base.errors import InputError as InputError
    from skincad.base.errors import RefusedError as RefusedError
    from skincad.base.errors import UnclearError as UnclearError
    from skincad.base.estimate import Estimate as Estimate
    from skincad.circuit.boards import board as _board
    from skincad.circuit.bode import gain as _gain
    from skincad.circuit.model import Circuit as Circuit
    from skincad.circuit.model import load_circuit as load_circuit
    from skincad.detector.detector import Detector as Detector
    from skincad.detector.taps import tap_test as tap_test
    from skincad.fabrication.films import film_offers as _film_offers
    from skincad.fabrication.making import make as _make
    from skincad.inputs.catalog import load as load
    from skincad.inputs.catalog import load_design as load_design
    from skincad.inputs.catalog import template_names as template_names
    from skincad.inputs.design import Design as Design
    from skincad.material.acceptance import accept as _accept
    from skincad.material.fit import fit_material as fit_material
    from skincad.mechanics.film.stress import film_stress as _film_stress
    from skincad.outputs.delivery import save_picture as save_picture
    from skincad.outputs.delivery import write as write
    from skincad.outputs.detector_code import export as export
    from skincad.outputs.simulators.package import package as _package
    from skincad.scenes.scene import Scene as Scene
    from skincad.scenes.scene import load_scene as load_scene
    from skincad.scenes.simulation import simulate as _simulate
    from skincad.shape.skin import Section
    from skincad.solids.mold import mold_solids as _mold_solids
    from skincad.solids.skin import skin_solid as _skin_solid
    from skincad.studies.accuracy.accuracy import accuracy as _accuracy
    from skincad.studies.advice import advise as _advise
    from skincad.studies.holding import check as _check
    from skincad.studies.optimising import optimise as _optimise
    from skincad.studies.solving import solve as _solve
    from skincad.studies.study import Study as Study
    from skincad.studies.study import load_study as load_study
    from skincad.studies.sweeping import sweep as _sweep
    from skincad.studies.wish import design_for as design_for

S = TypeVar("S")
R = TypeVar("R")
P = ParamSpec("P")

# Imported when it is first used: a check never loads the CAD kernel
_public, _names = face(
    __name__,
    """
    base.errors: InputError RefusedError UnclearError
    base.estimate: Estimate
    circuit.boards: board
    circuit.bode: gain
    circuit.model: Circuit load_circuit
    detector.detector: Detector
    detector.taps: tap_test
    fabrication.films: film_offers
    fabrication.making: make
    inputs.catalog: load load_design template_names
    inputs.design: Design
    material.acceptance: accept
    material.fit: fit_material
    mechanics.film.stress: film_stress
    outputs.delivery: save_picture write
    outputs.detector_code: export
    outputs.simulators.package: package
    scenes.scene: Scene load_scene
    scenes.simulation: simulate
    shape.skin: section
    solids.mold: mold_solids
    solids.skin: skin_solid
    studies.accuracy.accuracy: accuracy
    studies.advice: advise
    studies.holding: check
    studies.optimising: optimise
    studies.solving: solve
    studies.study: Study load_study
    studies.sweeping: sweep
    studies.wish: design_for
    """,
)
__all__ = _names()  # noqa: PLE0605


# by the name of a public function's argument: what loads it where a name or a path is given instead
_LOADERS = {
    "design": "skincad.inputs.catalog:load_design",
    "scene": "skincad.scenes.scene:load_scene",
    "circuit": "skincad.circuit.model:load_circuit",
    "subject": "skincad.studies.subject:load_subject",
    "study": "skincad.studies.study:load_study",
}


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name == "laws":
        return import_module("skincad.laws")
    thing = _public(name)
    globals()[name] = by_name(thing) if isfunction(unwrap(thing)) else thing
    return globals()[name]


def by_name(function: Callable[Concatenate[S, P], R]) -> Callable[Concatenate[S | str | Path, P], R]:
    """Return a function that also takes a template's name or a TOML file in the place of what it is about."""
    form = signature(function)
    loaded = [name for name in form.parameters if name in _LOADERS]
    if not loaded:
        return function  # type: ignore[return-value]  # it has no such place

    @wraps(function)
    def call(*given: Any, **named: Any) -> R:
        if "tier" in named and "model" in form.parameters and "model" not in named:  # its name before
            named["model"] = named.pop("tier")
        arguments = form.bind(*given, **named)
        for name in loaded:
            if isinstance(source := arguments.arguments.get(name), str | Path):
                arguments.arguments[name] = imported(_LOADERS[name])(source)
        return function(*arguments.args, **arguments.kwargs)

    call.__module__ = __name__  # where pickle finds it
    return call


if TYPE_CHECKING:
    accept = by_name(_accept)
    accuracy = by_name(_accuracy)
    advise = by_name(_advise)
    board = by_name(_board)
    check = by_name(_check)
    film_offers = by_name(_film_offers)
    film_stress = by_name(_film_stress)
    gain = by_name(_gain)
    make = by_name(_make)
    mold_solids = by_name(_mold_solids)
    optimise = by_name(_optimise)
    package = by_name(_package)
    simulate = by_name(_simulate)
    skin_solid = by_name(_skin_solid)
    solve = by_name(_solve)
    sweep = by_name(_sweep)

    def section(design: Design | str | Path) -> Section:
        """Return the design's section: a cache hides what it takes from type checkers."""


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
