"""The bores of a made part as a shop asks for them: where, how wide, how deep, which thread, for what.

Bores that are alike have one letter, and each its own number: D1, D2. Two on one line, in from both ends, are
one hole with two sides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import groupby
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from skincad.fabrication.bore_fits import full_thread, limits, purpose, thread
from skincad.fabrication.drawing_views import PartView, views
from skincad.inputs.design import Design
from skincad.solids.plan import Body, Bore, CutRole, ExtendedCut, Part, RotatedBody, Vector
from skincad.solids.projection import Place

if TYPE_CHECKING:
    import cadquery as cq

LETTERS = "DEFGHJKLMPQRSTUVXYZ"  # A to C are datums, N nuts, W a detail; I and O look like digits
PROBE_DISTANCE = 0.01  # mm beyond a bore's end, where there is material or none
ORDER = tuple(CutRole)
_SIDES = {"y": ("end a", "end b"), "z": ("below", "above")}


class Hole(NamedTuple):
    """One hole: its tag, and where it is in the view in which it is round, mm."""

    tag: str
    at: Place


class SideView(NamedTuple):
    """A bore seen from its side: in which view, and where its axis starts and ends there, mm."""

    view: str
    start: Place
    end: Place


@dataclass(frozen=True)
class HoleGroup:
    """Holes that are alike, seen round in one view. Lengths mm; `depth` is None where they go through.

    A conical one's `far_diameter` is at the last of its `sides`, to which it opens; elsewhere both are the
    same. `lean`, rad, is by how much its axis leans out of the view's line of sight.
    """

    letter: str
    view: str
    role: CutRole
    purpose: str
    diameter: float
    far_diameter: float
    depth: float | None
    thread: str  # "" where there is none
    limits: str  # of the diameter
    sides: tuple[str, ...]
    lean: float
    holes: tuple[Hole, ...]
    side_views: tuple[SideView, ...]
    full: float | None = None  # depth of its full thread, where that is not all of it

    @property
    def size(self) -> str:
        """The diameter as a drawing says it, both where it is conical."""
        if self.far_diameter == self.diameter:
            return f"Ø{number(self.diameter)}"
        return f"Ø{number(self.diameter)}-{number(self.far_diameter)}"

    @property
    def reach(self) -> str:
        """The depth, or THRU."""
        return "THRU" if self.depth is None else number(self.depth)


def number(value: float) -> str:
    """Return a length, mm, as drawings have it: to the micrometre, without zeros behind."""
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


class _DrilledBore(NamedTuple):
    bore: Bore
    role: CutRole
    opens: tuple[bool, bool]  # at its start, at its end
    lean: float
    start: Vector  # in the part's own frame
    end: Vector

    @property
    def axis(self) -> Vector:
        """The way from its start to its end, of length 1."""
        x, y, z = ((b - a) / self.bore.length for a, b in zip(self.start, self.end, strict=True))
        return x, y, z

    @property
    def mouth(self) -> Vector:
        """The middle of where it opens."""
        return self.start if self.opens[0] or not self.opens[1] else self.end

    def like(self) -> tuple[float | str, ...]:
        """What bores of one letter have in common."""
        depth = -1.0 if all(self.opens) else self.bore.length
        sizes = (round(v, 6) for v in (self.bore.radius, self.bore.far_radius, depth, abs(self.lean)))
        return (ORDER.index(self.role), self.bore.axis, *sizes)


def hole_groups(design: Design, part: Part, shape: cq.Solid) -> list[HoleGroup]:
    """Return all bores of a made part, `made` its solid in the mold, in groups of a letter each."""
    drilled, seen = sorted(_drilled_bores(part, shape), key=_DrilledBore.like), views(part)
    alike = [list(group) for _, group in groupby(drilled, key=_DrilledBore.like)]
    letters = [*LETTERS, *(f"{a}{b}" for a in LETTERS for b in LETTERS)]
    return [_group(design, part, letter, group, seen) for letter, group in zip(letters, alike, strict=False)]


def _group(
    design: Design, part: Part, letter: str, alike: list[_DrilledBore], seen: list[PartView]
) -> HoleGroup:
    first = alike[0]
    view = max(seen, key=lambda s: abs(_dot(s.of_part.towards, first.axis)))
    places: dict[Place, None] = {}
    for one in alike:
        x, y = view.of_part.at(one.mouth)
        places[(round(x, 6) + 0.0, round(y, 6) + 0.0)] = None
    rows = sorted(places, key=lambda at: (-at[1], at[0]))
    names = _SIDES[first.bore.axis]
    sides = [name for i, name in enumerate(names) if any(one.opens[i] for one in alike)]
    return HoleGroup(
        letter=letter,
        view=view.name,
        role=first.role,
        purpose=purpose(design, part, first.role),
        diameter=2 * first.bore.radius,
        far_diameter=2 * first.bore.far_radius,
        depth=None if all(first.opens) else first.bore.length,
        thread=thread(design, part, first.role),
        limits=limits(design, part, first.role),
        sides=tuple(sides),
        lean=abs(first.lean),
        holes=tuple(Hole(f"{letter}{i}", at) for i, at in enumerate(rows, 1)),
        side_views=tuple(_side_views(alike, [one for one in seen if one is not view])),
        full=full_thread(design, first.role),
    )


def _side_views(alike: list[_DrilledBore], seen: list[PartView]) -> list[SideView]:
    """Bores from their sides, those that lie behind others once."""
    rows = [
        SideView(view.name, view.of_part.at(one.start), view.of_part.at(one.end))
        for view in seen
        for one in alike
    ]
    return list({(row.view, *np.round([*row.start, *row.end], 6).tolist()): row for row in rows}.values())


def _drilled_bores(part: Part, shape: cq.Solid) -> list[_DrilledBore]:
    """The bores of a part. Whether they open at their ends is asked of the solid once for all that differ by
    their place alone."""
    rows: list[_DrilledBore] = []
    known: dict[tuple[object, ...], tuple[bool, bool]] = {}
    for cut in part.cuts:
        bore, turned = _bore(cut)
        if bore is None or bore.role is None:
            continue
        start, end = _ends(bore, 0.0)
        level = bore.start[1 if bore.axis == "y" else 2]
        kind = (bore.role, bore.axis, level, bore.length, bore.radius, turned and turned.angle)
        if kind not in known:
            low, high = (not shape.isInside(_placed(turned, p), 1e-6) for p in _ends(bore, PROBE_DISTANCE))
            known[kind] = low, high
        opens, lean = known[kind], 0.0
        if turned is not None and not isinstance(part.body, RotatedBody):
            start, end, lean = _placed(turned, start), _placed(turned, end), turned.angle
        rows.append(_DrilledBore(bore, bore.role, opens, lean, start, end))
    return rows


def _bore(cut: Body) -> tuple[Bore | None, RotatedBody | None]:
    """A cut's bore in its own frame, and how it is turned; None if it is none."""
    counts = cut.counts if isinstance(cut, ExtendedCut) else cut
    body, turned = (counts.body, counts) if isinstance(counts, RotatedBody) else (counts, None)
    return (body, turned) if isinstance(body, Bore) else (None, None)


def _ends(bore: Bore, extra: float) -> tuple[Vector, Vector]:
    """Where a bore's axis is at both ends, or this far beyond them, mm."""
    x, y, z = bore.start
    if bore.axis == "y":
        return (x, y - extra, z), (x, y + bore.length + extra, z)
    return (x, y, z - extra), (x, y, z + bore.length + extra)


def _placed(turned: RotatedBody | None, point: Vector) -> Vector:
    if turned is None:
        return point
    x, y, z = turned.placed(np.array([point]))[0].tolist()
    return x, y, z


def _dot(a: Vector, b: Vector) -> float:
    return math.fsum(u * v for u, v in zip(a, b, strict=True))
