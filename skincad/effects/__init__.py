"""The effects that a scene may name: one file each, one line each, imported when named.

One of INDICATORS is also asked what leaving it out would change, so what it computes with is imported
within its methods, not with its file.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from skincad.base.errors import InputError, did_you_mean
from skincad.base.faces import face, imported

if TYPE_CHECKING:
    from skincad.effects.kinds import Effect


EFFECTS = {
    "film": "skincad.effects.film:FilmStrips",
    "finite_strain": "skincad.effects.finite_strain:FiniteStrain",
    "free_ends": "skincad.effects.free_ends:FreeEnds",
    "friction": "skincad.effects.friction:Friction",
    "inertia": "skincad.effects.inertia:Inertia",
    "magnet": "skincad.effects.magnet:Magnetometers",
    "piezo": "skincad.effects.piezo:Piezo",
    "small_strain": "skincad.effects.small_strain:SmallStrain",
    "texture": "skincad.effects.texture:Texture",
    "viscosity": "skincad.effects.viscosity:Viscosity",
}
INDICATORS = ("film", "finite_strain", "free_ends", "inertia")  # say what leaving them out would change


def effect(name: str) -> type[Effect]:
    """Import and return the effect of this name; raises InputError for an unknown one."""
    if name not in EFFECTS:
        raise InputError(f"effects.{name}", "unknown effect", remedy=did_you_mean(name, EFFECTS))
    kind_class: type[Effect] = imported(EFFECTS[name])
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
        ReaderContext SceneOutline Share Step Term share_of
    modal: ModalPad
    moving: MovingPad
    piezo: Chain Piezo strip_charges
    pin_pad: SLIDING STICKING left_out
    small_strain: CondensedPad SmallStrain
    """,
)
