"""Each ridge on a spring, all springs coupled, so that a pressed skin is that of its check.

A plate at approach d meets ridge i with d - gap_i = sum_j C_ij F_j where F_i > 0. C is the reduced pad that
tells a check's yield (mechanics/contact/ridge_model.py), each ridge's own flexibility taken as the secant at
the check's force on it. That pad is long and in small strain; the check may know more. So all of C is scaled
by one factor and its diagonal then moved until the check's approach and forces solve the equation: at that
load the springs are the check, at others they are near it, and `Springs.elsewhere` says how near. Where there
is no reduced pad (one ridge, a doubly curved skin, forces that never make all touch) C is diagonal.

A stiffness K = C^-1 is the sum of squares of the rows of its Cholesky factor: as many springs, each along a
combination of ridges, are that same matrix in a simulator that knows no coupled springs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.base.estimate import Estimate
from skincad.base.progress import Progress
from skincad.base.result import Record, item, record, reported
from skincad.inputs.design import Design
from skincad.mechanics.check import check
from skincad.mechanics.contact.frictionless import press
from skincad.mechanics.models.table import unsupported_reason
from skincad.mechanics.models.winkler import crest_gaps, stiffnesses
from skincad.mechanics.problem import ContactError, Request, RidgeModel, SizeError, pad_of
from skincad.mechanics.verdict import ContactCheck
from skincad.outputs.simulators.links import feature_bodies
from skincad.shape.skin import skin_of

SPANS = (0.5, 2.0)  # of the load, where the springs are held against another check
LEAST_SHARE = 1e-3  # of the mean share; a ridge that carries less has no secant of its own


@record()
class LoadComparison(Record):
    """The springs against a check at another load."""

    force: float = item("N", "the plate's force")
    approach: float = item("mm", "the springs' approach")
    check_approach: float = item("mm", "the check's approach")
    shares: tuple[float, ...] = item("N", "force on each ridge by the springs", key="ridge_force_N")
    check_shares: tuple[float, ...] = item("N", "the same by the check", key="check_ridge_force_N")

    @property
    def approach_off(self) -> float:
        """Difference of the approaches, of the check's."""
        return abs(self.approach / self.check_approach - 1)

    @property
    def shares_off(self) -> float:
        """Largest difference of two forces on a ridge, of the mean one."""
        differs = np.abs(np.subtract(self.shares, self.check_shares))
        return float(differs.max()) * len(self.shares) / self.force


@record(eq=False)
class Springs(Record):
    """Springs of the ridges: `gap` `(n,)` mm, `flexibility` `(n, n)` mm/N, and the `verdict` behind them."""

    gap: Array = item("mm", "of each ridge below the first crest that touches")
    flexibility: Array
    coupled: bool = item(meaning="whether springs share the flexibility")
    verdict: ContactCheck
    members: tuple[tuple[int, ...], ...] = item(
        meaning="features on each spring, from 0; none: each is on its own", default=()
    )
    elsewhere: tuple[LoadComparison, ...] = item(
        meaning="the springs against checks at other loads", default=()
    )
    refused: tuple[str, ...] = item(meaning="at which loads there is no check, and why", default=())

    @reported("N", "the plate's force at which the springs are the check")
    def force(self) -> float:
        """Force of the check, N."""
        return self.verdict.force

    @reported(meaning="the check's model", key="tier")
    def model(self) -> str:
        """Name of the check's model."""
        return self.verdict.model

    @reported("mm", "approach after the first touch")
    def approach(self) -> Estimate:
        """Approach of the check, mm."""
        return self.verdict.approach

    @reported("N", "force on each ridge")
    def ridge_force(self) -> tuple[Estimate, ...]:
        """Forces of the check, N."""
        return tuple(self.verdict.ridge_force)

    @property
    def body_force(self) -> Array:
        """Force of the check on each spring, `(n,)` N."""
        return _summed(self.verdict, self.members)

    @reported("N/mm", "stiffness, `(n, n)`")
    def stiffness(self) -> Array:
        """Stiffness `(n, n)` N/mm."""
        inverse = np.linalg.inv(self.flexibility)
        return np.asarray((inverse + inverse.T) / 2)

    @property
    def alone(self) -> Array:
        """Stiffness `(n,)` N/mm of springs without neighbours that bear the check's forces at its approach,
        each its own where it bears next to none there."""
        force, reach = self.body_force, float(self.verdict.approach) - self.gap
        bears = (force > LEAST_SHARE * force.mean()) & (reach > 0)
        return np.where(bears, force, 1.0) / np.where(bears, reach, np.diag(self.flexibility))

    @property
    def rows(self) -> Array:
        """Rows `(n, n)` in (N/mm)^1/2 whose squares' sum is the stiffness."""
        return np.asarray(np.linalg.cholesky(self.stiffness).T)


def springs(
    design: Design, model: str = "auto", progress: Progress | None = None, *, coupled: bool = True
) -> Springs:
    """Return the springs of a design under a flat plate at the design's own force; not `coupled` those that
    stand `alone`, for a simulator that couples none.

    Raises InputError for a plate that is not flat; RefusedError for a check beyond its model's range.
    """
    if design.contact.plate.shape != "flat":
        rule = "must be 'flat' for mujoco and usd: their springs are those of a skin under a flat plate"
        remedy = "--set contact.plate=none, or leave these out by --for"
        raise InputError("contact.plate.shape", rule, design.contact.plate.shape, remedy)
    verdict = check(design, model=model, progress=progress)
    if verdict.out_of_range:
        raise RefusedError(f"no springs: {verdict.out_of_range}; take a smaller contact.force")
    if skin_of(design).standing:
        nominal = _of_pins(design, verdict)
    else:
        nominal = _fit(design, verdict, _reduced(design, verdict.force, progress))
    if not coupled:
        nominal = replace(nominal, flexibility=np.diag(1 / nominal.alone), coupled=False)
    elsewhere, refused = [], []
    for force in (span * verdict.force for span in SPANS):
        try:
            elsewhere.append(_compare_at(design, nominal, force, progress))
        except (InputError, RefusedError) as failure:
            refused.append(f"no check at {force:g} N: {failure}")
    return replace(nominal, elsewhere=tuple(elsewhere), refused=tuple(refused))


def _reduced(design: Design, force: float, progress: Progress | None) -> RidgeModel | None:
    """The linear pad reduced to one force a ridge, or None where there is none."""
    from skincad.mechanics.models import linear

    if unsupported_reason("linear", design, measured=False) or skin_of(design).count == 1:
        return None
    try:
        return linear.solve(pad_of(design), Request(force, ridge_model=True), progress).ridge_model
    except (SizeError, ContactError):
        return None


def _fit(design: Design, verdict: ContactCheck, model: RidgeModel | None) -> Springs:
    forces = np.array([share.value for share in verdict.ridge_force], dtype=float)
    approach = float(verdict.approach)
    if model is None:
        gap = crest_gaps(design)
        flexibility = np.diag(1 / stiffnesses(design))
    else:
        gap = model.gap * model.unit
        gap = gap - gap.min()
        flexibility = _secant(model, forces)
    flexibility = _through(gap, flexibility, forces, approach)
    if np.linalg.eigvalsh(flexibility).min() <= 0:
        if model is not None:  # ridges that take each other's load: then each on a spring of its own
            return _fit(design, verdict, None)
        raise RefusedError("no springs: the check's approach is less than a crest's own gap")
    return Springs(gap=gap, flexibility=flexibility, coupled=model is not None, verdict=verdict)


def _through(gap: Array, flexibility: Array, forces: Array, approach: float) -> Array:
    """A flexibility `(n, n)` mm/N scaled by one factor, then moved on its diagonal, until the springs bear
    `forces` `(n,)` N at the approach, mm."""
    loaded = forces > LEAST_SHARE * forces.mean()
    wanted, has = (approach - gap)[loaded], (flexibility @ forces)[loaded]
    scaled = flexibility * float(forces[loaded] @ wanted / (forces[loaded] @ has))
    miss = approach - gap - scaled @ forces
    scaled[np.diag_indices_from(scaled)] += np.where(loaded, miss / np.where(loaded, forces, 1.0), 0.0)
    return np.asarray(scaled)


def _of_pins(design: Design, verdict: ContactCheck) -> Springs:
    """The springs of pins: of the reduced model, each pin's own at the force that it bears. Pins that are one
    body move together: their stiffnesses add up, and are then made to bear the model's forces."""
    from skincad.mechanics.models.reduced import pin_model, pressed

    model = pin_model(design)
    forces, approach = pressed(model, verdict.force)
    least = np.maximum(forces, LEAST_SHARE * verdict.force / forces.size)
    indentation = np.where(
        forces == least,
        approach - model.gap - model.coupling @ forces,
        np.interp(least, model.force, model.indentation),
    )
    flexibility = model.coupling.toarray() + np.diag(indentation / least)
    gap, members, coupled = model.gap, tuple(feature_bodies(design).values()), True
    if len(members) < gap.size:
        belongs = _belongs(members)
        gap = np.array([model.gap[[*group]].min() for group in members])
        stiffness = belongs @ np.linalg.inv(flexibility) @ belongs.T
        grouped = np.asarray(np.linalg.inv(stiffness), dtype=float)
        flexibility = _through(gap, grouped, belongs @ forces, approach)
        if np.linalg.eigvalsh(flexibility).min() <= 0:  # groups that take each other's load
            coupled, alone = False, np.diag(np.diag(grouped))
            flexibility = _through(gap, alone, belongs @ forces, approach)
    return Springs(gap=gap, flexibility=flexibility, coupled=coupled, verdict=verdict, members=members)


def _belongs(members: Sequence[Sequence[int]]) -> Array:
    """Which feature `(n,)` is on which spring, `(springs, n)`: 1 or 0."""
    belongs = np.zeros((len(members), sum(map(len, members))))
    for spring, group in enumerate(members):
        belongs[spring, [*group]] = 1.0
    return belongs


def _summed(verdict: ContactCheck, members: Sequence[Sequence[int]]) -> Array:
    """The check's forces on each spring, N."""
    forces = np.array([float(share) for share in verdict.ridge_force])
    return np.asarray(_belongs(members) @ forces) if members else forces


def _secant(model: RidgeModel, forces: Array) -> Array:
    """Flexibility `(n, n)` mm/N of a reduced pad, each ridge's own at its force in `forces` `(n,)` N."""
    per_force = model.unit / model.scale
    flexibility = model.coupling * per_force
    for i, force in enumerate(forces):
        at = max(force / model.scale, model.force[1])
        flexibility[i, i] = np.interp(at, model.force, model.indentation[i]) / at * per_force
    return np.asarray((flexibility + flexibility.T) / 2)


def _compare_at(design: Design, model: Springs, force: float, progress: Progress | None) -> LoadComparison:
    pressed = press(model.flexibility, model.gap, force)
    other = check(design, force=force, model=model.verdict.model, progress=progress)
    return LoadComparison(
        force=force,
        approach=pressed.approach,
        check_approach=float(other.approach),
        shares=tuple(pressed.force.tolist()),
        check_shares=tuple(_summed(other, model.members).tolist()),
    )
