"""How the linear model's time and peak memory grow with ridges and with unknowns.

`python -m bench.bench_growth [most ridges]` prints both tables and the slopes of the logarithms; more than
101 ridges, 998 at most, are a row of their own.
Every row is a process of its own. The designs are plain-ridges (and yamada-2002, with strips) made wider:
the outermost crest stays as low and the force per ridge as large as with nine ridges.
"""

from __future__ import annotations

import sys
from typing import Any

from bench.measure import alone, slope
from skincad import load
from skincad.inputs import Design

RIDGES = (9, 21, 51, 101)
MOST_STRIPED = 51  # ridges; the strips' triangles make the meshes seven times larger
LADDER = ((0.5, 2), (0.5, 3), (1.0, 3), (1.0, 4), (2.0, 4), (2.0, 5))  # fineness and order


def wide(template: str, ridges: int) -> Design:
    """Return a template's design with this many ridges; the crests' sag stays what it is with nine."""
    base = load(template)
    times = ridges / base.ridge.count
    margin = base.skin.width - base.ridge.count * base.ridge.pitch
    return base.with_(
        ridge={"count": ridges},
        skin={
            "curvature_radius": base.skin.curvature_radius * times**2,
            "width": margin + ridges * base.ridge.pitch,
        },
        contact={"force": base.contact.force * times},
    )


def checked(template: str, ridges: int) -> dict[str, Any]:
    """Return the time by stage and the size of one linear check."""
    import skincad.mechanics.models.linear  # noqa: F401 the import is not the model's
    from skincad.mechanics.check import check

    verdict = check(wide(template, ridges), model="linear")
    share = (verdict.all_touch_force.value or 0.0) / verdict.force
    return {"seconds": verdict.seconds, "unknowns": verdict.unknowns, "threshold": share}


def solved(fineness: float, order: int) -> dict[str, Any]:
    """Return the time by stage and the size of one level on nine ridges."""
    from time import perf_counter

    from skincad.mechanics import pad_of, plane_piece
    from skincad.mechanics.models.linear import level

    design = load("plain-ridges")
    pad = pad_of(design)
    started = perf_counter()
    piece = plane_piece(pad, fineness)
    meshed = perf_counter()
    answer = level(piece, order, design.contact.force)
    stages = {"total": perf_counter() - started, "mesh": meshed - started, **answer.seconds}
    return {"seconds": stages, "unknowns": answer.unknowns}


def table(label: str, rows: dict[str, dict[str, Any]], sizes: list[float]) -> None:
    """Print rows by stage as multiples of the first row's total, and the slopes."""
    stages = list(next(iter(rows.values()))["seconds"])
    unit = next(iter(rows.values()))["seconds"]["total"]
    print(f"\n{label}; times as multiples of the first total, {unit:.3f} s")
    print(f"{'':>12} {'unknowns':>9} {'peak, MB':>9}" + "".join(f" {stage:>9}" for stage in stages))
    for name, row in rows.items():
        ratios = "".join(f" {row['seconds'].get(stage, 0.0) / unit:9.2f}" for stage in stages)
        print(f"{name:>12} {row['unknowns']:9d} {row['peak_MB']:9.0f}{ratios}")
    if len(sizes) > 1:
        both = list(rows.values())
        by_stage = [slope(sizes, [max(r["seconds"].get(stage, 0.0), 1e-9) for r in both]) for stage in stages]
        memory = slope(sizes, [r["peak_MB"] for r in both])
        print(f"{'slope':>12} {'':9} {memory:9.2f}" + "".join(f" {s:9.2f}" for s in by_stage))


def main() -> None:
    most = int(sys.argv[1]) if len(sys.argv) > 1 else RIDGES[-1]
    counts = sorted({n for n in (*RIDGES, max(most, RIDGES[-1])) if n <= most})
    for template, largest in (("plain-ridges", most), ("yamada-2002", min(most, MOST_STRIPED))):
        some = [n for n in counts if n <= largest]
        rows = {f"{n} ridges": alone(checked, template, n) for n in some}
        table(f"{template}, the linear model to its usual tolerance", rows, [float(n) for n in some])
    rows = {f"{f:g}, {k}": alone(solved, f, k) for f, k in LADDER}
    sizes = [float(row["unknowns"]) for row in rows.values()]
    table("plain-ridges, one level, by fineness and order", rows, sizes)


if __name__ == "__main__":
    main()
