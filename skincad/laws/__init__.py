"""Laws of rubber elasticity: one file each, one line each in the table, imported when named.

A law is a frozen table of constants, as in a design's `[material.law]`, with one energy. Stress, energy and
tangent modulus of a bar are here too; bodies use the energy in mechanics/bodies.

>>> law = skincad.laws.Ogden(mu=(0.0402,), alpha=(3.25,))
>>> [round(float(stress), 4) for stress in law.stress(np.array([0.8, 1.0, 1.5]))]
[-0.0206, 0.0, 0.0489]
>>> round(law.young_modulus(0.5), 4) == round(float(law.tangent_modulus(np.ones(1))[0]), 4) == 0.1206
True
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from skincad.base.errors import InputError, did_you_mean
from skincad.base.faces import face, imported

if TYPE_CHECKING:
    from skincad.laws.gent import Gent as Gent
    from skincad.laws.mooney_rivlin import MooneyRivlin as MooneyRivlin
    from skincad.laws.neo_hooke import NeoHooke as NeoHooke
    from skincad.laws.ogden import Ogden as Ogden
    from skincad.laws.rubber import Rubber
    from skincad.laws.yeoh import Yeoh as Yeoh

LAWS = {
    "neo-hooke": "skincad.laws.neo_hooke:NeoHooke",
    "mooney-rivlin": "skincad.laws.mooney_rivlin:MooneyRivlin",
    "yeoh": "skincad.laws.yeoh:Yeoh",
    "gent": "skincad.laws.gent:Gent",
    "ogden": "skincad.laws.ogden:Ogden",
}


def law(kind: str) -> type[Rubber]:
    """Import and return the law of this kind; raises InputError for an unknown one."""
    if kind not in LAWS:
        remedy = did_you_mean(kind, LAWS) or f"take one of {', '.join(LAWS)}"
        raise InputError("kind", "unknown law", kind, remedy)
    law_class: type[Rubber] = imported(LAWS[kind])
    return law_class


def law_of(table: Mapping[str, Any]) -> Rubber:
    """Return the law of a table with its `kind` and constants; raises InputError for broken rules."""
    kind = table.get("kind")
    if kind is None:
        raise InputError("kind", "is missing", remedy=f"take one of {', '.join(LAWS)}")
    law_class = law(str(kind))
    try:
        return law_class(**table)
    except InputError as broken:
        if broken.key != law_class.__name__.lower():  # a rule of one constant
            raise
        raise InputError("", broken.rule, broken.value, broken.remedy, broken.others) from None


# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    gent: Gent
    mooney_rivlin: MooneyRivlin
    neo_hooke: NeoHooke
    ogden: Ogden
    rubber: Candidate LONGEST Rubber SHORTEST
    yeoh: Yeoh
    """,
)
