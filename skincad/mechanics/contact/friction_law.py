"""What friction bears at a contact point, by its normal force and by its area.

By Coulomb's law that is the normal force times a coefficient. Other laws say which shear stress is borne at
which pressure, straight between a few knees and constant beyond the last; one knee is a constant shear stress
capped by Coulomb. A sliding point's force is then t = slope p + stress a, both of the line on which its
pressure lies: for given lines the equations of a step stay linear, and the lines are one more set to be
found.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from skincad.base.arrays import Array, Index
from skincad.mechanics.contact.grip import FrictionCoefficients
from skincad.mechanics.problem import ContactError

NONE = np.zeros(0)
NO_LINES = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class FrictionLaw:
    """A point that sticks bears `static`, one that slides `kinetic` times what `borne` says of it. Without
    knees that is the normal force; with them `static` is 1, and `pressure`, `stress` `(k + 1,)` MPa, both
    from 0 on, are of points of `area` `(m,)` mm2."""

    static: float
    kinetic: float
    bends: bool
    area: Array
    pressure: Array
    stress: Array

    def borne(self, normal: Array) -> Array:
        """Return the force `(m,)` N, static friction's of a law with knees, at normal forces `(m,)` N."""
        if not self.bends:
            return normal
        return self.area * np.interp(normal / self.area, self.pressure, self.stress)

    def line(self, normal: Array) -> Index:
        """Return on which line each point lies `(m,)`, 0 up to the first knee; nothing without knees."""
        if not self.bends:
            return NO_LINES
        return np.searchsorted(self.pressure[1:], normal / self.area)

    def sliding(self, line: Index, way: Array) -> tuple[Array, Array | None]:
        """Return slope and offset N `(m,)` of what drags points that slide on these lines, to +x where `way`
        is 1 and to -x where it is -1; None where no law has an offset."""
        if not self.bends:
            return self.kinetic * way, None
        slopes = np.append(np.diff(self.stress) / np.diff(self.pressure), 0.0)
        offsets = self.stress - slopes * self.pressure
        along = self.kinetic * way
        return along * slopes[line], along * offsets[line] * self.area


def law_of(cone: FrictionCoefficients, area: Array | None) -> FrictionLaw:
    """Return the law of points of `area` `(m,)` mm2, which Coulomb's does not ask for."""
    if not cone.breakpoints:
        return FrictionLaw(cone.static, cone.kinetic, False, NONE, NONE, NONE)
    if area is None:
        raise ContactError("friction by shear stress asks for the area of each contact point")
    pressure, stress = np.array([(0.0, 0.0), *cone.breakpoints]).T
    return FrictionLaw(1.0, cone.kinetic / cone.static, True, area, pressure, stress)
