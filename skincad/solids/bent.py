r"""The mold of a doubly curved skin.

    z up          axis x, at z = back_radius
    ______________________________
    \\  |      cover, flat       |  /
     \\ |______________________| /     end plates lean inward at the top: their inner faces are the planes
      \\ \\      carrier       / /      through the axis at the skin's ends
       \\ \\__           ___/ /
        \\__  ---skin---  __/       the middle is the lowest, both ends rise
          |_____cavity____|

What the straight mold has in the plane of its section stays: it is the section in every plane through the
axis, so end plates, combs and keepers are the straight ones, turned as rigid bodies by the angle of an end.
Cover, carrier's top and cavity's top and bottom are flat, and what goes through them is along z.

What differs, and why. The end plates are not parallel, so each has its own screws into the cavity. They lean
over the trough, so the carrier is laid in before the keepers (or plain plates) are put on, and silicone is
not poured into an open trough. The cover stands out over the plates' beveled tops, comes off first, and is
lifted there. A shim is an arc, cut so from sheet, and is drawn out by turning it about the axis. Then skin
and carrier leave along z: a bowl is open above, so y holds nothing back while the ends lean by less than
a right angle; in x each ridge's undercut is that of the section.

A skin in layers has a gate for each. A plug has the carrier's body, and under it what turns about the axis as
the skin does; before it is pulled, keepers are pushed up off their combs along the ends, and shims stay, or
plain plates are taken off. Pockets are along z, from the back's arc up to one level. A bone's shoulder has to
follow the arc, for it lies on the carrier.

The bowl of a doubly curved mold in the plane (y, z): the back's arc, the ends' planes, what is between. The
axis lies at y = 0 above; heights count from the back's middle, z = 0; angles from y = 0 towards +y.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from skincad.base.errors import InputError
from skincad.inputs.design import Design
from skincad.inputs.skin_tables import RADIUS_Y
from skincad.shape.curves import Loop, Point, Segment, area, flipped
from skincad.shape.skin import Section, skin_of
from skincad.solids.bone import bone_parts
from skincad.solids.cavity import cavity, split_ridges
from skincad.solids.ends import end_plates
from skincad.solids.fasteners import WASHER, run_out_room, screw_for
from skincad.solids.inserts import GRIP, PIN_RADIUS, pin, shims
from skincad.solids.layout import (
    BESIDE,
    EDGE,
    OVERHANG,
    SQUEEZED_SHARE,
    Layout,
    block_fits,
    block_process,
    end_angle,
    seal_thickness,
    stack_error,
)
from skincad.solids.lids import LEAST_PULL, carrier, core_pins, cover, cover_dowels, seal_sheet
from skincad.solids.plan import (
    ENDS,
    Body,
    Bore,
    CutRole,
    End,
    ExtendedCut,
    Grid,
    Part,
    PartRole,
    Prism,
    RevolvedBody,
    RotatedBody,
    mirrored,
    turned,
)
from skincad.solids.shots import SUNK, Blank, plugs, straight_blank, under
from skincad.solids.shrinkage import on_grid
from skincad.solids.skin import cast_skin
from skincad.solids.split import path

# mm, assumption: a skin of 100 mm rises by 0.13 mm then; beyond 1e6 the kernel has cancellation errors
LARGEST_RADIUS = 1e4
SHARE_OF_ARM = 0.3  # assumption: a shim rises by a twentieth of the arm then, some tenths of a millimetre
CUT_OVERRUN = 0.5  # mm, by which a cut is built further than what it takes away
LEAST_THREAD = 3.0  # mm, assumption: one diameter of thread, and the shortest inserts
TOP_EDGE = 0.5  # mm, assumption: least wall at the top between a bore and a leaning face; it widens downward
BORE_OVERRUN = 0.2  # mm, by which a bore from the curved back begins below its rim
_FROM_ABOVE = (CutRole.COVER_THREAD, CutRole.COVER_PIN)


def bent_parts(design: Design, shape: Section, place: Layout) -> list[Part]:
    """Return the closed mold's parts; `place` is that of the section's plane at an end, `design` is what is
    poured. Raises InputError for what finds no room."""
    grid = _grid(design, shape)
    lids = _lids(design, place, grid)
    skin = replace(cast_skin(design, shape), body=_skin(shape, grid))
    ends = [
        turned(part, grid.centre, *_stand(place, grid, end))
        for end in ENDS
        for part in end_plates(design, shape, place, end)
    ]
    pins = [_end_pin(design, place, grid, end, i) for i in (0, 1) for end in ENDS]
    rest = [_carrier(design, lids, grid), *core_pins(design, lids), *bone_parts(design)]
    rest += [cover(design, lids), *pins]
    rest += cover_dowels(design, lids)
    rest += [seal_sheet(design, lids)] if lids.top > lids.back else []
    return [skin, _cavity(design, shape, place, lids, grid), *ends, *rest, *_shims(design, grid)]


def bent_plugs(design: Design, shape: Section, place: Layout) -> list[list[Part]]:
    """Return the plugs: the carrier's body, and under it what turns about the axis as the skin does."""
    grid = _grid(design, shape)
    lids, gap = _lids(design, place, grid), design.mold.clearance

    def blank(design: Design, lids: Layout, number: int) -> Blank:
        half = design.skin.width / 2 - gap
        end = grid.half - math.asin((gap + SUNK / 10) / (grid.centre - SUNK))  # inside the plate, so sunk
        outline = under(design, number, [Point(half, SUNK), Point(-half, SUNK)])
        buried = half * SUNK * (2 * grid.centre - SUNK) * 2 * end
        core = RevolvedBody(outline, grid.centre, -end, end, grid=grid, buried=buried)
        section = straight_blank(design, place, number).body
        return Blank(_plate(design, lids, grid), (core,), straight=section)

    stages = plugs(design, shape, lids, blank)
    return [[replace(part, cuts=_from_arc(part.cuts, grid)) for part in stage] for stage in stages]


def shims_turn(design: Design) -> float:
    """Return the angle, rad, by which shims are turned out of the mold: their own, and a little."""
    inner = design.skin.back_radius
    return 2 * end_angle(design) + 2 * math.asin(design.mold.end_plate / inner) + 2 * GRIP / inner


def check_bent(design: Design) -> Iterator[InputError]:
    """Yield an error for each thing that a doubly curved mold can't be."""
    radius, choice = design.skin.radius_y, design.mold
    remedy = f"drop {RADIUS_Y}"
    if radius > LARGEST_RADIUS:
        rule = f"must be at most {LARGEST_RADIUS:g} mm for a mold: a flatter skin can be cast straight"
        yield from design.skin.refused_radius_y(rule)
    most = SHARE_OF_ARM * (radius - design.skin.thickness)
    if skin_of(design).slot is not None and choice.end_plate > most:
        rule = f"must be at most {most:.4g} mm, or a shim rises too far in it"
        yield InputError("mold.end_plate", rule, choice.end_plate, f"or enlarge {RADIUS_Y}")
    if choice.cavities > 1:
        yield InputError("mold.cavities", "must be 1 in a doubly curved mold", choice.cavities, remedy)
    if split_ridges(design):
        rule = "must be 'none' in a doubly curved mold: the pieces of a cavity are planned for straight ones"
        yield InputError("mold.split", rule, choice.split, f"give the ridges draft, or {remedy}")
    if choice.pour == "open":
        rule = "must be 'syringe' in a doubly curved mold: its end plates lean over the trough, in the way of"
        yield InputError("mold.pour", rule + " a carrier that is let down last", choice.pour, remedy)


def _grid(design: Design, shape: Section) -> Grid:
    centre = design.skin.back_radius
    return Grid(centre, end_angle(design), centre + shape.top)


def _stand(place: Layout, grid: Grid, end: End) -> tuple[float, float]:
    """Angle and base by which what belongs to an end is turned."""
    return (-grid.half, -place.end) if end == "a" else (grid.half, place.end)


def _lids(design: Design, place: Layout, grid: Grid) -> Layout:
    """The layout of what is flat above: carriers and end plates up to where the end plates' inner faces reach
    `place.back`, measured along them; the cavity's walls higher by a squeezed seal, where they leave it room
    as they narrow; and bolts and pins of the cover as far apart as the narrow top allows."""
    back = on_grid(height(grid, grid.half) + place.back * math.cos(grid.half))
    sealed = back + SQUEEZED_SHARE * seal_thickness(stack_error(design, place.spans, place.lid))
    top = next(
        (on_grid(top) for top in (sealed, back) if _cover_places(design, place, grid, top)[2] >= BESIDE), back
    )
    bolt, hole, web = _cover_places(design, place, grid, top)
    if place.back >= grid.centre or web < BESIDE:
        remedy = "make the skin longer or the radius larger"
        rule = f"leaves {web:.3g} mm at the narrow top between a bolt and a pin of the cover, which need "
        raise InputError(RADIUS_Y, rule + f"{BESIDE:g} mm", design.skin.radius_y, remedy)
    end = on_grid(half_length(grid, back))
    out = end + design.mold.end_plate / math.cos(grid.half) + OVERHANG
    keying = place.keying[1], 0.0  # there is no room along y
    lids = place._replace(back=back, top=top, end=end, cover=on_grid(out))
    bolts = (place.outer, bolt), (-place.outer, -bolt)
    return lids._replace(bolts=bolts, pin_along=hole, keying=keying)


def _cover_places(design: Design, place: Layout, grid: Grid, top: float) -> tuple[float, float, float]:
    """Return how far along y bolts and pins of the cover may stand where the cavity's walls end at `top`, and
    what is left between a bolt and a pin, mm."""
    holes, end = block_fits(design), half_length(grid, top)
    bolt, hole = (on_grid(min(place.pin_along, end - TOP_EDGE - r)) for r in (holes.thread, holes.slide))
    return bolt, hole, bolt + hole - holes.thread - holes.slide


def _cavity(design: Design, shape: Section, place: Layout, lids: Layout, grid: Grid) -> Part:
    """The block between the planes of the ends, less the trough and, above the back, the carrier's seat."""
    low, high = half_length(grid, place.bottom), half_length(grid, lids.top)
    corners = [Point(-low, place.bottom), Point(low, place.bottom), Point(high, lids.top)]
    corners += [Point(-high, lids.top), corners[0]]
    straight = cavity(design, shape, place)
    return Part(
        "cavity",
        PartRole.CAVITY,
        Prism(tuple(path(corners)), "x", -place.half, place.half, grid=grid),
        (
            _trough(shape, grid),
            _opening(place, lids, grid),
            *_end_bores(design, place, grid),
            *(cut for cut in cavity(design, shape, lids).cuts if cut.role in _FROM_ABOVE),
            *(cut for cut in straight.cuts if cut.role is CutRole.FEATURE),
        ),
        straight=straight,
    )


def _skin(shape: Section, grid: Grid) -> RevolvedBody:
    slots = tuple(flipped(slot.loop()) for slot in shape.slots)
    return RevolvedBody(flipped(shape.outline), grid.centre, -grid.half, grid.half, slots, grid)


def _trough(shape: Section, grid: Grid) -> ExtendedCut:
    """The negative of the skin; built into the carrier's seat, and out of the block at its ends."""
    outline = flipped(shape.outline)
    more = CUT_OVERRUN / grid.centre
    removed = RevolvedBody(outline, grid.centre, -grid.half, grid.half, grid=grid, role=CutRole.TROUGH)
    back = next(s for s in outline if s.kind == "back")
    ends = [Point(p.x, p.z + CUT_OVERRUN) for p in (back.start, back.end)]
    i = outline.index(back)
    raised = (*outline[:i], *path([back.start, *ends, back.end]), *outline[i + 1 :])
    return ExtendedCut(
        removed, RevolvedBody(raised, grid.centre, -grid.half - more, grid.half + more, grid=grid)
    )


def _opening(place: Layout, lids: Layout, grid: Grid) -> ExtendedCut:
    """The carrier's seat, from the back up; built out of the block at its ends and its top."""
    side, shape = place.trough, seat(grid, grid.half, lids.top)
    removed = Prism(shape, "x", -side, side, grid=grid, role=CutRole.SEAT)
    wider = seat(grid, grid.half + CUT_OVERRUN / grid.centre, lids.top + CUT_OVERRUN, -2 * CUT_OVERRUN)
    return ExtendedCut(removed, replace(removed, outline=wider))


def _end_bores(design: Design, place: Layout, grid: Grid) -> list[ExtendedCut]:
    """Threads for the end plates' screws, and holes for their pins, square to the leaning ends."""
    holes = block_fits(design)
    bores = []
    for x, z in ((x, z) for x in place.lanes for z in (place.comb_bolt, place.keeper_bolt)):
        deepest, plate, process = (
            _deepest(grid, z, holes.thread),
            design.mold.end_plate,
            block_process(design),
        )
        long, washers = screw_for(plate, deepest, process, bottomed=True)
        engaged = long - washers * WASHER - plate
        depth = on_grid(min(engaged + run_out_room(process), deepest))
        if engaged < LEAST_THREAD:
            rule = f"leaves {max(engaged, 0.0):.3g} mm of thread for a screw of an end plate, which needs "
            rule += f"{LEAST_THREAD:g} mm"
            raise InputError("skin.length", rule, design.skin.length, "make the skin longer")
        bores += _both_ends(CutRole.END_THREAD, place, grid, (x, z), depth, holes.thread)
    pinned = _pin_depth(place, grid)
    for x in place.pins:
        bores += _both_ends(CutRole.END_PIN, place, grid, (x, place.comb_pin), pinned, holes.press)
    return bores


def _deepest(grid: Grid, z: float, radius: float) -> float:
    """How deep bores at the height z of both ends may go until they come too near to each other, mm."""
    arm = (grid.centre - z - radius) * math.sin(grid.half)
    return (arm - EDGE / 2) / math.cos(grid.half)


def _pin_depth(place: Layout, grid: Grid) -> float:
    return on_grid(min(place.pin_depth, _deepest(grid, place.comb_pin, PIN_RADIUS)))


def _both_ends(
    role: CutRole, place: Layout, grid: Grid, at: tuple[float, float], depth: float, radius: float
) -> list[ExtendedCut]:
    x, z = at
    bores = []
    for end in ENDS:
        angle, base = _stand(place, grid, end)
        low, out = (base, base - CUT_OVERRUN) if end == "a" else (base - depth, base - depth)
        removed, built = (
            RotatedBody(Bore((x, start, z), "y", length, radius, role=role), grid.centre, angle, base)
            for start, length in ((low, depth), (out, depth + CUT_OVERRUN))
        )
        bores.append(ExtendedCut(removed, built))
    return bores


def _carrier(design: Design, lids: Layout, grid: Grid) -> Part:
    """The backing, whose bores are those of a straight one from where the arc is."""
    flat = carrier(design, lids)
    return replace(flat, body=_plate(design, lids, grid), cuts=_from_arc(flat.cuts, grid))


def _plate(design: Design, lids: Layout, grid: Grid) -> Prism:
    """A flat top above the back's arc, a clearance from the end plates all the way up."""
    gap = design.mold.clearance
    half = grid.half - math.asin(gap / grid.centre)
    wide = lids.trough - gap
    return Prism(seat(grid, half, lids.back, gap), "x", -wide, wide, grid=grid)


def _from_arc(cuts: tuple[Body, ...], grid: Grid) -> tuple[Body, ...]:
    placed = [_windowed(_from_back(cut, grid) if isinstance(cut, Bore) else cut, grid) for cut in cuts]
    short = [c for c in placed if isinstance(c, Bore) and c.role is CutRole.PULL and c.length < LEAST_PULL]
    return tuple(cut for cut in placed if cut not in short)


def _windowed(cut: Body, grid: Grid) -> Body:
    """A window from where the arc is: what it takes away begins at the mean height of the arc under it, by
    Green's theorem, so that its volume is right."""
    if not isinstance(cut, Prism):
        return cut
    nodes, weights = np.polynomial.legendre.leggauss(12)
    moment = 0.0
    for side in cut.outline:
        (x, y), (u, v) = side.start, side.end
        along = (nodes + 1) / 2
        rises = [rise(grid, y + share * (v - y)) for share in along.tolist()]
        moment += float(weights / 2 @ ((x + along * (u - x)) * np.array(rises))) * (v - y)
    counts = replace(cut, low=moment / area(cut.outline))
    return ExtendedCut(counts, replace(cut, low=-BORE_OVERRUN))


def _from_back(bore: Bore, grid: Grid) -> Bore:
    """A bore of the straight carrier from where the arc is: through ones from below it, pulls above; those of
    the mount are as they are, for over the arc the carrier is nowhere thinner than the straight one."""
    x, y, z = bore.start
    if bore.role in (CutRole.MOUNT, CutRole.MOUNT_PIN, CutRole.FIDUCIAL):
        return bore
    if bore.role is CutRole.PULL:
        z += on_grid(rise(grid, abs(y) + bore.radius))
        return replace(bore, start=(x, y, z), length=bore.start[2] + bore.length - z)
    widest = max(bore.radius, bore.far_radius)
    low = on_grid(rise(grid, max(0.0, abs(y) - widest)) - BORE_OVERRUN)
    return replace(bore, start=(x, y, low), length=bore.length - low, within=(grid.centre, grid.centre))


def _shims(design: Design, grid: Grid) -> list[Part]:
    """Shims as arcs through both end plates, with a grip beyond each."""
    arcs = []
    for part in shims(design):
        if isinstance(part.body, Prism):
            arm = grid.centre - part.body.outline[0].start.z
            out = grid.half + math.asin(design.mold.end_plate / arm) + GRIP / arm
            body = RevolvedBody(part.body.outline, grid.centre, -out, out, grid=grid)
            arcs.append(replace(part, body=body))
    return arcs


def _end_pin(design: Design, place: Layout, grid: Grid, end: End, i: int) -> Part:
    angle, base = _stand(place, grid, end)
    depth, thick = _pin_depth(place, grid), design.mold.end_plate
    start = (place.pins[i], base - (thick if end == "a" else depth), place.comb_pin)
    dowel = pin(PartRole.END_PIN, f"pin-{end}-{('left', 'right')[i]}", start, depth + thick, end)
    return turned(dowel, grid.centre, angle, base)


def height(grid: Grid, angle: float) -> float:
    """Return the height of the skin's back at an angle, mm."""
    return 2 * grid.centre * math.sin(angle / 2) ** 2


def half_length(grid: Grid, z: float, inside: float = 0.0) -> float:
    """Return the half length at the height z between the ends' planes, or planes `inside` them, mm."""
    return ((grid.centre - z) * math.sin(grid.half) - inside) / math.cos(grid.half)


def rise(grid: Grid, y: float) -> float:
    """Return the height of the back at y, mm."""
    return y * y / (grid.centre + math.sqrt(grid.centre**2 - y * y))


def seat(grid: Grid, half: float, top: float, inside: float = 0.0) -> Loop:
    """Return the outline (y, z) from the back's arc, -half to half rad, up to a flat top."""
    low, high = (Point(grid.centre * math.sin(a), height(grid, a)) for a in (-half, half))
    wide = half_length(grid, top, inside)
    return (Segment(low, high, math.tan(half / 2)), *path([high, Point(wide, top), Point(-wide, top), low]))


def gap_beside(carrier: Prism, gap: float) -> list[Prism]:
    """Return the gap round a carrier of this mold, down to its ledge: along both sides, and at both ends."""
    grid, top = carrier.grid, max(s.start.z for s in carrier.outline)
    if grid is None:
        raise ValueError("a straight carrier's gap is a frame")
    arc = carrier.outline[0]
    corner = Point(half_length(grid, top, gap), top)
    high = Point(grid.centre * math.sin(grid.half), height(grid, grid.half))
    rest = grid.half - math.asin(arc.end.x / grid.centre)
    turn = math.tan(rest / 4)
    end = (Segment(arc.end, high, turn), *path([high, Point(half_length(grid, top), top), corner, arc.end]))
    whole = seat(grid, grid.half, top)
    return [
        replace(carrier, outline=whole, low=carrier.high, high=carrier.high + gap),
        replace(carrier, outline=whole, low=carrier.low - gap, high=carrier.low),
        replace(carrier, outline=end),
        replace(carrier, outline=mirrored(end)),
    ]
