"""Castable artificial robot skin, and what it will feel.

>>> design = skincad.load("yamada-2002")
>>> skincad.check(design).passed
True
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from skincad.catalog import load as load
    from skincad.catalog import template_names as template_names
    from skincad.design import Design as Design
    from skincad.errors import InputError as InputError
    from skincad.errors import RefusedError as RefusedError
    from skincad.job import make as make
    from skincad.mechanics.check import check as check
    from skincad.quantities import Estimate as Estimate
    from skincad.solids.mold import mold_solids as mold_solids
    from skincad.solids.skin import skin_solid as skin_solid

__version__ = "0.1.0"

_HOMES = {
    "Design": "skincad.design",
    "Estimate": "skincad.quantities",
    "InputError": "skincad.errors",
    "RefusedError": "skincad.errors",
    "check": "skincad.mechanics.check",
    "load": "skincad.catalog",
    "make": "skincad.job",
    "mold_solids": "skincad.solids.mold",
    "skin_solid": "skincad.solids.skin",
    "template_names": "skincad.catalog",
}
__all__ = sorted(_HOMES)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that a check never loads the CAD kernel."""
    if name not in _HOMES:
        raise AttributeError(f"module 'skincad' has no attribute '{name}'")
    return getattr(import_module(_HOMES[name]), name)
