"""Which ridge slips first by another law of friction: told from the loads of a march by this one.

Just before the first ridge slips most of the contact sticks, so that what each ridge bears hangs little on
the law: by Coulomb the ridge with the largest tangential by normal force is next, by a constant shear stress
the one with the largest by contact area. An estimate: parts of ridges slip already by
then (docs/evidence/scenes.md#laws-of-friction).
"""

from __future__ import annotations

import numpy as np

from skincad.base.arrays import Array, Mask
from skincad.effects.kinds import PlatePath

LOADED = 0.02  # of the mean normal force of the ridges that touch; one with less has only just touched
PULLED = 0.05  # tangential by normal force; with less the ridges slip as they are pressed
CLEAR = 1.2  # by what factor the first must lead; chosen on those marches, where less told of flips in vain


def flipped(path: PlatePath, by_area: bool) -> tuple[int, int] | None:
    """Return which ridge slips first in a march, from 1, and which would by the other law, or None where it
    is the same, too close to call, or none slips. `by_area`: friction follows the area, the other Coulomb."""
    step = _first_slip(path)
    if step is None:
        return None
    here = step - 1
    pull, loaded = np.abs(path.pulled[here]), _loaded(path)[here]
    by_force, by_contact = (_share(pull, values[here], loaded) for values in (path.pressed, path.area))
    one, other = (by_contact, by_force) if by_area else (by_force, by_contact)
    slips = (path.slips[step] == 1) & (path.slips[here] < 1)
    first, instead = int(np.where(slips, one, -1.0).argmax()), int(other.argmax())
    return (first + 1, instead + 1) if other[instead] > CLEAR * other[first] else None


def _share(pull: Array, by: Array, loaded: Array) -> Array:
    return np.where(loaded, pull / np.where(loaded, by, 1.0), 0.0)


def _first_slip(path: PlatePath) -> int | None:
    """The step at which a loaded ridge begins to slip as the plate pulls, None without one."""
    press, pull = path.pressed.sum(axis=1), np.abs(path.pulled.sum(axis=1))
    slips, pulls = path.slips == 1, pull > PULLED * press
    begins = slips[1:] & ~slips[:-1] & _loaded(path)[:-1] & pulls[1:, None]
    steps = np.flatnonzero(begins.any(axis=1))
    return int(steps[0]) + 1 if steps.size else None


def _loaded(path: PlatePath) -> Mask:
    """Which ridges count at each step: not those that have just met the plate, nor those that leave it."""
    mean = path.pressed.sum(axis=1) / np.maximum((path.area > 0).sum(axis=1), 1)
    return np.asarray((path.pressed > LOADED * mean[:, None]) & (path.pressed[-1] > 0))
