"""The reduced model against the corrected one on pads that both can hold, and its time with 999 ridges.

`python -m bench.table_reduced`: some minutes. Every pad is a template with more ridges, its radius larger by
the square, so that its crests lie as far from each other."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import numpy as np

import skincad
from skincad.inputs import Design
from skincad.mechanics import Request
from skincad.mechanics.models import corrected, reduced
from skincad.shape import skin_of

PADS: tuple[tuple[str, int, dict[str, Any]], ...] = (
    ("plain-ridges", 45, {}),
    ("plain-ridges", 45, {"skin": {"length": 24.0}}),
    ("plain-ridges", 45, {"skin": {"length": 6.0}}),
    ("plain-ridges", 45, {"skin": {"thickness": 2.0}}),
    ("plain-ridges", 45, {"skin": {"thickness": 7.0}}),
    ("plain-ridges", 45, {"ridge": {"height": 0.9}}),
    ("plain-ridges", 101, {}),
    ("yamada-2002", 27, {}),
    ("milled-pad", 27, {}),
    ("fingertip-soft", 25, {}),
    ("lab-bench", 27, {}),
)
MOST = 999


def longer(design: Design, count: int, changes: dict[str, Any]) -> Design:
    """Return the design with so many ridges, its crests as far from each other, and as much force on each."""
    skin = skin_of(design)
    more = count / skin.count
    sizes = {
        "width": min(design.skin.width + (count - skin.count) * skin.pitch, 1000.0),
        "curvature_radius": min(design.skin.curvature_radius * more**2, 1e6),
        **changes.get("skin", {}),
    }
    load = {"force": design.contact.force * more, "friction": 0.0}
    return design.with_(ridge={"count": count, **changes.get("ridge", {})}, skin=sizes, contact=load)


def main() -> None:
    head = f"{'all touch':>11}{'approach':>10}{'share':>8}{'reduced, s':>12}{'corrected, s':>14}"
    print(f"{'relative difference to the corrected model':56}{head}")
    for name, count, changes in PADS:
        design = longer(skincad.load_design(name), count, changes)
        request, began = Request(design.contact.force), perf_counter()
        quick, middle = reduced.answer(design, request), perf_counter()
        full = corrected.answer(design, request)
        took = middle - began, perf_counter() - middle
        shares = [np.array([f.value for f in answer.ridge_force]) for answer in (quick, full)]
        share = np.abs(shares[0] - shares[1]).max() / shares[1].mean()
        force, approach = (
            (of(quick).value or 0.0) / (of(full).value or 1.0) - 1
            for of in (lambda a: a.all_touch_force, lambda a: a.approach)
        )
        what = f"{name}, {count} ridges, {changes or 'as it is'}"
        print(
            f"{what:56}{force:+11.2%}{approach:+10.2%}{share:8.2%}{took[0]:12.1f}{took[1]:14.1f}", flush=True
        )
    design, began = longer(skincad.load_design("plain-ridges"), MOST, {}), perf_counter()
    print(f"{MOST} ridges: {skincad.check(design)}\n{perf_counter() - began:.1f} s")


if __name__ == "__main__":
    main()
