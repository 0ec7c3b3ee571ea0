"""Whether the intervals of the all-touch force's exponents hold the linear model's.

`python -m bench.sensitivities [SEED ...]`: of all templates, or of random designs; a row for each design and
key, and how many of each key lie inside. Differences are 3 % each way, of the linear model at its finest
tolerance that check asks for.
"""

from __future__ import annotations

import math

import skincad
from bench import runner
from bench.campaign.random_designs import drawn
from skincad.base import InputError, RefusedError
from skincad.inputs import Design
from skincad.mechanics import KEYS, Request, intervals
from skincad.mechanics.models import linear
from skincad.mechanics.models.winkler import all_touch_force

BY, FINEST = 0.03, 5e-3


def exponent(design: Design, key: str) -> float | None:
    """The exponent by the linear model; None where the key is not given, or a guard or the model refuses."""
    table, _, name = key.partition(".")
    now = getattr(getattr(design, table), name)
    ends = []
    for by in (1 - BY, 1 + BY) if now else ():
        try:
            changed = design.with_(**{table: {name: now * by}})
            force = linear.answer(changed, Request(design.contact.force, FINEST)).all_touch_force.value
        except (InputError, RefusedError):
            return None
        if not force:
            return None
        ends.append((math.log(by), math.log(force)))
    if not ends:
        return None
    (low, first), (high, last) = ends
    return (last - first) / (high - low)


def judged(case: runner.Case) -> runner.Row:
    """Return of each key of a design its interval and the linear model's exponent."""
    design = drawn(case).design if isinstance(case, int) else skincad.load(case)
    stated = intervals(design, all_touch_force(design))
    answers = {key: exponent(design, key) for key in stated.keys() & {*KEYS}}
    return {
        "case": f"seed {case}" if isinstance(case, int) else case,
        "keys": {key: [*stated[key], answer] for key, answer in answers.items() if answer is not None},
    }


def line(row: runner.Row) -> str:
    return "\n".join(
        f"{row['case']:20} {key:24} {low:6.2f} to {high:6.2f}: {value:6.2f}"
        + ("" if low <= value <= high else "  OUTSIDE")
        for key, (low, high, value) in row["keys"].items()
    )


def main() -> None:
    parser = runner.parser(__doc__)
    parser.add_argument("seeds", type=int, nargs="*")
    options = parser.parse_args()
    cases = options.seeds or skincad.template_names()
    rows = runner.rows("sensitivities", judged, cases, options, line)
    for key in KEYS:
        known = [row["keys"][key] for row in rows if key in row["keys"]]
        print(f"{key:24} {sum(low <= value <= high for low, high, value in known)} of {len(known)} inside")


if __name__ == "__main__":
    main()
