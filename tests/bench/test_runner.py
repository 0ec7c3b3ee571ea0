"""The runner of the benches: records that a run goes on with, refusals, processes, shares and tables."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench import runner
from skincad.base import InputError

JUDGED: list[int] = []


@dataclass(frozen=True)
class Square:
    number: int
    squares: list[float]


def judge(case: int) -> Square:
    JUDGED.append(case)
    if case == 2:
        raise InputError("number", "must not be 2")
    return Square(case, [np.float64(case) ** 2, np.int64(7)])


def options(path: Path, *words: str) -> Any:
    return runner.parser("a bench", "count").parse_args(["3", "--records", str(path), *words])


@pytest.mark.parametrize("workers", ["1", pytest.param("2", marks=pytest.mark.slow)])
def test_a_run_goes_on_where_it_stopped(
    workers: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "new" / "rows.jsonl"
    JUDGED.clear()

    def rows(cases: list[int]) -> list[Square]:
        return runner.rows(
            "name", judge, cases, options(path, "--workers", workers), lambda row: str(row.number), Square
        )

    assert rows([3]) == [Square(3, [9.0, 7])]
    with path.open("a") as file:
        file.write('{"code": "another", "case": 1, "row": {}}\n')
    wanted = [Square(1, [1.0, 7]), Square(3, [9.0, 7])]
    assert rows([1, 2, 3]) == wanted
    assert rows([1, 2, 3]) == wanted
    printed = capsys.readouterr()
    assert printed.out.split() == ["3", "3", "1", "1", "3"]  # known ones first
    assert printed.err.count("2: refused: number: must not be 2") == 2
    if workers == "1":
        assert JUDGED == [3, 1, 2]  # none twice


def test_a_line_that_was_cut_off_counts_for_nothing(tmp_path: Path) -> None:
    path = tmp_path / "rows.jsonl"
    runner.rows("name", judge, [1], options(path))
    path.write_text(path.read_text()[:-9])
    assert runner.records(path) == {}
    runner.rows("name", judge, [3], options(path))
    assert [*runner.records(path)] == [3]


def test_refused_draws_are_drawn_again(capsys: pytest.CaptureFixture[str]) -> None:
    draws = iter(range(9))

    def make(number: int) -> tuple[int, int] | None:
        draw = next(draws)
        if draw == 1:
            raise InputError("draw", "must not be 1")
        return None if draw == 2 else (number, draw)

    assert list(runner.until(3, make)) == [(0, 0), (1, 3), (2, 4)]
    assert capsys.readouterr().out == "refused: draw: must not be 1\n"


def test_intervals_as_in_tables() -> None:
    """Wilson of 8 in 10 (Brown, Cai, DasGupta 2001)."""
    assert runner.wilson(8, 10) == pytest.approx((0.4902, 0.9433), abs=1e-4)  # four digits are printed there
    assert runner.wilson(0, 0) == (0.0, 1.0)
    assert runner.share(8, 10) == "8 of 10 = 80% (49% to 94%)"


def test_a_table_is_as_wide_as_its_cells() -> None:
    assert runner.table(("part", "in"), [("good", 1), ("a", 200)]) == ["part   in", "good    1", "a     200"]
