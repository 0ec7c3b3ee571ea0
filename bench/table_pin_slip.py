"""Slip of six graded pins, pressed and pulled, against CalculiX at finite strain with friction.

`python -m bench.table_pin_slip`: about two minutes on an idle core. Half of the skin is meshed, cut between
the pins: where a cut runs through a tip CalculiX may lose its contact.
"""

from __future__ import annotations

from collections.abc import Sequence
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

import skincad
from bench import calculix_pins
from skincad.effects.pin_pad import pin_pad
from skincad.inputs import Design
from skincad.mechanics import Drive, advance
from skincad.mechanics.contact.tips import unloaded

FRICTION, DOWN = 0.3, 0.2  # mm, after half of it
PULLS = 0.1, 0.2, 0.3, 0.4, 0.5  # mm
SIZE = 0.45  # mm, of elements


def six() -> Design:
    """Two rows of three pins, the middle one of each 0.1 mm higher."""
    return skincad.Design(
        name="six",
        skin={"curvature_radius": 1e8, "thickness": 2.0, "width": 12.0, "length": 8.0},
        pin={
            "columns": 3,
            "rows": 2,
            "pitch": 4.0,
            "root_diameter": 2.2,
            "tip_diameter": 1.8,
            "crown": 0.3,
            "heights": [2.4, 2.5, 2.4] * 2,
        },
        material={"name": "dragon-skin-20", "poisson_ratio": 0.49},
        mold={"process": "sla", "pour": "open"},
        contact={"force": 0.2},
    )


def compared(pulls: Sequence[float]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the pins' pulls and normal forces `(travels, pins, 2)`, N, by CalculiX and by skincad, at the
    plate's travels, mm, under the normal force that CalculiX has when it is down."""
    design = six()
    theirs, _ = calculix_pins.press(design, SIZE, [DOWN / 2, DOWN], pulls, FRICTION, large=True)
    force, tips = float(theirs[1, :, 1].sum()), pin_pad(design).tips
    state, ours = advance(tips, unloaded(tips), Drive(force, travel=0.0), FRICTION), []
    for travel in pulls:
        state = advance(tips, state, Drive(force, travel=travel), FRICTION)
        ours.append(np.stack([state.tangential, state.normal], axis=1))
    return theirs[2:], np.array(ours)


def main() -> None:
    began = perf_counter()
    both = compared(PULLS)
    print(f"{perf_counter() - began:.0f} s")
    for travel, *rows in zip(PULLS, *both, strict=True):
        for name, row in zip(("CalculiX", "skincad"), rows, strict=True):
            print(f"{travel:4} mm {name:9}", *(f"{1e3 * pull:7.2f}" for pull in row[:3, 0]))


if __name__ == "__main__":
    main()
