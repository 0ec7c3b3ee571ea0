"""The reduced model of pins against CalculiX in three dimensions, on random designs.

`python -m bench.table_reduced_pins [first] [end] [ratio]`: about half a minute a design. Nine or twenty-five
graded pins on flat, bent and doubly curved bases; Poisson's ratio 0.49 in both, or another: CalculiX has no
hybrid elements. `python -m bench.table_reduced_pins layers [first] [end]`: on a back of another silicone, a
twentieth to twenty times as stiff. `python -m bench.table_reduced_pins times`: seconds of a check by the
number of pins.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from time import perf_counter, process_time

import numpy as np

import skincad
from bench import calculix_pins, runner
from skincad.base import RefusedError
from skincad.inputs import Design, layers, shoulder
from skincad.inputs.material import silicone
from skincad.mechanics.models import reduced
from skincad.shape import skin_of

FINENESS = 6  # elements over a tip
LEVELS = 0.92, 0.98  # of the approach at which all touch
STRAIN = 0.05  # of a pin, at the force whose shares are compared


def random_pins(seed: int) -> Design:
    """Return one of the designs, by its number."""
    rng = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return round(float(rng.uniform(low, high)), 3)

    tip = between(0.8, 3.0)
    root, height = tip * between(1.05, 1.4), tip * between(0.5, 1.8)
    pitch, crown = root + tip * between(0.3, 1.2), tip * between(0.06, 0.25)
    thickness, margin = pitch * between(0.3, 1.2), root / 2 + tip * between(0.15, 1.0)
    count = int(rng.choice([3, 3, 3, 5]))
    drop = height * between(0.02, 0.08)
    rings = count // 2 + 1
    width = (count - 1) * pitch + 2 * margin
    lean, kind = math.radians(between(2, 6)), rng.choice(["flat", "flat", "bent", "dome"])
    radius = (count - 1) * pitch / 2 / math.sin(lean)
    if kind != "flat":
        thickness += radius * (1 - math.cos(1.3 * lean)) * (2 if kind == "dome" else 1)
    skin = {"thickness": thickness, "width": width, "length": width}
    skin["curvature_radius"] = 1e8 if kind == "flat" else radius
    pin = {"pattern": "square", "columns": count, "rows": count, "pitch": pitch, "root_diameter": root}
    pin |= {"tip_diameter": tip, "crown": crown}
    if kind == "dome":
        skin["curvature_radius_y"] = radius
    pin |= {"heights": [height - i * drop for i in range(rings)]}
    return skincad.Design(
        name=f"{kind}-{count}x{count}",
        skin=skin,
        pin=pin,
        material={"name": "dragon-skin-20", "poisson_ratio": 0.49},
        mold={"process": "sla", "pour": "open"},
        contact={"force": 1.0, "friction": 0.0},
    )


def layered(seed: int) -> Design:
    """Return one of the designs with a back of another silicone, by its number."""
    design, rng = random_pins(seed), np.random.default_rng((seed, 1))
    deep = round(float(rng.uniform(0.25, 0.6)) * shoulder(design.skin), 3)
    modulus = round(silicone(design).young_modulus.value * float(20 ** rng.uniform(-1, 1)), 4)
    where = str(rng.choice(["thickness", "depth"]))
    return design.with_(shot=[{where: deep, "young_modulus": modulus, "poisson_ratio": 0.49}])


def compared(design: Design) -> tuple[float, float, float, float]:
    """Return the all-touch force in N by CalculiX, and how much the reduced model's is more, relative; the
    same of the approach; and the largest difference of forces, of their mean."""
    model, tip = reduced.feature_model(design, 1.0, {}), skin_of(design).profile.tip_width
    first = reduced.all_touch_force(model)
    closes = reduced.pressed(model, first)[1]
    nominal = STRAIN * silicone(design).young_modulus.value * math.pi / 4 * tip**2 * model.gap.size
    end = max(reduced.pressed(model, max(nominal, 1.3 * first))[1], 1.2 * closes)
    down = np.array([*(level * closes for level in LEVELS), end])
    forces, rises = calculix_pins.press(design, tip / FINENESS, down.tolist())
    forces = forces[:, :, 1]
    last, total = int(model.gap.argmax()), forces.sum(axis=1)
    gaps = model.gap[last] - down[:2] - rises[:2, last]  # before it touches, where forces have no kink
    touch = down[0] + (down[1] - down[0]) * gaps[0] / (gaps[0] - gaps[1])
    rise = math.log(total[1] / total[0]) / math.log(down[1] / down[0])
    theirs = float(total[1] * (touch / down[1]) ** rise)
    shares, approach = reduced.pressed(model, float(total[-1]))
    off = float(np.abs(shares - forces[-1]).max() / forces[-1].mean())
    return theirs, first / theirs - 1, approach / end - 1, off


def many(count: int) -> Design:
    """Return rows of as many fine pins on a slightly curved base, lower outwards."""
    width = count + 1.0
    skin = {"thickness": 5.0, "width": width, "length": width}
    pin = {"pattern": "square", "columns": count, "rows": count, "pitch": 1.0, "crown": 0.08}
    pin |= {"heights": [0.5 - 0.002 * ring for ring in range((count + 1) // 2)]}
    return skincad.Design(
        name=f"pins-{count**2}",
        skin={**skin, "curvature_radius": 200.0, "curvature_radius_y": 300.0},
        pin={**pin, "root_diameter": 0.7, "tip_diameter": 0.5},
        material={"name": "dragon-skin-20"},
        mold={"process": "sla"},
        contact={"force": 10.0},
    )


def judged(seed: int, make: Callable[[int], Design], ratio: float) -> runner.Row:
    """Return a design's comparison; RefusedError where CalculiX fails."""
    design, began = make(seed).with_(material={"poisson_ratio": ratio}), perf_counter()
    try:
        numbers = compared(design)
    except RuntimeError as failure:
        raise RefusedError(f"{design.name} {str(failure).splitlines()[0]}") from None
    name = design.name
    if design.shot:
        stiff = layers(design)[0].young_modulus.value / silicone(design).young_modulus.value
        name += f", {stiff:.2g}"
    return {"seed": seed, "name": name, "numbers": numbers, "seconds": perf_counter() - began}


def line(row: runner.Row) -> str:
    """Return a design's line."""
    force, off, approach, share = row["numbers"]
    numbers = f"{force:17.4f}{off:+8.1%}{approach:+10.1%}{share:8.1%}{row['seconds']:6.0f}"
    return f"{row['seed']:3} {row['name']:16}{numbers}"


def times() -> None:
    """Print the seconds of a check by the number of pins."""
    for count in (22, 44):
        began, cpu = perf_counter(), process_time()
        result = skincad.check(many(count))
        spent = f"{perf_counter() - began:.1f} s, {process_time() - cpu:.1f} s of processors"
        print(f"{result.name}: {spent}; all touch at {result.all_touch_force}", flush=True)


def main() -> None:
    parser = runner.parser(__doc__)
    parser.add_argument("words", nargs="*", help="layers or times; first and last seed; Poisson's ratio")
    options = parser.parse_args()
    words, make = options.words, random_pins
    if words == ["times"]:
        times()
        return
    if words[:1] == ["layers"]:
        words, make = words[1:], layered
    first, end = (int(word) for word in (words[:2] or ("0", "16")))
    ratio = float(words[2]) if len(words) > 2 else 0.49
    print(f"{'':20}{'all touch at, N':>17}{'off':>8}{'approach':>10}{'share':>8}{'s':>6}")
    judge = partial(judged, make=make, ratio=ratio)
    runner.rows(f"{make.__name__}-{ratio:g}", judge, range(first, end), options, line)


if __name__ == "__main__":
    main()
