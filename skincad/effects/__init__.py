"""The effects that a scene may name: one file each, one line each, imported when named.

One that `indicates` is also asked what leaving it out would change, so what it computes with is imported
within its methods, not with its file.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from skincad.base.errors import InputError, did_you_mean
from skincad.base.faces import face

if TYPE_CHECKING:
    from skincad.effects.kinds import Effect


class Row(NamedTuple):
    """Module and class of an effect, and whether it says what leaving it out would change."""

    where: str
    indicates: bool = False


EFFECTS = {
    "film": Row("skincad.effects.film:FilmStrips", indicates=True),
    "finite_strain": Row("skincad.effects.finite_strain:FiniteStrain", indicates=True),
    "free_ends": Row("skincad.effects.free_ends:FreeEnds", indicates=True),
    "friction": Row("skincad.effects.friction:Friction"),
    "inertia": Row("skincad.effects.inertia:Inertia", indicates=True),
    "piezo": Row("skincad.effects.piezo:Piezo"),
    "small_strain": Row("skincad.effects.small_strain:SmallStrain"),
    "texture": Row("skincad.effects.texture:Texture"),
    "viscosity": Row("skincad.effects.viscosity:Viscosity"),
}


def effect(name: str) -> type[Effect]:
    """Import and return the effect of this name; raises InputError for an unknown one."""
    if name not in EFFECTS:
        raise InputError(f"effects.{name}", "unknown effect", remedy=did_you_mean(name, EFFECTS))
    module, _, kind = EFFECTS[name].where.partition(":")
    kind_class: type[Effect] = getattr(import_module(module), kind)
    return kind_class


# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    chosen_steps: ChosenPad UPDATE_INTERVAL
    finite_strain: FiniteStrain sway_amplification sway_angle sway_force
    free_ends: end_compliance force_changes
    friction: Friction
    inertia: plate_ringing
    kinds: Drift Effect Law LeftOutEffect MASS MOVING MarchedPad Observables PadChange PlatePath RELIEF Reader
        ReaderContext RidgePath SceneOutline SectionPad Share Step Term share_of
    modal: ModalPad
    moving: MovingPad
    piezo: Chain Piezo SIDES fitted strip_charges
    pin_pad: SLIDING STICKING left_out
    small_strain: CondensedPad SmallStrain
    """,
)
