"""Castable artificial robot skin, and what it will feel.

>>> design = skincad.load_design("yamada-2002")
>>> skincad.check(design).passed
True
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from skincad.base.version import __version__ as __version__

if TYPE_CHECKING:
    from skincad.base.errors import InputError as InputError
    from skincad.base.errors import RefusedError as RefusedError
    from skincad.base.errors import UnclearError as UnclearError
    from skincad.base.estimate import Estimate as Estimate
    from skincad.circuit.bode import gain as gain
    from skincad.circuit.model import Circuit as Circuit
    from skincad.circuit.model import load_circuit as load_circuit
    from skincad.fabrication.making import make as make
    from skincad.inputs.catalog import load as load
    from skincad.inputs.catalog import load_design as load_design
    from skincad.inputs.catalog import template_names as template_names
    from skincad.inputs.design import Design as Design
    from skincad.ladders.climbing import accuracy as accuracy
    from skincad.material.fit import fit_material as fit_material
    from skincad.mechanics.film.stress import film_stress as film_stress
    from skincad.mechanics.touching import check as check
    from skincad.outputs.delivery import write as write
    from skincad.packages.packing import package as package
    from skincad.scenes.scene import Scene as Scene
    from skincad.scenes.scene import load_scene as load_scene
    from skincad.scenes.simulation import simulate as simulate
    from skincad.shape.cross_section import section as section
    from skincad.solids.mold import mold_solids as mold_solids
    from skincad.solids.skin import skin_solid as skin_solid
    from skincad.studies.advice import advise as advise
    from skincad.studies.optimising import optimise as optimise
    from skincad.studies.solving import solve as solve
    from skincad.studies.study import Study as Study
    from skincad.studies.study import load_study as load_study
    from skincad.studies.sweeping import sweep as sweep

_HOMES = {  # name -> where it is, imported when it is first used: a check never loads the CAD kernel
    "Circuit": "circuit.model:Circuit",
    "Design": "inputs.design:Design",
    "Estimate": "base.estimate:Estimate",
    "InputError": "base.errors:InputError",
    "RefusedError": "base.errors:RefusedError",
    "UnclearError": "base.errors:UnclearError",
    "Scene": "scenes.scene:Scene",
    "Study": "studies.study:Study",
    "advise": "studies.advice:advise",
    "accuracy": "ladders.climbing:accuracy",
    "check": "mechanics.touching:check",
    "film_stress": "mechanics.film.stress:film_stress",
    "fit_material": "material.fit:fit_material",
    "gain": "circuit.bode:gain",
    "load": "inputs.catalog:load",
    "load_circuit": "circuit.model:load_circuit",
    "load_design": "inputs.catalog:load_design",
    "load_scene": "scenes.scene:load_scene",
    "load_study": "studies.study:load_study",
    "make": "fabrication.making:make",
    "mold_solids": "solids.mold:mold_solids",
    "package": "packages.packing:package",
    "optimise": "studies.optimising:optimise",
    "section": "shape.cross_section:section",
    "simulate": "scenes.simulation:simulate",
    "skin_solid": "solids.skin:skin_solid",
    "solve": "studies.solving:solve",
    "sweep": "studies.sweeping:sweep",
    "template_names": "inputs.catalog:template_names",
    "write": "outputs.delivery:write",
}
__all__ = sorted(_HOMES)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used."""
    if name not in _HOMES:
        raise AttributeError(f"module 'skincad' has no attribute '{name}'")
    module, _, thing = _HOMES[name].partition(":")
    globals()[name] = found = getattr(import_module(f"skincad.{module}"), thing)
    return found


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
