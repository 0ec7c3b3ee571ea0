"""The verdict in words: each way it can end, said once and right; the tables of ladders."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from skincad import Estimate, check, load
from skincad.mechanics import Change, ContactCheck, wiring_order
from skincad.outputs import ACCURACY, CHECK
from skincad.studies import Ladder, Measurement, measures_of
from tests.conftest import skincad_process

BLOCKS, CLEAR = "▁▂▃▄▅▆▇█", "·"  # a ridge's force in eighths of the largest; a ridge without load
MOST_BARS = 60  # in a terminal


@pytest.fixture(scope="module")
def passed() -> ContactCheck:
    return check(load("plain-ridges"), force=5.0, model="linear", tol=0.05)


def verdict(check: ContactCheck) -> str:
    return str(check).splitlines()[0]


def force_bars(check: ContactCheck) -> str:
    (line,) = (row for row in str(check).splitlines() if row.startswith("  ridge forces   "))
    return line.removeprefix("  ridge forces   ")


@pytest.mark.slow
def test_each_ending_has_its_words(passed: ContactCheck) -> None:
    none = Estimate(None, None, "N")
    needs_more, unclear = Estimate(6.0, 0.5, "N"), Estimate(4.8, 0.5, "N")
    for change, words in (
        ({}, "Passes: all 9 ridges touch a flat plate at 5 N; they already do at 3.0 "),
        (
            {"ridges": 2, "touching": 2},
            "Passes: both ridges touch a flat plate at 5 N; they already do at 3.0 ",
        ),
        (
            {"touching": 7, "all_touch_force": needs_more},
            "FAILS: 7 of 9 ridges touch a flat plate at 5 N; all need 6.00 ± 0.50 N.",
        ),
        (
            {"all_touch_force": unclear},
            "UNDECIDED: 9 of 9 ridges touch a flat plate at 5 N, but the force they need is 4.80 ± 0.50 N.",
        ),
        (
            {"touching": 7, "all_touch_force": Estimate(5.2, 0.5, "N")},
            "UNDECIDED: 7 of 9 ridges touch a flat plate at 5 N. All need 5.20 ± 0.50 N, which may be less.",
        ),
        (
            {"touching": 5, "all_touch_force": none},
            "FAILS: 5 of 9 ridges touch a flat plate at 5 N; "
            "the force that all need is beyond the model's range.",
        ),
        ({"out_of_range": "too soft"}, "UNDECIDED: too soft."),
        ({"ridges": 1, "touching": 1}, "Passes: the one ridge touches a flat plate at any force."),
        ({"ridges": 1, "touching": 1, "out_of_range": "crushed"}, "UNDECIDED: crushed."),
    ):
        changed = replace(passed, **change)
        assert verdict(changed).startswith(words)
        assert verdict(changed).upper().startswith(changed.verdict.upper())
        assert changed.passed == (changed.verdict == "passes")
        assert changed.as_json()["verdict"] == changed.verdict


def test_a_check_is_five_lines_and_its_details_repeat_none(passed: ContactCheck) -> None:
    known = replace(passed, warnings=())
    first, margin, error, forces, last = str(known).splitlines()
    assert first.startswith("Passes: all 9 ridges touch a flat plate at 5 N; they already do at 3.0 ")
    assert margin.startswith(f"  margin         {passed.margin:.2f} N in the worst case (5 N applied")
    shares = [float(share) for share in re.findall(r"([\d.e-]+) N (?:from|for)", error)]
    assert len(shares) == 1 + len(passed.left_out)
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) == pytest.approx(passed.all_touch_force.error, rel=0.05)
    assert forces.endswith(f"{passed.ridge_force[0]} to {passed.ridge_force[4]}")
    assert last == "Next: `skincad make DESIGN` makes its mold."
    rows = known.details().splitlines()
    assert rows[:5] == str(known).splitlines()
    assert len(set(rows)) == len(rows) > 10


@pytest.mark.parametrize(
    ("forces", "order"),
    [
        ((0.1, 0.4, 0.5, 0.6, 0.7, 0.6, 0.5, 0.4, 0.1), (5, 4, 6, 3, 7, 2, 8, 1, 9)),
        ((0.1, 0.6, 0.7, 0.7, 0.6, 0.1), (3, 4, 2, 5, 1, 6)),
        ((0.1, 0.2, 0.3, 0.4), (4, 3, 2, 1)),  # as under a plate that leans
        ((0.7, 0.6999, 0.7001, 0.7, 0.7), (3, 2, 1, 4, 5)),  # all alike: neighbours in the middle
        ((0.4, 0.9, 0.2, 0.9, 0.4), (2, 4, 1, 5, 3)),
        ((0.0, 0.0, 0.0), (2, 1, 3)),
    ],
)
def test_the_ridges_that_bear_most_are_wired_first(forces: tuple[float, ...], order: tuple[int, ...]) -> None:
    assert wiring_order([Estimate(force, 0.5, "N") for force in forces]) == order


def test_only_skins_with_films_say_which_to_wire(passed: ContactCheck) -> None:
    """And with more than two ridges, whose four strips four channels take."""
    assert passed.wire_first == ()
    assert "wire first" not in str(passed)
    assert passed.as_json()["wire_first"] == []
    assert passed.as_json()["wire_first_rests_on"] is None
    wired = check(load("yamada-2002"), model="winkler")
    (line,) = (row for row in str(wired).splitlines() if row.startswith("  wire first     "))
    assert line.startswith("  wire first     ridges 5 and 4 if there are four channels, then 6 and 3: ")
    assert wired.as_json()["wire_first"] == [5, 4, 6, 3, 7, 2, 8, 1, 9]
    assert wired.as_json()["wire_first_rests_on"].startswith("ridge_force_N: ")
    three = check(load("steep-fingertip"), model="winkler")
    assert "ridges 2 and 1 if there are four channels, then 3: " in str(three)
    for settings in (["film=none", "contact.film=none"], ["ridge.count=2"], ["slot=none"]):
        assert check(load("yamada-2002", settings), model="winkler").wire_first == ()


def test_a_warning_is_not_hidden(passed: ContactCheck) -> None:
    assert "  note           mind this" in str(replace(passed, warnings=("mind this",))).splitlines()


def test_bars_are_parts_of_the_largest_force(passed: ContactCheck) -> None:
    forces = (0.0, 0.01, 0.5, 0.99, 1.0)
    some = replace(passed, ridge_force=tuple(Estimate(force, 0.1, "N") for force in forces), ridges=5)
    bars = CLEAR + BLOCKS[0] + BLOCKS[3] + BLOCKS[6] + BLOCKS[7]
    assert force_bars(some) == f"{bars}  0.00 ± 0.10 N to 1.00 ± 0.10 N"
    many = replace(passed, ridge_force=(Estimate(1.0, 0.1, "N"),) * 201 + (Estimate(0.0, 0.1, "N"),))
    bars, words = force_bars(many).split("  ")
    assert len(bars) <= MOST_BARS
    assert bars == BLOCKS[7] * (len(bars) - 1) + CLEAR  # the last bar holds the ridge without load
    assert words.endswith(", 4 ridges a bar")
    assert force_bars(replace(passed, ridge_force=many.ridge_force[:1])) == f"{BLOCKS[7]}  1.00 ± 0.10 N"


@pytest.mark.slow
@pytest.mark.parametrize(("encoding", "bars"), [("ascii", "[0-9]{9}"), ("utf-8", f"[{CLEAR}{BLOCKS}]{{9}}")])
def test_bars_are_digits_where_blocks_cannot_be_printed(tmp_path: Path, encoding: str, bars: str) -> None:
    words = ("check", "plain-ridges", "--model", "winkler", "--force", "1", "--no-advice")
    done = skincad_process(*words, cwd=tmp_path, PYTHONIOENCODING=encoding)
    line = next(line for line in done.stdout.splitlines() if "ridge forces" in line).split()[2]
    assert re.fullmatch(bars, line)
    assert line[0] == ("0" if encoding == "ascii" else CLEAR)
    assert line[4] == ("9" if encoding == "ascii" else BLOCKS[7])


def test_a_check_that_fails_says_what_to_change(passed: ContactCheck) -> None:
    failed = replace(passed, touching=7, all_touch_force=Estimate(6.0, 0.5, "N"))
    assert (
        CHECK.next_step(failed)
        == "`skincad check {design} --advice` looks for a change with which it passes."
    )
    change = Change("ridge.levelling", 0.0, 0.5, Estimate(3.0, 0.5, "N"))
    known = replace(failed, changes=(change,))
    assert CHECK.next_step(known) == "`skincad check {design} --set ridge.levelling=0.5` passes."
    rough = replace(failed, changes=(replace(change, model="winkler"),))
    assert CHECK.next_step(rough).endswith("--set ridge.levelling=0.5` may pass, by the winkler model.")
    none = replace(failed, changes=())
    assert CHECK.next_step(none) == "change two keys: no single change passes; or press with 6.5 N."
    assert CHECK.next_step(replace(none, search_cut_short=True)) == CHECK.next_step(failed)


def test_a_notebook_shows_verdict_and_bars(passed: ContactCheck) -> None:
    page = replace(passed, warnings=("<b>",))._repr_html_()
    assert verdict(passed) in page
    assert page.count("<rect") == passed.ridges
    assert "&lt;b&gt;" in page
    assert not re.search(r"(src|href)=|<b><|url\(", page)


def test_an_undecided_check_says_what_may_decide_it(passed: ContactCheck) -> None:
    unclear = replace(passed, all_touch_force=Estimate(4.8, 0.5, "N"))
    assert CHECK.next_step(unclear).startswith("`skincad check {design} --model corrected` (about ")
    last = replace(unclear, next_model=None, left_out=())
    expected = "no model here can decide it. The design passes from 5.3 N and fails below 4.3 N."
    assert CHECK.next_step(last) == expected
    assert unclear.as_json()["next_step"] == unclear.next_step
    friction = tuple(replace(part, effect="friction", threshold=0.1) for part in passed.left_out[:1])
    lasting = replace(unclear, all_touch_force=Estimate(4.9, 0.6, "N"), left_out=friction)
    expected = "give contact.friction (as `--set contact.friction=0.5`): its error alone leaves this open."
    assert CHECK.next_step(lasting) == expected
    for decided in (passed, replace(passed, all_touch_force=Estimate(6.0, 0.5, "N"))):
        assert decided.next_step == ""


def test_a_yield_is_told_only_with_its_error(passed: ContactCheck) -> None:
    part_yield = passed.manufacture
    assert part_yield is not None
    unknown = [Estimate(None, None, ""), Estimate(None, 0.1, ""), Estimate(0.9, None, "")]
    for other in (None, *(replace(part_yield, passing=passing) for passing in unknown)):
        assert not any("yield" in line for line in CHECK.details(replace(passed, manufacture=other)))


@pytest.mark.parametrize(
    ("share", "interval", "words"),
    [
        (0.9, (0.8049, 0.93), "90 % (80 to 93 %) of parts pass"),
        (0.992, (0.474, 1.0), "99 % (47 to 100 %) of parts pass"),
        (1.0, (0.99864, 1.0), "100.0 % (99.8 to 100 %) of parts pass"),
        (0.004, (0.0, 0.379), "0 % (0 to 38 %) of parts pass"),
        (0.4, (0.02, 0.97), "unknown (2 to 97 % are possible)"),
    ],
)
def test_a_yield_is_told_inside_0_to_100_percent(
    passed: ContactCheck, share: float, interval: tuple[float, float], words: str
) -> None:
    assert passed.manufacture is not None
    known = replace(passed.manufacture, passing=Estimate(share, 0.5, "1"), interval=interval)
    assert any(words in line for line in CHECK.details(replace(passed, manufacture=known)))


def test_forces_of_very_many_ridges_are_shown_as_a_range() -> None:
    design = load("plain-ridges", ["ridge.count=31", "skin.width=33", "skin.curvature_radius=1000"])
    verdict_of_many = check(design, model="winkler")
    values = [share.value or 0.0 for share in verdict_of_many.ridge_force]
    line = next(line for line in CHECK.details(verdict_of_many) if "each ridge" in line)
    assert f"{min(values):.3f} to {max(values):.3f} (±" in line


def test_a_measure_has_a_readers_name_above_its_column() -> None:
    point = Measurement("linear", "fineness 1", 10, (1.0,), {"mesh F9": 0.12, "whole approach": 0.34})
    ladder = Ladder("contact", "contact of a skin", (point,), measures_of({}, ""))
    text = ACCURACY.rows("ladder_lines", ladder)
    assert not [line for line in text if "F9" in line]
    for name, value in (("mesh all-touch force", "0.12"), ("whole approach", "0.34")):
        head, row = text[1].index(name) + len(name), text[2].index(value) + len(value)
        assert head - row in (0, 1), text  # a star may stand after the value
