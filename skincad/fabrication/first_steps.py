"""Preparation of the made parts before the mold is first closed: lines of the casting sheet."""

from __future__ import annotations

from collections.abc import Iterator

from skincad.fabrication.bore_fits import PINNED, THREADED, is_pressed, process_of, thread
from skincad.fabrication.rules import coating
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.shape.skin import skin_of
from skincad.solids.mold import ClosedMold
from skincad.solids.plan import Part, bores


def preparation(design: Design, closed: ClosedMold) -> str:
    """Return how the made parts become a mold: degreased, sealed, threaded, pinned, tried, the carrier
    weighed."""
    parts = [part for part in closed.parts if part.made == "made"]
    steps = [*_sealing(design, parts), *_threading(design, parts), *_pinning(parts), _dry_fit(design)]
    last = "Weigh the carrier and write it down: the inspection takes it off the skin's mass."
    return " ".join([*steps, "Degrease all parts and let them dry.", last])


def _sealing(design: Design, parts: list[Part]) -> Iterator[str]:
    """What keeps a resin from stopping the silicone's cure."""
    if not silicone(design).platinum_cure:
        return
    names = [part.name for part in parts if process_of(design, part).inhibits_platinum]
    coats = {coating(design, process_of(design, part)) for part in parts} - {0.0}
    if names:
        which = "all parts" if len(names) == len(parts) else _listed(names)
        seal = "".join(f", then seal with a coat of {coat:g} mm" for coat in sorted(coats))
        yield f"Wash, post-cure and bake {which} by the resin's data sheet{seal}."


def _threading(design: Design, parts: list[Part]) -> Iterator[str]:
    """Threads by what brings them: the tap, or an insert."""
    where: dict[str, list[str]] = {}
    for part in parts:
        for role in sorted(THREADED, key=lambda role: role.name):
            if bores(part, role):
                names = where.setdefault(thread(design, part, role), [])
                names += [part.name] * (part.name not in names)
    for what, names in where.items():
        kind, _, how = what.partition(" insert, ")
        if how:
            yield f"Set the {kind} inserts ({how}) into {_listed(names)}."
            continue
        name, _, deep = what.partition(" x ")
        yield f"Tap the {name} threads of {_listed(names)}" + (f", {deep} mm deep (mount)." if deep else ".")


def _pinning(parts: list[Part]) -> Iterator[str]:
    """Where the pins are pressed in."""
    roles = sorted(PINNED, key=lambda role: role.name)
    names = [p.name for p in parts if any(is_pressed(p, role) and bores(p, role) for role in roles)]
    if names:
        yield f"Press the dowel pins into {_listed(names)}."


def _dry_fit(design: Design) -> str:
    """What must fit before silicone is mixed."""
    slot = skin_of(design).slot
    fits = ["end plates and cover slide onto their pins", "the carrier drops onto its ledge"]
    if slot is not None and design.mold.method == "shim":
        fits.append("each shim drops into its notches by itself")
    elif slot is not None and design.film is not None:
        fits.append("a spare strip drops into each notch by itself")
    return f"Try, dry: {_listed(fits)}."


def _listed(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]]) if len(words) > 1 else words[0]
