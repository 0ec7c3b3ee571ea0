"""The stress in every film strip, S1 and S2 of each ridge, under a normal and a tangential force (Fig 8).

Paper: S1 and S2 bear the same stress under a normal force, and differ under a tangential one. Small strain,
plane strain; first the normal force without friction, then the tangential one with full stick (stick.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from skincad.base.arguments import require_goals, require_number
from skincad.base.errors import InputError, RefusedError
from skincad.base.stopwatch import Progress
from skincad.inputs.design import Design
from skincad.inputs.skin_tables import Slot
from skincad.mechanics.film.answer import FilmStress, FilmStresses
from skincad.mechanics.film.rungs import solve
from skincad.mechanics.problem import Pad, pad_of
from skincad.mechanics.touching import LARGEST_FORCE, require_force
from skincad.mechanics.validity import SMALL_STRAIN, limits, slope_warnings
from skincad.shape.skin import skin_of

DEFAULT_TOLERANCE = 0.02  # of the largest; finite strain and free ends change more (docs/facts.md)
LEFT_OUT_NOTE = "the pad is taken as long and strains as small: free ends and finite strain are left out"


def film_stress(
    design: Design,
    force: float | None = None,
    tangential: float | None = None,
    *,
    tol: float | None = None,
    progress: Progress | None = None,
) -> FilmStresses:
    """Return the films' stress under a normal force alone, and pulled by a tangential one too, N.

    `force` is the design's own if None, `tangential` a quarter of it; `tol` relative to the largest stress.
    The stress field of the third ridge and of the middle one can be drawn. Raises as `film_stresses`.
    """
    normal = design.contact.force if force is None else force
    middle = (skin_of(design).count + 1) // 2
    pulls = (0.0, normal / 4 if tangential is None else tangential)
    alone, both = film_stresses(
        design, normal, pulls, tol=tol, show=sorted({min(3, middle), middle}), progress=progress
    )
    return FilmStresses(design.name, (alone, both))


def film_stresses(
    design: Design,
    force: float | None = None,
    tangential: Sequence[float] = (0.0,),
    *,
    tol: float | None = None,
    show: Sequence[int] = (),
    progress: Progress | None = None,
) -> tuple[FilmStress, ...]:
    """Return the films' stresses at a normal force and each tangential one, N, from one solution.

    `force` is the design's own if None, `tol` relative to the largest stress; `show` names ridges whose
    stress field comes as `fields`. Where the film is `ignored`, the stress is the silicone's in the film's
    place (the slot's, without a film). Raises InputError without slots, where they are empty, or for bad
    numbers; RefusedError where ridges strain beyond the model's range.
    """
    normal = design.contact.force if force is None else force
    wanted = DEFAULT_TOLERANCE if tol is None else tol
    check_request(design, normal, tangential, wanted, show)
    pad, thickness = filled_pad(design)
    states = solve(pad, thickness, normal, tangential, wanted, show, progress)
    notes = [LEFT_OUT_NOTE, *slope_warnings(design)]
    if design.film_state == "ignored":
        notes.append("the film is ignored: this is the silicone's stress in its place")
    results = [
        replace(state, name=design.name, film=design.film_state, warnings=(*state.warnings, *notes))
        for state in states
    ]
    return tuple(_in_range(design, state) for state in results)


def filled_pad(design: Design) -> tuple[Pad, float]:
    """Return the pad with a strip in each slot, and the strips' thickness in mm.

    An ignored film is a strip of the skin's own moduli.
    """
    slot, pad = _filled_slot(design), pad_of(design)
    thickness = design.film.thickness if design.film else slot.thickness
    if pad.strips:
        return pad, thickness
    strips = tuple(slot.loop(thickness) for slot in pad.section.slots)
    return replace(
        pad,
        strips=strips,
        film_modulus=pad.young_modulus,
        film_ratio=pad.poisson_ratio,
        film_density=pad.density,
    ), thickness


def check_request(
    design: Design,
    force: float,
    tangential: Sequence[float] = (0.0,),
    tol: float = DEFAULT_TOLERANCE,
    show: Sequence[int] = (),
) -> None:
    """Raise InputError for a request that `film_stresses` refuses before any work."""
    skin = skin_of(design)
    _filled_slot(design)
    require_force(force)
    rule = f"must be from -{LARGEST_FORCE:g} to {LARGEST_FORCE:g} N"
    for pull in tangential:
        require_number("tangential", pull, lambda value: abs(value) <= LARGEST_FORCE, rule)
    require_goals(tol, None, "0.02")
    for ridge in show:
        if not 1 <= ridge <= skin.count:
            raise InputError("show", f"must be a ridge from 1 to {skin.count}", ridge)


def _filled_slot(design: Design) -> Slot:
    """The slot of each film, if stress crosses it."""
    slot = skin_of(design).slot
    if slot is None:
        raise InputError(
            "slot", "is missing: a film's stress needs its place", remedy="add [slot] and [film]"
        )
    if design.film_state == "loose":
        raise InputError(
            "contact.film",
            "leaves the slots empty, and no stress crosses an empty slot",
            design.film_state,
            "add a [film] and say 'bonded', or say 'ignored'",
        )
    return slot


def _in_range(design: Design, state: FilmStress) -> FilmStress:
    """Warn about nominal strains beyond small strain; raise RefusedError beyond the model's range."""
    normal, shear = (
        max(abs(force.value or 0.0) for force in forces)
        for forces in (state.ridge_force, state.ridge_tangential)
    )
    limit = limits(design)
    if wrong := limit.overload_reason(normal, shear) or state.fault:
        raise RefusedError(f"{wrong}; take smaller forces")
    strain = limit.strain(normal, shear)
    if strain <= SMALL_STRAIN:
        return state
    note = f"nominal ridge strain {strain:.2g} is beyond the small-strain range ({SMALL_STRAIN:g})"
    return replace(state, warnings=(*state.warnings, note))
