"""The wire between a board and `skincad listen`: lines in bulk, gaps, restarts, and what cannot be read."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

from skincad.base import InputError
from skincad.detector import Block, Wire
from tests.refusals import refused

CHANNELS = ((2, "S1"), (2, "S2"), (7, "S1"), (7, "S2"))
HEADER = "ridge_2_S1_V,ridge_2_S2_V,ridge_7_S1_V,ridge_7_S2_V"
RATE, LONGEST = 1000.0, 50
DRAWN = np.random.default_rng(4).normal(1.65, 0.3, (400, 4))


def wire(*, noisy: bool = False, channels: tuple[tuple[int, str], ...] = CHANNELS) -> Wire:
    return Wire("board", channels, RATE, longest_gap=LONGEST, noisy=noisy)


def text(
    counts: Iterable[object], head: str = "sample", values: np.ndarray = DRAWN, end: str = "\n"
) -> bytes:
    rows = [f"{head},{HEADER}"]
    rows += [
        f"{count},{','.join(map(repr, row))}" for count, row in zip(counts, values.tolist(), strict=False)
    ]
    return (end.join(rows) + end).encode()


def read(data: bytes, size: int = 10**9, reader: Wire | None = None) -> list[Block]:
    reader = reader or wire()
    blocks = [block for k in range(0, len(data), size) for block in reader.push(data[k : k + size])]
    return blocks + reader.finish()


def joined(blocks: list[Block]) -> tuple[np.ndarray, ...]:
    parts = [(block.values, block.numbers, block.times) for block in blocks]
    return tuple(np.concatenate(part) for part in zip(*parts, strict=True))


def test_what_comes_before_a_refused_line_is_given() -> None:
    reader, data = wire(), text(range(300)) + b"300,1,2,nan,1\n" + b"301,1,2,3,1\n"
    blocks, fault = reader.up_to_fault(data)
    assert fault is not None
    assert str(fault).startswith("board, sample 300, ridge_7_S1_V: must be finite")
    np.testing.assert_array_equal(joined(blocks)[0], DRAWN[:300])
    reader = wire()
    blocks, fault = reader.up_to_fault(text(range(300)))
    assert fault is None
    np.testing.assert_array_equal(joined(blocks)[0], DRAWN[:300])


LOST = [*range(100, 200), *range(203, 260), *range(900, 1000), *range(100)]  # a gap, a long one, a restart


@pytest.mark.parametrize("size", [1, 7, 1000, 4095])
@pytest.mark.parametrize("end", ["\n", "\r\n"])
def test_bytes_cut_anywhere_give_the_same(size: int, end: str) -> None:
    data = text(LOST, end=end)
    half = data.index(b"\n", len(data) // 2) + 1
    again = f"# a remark{end}sample,{HEADER}{end}alarm,230,gross slip ahead,{end}{end}".encode()
    data = data[:half] + again + data[half:]
    whole, pieces = wire(), wire()
    one, many = read(data, reader=whole), read(data, size, pieces)
    for here, there in zip(joined(one), joined(many), strict=True):
        np.testing.assert_array_equal(here, there)
    for blocks in (one, many):
        assert [block.begins for block in blocks if block.begins] == ["start", "gap", "restart"]
        assert [lost for block in blocks for lost in block.lost] == [(3, 200)]
        assert sum(block.gap for block in blocks) == 640
    assert whole.alarms == pieces.alarms
    assert [(alarm.kind, alarm.ridge, alarm.index) for alarm in whole.alarms] == [
        ("gross slip ahead", None, 230)
    ]


def test_numbers_have_the_bits_that_python_reads() -> None:
    (block,) = read(text(range(400)))
    assert block.values.tobytes() == DRAWN.tobytes()


def test_a_gap_is_filled_by_straight_lines_and_time_stays_right() -> None:
    (block,) = read(text([5, 6, 10, 11], values=DRAWN[:4]))
    np.testing.assert_array_equal(block.numbers, np.arange(5, 12))
    np.testing.assert_allclose(block.times, np.arange(7) / RATE)
    steps = np.linspace(0, 1, 5)[:, None]
    np.testing.assert_allclose(block.values[1:6], DRAWN[1] * (1 - steps) + DRAWN[2] * steps)  # rounding
    assert (block.lost, block.rows.tolist()) == (((3, 7),), [0, 1, 5, 6])


@pytest.mark.parametrize(("missing", "begins"), [(LONGEST, ["start"]), (LONGEST + 1, ["start", "gap"])])
def test_after_a_gap_longer_than_its_memory_all_begins_anew(missing: int, begins: list[str]) -> None:
    blocks = read(text([0, 1, missing + 2, missing + 3], values=DRAWN[:4]))
    assert [block.begins for block in blocks] == begins
    assert blocks[-1].times[-1] == pytest.approx((missing + 3) / RATE)


def test_the_counter_wraps_and_a_smaller_one_is_a_restart() -> None:
    last = 2**32 - 1
    (block,) = read(text([last - 1, last, 0, 1]))
    np.testing.assert_array_equal(block.numbers, [last - 1, last, 0, 1])
    np.testing.assert_allclose(block.times, np.arange(4) / RATE)
    (block,) = read(text([last, 2, 3]))
    assert block.lost == ((2, 0),)
    for counts in ([10, 11, 5, 6], [3 * 10**9, 0, 1], [10, 11, 11, 12]):
        assert [block.begins for block in read(text(counts))] == ["start", "restart"]


def test_columns_are_read_by_name_and_others_passed_over() -> None:
    data = b"sample,ridge_7_S2_V,note,ridge_2_S1_V\n5,1.5,,0.25\n6,1.5,loose,0.5\n"
    (block,) = read(data, reader=wire(channels=((2, "S1"), (7, "S2"))))
    np.testing.assert_array_equal(block.values, [[0.25, 1.5], [0.5, 1.5]])


def test_times_count_samples_and_their_rate_may_be_off_by_a_little() -> None:
    stamps = np.delete(np.arange(300) / (1.015 * RATE), [40, 41])
    blocks = read(text(map(repr, stamps.tolist()), "time_s"))
    assert [lost for block in blocks for lost in block.lost] == [(2, 40)]
    assert joined(blocks)[2][-1] == stamps[-1]


def test_of_a_noisy_line_a_garbled_one_is_a_lost_sample() -> None:
    data = text(range(6), values=DRAWN[:6]).replace(b"\n3,", b"\n3,1.2.3,").replace(b"\n1,", b"?1,")
    reader = wire(noisy=True)
    blocks = read(b"4,1.0,garbage from before\n" + data, reader=reader)
    assert [lost for block in blocks for lost in block.lost] == [(1, 3)]
    assert blocks[0].numbers[0] == 2  # 0 came in one line with 1


GOOD = text(range(40)).decode()
BAD = {
    "no header": (GOOD.split("\n", 1)[1], "has no header before its numbers"),
    "nothing": ("# a remark\n", "has no header; first line: sample,ridge_2_S1_V"),
    "too few channels": (GOOD.replace("_7_S2", "_8_S2"), "has no channel ridge_7_S2_V"),
    "and which there are": (GOOD.replace("_7_S2", "_8_S2"), "connect it, or listen with --ridges 2"),
    "other columns": (GOOD + GOOD.replace("_7_S", "_8_S"), "board: must keep its columns"),
    "NaN": (GOOD + "40,1.0,nan,1.0,1.0\n", "sample 40, ridge_2_S2_V: must be finite, got nan"),
    "infinite": (GOOD + "40,1.0,1.0,1.0,-inf\n", "sample 40, ridge_7_S2_V: must be finite, got -inf"),
    "a word": (GOOD + "40,1.0,1.0,1.0,one\n", "board, line 42: must be 5 numbers"),
    "an empty value": (GOOD + "40,1.0,,1.0,1.0\n", "board, line 42: must be 5 numbers"),
    "a value too few": (
        GOOD + "40,1.0,1.0,1.0\n41,1.0,1.0,1.0,1.0,1.0\n",
        "board, line 42: must be 5 numbers",
    ),
    "half a counter": (GOOD + "40.5,1.0,1.0,1.0,1.0\n", "board, sample: must be a whole number, got 40.5"),
    "a counter of NaN": (GOOD + "nan,1.0,1.0,1.0,1.0\n", "board, sample: must be a whole number, got nan"),
    "an alarm": (GOOD + "alarm,soon,\n", "must be alarm,SAMPLE,KIND,RIDGE"),
    "time stands": (GOOD.replace("sample", "time_s") + "39,1,1,1,1\n", "time_s must grow from row to row"),
    "another rate": (
        GOOD.replace("sample", "time_s"),
        "must have the detector's 1000 samples a second, to 2%, got 1; listen with --rate 1",
    ),
    "a little": (
        text([f"{k / 1030:.6f}" for k in range(40)], "time_s").decode(),
        "got 1030; listen with --rate 1030",
    ),
    "no lines": ("\0" * 200_000, "must send lines of numbers"),
}


@pytest.mark.parametrize("name", BAD)
def test_what_cannot_be_read_is_refused(name: str) -> None:
    data, words = BAD[name]
    with refused(words):
        read(data.encode(), 1000)


def test_a_noisy_line_is_refused_where_its_board_is_wrong() -> None:
    for name in ("too few channels", "other columns", "NaN", "no lines"):
        with pytest.raises(InputError):
            read(BAD[name][0].encode(), reader=wire(noisy=True))
