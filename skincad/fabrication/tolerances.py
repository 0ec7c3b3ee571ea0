"""Tolerances on a shop drawing: those of the process, and which sizes matter and why.

How far a crest may be off follows from the check: until the verdict's margin is used up. What pins and slits
allow follows from the gaps that parts slide with.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from skincad.fabrication.bore_fits import PINNED, process_of
from skincad.fabrication.drawn_features import downward, leftward
from skincad.fabrication.rules import Case, grooves, maker, slit_play, walls_close
from skincad.inputs.design import Design
from skincad.inputs.mold_table import Mount
from skincad.inputs.process import Process, processes
from skincad.shape.skin import skin_of
from skincad.solids.fasteners import METRIC
from skincad.solids.inserts import PIN_RADIUS
from skincad.solids.layout import fits
from skincad.solids.plan import CAVITIES, Part, PartRole
from skincad.solids.shrinkage import shrinkage

UNCHECKED_NOTE = "Grooves: made without the check, so their limits are not known."


CUTTERS = {"wire": "Wire", "mill": "Ball-end mill"}


class CrestAllowance(NamedTuple):
    """What the check says of the mold's crests: by how much each may be lower alone until the
    verdict's margin is used up, mm (empty where it has none)."""

    drops: tuple[float, ...]


def general_tolerance(design: Design, part: Part) -> str:
    """Return what holds where a size has no limits of its own."""
    return f"±{process_of(design, part).tolerance:g} (by {maker(design, part)})"


def surface_words(design: Design, part: Part) -> str:
    """Return how rough all faces may be, µm (ISO 21920-1); "" where the process says nothing of it."""
    rough = process_of(design, part).roughness
    return f"Ra {rough:g}" if rough else ""


def process_words(design: Design, part: Part) -> str:
    """Return how a part is made."""
    name, process = maker(design, part), process_of(design, part)
    based = f" (as {process.based_on})" if process.based_on not in (None, name) else ""
    return f"{name}{based}{_TOOLS.get(process.tool, '') if not process.layer else ', printed'}"


_TOOLS = {"mill": ", milled", "wire": ", wire erosion"}


def material_words(design: Design, part: Part) -> str:
    """Return of what a part can be: assumption, by what its process cuts."""
    process = process_of(design, part)
    if process.layer:
        return "rigid resin or filament" + (", sealed against silicone" if process.inhibits_platinum else "")
    return "brass or tool steel" if process.tool == "wire" else "aluminium or brass"


def notes(design: Design, part: Part) -> list[str]:
    """Return what holds for the whole part."""
    share = 100 * shrinkage(design)
    edges = f"{'right' if leftward(part) else 'left'} and {'upper' if downward(part) else 'lower'}"
    rows = [f"Coordinates x, y from the view's {edges} edge. Exact shape: the STEP file."]
    if part.role in CAVITIES and share:
        rows.append(
            f"Trough larger than the skin by the silicone's shrinkage, {share:.3g} %: sizes are the mold's."
        )
    if part.role in CAVITIES or part.role in (PartRole.COMB, PartRole.KEEPER):
        rows.append("Edges at trough and slits sharp and free of burrs; all others broken 0.1 to 0.3.")
    else:
        rows.append("Edges broken 0.1 to 0.3; the face on the silicone flat and free of scratches.")
    process = process_of(design, part)
    if process.inhibits_platinum:
        rows.append("The process may keep platinum silicone from curing: wash, cure fully and seal the part.")
    return [*rows, *_cutter(Case(design, part, maker(design, part), process))]


def _cutter(case: Case) -> list[str]:
    """The thickest wire or mill that the narrowest groove takes, and the cavity's inner corners."""
    process, ridge = case.process, skin_of(case.design).profile
    takes = [(groove.width, f"a {groove.width:.4g} wide {groove.where}") for groove in grooves(case)]
    if not takes or process.tool not in CUTTERS:
        return []
    if case.part.role in CAVITIES and ridge.tip_fillet:
        takes.append((2 * ridge.tip_fillet, f"inner corners of radius {ridge.tip_fillet:g}"))
    width, where = min(takes)
    kerf = math.floor(100 * (width - 2 * process.spark_gap) + 1e-6) / 100
    if kerf <= 0:
        return []
    sparks = f"; {process.spark_gap:g} a side sparks off" if process.spark_gap else ""
    return [f"{CUTTERS[process.tool]}: Ø{kerf:g} at most, for {where}{sparks}."]


def what_matters(design: Design, part: Part, judged: CrestAllowance | None) -> list[str]:
    """Return which sizes of a part matter and why; `judged` is None where nobody asked for the check."""
    rows = _crests(design, part, judged) if part.role in CAVITIES and part.role is not PartRole.BASE else []
    if part.role is PartRole.COMB:
        process = process_of(design, part)
        gap, drawn = slit_play(design, process), design.mold.slit_clearance
        lays = "strip" if design.mold.method == "cast-in" else "shim"
        out = f" ({drawn:g} as drawn, less growth and coat)" if gap != drawn else ""
        rows.append(
            f"Slits: {gap:.4g} a side beside the {lays}{out}. Narrower ones jam it, wider ones let silicone "
            f"in and the film lie aside; {_tolerance_words(process, gap)}"
        )
    if part.role is PartRole.CARRIER:
        drawn, by = design.mold.clearance, processes(design.printer)[design.mold.process]
        gap = drawn - walls_close(design, by) - walls_close(design, process_of(design, part))
        out = f" ({drawn:g} as drawn, less growth and coats)" if gap != drawn else ""
        rows.append(
            f"Length and width: {gap:.4g} a side to its seat{out}; larger it jams, smaller the flash grows."
        )
    if part.role is PartRole.CARRIER and design.mount and design.mount.thread:
        metric = METRIC[design.mount.thread]
        off = (metric.clearance - metric.diameter) / 4
        rows.append(
            f"Mount: {pattern_words(design.mount)} about the middle, its threads within ±{off:.3g}, half of "
            "what clearance holes by ISO 273 (medium) leave a side. No hole of it goes through."
        )
    pins = {cut.role for cut in part.cuts} & PINNED
    if pins:
        sliding = fits(design, maker(design, part)).slide - PIN_RADIUS
        rows.append(
            f"Pin holes: place within ±{sliding / 2:.3g}, half of the pins' play of {sliding:.3g} a side, or "
            "the parts don't slide onto each other."
        )
    return rows


def pattern_words(mount: Mount) -> str:
    """Return the pattern of a mount's screws, mm."""
    if mount.pattern == "circle":
        return f"circle of {mount.diameter:g}"
    wide, long = mount.pitch_x, mount.pitch_y
    return f"rectangle of {wide:g} x {long:g}" if wide and long else f"two in line, {wide or long:g} apart,"


def _tolerance_words(process: Process, gap: float) -> str:
    word = "keeps" if process.tolerance <= gap else "does not keep"
    return f"the process, ±{process.tolerance:g}, {word} that gap."


def _crests(design: Design, part: Part, judged: CrestAllowance | None) -> list[str]:
    """What the crests' heights may differ by: the grooves' depths."""
    sigma = f"{process_of(design, part).crest_sigma:g}"
    if judged is None:
        return [UNCHECKED_NOTE]
    rows = []
    if judged.drops:
        least = min(judged.drops)
        which = judged.drops.index(least) + 1
        word = "any depth does" if math.isinf(least) else f"ridge {which} allows least, {least:.4f}"
        rows.append(
            "Grooves: each alone may be too shallow by what the table allows until the check's margin is "
            f"used up and a ridge stays off the plate; {word}. The process's sigma is {sigma}."
        )
    else:
        rows.append(
            f"Grooves: the check leaves no margin, or has none to say; the process's sigma is {sigma}."
        )
    return rows
