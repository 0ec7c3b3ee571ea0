"""Small strain, plane strain: the law of every scene that names no other.

Range: nominal strains of a ridge up to about 0.1; the result's `left_out` says where a scene lies. The pad is
condensed once, so a step is a contact problem alone. Reference: the linear model's verification table.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from skincad.base.arrays import Array
from skincad.base.errors import InputError, RefusedError
from skincad.effects.kinds import (
    FRICTIONLESS,
    MASS,
    MOVING,
    RATE,
    RELIEF,
    Discretisation,
    Law,
    LeftOutEffect,
    MarchedPad,
    Observables,
    Share,
    Step,
    Term,
)
from skincad.inputs.design import Design
from skincad.mechanics.contact.frictional import halved, solve_contact
from skincad.mechanics.contact.state import Compliance, ContactState, Drive, at_rest
from skincad.mechanics.film import turning
from skincad.mechanics.problem import ContactError
from skincad.mechanics.validity import Limits, limits

if TYPE_CHECKING:
    from skincad.mechanics.bodies.mesh import PadPiece
    from skincad.mechanics.film.fields import DeformedSection, WholeState
    from skincad.mechanics.film.sliding import ContactPad

MOST_BY_PRESS = 0.1  # of rings' forces, by friction that no press tells; assumption: twice what was seen


class SmallStrain(Law):
    """Linear elasticity."""

    condenses: ClassVar[bool] = True
    gives: ClassVar[frozenset[str]] = frozenset({MASS, RATE, RELIEF})

    masses: bool = Field(
        default=True,
        description="whether the skin's mass counts, by its slow modes; it does where steps are short enough",
    )

    @property
    def swings(self) -> bool:
        """Whether its quasi-static pads take what slow modes add."""
        return self.masses

    def limits(self, design: Design) -> Limits:
        """Return where small strain ends."""
        return limits(design)

    def marched(
        self, piece: PadPiece, mesh: object, order: int, films: bool, terms: Sequence[Term]
    ) -> MarchedPad:
        """Return the condensed pad, or where a term asks for masses or a past the pad that has them."""
        if any(term.asks & MOVING for term in terms):
            from skincad.effects.moving import MovingPad
            from skincad.mechanics.dynamics.pad import linear

            return MovingPad(linear(piece, mesh, order, films), piece)
        from skincad.mechanics.film.sliding import sliding

        rises = [term.rise for term in terms if RELIEF in term.asks]
        return CondensedPad(sliding(piece, mesh, order, films), max(rises, default=None))


@dataclass(frozen=True, eq=False)
class CondensedPad:
    """A pad of constant compliance; its states are grips. `rise` mm is how far its plate is from plane,
    None of one that is. `levels` keeps what the latest touching points make of a round one."""

    pad: ContactPad
    rise: float | None = None
    levels: dict[bytes, Compliance] = field(default_factory=dict)

    @cached_property
    def skin(self) -> Compliance:
        """The pad as a flat plate sees it, with the factorisations of its latest sets."""
        pad = self.pad
        return Compliance(pad.compliance, pad.gap, np.zeros(2 * pad.gap.size), area=pad.area)

    @property
    def discretisation(self) -> Discretisation:
        """Its contact points and unknowns."""
        return Discretisation(self.pad.ridge, self.pad.area, self.pad.unknowns)

    @property
    def compliance(self) -> Array:
        """Of the contact points `(2 m, 2 m)`, mm/N."""
        return self.skin.compliance

    def start(self) -> ContactState:
        """The unloaded state."""
        return at_rest(self.pad.gap.size)

    def advanced(self, state: ContactState, step: Step, share: Share) -> ContactState:
        """Return the converged state at the step's end."""
        cone = share.cone or FRICTIONLESS
        lower = None if share.relief is None else share.relief(self.pad.x + state.anchor)

        level = self.skin if self.pad.pulled is None else self._level(state)

        def seen(drive: Drive) -> Compliance:
            skin = level if drive.normal else self.skin  # a plate that is clear holds nothing
            skin = turning.rotated_pad(self.pad, drive.angle) if drive.angle else skin
            return skin if lower is None else replace(skin, gap=skin.gap + lower)

        if swing := share.swing:
            return solve_contact(seen(step.after).swung(swing), state, swing.drive, cone)
        return halved(seen, state, step.before, step.after, cone)

    def shown(self, state: ContactState) -> DeformedSection:
        """Return the whole section in a state."""
        return self._whole.deformed_section(*self._placed(state))

    def fault(self, state: ContactState, besides: Sequence[Array] = ()) -> str | None:
        """Return what of the skin would collide unseen in a state, or None; of a pad without a mesh nothing
        is known to. `besides` are displacements that no force holds, by parity, mm."""
        if self.pad.whole is None:
            return None
        from skincad.mechanics.film.fields import collision

        whole, (force, plate, angle) = self.pad.whole, self._placed(state)
        moved = whole.moved(force, besides)
        return collision(whole.piece, whole.body, moved, plate, angle, self._give(state))

    def left_out(self, state: ContactState, coefficient: float) -> list[LeftOutEffect]:
        """Return what a round skin leaves out of slip: that a level plate presses pulled rings unevenly, and
        the friction of this coefficient that spreads outward under the press. Nothing of a section along y,
        which knows both, and where nothing is pulled.

        Where the pressure round a ring is p (1 + e cos), its last part lets go where it bears up to 1 + e of
        the mean: by half of that later, in solids (bench/ring_friction.py). What friction changes of the
        rings' forces is a second solve, of the press alone.
        """
        if self.pad.pulled is None or not state.tangential.any():
            return []
        from skincad.mechanics.models import friction

        called, rings = self.pad.held_level(state.touches)[1] @ state.tangential, self.pad.ridge
        borne = np.maximum(np.bincount(rings, state.normal), 1e-300)
        uneven = 2 * np.abs(np.bincount(rings, called)) / borne
        ring, most = uneven.argmax(), float(uneven.max())
        what = f"rings harder behind, ring {ring}" if self.pad.ridge.max() > 1 else "skins harder behind,"
        words = f"a level plate presses pulled {what} by {most:.0%}"
        entries = [LeftOutEffect("uneven_pressure", words, min(1.0, most / 2))]
        words = "friction that spreads outward under the press"
        try:
            press = friction.solve(self._whole.piece.whole, coefficient, float(state.normal.sum())).relative
        except (ContactError, InputError) as failure:
            return [*entries, LeftOutEffect("press_friction", f"{words}: {failure}", MOST_BY_PRESS)]
        words += f" lets the skin give way by {-press.approach:.0%} less"
        return [*entries, LeftOutEffect("press_friction", words, press.share)]

    def _level(self, state: ContactState) -> Compliance:
        """A round skin as a level plate sees it that touches what it touched before the step. Displacements
        go on from where they are: what touches later does so as tilted as it is then."""
        touches = state.touches
        if not touches.any():
            return self.skin
        if (key := touches.tobytes()) not in self.levels:
            self.levels.clear()
            compliance, m = self.skin.compliance.copy(), touches.size
            compliance[:m, :m] = self.pad.held_level(touches)[0]
            self.levels[key] = replace(self.skin, compliance=compliance, solved={})
        seen, free = self.levels[key], self.skin.free.copy()
        along = state.anchor + state.travel
        free[: along.size] = along - seen.compliance[: along.size, : along.size] @ state.tangential
        return replace(seen, free=free)

    @property
    def _whole(self) -> WholeState:
        if self.pad.whole is None:
            raise RefusedError("a pad that was not condensed from a mesh has no field to show")
        return self.pad.whole

    def _give(self, state: ContactState) -> tuple[Array, Array]:
        """Where the ridges are and how much more free ends let them down, `(ridges,)` mm: the mesh's field is
        that of an endless pad."""
        whole = self._whole.piece.whole
        numbers = np.array(whole.ridges)
        at = np.searchsorted(numbers, self.pad.ridge)
        x = np.bincount(at, self.pad.x) / np.bincount(at)
        if not whole.ends:
            return x, np.zeros_like(x)
        return x, np.asarray(np.array(whole.ends) @ np.bincount(at, state.normal))

    def _placed(self, state: ContactState) -> tuple[Array, float, float]:
        """Forces on the skin, and the plate: its height over x = 0, mm, and its angle."""
        force = turning.in_skin_axes(state.force, state.angle)
        height = self._whole.piece.whole.top - turning.depth(self.pad, state) / math.cos(state.angle)
        height += self.rise or 0.0  # what is looked for lies behind the foremost level by no more
        return force, height, state.angle

    def reading(self, before: ContactState, state: ContactState) -> Observables:
        """Return the observables of a state."""
        force = turning.in_skin_axes(state.force, state.angle) if state.angle else state.force
        # a force that turned round within the step had done so before its point slipped
        turned = before.tangential * state.tangential < 0
        mean = np.where(turned, 1.0, 0.5) * state.tangential
        mean += np.where(turned, 0.0, 0.5) * before.tangential
        compliance = self.pad.compliance if self.pad.pulled is None else self._level(state).compliance
        elastic, dissipated = float(force @ compliance @ force) / 2, -float(mean @ state.slipped)
        work = turning.work(self.pad, before, state) if before.angle or state.angle else None
        if self.rise is not None:
            # the plate lowers each point by as much as it goes down, not by its approach
            m = self.pad.gap.size
            down = -self.skin.compliance[m:] @ (state.force - before.force)
            pull = float((before.tangential + state.tangential).sum()) / 2
            work = float((before.normal + state.normal) / 2 @ down) + pull * (state.travel - before.travel)
        return Observables.of(state, self.pad.strips @ force, elastic, dissipated, work=work)
