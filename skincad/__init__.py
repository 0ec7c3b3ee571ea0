"""Castable artificial robot skin, and what it will feel.

>>> design = skincad.load("yamada-2002")
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
    from skincad.base.estimate import Estimate as Estimate
    from skincad.inputs.catalog import load as load
    from skincad.inputs.catalog import template_names as template_names
    from skincad.inputs.design import Design as Design
    from skincad.mechanics.touching import check as check
    from skincad.outputs.making import make as make
    from skincad.solids.mold import mold_solids as mold_solids
    from skincad.solids.skin import skin_solid as skin_solid

_HOMES = {
    "Design": "skincad.inputs.design",
    "Estimate": "skincad.base.estimate",
    "InputError": "skincad.base.errors",
    "RefusedError": "skincad.base.errors",
    "check": "skincad.mechanics.touching",
    "load": "skincad.inputs.catalog",
    "make": "skincad.outputs.making",
    "mold_solids": "skincad.solids.mold",
    "skin_solid": "skincad.solids.skin",
    "template_names": "skincad.inputs.catalog",
}
__all__ = sorted(_HOMES)  # noqa: PLE0605


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that a check never loads the CAD kernel."""
    if name not in _HOMES:
        raise AttributeError(f"module 'skincad' has no attribute '{name}'")
    return getattr(import_module(_HOMES[name]), name)
