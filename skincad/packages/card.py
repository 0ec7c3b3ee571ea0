"""The model card: what was simplified, what each number rests on, where it holds. Licence: the owner's."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from skincad.base.reading import markdown_text
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


def card(package: Package) -> dict[str, Any]:
    """Return the card as JSON: `simplified` in words, `numbers` with what each rests on and its range."""
    return {
        "name": package.name,
        "for": list(package.kinds),
        "frame": FRAME,
        "licence": None,
        "mass_g": package.weighs.mass,
        "simplified": [*_simplified(package), *package.notes],
        "numbers": [dict(zip(("what", "rests_on", "holds"), row, strict=True)) for row in _numbers(package)],
        "springs": None if package.springs is None else _springs(package.springs),
    }


def markdown(package: Package) -> str:
    """Return the card as Markdown."""
    lines = [f"# {package.name}: model card", "", f"For {', '.join(package.kinds)}. Frame: {FRAME}.", ""]
    lines += [f"Licence: {LICENCE}.", "", "## What was simplified", ""]
    lines += [f"- {markdown_text(text)}" for text in [*_simplified(package), *package.notes]]
    lines += ["", "## What each number rests on, and where it holds", ""]
    lines += ["| number | rests on | holds |", "|---|---|---|"]
    lines += [f"| {' | '.join(map(markdown_text, row))} |" for row in _numbers(package)]
    if package.springs:
        lines += ["", "## Springs against checks", "", *_table(package.springs)]
    return "\n".join([*lines, ""])


def _simplified(package: Package) -> Iterator[str]:
    yield "carrier, skin and what fills its slots are rigid links"
    yield "leads, screws and the silicone in the carrier's holes are left out"
    if package.surfaces:
        yield "convex hulls are what touches: they fill the root fillets; crests are within 1e-4 of the pitch"
    if package.springs:
        linked = "coupled springs" if package.springs.coupled else "a spring of its own, neighbours apart"
        yield f"each ridge slides along z on {linked}; sideways it is rigid"
        yield "MuJoCo's friction acts on a whole ridge, so incipient slip inside a contact is not in it"
    if "urdf" in package.kinds:
        yield "in URDF the ridges are fixed: the format knows no springs"
    if package.response:
        yield "the films' response is that of a long pad in small strain, its contact that of one load"


def _numbers(package: Package) -> Iterator[tuple[str, str, str]]:
    design, material = package.design, silicone(package.design)
    yield (
        f"mass {package.weighs.mass:.6g} g, centres and inertias",
        f"the exact solids of skin.step and carrier.step; {material.density / 1e3:g} g/cm3 of "
        f"{material.name}, {lid_process(design).density:g} g/cm3 of the carrier",
        "as designed; parts weigh what their silicone's batch weighs",
    )
    if package.springs:
        yield from _of_springs(package, package.springs)
    if package.taxels:
        yield (
            f"{len(package.taxels.names)} taxels",
            "the exact section, in the middle of the length",
            "unloaded",
        )
    if package.mesh:
        yield (
            f"{sum(map(len, package.mesh.elements.values()))} tetrahedra of second order",
            "the exact section, swept along y; materials.json has moduli, densities and laws",
            f"edges are straight: the volume is off by {package.mesh.deviation:.1e} of it",
        )
    if package.heights:
        yield (
            f"height map, {package.heights.pixel:.4g} mm a pixel",
            "the exact section's highest points",
            f"levels of {package.heights.scale:.3g} mm, unloaded; undercut flanks are hidden",
        )
    if package.response:
        yield _of_response(package.response)


def _of_springs(package: Package, springs: Springs) -> Iterator[tuple[str, str, str]]:
    verdict, (armature, damping) = springs.verdict, slide_damping(springs)
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
    stated = package.design.contact.friction is not None
    yield (
        f"friction {friction(package.design):g}",
        "contact.friction" if stated else f"assumption: {FRICTION:g} where contact.friction is not given",
        "dry, Coulomb; a plate that is held creeps by up to 2 % of the approach a second, one that slides is "
        "lifted by about step x friction x speed",
    )


def _of_response(response: FilmResponse) -> tuple[str, str, str]:
    largest = max(float(np.abs(stress[..., 0]).max()) for stress in (response.normal, response.tangential))
    error = float(response.error[..., 0].max())
    change = response.at_other_forces[..., 0].max(axis=(1, 2))
    spans = " and ".join(
        f"{c:.2g} MPa/N at {s * response.force:g} N" for c, s in zip(change, RESPONSE_SPANS, strict=True)
    )
    return (
        f"response: stress through a film, up to {largest:.3g} ± {error:.2g} MPa/N",
        f"condensed compliance, plane strain, {response.unknowns} unknowns",
        f"contact of {response.force:g} N, full stick; it differs by up to {spans}",
    )


def _springs(springs: Springs) -> dict[str, Any]:
    verdict = springs.verdict
    return {
        "force_N": verdict.force,
        "tier": verdict.tier,
        "approach_mm": verdict.approach.as_json(),
        "ridge_force_N": [force.as_json() for force in verdict.ridge_force],
        "gap_mm": springs.gap.tolist(),
        "stiffness_N_per_mm": springs.stiffness.tolist(),
        "coupled": springs.coupled,
        "refused": list(springs.refused),
        "elsewhere": [
            {
                "force_N": other.force,
                "approach_mm": other.approach,
                "check_approach_mm": other.check_approach,
                "ridge_force_N": list(other.shares),
                "check_ridge_force_N": list(other.check_shares),
            }
            for other in springs.elsewhere
        ],
    }


def _table(springs: Springs) -> Iterator[str]:
    yield "| force, N | approach by springs, mm | by the check | forces on ridges differ, of the mean one |"
    yield "|---|---|---|---|"
    for e in springs.elsewhere:
        yield f"| {e.force:g} | {e.approach:.4f} | {e.check_approach:.4f} | {e.shares_off:.1%} |"
    yield from ("", *(f"- {markdown_text(text)}" for text in springs.refused))
