"""Designs that the tests of this room share."""

from __future__ import annotations

from functools import partial
from typing import Any

from skincad import load
from skincad.inputs.design import Design
from skincad.mechanics.check import check
from skincad.mechanics.models import linear
from skincad.mechanics.problem import Answer, Request

linear_check = partial(check, model="linear")  # the verdict by one model, whatever it leaves out
BARE = {"slot": None, "film": None, "contact": {"film": "ignored"}}


# a third of the nine ridges, so curved that the outer ones touch at a sixth of their 1.3 N: much for little
THREE: dict[str, Any] = {"ridge": {"count": 3}, "skin": {"width": 5.0, "curvature_radius": 12.0}}
SHORT: dict[str, Any] = {"ridge": {"count": 3}, "skin": {**THREE["skin"], "length": 6.0}}


def plane(
    design: Design, *, force: float | None = None, tol: float | None = None, budget: float | None = None
) -> Answer:
    """The linear model's answer alone: no yield, which takes as long again, and no verdict."""
    return linear.answer(design, Request(force or design.contact.force, tol, budget))


def yamada() -> Design:
    """The paper's skin under a plate without friction: what other effects leave in an error is looked at."""
    return load("yamada-2002").with_(contact={"friction": 0.0})


def filleted() -> Design:
    """The reference section of docs/facts.md with tip fillet 0.05 and root fillet 0.08."""
    return yamada().with_(**BARE)


def reference() -> Design:
    """The reference section of docs/facts.md: sharp corners, no slots."""
    return yamada().with_(**BARE, ridge={"tip_fillet": 0.0, "root_fillet": 0.0})


def void_slots(thickness: float) -> Design:
    """The reference section of docs/facts.md with empty slots of this thickness, mm."""
    return yamada().with_(
        film=None,
        contact={"film": "loose"},
        slot={"thickness": thickness},
        ridge={"tip_fillet": 0.0, "root_fillet": 0.0},
    )


def wide(ridges: int) -> Design:
    """Ridges at the pitch of plain-ridges on a nearly flat pad."""
    sizes = [f"ridge.count={ridges}", f"skin.width={ridges + 5}", "skin.curvature_radius=1e5"]
    return load("plain-ridges", [*sizes, f"contact.force={0.45 * ridges}"])
