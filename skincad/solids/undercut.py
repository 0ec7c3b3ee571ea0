"""Where a cavity has to be split, because a ridge would be squeezed too much on its way out.

Rubber keeps its volume and the skin is long. So a ridge that passes an opening w out of its width W stretches
upward by W / w - 1, which is held against the elongation at break. Friction and bending are left out.
"""

from __future__ import annotations

from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import skin_of

SAFE_SHARE = 0.2  # assumption: a cast edge has nicks, from which it tears long before a test bar does


def safe_strain(design: Design) -> float:
    """Return the nominal squeeze that the silicone takes: its stretch is `SAFE_SHARE` of that at break."""
    return 1 - 1 / (1 + SAFE_SHARE * silicone(design).elongation_at_break)


def split_ridges(design: Design) -> list[int]:
    """Return the ridges at which the cavity is parted: with split = "auto" those that are squeezed beyond
    what is safe, and their mirror images, so that the pieces between come out straight."""
    if design.mold.split == "none":
        return []
    skin, limit = skin_of(design), safe_strain(design)
    caught = [ridge for ridge, undercut in skin.undercuts.items() if undercut.strain > limit]
    return sorted({*caught, *(skin.count + 1 - ridge for ridge in caught)})
