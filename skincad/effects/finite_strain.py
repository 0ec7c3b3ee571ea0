"""Finite strain, plane strain: for shear and squeeze beyond the linear range.

Range: the design's [material.law], or neo-Hooke, as silicones are up to strains of about 0.5; quasi-static,
under a flat plate that keeps its angle. Where the skin's surface folds that is told, and the march goes on
without contact in the fold (mechanics/contact/folding.py). A step linearises the body several times, so it
costs some hundred times one of small strain; with `steps = "chosen"` only a few are taken so
(chosen_steps.py). The whole pad is meshed: mirrored loads have mirrored results to the mesh's error only.
Films: Cauchy stress on the strip as it then lies (mechanics/bodies/film_field.py). Reference: the
finite-strain model without friction, simple shear with, and small strain at small loads
(tests/mechanics/contact/test_dragged.py).

P-delta, for what is left out: how much a ridge's normal force increases its bending under a pull. A ridge
under a normal force P, displaced sideways by a pull, is also bent by P times that displacement. Both grow by
1 / (1 - P / Pcr), with Pcr the force at which the ridge sways without any pull: Timoshenko and Gere, Theory
of Elastic Stability, 2nd ed., chap. 1 (beam-columns). Nothing here is fitted. The ridge is a column that
bends and shears between two halves of elastic space, which its root and its tip turn in: the plate keeps a
tip level only as far as silicone does. It is as squat and wide as P has pressed it. bench/left_out.py
compares it with simulations at finite strain.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import Field

from skincad.base.errors import RefusedError
from skincad.base.machine import one_blas_thread
from skincad.effects.kinds import Law, LeftOutEffect, SceneOutline, Term
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.mechanics.validity import limits, plane_modulus
from skincad.shape.feature import BAR
from skincad.shape.skin import skin_of

if TYPE_CHECKING:
    from skincad.effects.chosen_steps import ChosenPad
    from skincad.mechanics.bodies.mesh import PadPiece

WITHIN = 2.0
# Of a skin without films, by its nominal strain: what changes of the travel under a pull, and of a face's
# approach. Assumption: 1.1 on the face of flat-magnet, 0.7 to 1.5 on ridges with the section of rings-5
BY_STRAIN = 1.5
FACE_FOLD = 0.01  # of a face's thickness; assumption: it may fold as deep as a ridge's fillets are round
MOST = 2.0  # of the differential stress, change that is told: beyond it ridges nearly sway by themselves


class FiniteStrain(Law):
    """Rubber elasticity, neo-Hookean where the design has no [material.law]."""

    creases: Literal["stop", "pass"] = Field(
        default="pass",
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
    ) -> ChosenPad:
        """Return a meshed whole pad to be marched. With chosen steps the next is taken once a point has moved
        by UPDATE_INTERVAL of the narrowest crest. RefusedError for terms that ask for more than friction."""
        from skincad.effects.chosen_steps import UPDATE_INTERVAL, ChosenPad
        from skincad.mechanics.bodies import elements, plane_body
        from skincad.mechanics.bodies.film_field import strip_stress
        from skincad.mechanics.bodies.mesh import height_of
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
        strips = strip_stress(body, order, piece) if films else None
        narrowest = min(np.ptp(whole.x[whole.ridge == number]) for number in np.unique(whole.ridge))
        fillets = [s.radius for s in pad.section.outline if s.kind in ("tip_fillet", "root_fillet")]
        if pad.face:  # as wide as the skin, and strained by what it moves over its thickness
            narrowest, fillets = min(narrowest, height_of(pad)), [FACE_FOLD * height_of(pad)]
        interval = None if self.steps == "all" else UPDATE_INTERVAL * float(narrowest)
        through = None if self.creases == "stop" else max(fillets, default=0.0)
        return ChosenPad(whole, strips, pad.young_modulus, through, interval)

    @staticmethod
    def left_out(outline: SceneOutline) -> LeftOutEffect | None:
        """Return by P-delta on the ridge that is pressed hardest (`sway_force`), of the largest
        differential stress of any ridge.

        Nothing is fitted. What is said is 0.54 to 1.3 times what is found in 17 random scenes, 0.44 to 1.8 in
        30 others, 27 of them within a factor of two; of the ridge told alone 0.57 to 3.0, 26 of 30 (as of
        bench/left_out.py, seeds 1 and 2). It is low where leaning ridges, which pressing turns upright,
        are pulled little.
        """
        design, normal = outline.design, outline.ridge_normal
        if normal <= 0:
            return None
        if skin_of(design).family != "ridge":
            ends, path = limits(design), outline.path
            strain = ends.strain(
                float(ends.on_first(path.pressed).max()), approach=float(path.approach.max())
            )
            return LeftOutEffect("finite_strain", f"nominal strain {strain:.2g}", BY_STRAIN * strain)
        part = normal / sway_force(design, normal)
        strain = normal / (plane_modulus(design) * design.skin.length * skin_of(design).profile.mean_width)
        text = f"nominal strain {strain:.2g}, and {part:.0%} of the force at which a ridge so pressed sways"
        return LeftOutEffect(
            "finite_strain", text, sway_amplification(design, normal, MOST), calibrated=True, within=WITHIN
        )


BISECTIONS = 60  # of an angle below pi, to rounding
LARGEST_SQUEEZE = 0.9  # of the height pressed away, where nothing is left to sway


def sway_force(design: Design, normal: float) -> float:
    """Return the force Pcr, N, at which a ridge, the highest of unlike ones, sways that `normal` N press.

    An end of width b that turns by theta in a half-space has the moment pi E' L b^2 theta / 16, of the
    pressure E' theta x / (2 sqrt(a^2 - x^2)), a = b / 2, which solves Johnson's integral equation (Contact
    Mechanics, 1985, sec. 2.7). The column that sways between two such springs bears P_b = phi^2 E' I / h^2
    in bending (`sway_angle`), and with its shear G A / 2 (sqrt(1 + 4 P_b / (G A)) - 1): Haringx, Philips
    Res. Rep. 3 (1948) 401.
    """
    skin = skin_of(design)
    modulus, length, material = plane_modulus(design), design.skin.length, silicone(design)
    squeeze = min(normal / (modulus * length * skin.profile.mean_width), LARGEST_SQUEEZE)
    height = max(skin.heights) * (1 - squeeze)
    width, tip = (
        width_at_rest * (1 + squeeze) for width_at_rest in (skin.profile.mean_width, skin.profile.tip_width)
    )
    bending = modulus * length * width**3 / 12
    root, top = (
        math.pi * modulus * length * b**2 / 16 * height / bending for b in (skin.profile.root_width, tip)
    )
    straight = sway_angle(root, top) ** 2 * bending / height**2
    shear = BAR.shear * material.young_modulus.value / (2 * (1 + material.poisson_ratio)) * length * width
    return shear / 2 * (math.sqrt(1 + 4 * straight / shear) - 1)


def sway_amplification(design: Design, normal: float, most: float) -> float:
    """Return the relative increase of a ridge's bending by P-delta under `normal` N: P / (Pcr - P), at most
    `most`, the value for a ridge that buckles."""
    critical = sway_force(design, normal)
    if normal * (1 + most) >= most * critical:
        return most
    return normal / (critical - normal)


def sway_angle(root: float, top: float) -> float:
    """Return phi, in which a column that may sway buckles at phi^2 E I / h^2; its ends turn in springs of
    `root` and `top` times E I / h.

    With G = 6 / spring, (G_a G_b phi^2 - 36) / (6 (G_a + G_b)) = phi cot phi: the alignment chart's equation,
    Kavanagh, Trans. ASCE 127 II (1962) 81.
    """
    one, other = 6 / root, 6 / top
    low, high = 0.0, math.pi
    for _ in range(BISECTIONS):
        phi = (low + high) / 2
        missing = (one * other * phi**2 - 36) * math.sin(phi) - 6 * (one + other) * phi * math.cos(phi)
        low, high = (phi, high) if missing < 0 else (low, phi)
    return low
