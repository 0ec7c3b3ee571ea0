"""Slip of six graded pins, pressed and pulled, against CalculiX at finite strain with friction.

`python -m bench.table_pin_slip`: about two minutes on an idle core. Half of the skin is meshed, cut between
the pins: where a cut runs through a tip CalculiX may lose its contact.
"""

from __future__ import annotations

from time import perf_counter

import skincad
from bench import calculix_pins
from skincad.effects.pin_pad import pin_pad
from skincad.inputs.design import Design
from skincad.mechanics.contact.state import Drive
from skincad.mechanics.contact.tips import advance, unloaded

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


def main() -> None:
    """Print each pin's pull, mN, by CalculiX and by skincad, at each travel of the plate."""
    design, began = six(), perf_counter()
    theirs, _ = calculix_pins.press(design, SIZE, [DOWN / 2, DOWN], PULLS, FRICTION, large=True)
    force = float(theirs[1, :, 1].sum())
    print(f"{perf_counter() - began:.0f} s; normal force {force:.4f} N")
    tips = pin_pad(design).tips
    state = advance(tips, unloaded(tips), Drive(force, travel=0.0), FRICTION)
    for travel, row in zip(PULLS, theirs[2:], strict=True):
        state = advance(tips, state, Drive(force, travel=travel), FRICTION)
        for name, pulls in (("CalculiX", row[:, 0]), ("skincad", state.tangential)):
            print(f"{travel:4} mm {name:9}", *(f"{1e3 * pull:7.2f}" for pull in pulls[:3]))


if __name__ == "__main__":
    main()
