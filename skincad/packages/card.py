"""The model card: what was simplified, what each number rests on, where it holds. Licence: the owner's."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from skincad.base.plain import markdown_text
from skincad.inputs.material import silicone
from skincad.mechanics.film.response import SPANS as RESPONSE_SPANS
from skincad.packages.mjcf import FRICTION, STEP, friction, slide_damping
from skincad.packages.springs import Springs
from skincad.solids.layout import lid_process

if TYPE_CHECKING:
    from skincad.mechanics.film.response import FilmResponse
    from skincad.packages.packing import Package

FRAME = "x across the ridges, y along them, z out of the skin; the skin's flat back is at z = 0"
LICENCE = "to be stated by the skin's owner"


def card(found: Package) -> dict[str, Any]:
    """Return the card as JSON: `simplified` in words, `numbers` with what each rests on and its range."""
    return {
        "name": found.name,
        "for": list(found.kinds),
        "frame": FRAME,
        "licence": None,
        "mass_g": found.weighs.mass,
        "simplified": [*_simplified(found), *found.notes],
        "numbers": [dict(zip(("what", "rests_on", "holds"), row, strict=True)) for row in _numbers(found)],
        "springs": None if found.springs is None else _springs(found.springs),
    }


def markdown(found: Package) -> str:
    """Return the card as Markdown."""
    lines = [f"# {found.name}: model card", "", f"For {', '.join(found.kinds)}. Frame: {FRAME}.", ""]
    lines += [f"Licence: {LICENCE}.", "", "## What was simplified", ""]
    lines += [f"- {markdown_text(text)}" for text in [*_simplified(found), *found.notes]]
    lines += ["", "## What each number rests on, and where it holds", ""]
    lines += ["| number | rests on | holds |", "|---|---|---|"]
    lines += [f"| {' | '.join(map(markdown_text, row))} |" for row in _numbers(found)]
    if found.springs:
        lines += ["", "## Springs against checks", "", *_table(found.springs)]
    return "\n".join([*lines, ""])


def _simplified(found: Package) -> Iterator[str]:
    yield "carrier, skin and what fills its slots are rigid links"
    yield "leads, screws and the silicone in the carrier's holes are left out"
    if found.surfaces:
        yield "convex hulls are what touches: they fill the root fillets; crests are within 1e-4 of the pitch"
    if found.springs:
        linked = "coupled springs" if found.springs.coupled else "a spring of its own, neighbours apart"
        yield f"each ridge slides along z on {linked}; sideways it is rigid"
        yield "MuJoCo's friction acts on a whole ridge, so incipient slip inside a contact is not in it"
    if "urdf" in found.kinds:
        yield "in URDF the ridges are fixed: the format knows no springs"
    if found.response:
        yield "the films' response is that of a long pad in small strain, its contact that of one load"


def _numbers(found: Package) -> Iterator[tuple[str, str, str]]:
    design, stuff = found.design, silicone(found.design)
    yield (
        f"mass {found.weighs.mass:.6g} g, centres and inertias",
        f"the exact solids of skin.step and carrier.step; {stuff.density / 1e3:g} g/cm3 of {stuff.name}, "
        f"{lid_process(design).density:g} g/cm3 of the carrier",
        "as designed; parts weigh what their silicone's batch weighs",
    )
    if found.springs:
        yield from _of_springs(found, found.springs)
    if found.taxels:
        yield (
            f"{len(found.taxels.names)} taxels",
            "the exact section, in the middle of the length",
            "unloaded",
        )
    if found.mesh:
        yield (
            f"{sum(map(len, found.mesh.elements.values()))} tetrahedra of second order",
            "the exact section, swept along y; materials.json has moduli, densities and laws",
            f"edges are straight: the volume is off by {found.mesh.deviation:.1e} of it",
        )
    if found.heights:
        yield (
            f"height map, {found.heights.pixel:.4g} mm a pixel",
            "the exact section's highest points",
            f"levels of {found.heights.scale:.3g} mm, unloaded; undercut flanks are hidden",
        )
    if found.response:
        yield _of_response(found.response)


def _of_springs(found: Package, held: Springs) -> Iterator[tuple[str, str, str]]:
    verdict, (armature, damping) = held.verdict, slide_damping(held)
    yield (
        f"springs: approach {verdict.approach} and ridge forces at {verdict.force:g} N",
        f"the check, {verdict.tier} tier",
        f"exactly there; at other loads see the table; flat plate, timestep up to {STEP:g} s",
    )
    yield (
        f"armature {armature:.3g} kg and damping {damping:.3g} N s/m of each slide",
        "what MuJoCo's step needs",
        "numbers of the method: they say nothing of how fast the silicone gives way",
    )
    given = found.design.contact.friction is not None
    yield (
        f"friction {friction(found.design):g}",
        "contact.friction" if given else f"assumption: {FRICTION:g} where contact.friction is not given",
        "dry, Coulomb; a plate that is held creeps by up to 2 % of the approach a second, one that slides is "
        "lifted by about step x friction x speed",
    )


def _of_response(felt: FilmResponse) -> tuple[str, str, str]:
    largest = max(float(np.abs(each[..., 0]).max()) for each in (felt.normal, felt.tangential))
    error = float(felt.error[..., 0].max())
    change = felt.at_other_forces[..., 0].max(axis=(1, 2))
    spans = " and ".join(
        f"{c:.2g} MPa/N at {s * felt.force:g} N" for c, s in zip(change, RESPONSE_SPANS, strict=True)
    )
    return (
        f"response: stress through a film, up to {largest:.3g} ± {error:.2g} MPa/N",
        f"condensed compliance, plane strain, {felt.unknowns} unknowns",
        f"contact of {felt.force:g} N, full stick; it differs by up to {spans}",
    )


def _springs(held: Springs) -> dict[str, Any]:
    verdict = held.verdict
    return {
        "force_N": verdict.force,
        "tier": verdict.tier,
        "approach_mm": verdict.approach.as_json(),
        "ridge_force_N": [each.as_json() for each in verdict.ridge_force],
        "gap_mm": held.gap.tolist(),
        "stiffness_N_per_mm": held.stiffness.tolist(),
        "coupled": held.coupled,
        "refused": list(held.refused),
        "elsewhere": [
            {
                "force_N": other.force,
                "approach_mm": other.approach,
                "check_approach_mm": other.check_approach,
                "ridge_force_N": list(other.shares),
                "check_ridge_force_N": list(other.check_shares),
            }
            for other in held.elsewhere
        ],
    }


def _table(held: Springs) -> Iterator[str]:
    yield "| force, N | approach by springs, mm | by the check | forces on ridges differ, of the mean one |"
    yield "|---|---|---|---|"
    for e in held.elsewhere:
        yield f"| {e.force:g} | {e.approach:.4f} | {e.check_approach:.4f} | {e.shares_off:.1%} |"
    yield from ("", *(f"- {markdown_text(text)}" for text in held.refused))
