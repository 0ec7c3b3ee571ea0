"""Where screws, nuts, pins, notches and pull holes are, how long and thick they must be; how a cover bows."""

from __future__ import annotations

import math
import re
from functools import cache
from itertools import pairwise, product
from math import perm

import numpy as np
import pytest
from numpy.polynomial.legendre import leggauss
from scipy.sparse import coo_matrix, identity
from scipy.sparse.linalg import spsolve

import skincad
from skincad.base import InputError
from skincad.fabrication import Job, casting_sheet, manifold
from skincad.inputs import PROCESSES, Design, Mount, processes
from skincad.shape import section
from skincad.solids import (
    CAVITIES,
    END_PLATES,
    LENGTHS,
    METRIC,
    MOST_BOW,
    Bore,
    CutRole,
    Layout,
    Part,
    PartRole,
    Prism,
    blind_thread,
    bores,
    bow,
    fits,
    insert_radius,
    lid_process,
    run_out_room,
    scaled_for_shrinkage,
    screw_for,
    split_ridges,
    standard_length,
    thick_enough,
    torque,
)
from skincad.solids.fasteners import blind_depth, engagement, least_thickness
from skincad.solids.layout import Spans, choose_screws, layout, screw_rows
from skincad.solids.mold import mold
from tests.designs import KINDS, of_one_printer, three_ridges
from tests.solids.kinds import FEW, few_ridges

NUT_HEIGHT, NUT_FLATS = 2.4, 5.5  # mm, ISO 4032, M3


def filling(cut: Bore | Prism) -> Part:
    return Part("plug", PartRole.COVER, cut)


def pockets(design: Design) -> list[tuple[Part, Prism]]:
    cuts = [(part, cut) for part in mold(design).parts for cut in part.cuts if isinstance(cut, Prism)]
    return [(part, cut) for part, cut in cuts if cut.axis == "y"]


@pytest.mark.parametrize("name", ["lab-bench", "nozzle-04", "plain-ridges"])
def test_a_nut_goes_into_each_pocket_of_a_printed_end_plate_and_does_not_turn(name: str) -> None:
    nuts = pockets(of_one_printer(name))
    assert len(nuts) == 4
    for part, cut in nuts:
        assert part.name.startswith("end-b")
        assert cut.high == part.body.high  # open outward
        assert cut.high - cut.low >= NUT_HEIGHT
        levels = [s.start.z for s in cut.outline]
        flats = max(levels) - min(levels)
        # play as the process needs it, but less than what lets a hexagon turn: corner to corner
        assert NUT_FLATS + 0.2 <= flats + 1e-9 < 2 / math.sqrt(3) * NUT_FLATS


def test_a_pocket_is_open_to_its_bolt_hole_which_is_as_wide_as_its_thread_asks(yamada: Design) -> None:
    """Two cuts that meet on a face: by genus one hole each; a film between would make it none."""
    plate = mold(skincad.load("plain-ridges")).part("end-b")
    assert manifold(plate, 1e-3).genus() == 4 + 2  # bolts, pins
    assert pockets(yamada) == []  # wire-cut: tapped
    parts = mold(skincad.load("milled-pad")).parts
    for role in (CutRole.END_THREAD, CutRole.PULL):
        wide = {2 * hole.radius for part in parts for hole in bores(part, role)}
        assert wide == {3.0 - 0.5}  # ISO 2306, coarse pitch


@pytest.mark.parametrize("name", KINDS)
def test_cuts_lie_in_their_part_and_meet_no_other_by_volume(name: str) -> None:
    for part in mold(skincad.load(name)).parts:
        body = manifold(Part("body", PartRole.COVER, part.body), 1e-3)
        plugs = [manifold(filling(cut), 1e-3) for cut in part.cuts]
        for i, one in enumerate(plugs):
            assert (one - body).volume() < 1e-9, (part.name, i)
            assert all((one ^ other).volume() < 1e-9 for other in plugs[i + 1 :]), (part.name, i)


def test_holes_are_those_of_the_process(yamada: Design) -> None:
    known = processes()
    tight = yamada.with_(mold={"clearance": 0.0})
    for name in ("fdm", "sla", "cnc", "edm"):
        holes = fits(tight, name)
        assert holes.slide == 1.0 + known[name].clearance
        # below the pin's radius: metal by what P7 asks for, a print by what is reamed out of it
        assert holes.press == (0.9 if known[name].layer else 0.995)
    assert fits(yamada, "edm").slide == 1.0 + yamada.mold.clearance
    printed = tight.with_(mold={"end_plate_process": "fdm"})
    radii = {cut.radius for cut in mold(printed).part("end-a-comb").cuts if isinstance(cut, Bore)}
    assert radii == {1.7, 1.2}


@pytest.mark.parametrize("name", KINDS)
def test_a_screwdriver_finds_a_notch_at_each_side_of_each_end_plate(name: str) -> None:
    closed = mold(skincad.load(name))
    cavity = closed.part("cavity").body if name != "steep-fingertip" else closed.part("cavity-base").body
    for part in closed.parts:
        nicks = [c for c in part.cuts if isinstance(c, Prism) and c.axis == "z"]
        if not part.name.startswith("end-"):
            assert nicks == []
            continue
        outer = part.body.low if part.name.startswith("end-a") else part.body.high
        notches = [c for c in nicks if outer not in {s.start.z for s in c.outline}]  # no marks
        assert len(notches) in (2, 4), part.name
        for notch in notches:
            assert sum(abs(s.start.z) == cavity.high for s in notch.outline) == 2  # on the parting
            assert notch.high - notch.low >= 3.0


@pytest.mark.parametrize("end", ["a", "b"])
def test_nicks_tell_where_the_strips_numbers_begin(end: str) -> None:
    closed = mold(skincad.load("yamada-2002"))
    comb = closed.part(f"end-{end}-comb")
    outer = comb.body.low if end == "a" else comb.body.high
    cuts = [c for c in comb.cuts if isinstance(c, Prism) and c.axis == "z"]
    marks = [c for c in cuts if outer in {s.start.z for s in c.outline}]  # a prism along z has (x, y)
    assert len(marks) == {"a": 1, "b": 2}[end]
    for mark in marks:
        assert max(s.start.x for s in mark.outline) < 0  # ridge 1 has the smallest x


@pytest.mark.parametrize("shrinks", [0.0, 0.02])
@pytest.mark.parametrize(
    ("bent", "what"), [(None, "the pins of a mold's cover"), (100.0, "bolts and pins of a mold")]
)
def test_too_short_a_skin_is_told(yamada: Design, shrinks: float, bent: float | None, what: str) -> None:
    """What is poured is longer, and so is what it needs: a skin as long as it is told to be has room."""

    def refused(length: float) -> list[InputError]:
        skin = {"length": length, "curvature_radius_y": bent}
        design = scaled_for_shrinkage(yamada.with_(mold={"shrinkage": shrinks}, skin=skin))
        return [error for error in layout(design, section(design))[1] if error.key == "skin.length"]

    (refusal,) = refused(2.5)
    assert refusal.value == pytest.approx(2.5, rel=1e-9)  # a length is put on a grid of 1e-12 mm
    assert what in str(refusal)
    least = float(str(refusal).split()[5])
    assert refused(least) == []
    (nearly,) = refused(least - 0.002)
    assert f"at least {least:g} mm" in str(nearly)
    # pins of 2 mm with their gap and 0.8 mm beside them, or two rows of screws
    room = 2 * (1.0 + yamada.mold.clearance + 0.8) if bent is None else 9.0
    assert least == pytest.approx((1 - shrinks) * room, abs=1.1e-3)  # rounded up to 1 um


@pytest.mark.parametrize(("thickness", "carrier"), [(3.0, 3.2), (3.0, 3.0), (2.5, 3.5)])
def test_the_least_floor_of_a_split_cavity_leaves_its_pins_apart(thickness: float, carrier: float) -> None:
    """A wall has the cover's pins from above and the base's from below; 1.2 mm stay between their holes."""
    change = {"skin": {"thickness": thickness}, "slot": None, "film": None, "contact": {"film": None}}
    steep = skincad.load("steep-fingertip").with_(**change, mold={"carrier_thickness": carrier, "floor": 9.0})
    with pytest.raises(InputError, match=r"^mold.floor: must be at least") as refused:
        mold(steep)
    least = float(str(refused.value).split()[5])
    closed = mold(steep.with_(mold={"floor": least}))
    above, below = closed.part("pin-cover-right").body, closed.part("pin-base-right").body
    between = above.start[2] - (below.start[2] + below.length) - 2 * steep.mold.clearance
    assert between == pytest.approx(1.2, abs=1.1e-3)  # the least is rounded up to 1 um
    # and the pieces stand on the base with a foot of 1 mm or more under the deepest ridge
    base, skin = closed.part("cavity-base"), closed.part("skin")
    assert manifold(base, 0.01).bounding_box()[5] + 1.0 <= manifold(skin, 0.01).bounding_box()[2]


NU = 0.35  # the formula has none
PRESSURE, LEAST_COVER = 0.01, 4.0  # MPa of a syringe pushed by hand; mm
# N/mm: a spring a node that keeps a plate on two screws from turning about them; its load is none
TINY = 1e-6
POWERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (3, 1), (1, 3)]


def terms(x: float, y: float, by_x: int = 0, by_y: int = 0) -> np.ndarray:
    """The element's twelve terms at a point, or their derivatives."""
    powers = [(perm(i, by_x) * perm(j, by_y), max(i - by_x, 0), max(j - by_y, 0)) for i, j in POWERS]
    return np.array([factor * x**i * y**j for factor, i, j in powers], dtype=float)


def element(a: float, b: float, rigid: float) -> tuple[np.ndarray, np.ndarray]:
    """Stiffness and load of a rectangle a by b by Adini, Clough and Melosh (Zienkiewicz, section 10.4):
    deflection and both slopes at each corner."""
    corners = [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)]
    at = np.array([terms(x, y, *d) for x, y in corners for d in ((0, 0), (1, 0), (0, 1))])
    of = np.linalg.inv(at)
    law = rigid / (1 - NU**2) * np.array([[1, NU, 0], [NU, 1, 0], [0, 0, (1 - NU) / 2]])
    points, weights = leggauss(4)
    stiff, load = np.zeros((12, 12)), np.zeros(12)
    for u, wu in zip((points + 1) / 2, weights / 2, strict=True):
        for v, wv in zip((points + 1) / 2, weights / 2, strict=True):
            x, y, area = a * u, b * v, a * b * wu * wv
            curve = np.array([terms(x, y, 2, 0), terms(x, y, 0, 2), 2 * terms(x, y, 1, 1)]) @ of
            stiff += area * curve.T @ law @ curve
            load += area * terms(x, y) @ of
    return stiff, load


def lines(limit: float, fixed: set[float], size: float) -> np.ndarray:
    """A grid's lines from -limit to limit, one through every fixed place, about `size` apart."""
    stops = sorted({-limit, limit, *(v for v in fixed if abs(v) < limit)})
    parts = [np.linspace(u, v, max(1, round((v - u) / size)) + 1)[:-1] for u, v in pairwise(stops)]
    return np.concatenate([*parts, [limit]])


def plate_bow(place: Layout, modulus: float, size: float, points: tuple[tuple[float, float], ...]) -> float:
    """The largest deflection over the carriers, mm, of a plate held at points, pushed up over them."""
    borders = {c + s * place.trough for c in place.centres for s in (-1, 1)}
    xs = lines(place.half, borders | {x for x, _ in points}, size)
    ys = lines(place.cover, {-place.end, place.end} | {y for _, y in points}, size)
    number = np.arange(xs.size * ys.size).reshape(xs.size, ys.size)
    rows_, columns, values, force = [], [], [], np.zeros(3 * number.size)
    elements = {}
    for i, j in product(range(xs.size - 1), range(ys.size - 1)):
        a, b = xs[i + 1] - xs[i], ys[j + 1] - ys[j]
        key = round(a, 9), round(b, 9)
        if key not in elements:
            elements[key] = element(a, b, modulus * place.lid**3 / 12)
        stiff, load = elements[key]
        nodes = number[i, j], number[i + 1, j], number[i + 1, j + 1], number[i, j + 1]
        dofs = np.array([3 * n + k for n in nodes for k in range(3)])
        rows_.append(np.repeat(dofs, 12))
        columns.append(np.tile(dofs, 12))
        values.append(stiff.ravel())
        x, y = (xs[i] + xs[i + 1]) / 2, (ys[j] + ys[j + 1]) / 2
        if abs(y) < place.end and min(abs(x - c) for c in place.centres) < place.trough:
            force[dofs] += PRESSURE * load
    size_ = force.size
    whole = coo_matrix((np.concatenate(values), (np.concatenate(rows_), np.concatenate(columns))))
    whole = whole.tocsr() + TINY * identity(size_)
    fixed = {3 * number[np.argmin(abs(xs - x)), np.argmin(abs(ys - y))] for x, y in points}
    free = np.array([i for i in range(size_) if i not in fixed])
    w = np.zeros(size_)
    w[free] = spsolve(whole[free][:, free], force[free])
    over = abs(ys) <= place.end + 1e-9
    return float(abs(w[::3].reshape(number.shape)[:, over]).max())


@cache
def placed(name: str, cavities: int) -> tuple[Design, Layout]:
    design = scaled_for_shrinkage(skincad.load(name).with_(mold={"cavities": cavities}))
    return design, layout(design, section(design), split_cavity=bool(split_ridges(design)))[0]


@pytest.mark.parametrize("cavities", [1, 6])
@pytest.mark.parametrize("name", KINDS)
def test_no_cover_bows_by_more_than_the_formula_allows(name: str, cavities: int) -> None:
    if name == "steep-fingertip" and cavities > 1:
        return  # a split cavity has one skin
    design, place = placed(name, cavities)
    modulus = lid_process(design).part_modulus
    formula = bow(place.spans, place.lid, modulus)
    computed = plate_bow(place, modulus, 2.0, place.bolts)
    assert computed <= formula <= MOST_BOW == 0.02
    assert computed > 0.1 * formula  # a plate on its walls' screws is stiffer than beams, not tenfold


def test_a_plate_on_its_corners_bows_as_in_the_books() -> None:
    """Timoshenko and Woinowsky-Krieger, section 47: 0.0257 q a4 / D for nu 0.3; the elements against that, so
    that they may judge. The formula has 2 x 5/384 and no 1 - nu2."""
    side, thick, modulus = 40.0, 4.0, 2000.0
    _, place = placed("yamada-2002", 1)
    square = place._replace(half=side / 2, cover=side / 2, end=side / 2, trough=side / 2, lid=thick)
    corners = tuple((x, y) for x in (-side / 2, side / 2) for y in (-side / 2, side / 2))
    rigid = modulus * thick**3 / 12 / (1 - NU**2)
    coefficient = plate_bow(square, modulus, 1.0, corners) * rigid / (PRESSURE * side**4)
    assert coefficient == pytest.approx(0.0257, rel=0.05)  # nu 0.35, not 0.3, and elements of a fortieth
    formula = bow(Spans(side, side, side), thick, modulus) * modulus * thick**3 / 12 / (PRESSURE * side**4)
    assert formula == pytest.approx(10 / 384, rel=1e-12)
    assert formula / (1 - NU**2) > coefficient


def test_a_beam_under_a_load_in_its_middle_bows_as_integrated() -> None:
    """Moment by hand, twice integrated numerically, from the middle where the slope is none."""
    a, c, modulus, thick = 41.0, 26.0, 2000.0, 5.0
    x = np.linspace(0.0, a / 2, 20001)
    inner = np.clip(x - (a - c) / 2, 0.0, None)
    moment = PRESSURE * (c / 2 * x - inner**2 / 2)
    step = x[1] - x[0]
    slope = np.cumsum(moment[::-1])[::-1] * step / (modulus * thick**3 / 12)
    assert bow(Spans(a, c, 0.0), thick, modulus) == pytest.approx(slope.sum() * step, rel=1e-3)  # first order


def test_a_cover_is_as_thick_as_it_must_and_has_as_few_screws_as_it_may() -> None:
    spans = Spans(60.0, 50.0, 0.0)
    thick = thick_enough(spans, 2000.0, 0.5)
    assert bow(spans, thick, 2000.0) <= MOST_BOW < bow(spans, thick - 0.5, 2000.0)
    assert thick_enough(Spans(10.0, 5.0, 0.0), 2000.0, 0.5) == LEAST_COVER
    choices = screw_rows(40.0, 10.0, 3.2, 8.0)
    assert choices[:2] == [(1, 0.0, 60.0), (2, pytest.approx(33.6), pytest.approx(33.6))]
    assert all(row.spacing >= 8.0 for row in choices[1:])
    row, least = choose_screws(choices, 60.0, 50.0, 2000.0, None, 0.5)
    assert least == thick
    fewer = [choice for choice in choices if choice.screws < row.screws]
    assert all(bow(Spans(60.0, 50.0, choice.reach), thick, 2000.0) > MOST_BOW for choice in fewer)
    assert choose_screws(choices, 60.0, 50.0, 2000.0, 3.0, 0.5)[1] == 3.0  # given, so kept


def test_screws_stand_between_the_skins_and_clear_of_all_else() -> None:
    """Six skins on two screws bowed by 3.76 mm: each land has its own."""
    for name in ("yamada-2002", "lab-bench"):
        _, place = placed(name, 6)
        row_places = sorted({x for x, _ in place.bolts})
        assert len(row_places) == 7
        for x, _ in place.bolts:
            assert min(abs(x - lane) for lane in place.lanes) >= 1.2 + 2 * 1.7 - 1e-9
            assert min(abs(x - c) for c in place.centres) >= place.trough + 1.2 + 1.7 - 1e-9


@pytest.mark.parametrize("name", KINDS)
def test_pins_stand_aside_of_screws(name: str) -> None:
    design, place = placed(name, 1)
    for pin in mold(design).of(PartRole.COVER_PIN):
        for bolt in place.bolts:
            away = math.dist(pin.body.start[:2], bolt)
            assert away >= 1.0 + design.mold.clearance + 1.7 + 1.2 - 0.7  # keyed aside by that


LISTED = {5, 6, 8, 10, 12, 16, 20, 25, 30}  # ISO 4762, M3; a longer one is cut from a rod


@pytest.mark.parametrize("name", [*KINDS, "bent"])
def test_every_screw_is_in_the_standard_and_ends_free_in_its_hole(name: str) -> None:
    """By the sheet's own words against the parts' bores: at least 1 mm free, and 2.5 more for the tap."""
    design = three_ridges() if name == "bent" else skincad.load(name)
    closed = mold(design)
    text = casting_sheet(Job(design, closed), [], "", True)
    lengths = [int(size) for size in re.findall(r"M3 x (\d+)", text)]
    assert len(lengths) == 2
    assert {length for length in lengths if length <= 30} <= LISTED
    assert (max(lengths) > 30) == ("studs, DIN 976" in text)
    cover, blocks = closed.first(PartRole.COVER), closed.of(*CAVITIES)
    ((count, long),) = re.findall(r"(\d+) M3 x (\d+) for the cover", text)
    assert int(count) == len(bores(cover, CutRole.COVER_BOLT))
    clamped = cover.body.high - cover.body.low
    clamped += max((b.length for p in blocks for b in bores(p, CutRole.COVER_BOLT)), default=0.0)
    hole = min(b.length for p in blocks for b in bores(p, CutRole.COVER_THREAD))
    washers = re.search(r"for the cover.*?, (\d+) washers", text)
    engaged = int(long) - clamped - (0.5 * int(washers[1]) if washers else 0.0)
    process = Job(design).block_process
    tap = 0.0 if closed.of(PartRole.BASE) or process.thread != "tapped" else 2.5  # a split base's are open
    assert hole - engaged >= 1.0 + tap - 1e-9
    assert engaged >= 1.25 * 3 - 1e-9
    if name != "bent":  # along y: through both plates, and a nut or the thread of the second
        ends = [p for p in closed.of(*END_PLATES) if p.end == "b"]
        tapped = any(bores(p, CutRole.END_THREAD) for p in ends)
        assert lengths[0] >= closed.length + 2 * design.mold.end_plate + (0.0 if tapped else 0.5)


def test_a_blind_hole_is_as_deep_as_its_screw_of_the_list_needs() -> None:
    known = processes()
    for name in PROCESSES:
        process = known[name]
        for clamped in (1.0, 4.0, 4.5, 10.0, 33.3):
            deep = blind_depth(clamped, process)
            long, washers = screw_for(clamped, deep, process)
            assert (long, washers) == (standard_length(clamped + engagement(process)), 0)
            assert screw_for(clamped, deep - 0.4, process)[1] <= 1
            if process.thread == "tapped":
                assert deep == pytest.approx(long - clamped + 1.0 + 2.5, abs=1e-12)
                assert screw_for(clamped, deep - 0.4, process) == (long, 1)  # a washer of 0.5 makes up for it
                assert screw_for(clamped, deep - 2.5, process, bottomed=True) == (long, 0)
    assert set(LENGTHS) == LISTED
    assert [standard_length(v) for v in (1.0, 5.0, 5.01, 20.5, 30.0)] == [5.0, 5.0, 6.0, 25.0, 30.0]
    assert standard_length(133.2) == 134.0
    far = skincad.load("plain-ridges", [*FEW, "skin.length=130"])
    assert "M3 studs, DIN 976, with a nut at both ends: 4 M3 x 143 through both end plates" in casting_sheet(
        Job(far), [], "", True
    )


def test_torque_is_what_the_head_bears_and_a_thin_plate_has_nuts() -> None:
    """0.2 d F, F by 20 MPa in plastic on the ring of a head of 5.5 mm round a hole of 3.4. Golden sheets
    have the numbers."""
    known, ring = processes(), math.pi / 4 * (5.5**2 - 3.4**2)
    assert torque(known["sla"]) == torque(known["fdm"]) == pytest.approx(0.2 * 3e-3 * 20 * ring, abs=0.01)
    assert torque(known["edm"]) == pytest.approx(0.2 * 3e-3 * 60 * ring, abs=0.01)
    assert engagement(known["cnc"]) == 1.5 * 3.0
    steel, thin = (few_ridges(mold={"end_plate": thick}) for thick in (3.75, 3.7))
    for design, role in ((steel, CutRole.END_THREAD), (thin, CutRole.END_BOLT)):
        plate = mold(design).part("end-b-comb")
        assert len(bores(plate, role)) == 2
    assert "with nuts, 0 of them sunk" in casting_sheet(Job(thin), [], "", True)


@pytest.mark.parametrize("cover", [4.0, 46.0])
def test_a_floor_stays_under_the_threads_of_the_thickest_cover(cover: float) -> None:
    """A screw of 55 for a cover of 46 goes 9 into the cavity: 10 of hole with an insert."""
    flat = skincad.load("plain-ridges", ["ridge.height=0.2", "mold.pour=open", f"mold.cover={cover}"])
    block = mold(flat).part("cavity")
    deep = {b.length for b in bores(block, CutRole.COVER_THREAD)}
    assert deep == {7.0} if cover == 4.0 else {10.0}
    bottom = min(s.start.z for s in block.body.outline)
    assert min(b.start[2] for b in bores(block, CutRole.COVER_THREAD)) - bottom >= 1.2


METAL, RESIN = processes()["edm"], processes()["sla"]
# source: ISO 261 (diameter, coarse pitch), ISO 273 (medium clearance hole)
COARSE = {"M2": (2.0, 0.4, 2.4), "M2.5": (2.5, 0.45, 2.9), "M3": (3.0, 0.5, 3.4), "M4": (4.0, 0.7, 4.5)}


@pytest.mark.parametrize("name", COARSE)
def test_a_thread_has_its_drill_its_screw_and_its_run_out(name: str) -> None:
    """ISO 2306 rounds diameter less pitch to the drills that there are, by 0.05 mm at most."""
    diameter, pitch, clearance = COARSE[name]
    assert METRIC[name][:2] == (diameter, pitch)
    assert METRIC[name].drill == pytest.approx(diameter - pitch, abs=0.051)
    assert METRIC[name].clearance == clearance
    assert METRIC[name].insert_hole >= diameter + 2 * pitch  # there is brass round the thread
    tapped, insert = blind_thread(name, METAL), blind_thread(name, RESIN)
    assert tapped.insert == ""
    assert tapped.least == diameter  # in metal
    assert tapped.depth - tapped.most == pytest.approx(5 * pitch, abs=1e-9)  # DIN 76-1, short
    assert tapped.most - tapped.least == pytest.approx(1.0)  # a screw of a standard length finds its place
    assert insert.insert == "glued"
    assert insert.most == METRIC[name].insert >= insert.least == 1.5 * diameter
    assert insert.depth == pytest.approx(insert.most + 1.0, abs=1e-9)
    process = RESIN.model_copy(update={"thread": "tapped"})
    assert blind_thread(name, process).least == 1.5 * diameter  # in plastic


def test_threads_of_a_mold_and_its_mount_take_their_depth_from_the_process() -> None:
    for process in (METAL, RESIN):
        blind = blind_thread("M3", process)
        assert 2 * blind.radius == (2.5 if not blind.insert else 2 * insert_radius("M3", blind.insert))
        assert blind.depth - blind.most + (0.0 if blind.insert else 1.0) == pytest.approx(
            run_out_room(process)
        )
    # a carrier is as thick as the deepest hole asks
    for mount, process, deepest, word in (
        (Mount(thread="M3", diameter=9.0), METAL, 3.0 + 1.0 + 2.5, "M3 threads"),
        (Mount(thread="M4", diameter=9.0), RESIN, 8.1 + 1.0, "M4 glued inserts"),
        (Mount(thread="M2", diameter=9.0, pin=3.0), METAL, 2.0 + 1.0 + 2.0, "M2 threads"),
        (Mount(fiducials=3, fiducial_depth=2.0), METAL, 2.0, "fiducials"),
    ):
        need, what = least_thickness(mount, process)
        assert math.isclose(need, deepest + 1.0, abs_tol=1e-9)
        assert word in what
