"""Finite strain, plane strain: for shear and squeeze beyond the linear range.

Range: the design's [material.law], or neo-Hooke, as silicones are up to strains of about 0.5; quasi-static,
under a flat plate that keeps its angle. Where the skin's surface folds the march stops and says so
(mechanics/contact/press_path.py). A step linearises the body several times, so it costs some hundred times
one of small strain; with `steps = "chosen"` only a few are taken so (chosen_steps.py). The whole pad is
meshed: mirrored loads have mirrored results to the mesh's error only. Films: Cauchy stress on the strip as it
then lies (mechanics/bodies/film_field.py). Reference: the finite-strain model without friction, simple shear
with, and small strain at small loads (tests/mechanics/contact/test_dragged.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field

from skincad.base.errors import RefusedError
from skincad.base.machine import one_blas_thread
from skincad.effects.kinds import Law, LeftOutEffect, SceneOutline, Term
from skincad.mechanics.left_out import sway_amplification, sway_force
from skincad.mechanics.validity import mean_width, plane_modulus

if TYPE_CHECKING:
    from skincad.effects.chosen_steps import ChosenPad
    from skincad.effects.large_pad import LargePad
    from skincad.mechanics.film.stick import PadPiece

WITHIN = 2.0
MOST = 2.0  # of the differential stress, change that is told: beyond it ridges nearly sway by themselves


class FiniteStrain(Law):
    """Rubber elasticity, neo-Hookean where the design has no [material.law]."""

    creases: Literal["stop", "pass"] = Field(
        default="stop",
        description="where the surface folds onto itself: stop there, or pass on without contact in the fold",
    )
    steps: Literal["all", "chosen"] = Field(
        default="all",
        description="which steps are taken at finite strain: all, or chosen ones, the skin linear about them "
        "in between: some ten times as fast, with an error that is told",
    )
    halves: ClassVar[bool] = False

    @property
    def swings(self) -> bool:
        """Chosen steps take what slow modes add."""
        return self.steps == "chosen"

    def marched(
        self,
        piece: PadPiece,
        mesh: object,
        order: int,
        films: bool,
        terms: Sequence[Term] = (),
    ) -> LargePad | ChosenPad:
        """Return a meshed whole pad to be marched; RefusedError for terms that ask for more than friction."""
        from skincad.effects.large_pad import LargePad
        from skincad.mechanics.bodies import elements, plane_body
        from skincad.mechanics.bodies.film_field import strip_stress
        from skincad.mechanics.contact.frictional_pad import frictional_pad_of
        from skincad.mechanics.film.sliding import of_ends

        needs = frozenset[str]().union(*(term.asks for term in terms))
        if needs:
            raise RefusedError(
                f"finite_strain is quasi-static: leave out effects that need {', '.join(needs)}"
            )
        pad, unit = piece.pad, piece.unit
        curved = elements.curved(mesh, order)
        with one_blas_thread():
            body = plane_body.body(curved, order, pad.materials, pad.laws, face=pad.face)
            scale, ends = pad.young_modulus * unit * pad.length, partial(of_ends, pad)
            whole = frictional_pad_of(body, pad.top, unit, scale, pad.length, ends)
        strips = (
            strip_stress(body, order, pad.materials, piece.slots, piece.thickness, unit, pad.laws)
            if films
            else None
        )
        large = LargePad(whole, strips, pad.young_modulus, self.creases == "stop")
        if self.steps == "all":
            return large
        from skincad.effects.chosen_steps import chosen

        return chosen(large)

    @staticmethod
    def left_out(outline: SceneOutline) -> LeftOutEffect | None:
        """Return by P-delta on the ridge that is pressed hardest (mechanics/left_out.py), of the largest
        differential stress of any ridge.

        Nothing is fitted. What is said is 0.54 to 1.3 times what is found in 17 random scenes, 0.44 to 1.8 in
        30 others, 27 of them within a factor of two; of the ridge told alone 0.57 to 3.0, 26 of 30 (as of
        bench/left_out.py, seeds 1 and 2). It is low where leaning ridges, which pressing turns upright,
        are pulled little.
        """
        design, normal = outline.design, outline.ridge_normal
        if normal <= 0:
            return None
        part = normal / sway_force(design, normal)
        strain = normal / (plane_modulus(design) * design.skin.length * mean_width(design))
        text = f"nominal strain {strain:.2g}, and {part:.0%} of the force at which a ridge so pressed sways"
        return LeftOutEffect(
            "finite_strain", text, sway_amplification(design, normal, MOST), calibrated=True, within=WITHIN
        )
