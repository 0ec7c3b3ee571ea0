"""Random sections with nothing said of the mold but its process: what is computed makes one, that of plain
values in a round block where these make one."""

from __future__ import annotations

from functools import cache
from itertools import islice

import pytest

import skincad
from bench.campaign.soundness import faults
from bench.table_molds import refusals, sections
from skincad.base import InputError
from skincad.fabrication import Job, casting_sheet, extent
from skincad.inputs import Design
from skincad.solids import CAVITIES, ClosedMold, PartRole
from skincad.solids.mold import mold
from tests.designs import RIDGED
from tests.solids.kinds import few_ridges

FEW, MANY = 80, 1000
RANDOM = pytest.mark.evidence(subject="seeds: molds")
RESCUED = 12  # of them are built
LARGEST_SHARE = 0.10  # of valid sections without a mold; those shorter than 4 mm are 6 % of what is drawn
# what a mold has where bolts, pins, gate and vent find room
PLAIN = {"wall": 13.0, "floor": 9.0, "carrier_thickness": 4.0, "carrier": "perforated"}
PLAIN |= {"pour": "syringe", "gate": 2.0, "vent": 1.0}
# what a refusal may name: what a person wrote, or a clearance, where it is the slots' place that is told
WRITTEN = {"skin.length", "mold.slit_clearance"}
Planned = ClosedMold | InputError


@cache
def few() -> list[tuple[Design, Planned, Planned]]:
    """Random sections, each with its mold, and with that of the plain values."""
    return [(design, planned(design), planned(plain(design))) for design in sections(FEW, seed=1)]


def plain(design: Design) -> Design:
    """The design with each value that the mold would compute written down, where nobody wrote another."""
    values = design.mold.model_dump(exclude_none=True)
    return design.with_(mold={key: value for key, value in PLAIN.items() if key not in values})


def planned(design: Design) -> Planned:
    try:
        return mold(design)
    except InputError as refused:
        return refused


def keys(refused: InputError) -> set[str]:
    return {error.key for error in (refused, *refused.others)}


@RANDOM
def test_nine_of_ten_random_sections_have_a_mold() -> None:
    for refused, count in (
        ([result for _, result, _ in few() if isinstance(result, InputError)], FEW),
        ([result for _, result in refusals(sections(MANY))], MANY),
    ):
        assert len(refused) <= LARGEST_SHARE * count, "\n".join(map(str, refused))
        for result in refused:
            assert keys(result) <= WRITTEN, result
            assert result.remedy
    # a value that was written is refused, not changed
    refused = set().union(*(keys(result) for _, _, result in few() if isinstance(result, InputError)))
    computed = {"mold.wall", "mold.carrier_thickness", "mold.carrier", "mold.gate", "mold.vent"}
    assert refused <= computed | WRITTEN | {"skin.thickness"}
    assert {"mold.wall", "mold.carrier_thickness", "mold.gate"} <= refused


@RANDOM
def test_where_plain_values_make_a_mold_the_computed_one_is_that_in_a_round_block() -> None:
    """Up to the next half millimetre of width and height, where neither wall nor floor is given."""
    pairs = [(mold(d), mold(plain(d))) for d in map(skincad.load, RIDGED)]
    pairs += [(one, other) for _, one, other in few() if isinstance(other, ClosedMold)]
    for computed, given in pairs:
        sides = [(extent(m.of(*CAVITIES)[0]), extent(m.first(PartRole.COVER))) for m in (computed, given)]
        assert sides[0][0][1] == sides[1][0][1]  # the skin's negative, open at its ends
        for size, least in ((sides[0][i][j], sides[1][i][j]) for i, j in ((0, 0), (0, 2), (1, 0), (1, 1))):
            assert -0.05 - 1e-9 <= size - least < 0.5
    assert len(pairs) > FEW / 5  # else nothing is shown


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"skin": {"thickness": 0.4}}, "mold.carrier_thickness"),
        ({"mold": {"clearance": 0.9}}, "mold.wall"),
        ({"mold": {"clearance": 0.9}}, "mold.floor"),
        ({"skin": {"thickness": 2.0}}, "mold.gate"),
    ],
)
def test_one_change_needs_another_value_than_the_plain_one(yamada: Design, change: dict, key: str) -> None:
    table, value = key.split(".")
    flat = yamada.with_(skin={"curvature_radius": 1e3})
    changed = flat.with_(**change, slot=None)
    assert mold(changed)
    assert key not in {"mold." + k for k in changed.mold.model_dump(exclude_none=True)}
    with pytest.raises(InputError) as refused:
        mold(changed.with_(**{table: {value: PLAIN[value]}}))
    assert refused.value.key == key


def test_a_split_cavity_has_the_floor_that_its_pieces_need() -> None:
    steep = skincad.load("steep-fingertip", ["mold.floor=none"])
    assert mold(steep)
    with pytest.raises(InputError, match=r"^mold.floor: must be at least"):
        mold(steep.with_(mold={"floor": 9.0, "carrier_thickness": 3.0}))


def test_a_skin_too_thin_for_a_gate_is_poured_open_and_a_gang_has_gates(yamada: Design) -> None:
    thin = yamada.with_(skin={"thickness": 1.0, "curvature_radius": 1e3}, slot=None)
    assert (Job(yamada).gate, Job(thin).gate) == (2.0, None)
    sheet = casting_sheet(Job(thin), [], "", True)
    assert "pour in a thin stream" in sheet
    assert "gate" not in sheet
    with pytest.raises(InputError, match=r"^skin.thickness: leaves .* for the gate"):
        mold(thin.with_(mold={"pour": "syringe"}))
    assert "End a has the gate" in casting_sheet(Job(few_ridges(mold={"cavities": 2})), [], "", True)


@pytest.mark.slow
def test_the_cover_of_a_short_skin_is_clamped_and_its_parts_are_sound(yamada: Design) -> None:
    short = yamada.with_(skin={"length": 5.0})
    closed = mold(short)
    assert {cut.radius for cut in closed.part("cover").cuts[:2]} == {0.995}  # pins, no bolts
    sheet = casting_sheet(Job(short, closed), [], "", True)
    assert "two clamps that hold the cover down" in sheet
    assert "2 for the cover" not in sheet
    assert list(faults(short, kernel=False)) == []


@RANDOM
def test_molds_that_only_computed_values_make_are_sound() -> None:
    """True solids of a dozen; those of many ridges take the kernel minutes, and are built the same way."""
    small = (d for d in sections(200, seed=2) if d.ridge.count <= 5 and d.skin.length < 60)
    rescued = (
        d for d in small if isinstance(planned(plain(d)), InputError) and isinstance(planned(d), ClosedMold)
    )
    checked = 0
    for design in islice(rescued, RESCUED):
        assert list(faults(design)) == [], design
        checked += 1
    assert checked == RESCUED
