"""The skin's construction against booleans of the same ridges, as ratios of medians in one run.

python -m bench.bench_skin [repeats]
"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import reduce
from time import perf_counter

import cadquery as cq

import skincad
from skincad.shape import Loop, Point, Segment, loop, section, skin_of
from skincad.solids import Part, PartRole, Prism, skin_part, solid, unchecked_solid


def pieces(design: skincad.Design) -> list[Part]:
    """The block under the base circle, and each ridge as a solid of its own that reaches into it."""
    outline, half = section(design).outline, design.skin.length / 2

    def part(shape: Loop) -> Part:
        return Part("piece", PartRole.SKIN, Prism(shape, "y", -half, half))

    corners = [s for s in outline if s.kind in ("back", "side")]
    left, right = corners[2].start, corners[1].end
    top = Segment(right, left, math.tan(math.asin(left.x / -design.skin.curvature_radius) / 2))
    ridges = []
    for ridge in range(1, skin_of(design).count + 1):
        rows = [s for s in outline if s.feature == ridge]
        a, b = rows[-1].end, rows[0].start
        foot = loop([Point(a.x, a.z), Point(a.x, a.z - 0.5), Point(b.x, b.z - 0.5), Point(b.x, b.z)])
        ridges.append(part((*rows, *foot[:3])))
    return [part((corners[0], corners[1], top, corners[2])), *ridges]


def median(job: Callable[[], object], repeats: int) -> float:
    times = []
    for _ in range(repeats):
        begin = perf_counter()
        job()
        times.append(perf_counter() - begin)
    return statistics.median(times)


def main() -> None:
    """Print the table."""
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    base = skincad.load("yamada-2002")
    print("construction of the skin from its section's segments, s; booleans as multiples of it")
    print("ridges   direct  + checks  n-ary fuse and cut  pairwise  volume error")
    for count in (9, 45):
        skin = {"curvature_radius": 60.0 * count / 9, "width": 2.0 + count}
        design = base.with_(ridge={"count": count}, skin=skin)
        plan, parts = skin_part(design), pieces(design)
        slots = [replace(plan, body=replace(plan.body, outline=h, holes=())) for h in plan.body.holes]

        def made(rows: list[Part]) -> list[cq.Solid]:
            return [unchecked_solid(part) for part in rows]

        def booleans() -> cq.Shape:
            body, *ridges = made(parts)  # noqa: B023
            return body.fuse(*ridges).cut(*made(slots))  # noqa: B023

        def pairwise() -> cq.Shape:
            whole = reduce(lambda a, b: a.fuse(b), made(parts))  # noqa: B023
            return reduce(lambda a, b: a.cut(b), made(slots), whole)  # noqa: B023

        direct = median(lambda p=plan: unchecked_solid(p), repeats)
        checked = median(lambda p=plan: solid(p), repeats)
        n_ary, pairs = median(booleans, repeats), median(pairwise, max(1, repeats // 5))
        error = booleans().Volume() / plan.volume - 1
        ratios = f"{checked / direct:8.1f}x {n_ary / direct:18.1f}x {pairs / direct:8.1f}x"
        print(f"{count:6d} {direct:8.4f} {ratios} {error:13.1e}")


if __name__ == "__main__":
    main()
