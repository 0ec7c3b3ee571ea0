"""Designs that the tests of this room share."""

from __future__ import annotations

from functools import partial
from typing import Any

from skincad import check, load
from skincad.base import Estimate
from skincad.inputs import Design
from skincad.mechanics import Answer, Request
from skincad.mechanics.models import linear

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


def value(estimate: Estimate) -> float:
    """The value of what is known."""
    assert estimate.value is not None
    return estimate.value


def assert_inside(answer: Answer, exact: Any) -> None:
    """Each number's true value lies within the error that is stated of it."""
    for stated, true in (
        (answer.all_touch_force, exact.all_touch_force),
        (answer.approach, exact.approach),
        *zip(answer.ridge_force, exact.ridge_force, strict=True),
    ):
        value = true.value if isinstance(true, Estimate) else true
        assert abs((stated.value or 0.0) - (value or 0.0)) <= (stated.error or 0.0)


def doubled(design: Design) -> Design:
    """Lengths times 2 and moduli by 4 leave every force as it is."""
    lengths = {
        "skin": ("curvature_radius", "thickness", "width", "length"),
        "ridge": ("pitch", "height", "root_width", "tip_width", "crown", "tip_fillet", "root_fillet"),
        "slot": ("thickness", "depth", "offset", "elevation"),
        "film": ("thickness",),
    }
    data = design.model_dump(exclude_none=True)
    change = {t: {key: 2 * data[t][key] for key in keys} for t, keys in lengths.items() if t in data}
    if "film" in change:
        change["film"]["young_modulus"] = data["film"]["young_modulus"] / 4
    return design.with_(**change, material={"young_modulus": 0.2})


def yamada() -> Design:
    """The paper's skin under a plate without friction: what other effects leave in an error is looked at."""
    return load("yamada-2002").with_(contact={"friction": 0.0})


def filleted() -> Design:
    """The reference section of docs/evidence/facts.md with tip fillet 0.05 and root fillet 0.08."""
    return yamada().with_(**BARE)


def small() -> Design:
    """Three ridges on a short pad: free ends and finite strain count."""
    return reference().with_(**SHORT, contact={"force": 0.65})


def reference() -> Design:
    """The reference section of docs/evidence/facts.md: sharp corners, no slots."""
    return yamada().with_(**BARE, ridge={"tip_fillet": 0.0, "root_fillet": 0.0})


def void_slots(thickness: float) -> Design:
    """The reference section of docs/evidence/facts.md with empty slots of this thickness, mm."""
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
