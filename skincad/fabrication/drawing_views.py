"""From where a made part is drawn: three views in first-angle arrangement (ISO 5456-2), in its own frame.

Below the front view is what is seen from above, to its right what is seen from the left. The front view is
the one that shows most: an end plate's outer face, a lid's plan, what one sees of a cavity at end a.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from skincad.solids.plan import Part, PartRole, RotatedBody, Vector
from skincad.solids.projection import View

FRONT, ABOVE, LEFT = "front", "above", "left"
LIDS = {PartRole.CARRIER, PartRole.COVER}


class PartView(NamedTuple):
    """A view of a part: its place on the sheet, from where it is seen in words, and the view in the part's
    own frame and in that in which its solid is."""

    name: str
    words: str
    of_part: View
    of_solid: View


def views(part: Part) -> list[PartView]:
    """Return front view, view from above and view from the left of a part."""
    right, up = _front(part)
    front = View(right, up)
    x, y, z = front.towards
    below, from_left = View(right, (-x, -y, -z)), View(front.towards, up)
    if part.role in LIDS:
        words = "from above", "from end b", "from the left"
    else:
        words = f"from outside end {part.end or 'a'}", "from above", "from its left"
    return [
        PartView(name, caption, view, _turned(part, view))
        for name, caption, view in zip((FRONT, ABOVE, LEFT), words, (front, below, from_left), strict=True)
    ]


def _front(part: Part) -> tuple[Vector, Vector]:
    if part.role in LIDS:
        return (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
    return (-1.0 if part.end == "b" else 1.0, 0.0, 0.0), (0.0, 0.0, 1.0)


def _turned(part: Part, view: View) -> View:
    """The same view of a part that stands turned in the mold."""
    if not isinstance(part.body, RotatedBody):
        return view
    turn, shift = part.body.placement()
    right, up = (tuple((turn @ np.array(way)).tolist()) for way in (view.right, view.up))
    return View(right, up, tuple(shift.tolist()))
