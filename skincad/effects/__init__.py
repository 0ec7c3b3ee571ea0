"""The effects that a scene may name: one file each, one line each, imported when named."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from skincad.base.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from skincad.effects.kinds import Effect

EFFECTS = {
    "film": "skincad.effects.film:FilmStrips",
    "finite_strain": "skincad.effects.finite_strain:FiniteStrain",
    "free_ends": "skincad.effects.free_ends:FreeEnds",
    "friction": "skincad.effects.friction:Friction",
    "inertia": "skincad.effects.inertia:Inertia",
    "piezo": "skincad.effects.piezo:Piezo",
    "small_strain": "skincad.effects.small_strain:SmallStrain",
    "viscosity": "skincad.effects.viscosity:Viscosity",
}


def effect(name: str) -> type[Effect]:
    """Import and return the effect of this name; raises InputError for an unknown one."""
    if name not in EFFECTS:
        raise InputError(f"effects.{name}", "unknown effect", remedy=did_you_mean(name, EFFECTS))
    module, _, kind = EFFECTS[name].partition(":")
    found: type[Effect] = getattr(import_module(module), kind)
    return found
