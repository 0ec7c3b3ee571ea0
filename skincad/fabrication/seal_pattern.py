"""The cutting pattern of the foam under the cover, flat, mm: outline, and the cover's holes over carriers."""

from __future__ import annotations

from typing import NamedTuple

from skincad.fabrication.cut_profile import cut_profile
from skincad.shape.curves import Loop
from skincad.solids.layout import SQUEEZED_SHARE
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import PartRole, Prism
from skincad.solids.projection import Place


class SealPattern(NamedTuple):
    """A seal's outline and then its holes, seen from above with end b up, mm, and what is said of it."""

    loops: tuple[Loop, ...]
    notes: list[str]

    @property
    def box(self) -> tuple[Place, Place]:
        """Lower left and upper right corner, mm: its outline has straight sides."""
        x, y = zip(*(s.start for s in self.loops[0]), strict=True)
        return (min(x), min(y)), (max(x), max(y))


def seal_pattern(closed: ClosedMold) -> SealPattern:
    """Return the pattern of a mold's seal. Raises ValueError where it has none."""
    seal = closed.first(PartRole.SEAL)
    profile = cut_profile(seal)
    if profile is None or not isinstance(seal.body, Prism):
        raise ValueError("a seal is cut from a sheet")
    high = seal.body.high - seal.body.low
    notes = [
        f"closed-cell EVA foam, sheet of {high / SQUEEZED_SHARE:.3g} mm, squeezed to {high:.3g} mm by the "
        "closed cover",
        "seen from above, end b up; CUT at nominal size, kerf not compensated; foam does not shrink: 1:1",
    ]
    return SealPattern(profile.loops, notes)
