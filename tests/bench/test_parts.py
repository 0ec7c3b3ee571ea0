"""The benches' own parts: the runner's records, refusals, processes and tables; costs; CalculiX's files.

Nothing is asserted of time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench import calculix, runner
from bench.costs import alone, measured
from skincad.base import InputError
from skincad.mechanics import default_sizes, pad_of
from tests.mechanics.designs import filleted, yamada

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


@pytest.mark.dear("two workers import all that a judge needs")
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


PRINTED = """
 displacements (vx,vy,vz) for set REFERENCE and time  0.1000000E+01

      4937  0.000000E+00 -1.663271E-01  0.000000E+00

 statistics for slave set RIDGE1, master set UNDER and time  0.1000000E+01

   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)

   -1.491300E-19 -5.442007E-03 -5.308000E-19 -2.720384E-14 -2.221845E-18  2.219331E-02

 statistics for slave set RIDGE2, master set UNDER and time  0.1000000E+01

   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)

   -1.030183E-19 -3.072085E-02 -1.268648E-19  4.051365E-14  5.468852E-19  9.460409E-02
"""


def test_calculix_output_is_read() -> None:
    shares, approach = calculix.read(PRINTED, 2)
    assert shares.tolist() == [5.442007e-3, 3.072085e-2]
    assert approach == 0.1663271
    with pytest.raises(RuntimeError, match="no contact forces"):
        calculix.read(PRINTED, 3)


@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
def test_quads_fill_the_section(tmp_path: Path) -> None:
    pad = pad_of(filleted())
    mesh = calculix.quads(pad, default_sizes(pad, 0.25), tmp_path)
    x, z = mesh.nodes[mesh.elements].transpose(2, 0, 1)
    ring = [0, 4, 1, 5, 2, 6, 3, 7]  # corners and middles in turn
    x, z = x[:, ring], z[:, ring]
    areas = (x * np.roll(z, -1, axis=1) - np.roll(x, -1, axis=1) * z).sum(axis=1) / 2
    assert (areas > 0).all()
    # arcs by two chords an edge: their sagittas are 2e-4 of the area at this fineness
    assert areas.sum() == pytest.approx(pad.section.area, rel=1e-3)
    assert sorted(mesh.faces) == list(pad.ridges)
    assert (mesh.nodes[mesh.back, 1] == 0).all()


def test_calculix_is_not_given_strips(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="without slots"):
        calculix.quads(pad_of(yamada()), default_sizes(pad_of(yamada()), 0.25), tmp_path)


def test_time_at_equal_error() -> None:
    seconds, errors = np.array([1.0, 4.0, 2.0, 16.0]), np.array([1e-1, 1e-2, 2e-1, 1e-3])
    # the row of 2 s is beaten by that of 1 s; between 4 s and 16 s time goes as error^(-log 4 / log 10)
    assert calculix.time_at(10**-2.5, seconds, errors) == pytest.approx(8.0)
    assert calculix.time_at(1.0, seconds, errors) == pytest.approx(1.0)
    assert math.isnan(calculix.time_at(1e-4, seconds, errors))


@pytest.mark.slow
def test_alone_measures_another_process() -> None:
    row = alone(measured, "winkler")
    assert row["unknowns"] == 9
    assert row["peak_MB"] > 10  # an interpreter with numpy
    with pytest.raises(RuntimeError, match="KeyError"):
        alone(measured, "no-such-model")
