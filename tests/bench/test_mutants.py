"""Small changes of a text, the tests that they are given to, a run's records: on what is written here."""

from __future__ import annotations

import json
import shutil
import textwrap
from pathlib import Path
from typing import Any

import pytest

from bench import covered, mutants
from bench.mutate import mutated, sites

HERE = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("text", "changes"),
    [
        ("x = a < b", {"x = a <= b", "x = a > b"}),
        ("x = a is not b", {"x = a is b"}),
        ("x = a not in b", {"x = a in b"}),
        ("x = not a", {"x =  a"}),
        ("x = (a) + (-b)", {"x = (a) - (-b)", "x = (a) + (b)"}),
        ("x = a and not b", {"x = a or not b", "x = a and  b"}),
        ("x = a or b or c", {"x = a and b or c", "x = a or b and c"}),
        ("x = max(a)", {"x = min(a)"}),
        ("x = np.minimum(a).max()", {"x = np.maximum(a).max()", "x = np.minimum(a).min()"}),
        ("x = True", {"x = False"}),
        ("x = 3", {"x = 4", "x = 2"}),
        ("x = 0.5", {"x = 1.0", "x = 0.25"}),
        ("x = 0.0", {"x = 1.0"}),
        ("x *= a", {"x /= a"}),
        ("é, x = 'é', a + b", {"é, x = 'é', a - b"}),
        ("x = (\n    a  # no + b\n    * b\n)", {"x = (\n    a  # no + b\n    / b\n)"}),
    ],
)
def test_each_operator_and_constant_turns_into_its_neighbours(text: str, changes: set[str]) -> None:
    assert {mutated(text, site, after) for site in sites(text) for after in site.after} == changes


@pytest.mark.parametrize(
    "text",
    [
        'x = "a" + b',
        "x = [a] * b",
        'x = f"{a + 1:.3f} {b * 2}"',
        "x: Literal[1]",
        "def f(x: Literal[1]) -> Literal[1]: ...",
        "@dataclass(frozen=True)\nclass A: ...",
        "x = zip(a, b, strict=True)",
        "if TYPE_CHECKING:\n    x = 1",
    ],
)
def test_what_changes_no_result_is_left_alone(text: str) -> None:
    assert not list(sites(text))


def tree(path: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        file = path / f"{name}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(textwrap.dedent(text).lstrip())
    return path


def test_drawing_is_the_same_of_the_same_seed() -> None:
    one, two, other = (
        [mutant for mutant, _ in mutants.drawn(HERE, "skincad/base/*.py", seed, 20)] for seed in (1, 1, 2)
    )
    assert one == two != other
    assert len(one) == 20
    assert {Path(mutant.file).parent.as_posix() for mutant in one} == {"skincad/base"}


@pytest.mark.slow
def test_a_run_tells_what_is_seen_and_goes_on_where_it_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Of a function's two constants the test sees one; of a table, read while it is imported, the first row;
    of what no test runs, nothing."""
    here = tree(
        tmp_path / "tree",
        {
            "skincad/__init__": "",
            "skincad/x": """
                TABLE = (
                    10,
                    20,
                )


                def both():
                    return (
                        3,
                        4 + TABLE[0],
                    )


                def never():
                    return 5
            """,
            "tests/__init__": "",
            "tests/test_x": """
                from skincad.x import both


                def test_seen():
                    assert both()[0] == 3
                    assert both()[1] == 14


                def test_elsewhere(): ...
            """,
        },
    )
    monkeypatch.setattr(mutants, "HERE", here)
    monkeypatch.setattr(mutants, "copy", shutil.copytree)
    out = tmp_path / "out"
    mutants.main(["--count", "99", "-o", str(out)])
    answer = capsys.readouterr().out.splitlines()
    records = [json.loads(line) for line in (out / "records.jsonl").read_text().splitlines()]
    assert {(record["before"], record["by"]) for record in records} == {
        *((before, "tests/test_x.py::test_seen") for before in ("10", "3", "4", "+", "0")),
        ("20", None),
        ("5", None),
    }
    table = {record["before"]: record["tests"] for record in records}
    # of the table all that import from its file
    assert table == {"10": 2, "20": 2, "3": 1, "4": 1, "+": 1, "0": 1, "5": 0}
    assert answer[0] == "5 of 7 seen (71%), not seen:"
    assert [line.partition("  ")[2][:4] for line in answer[1:]] == ["'20'", "'5' "]
    assert answer[2].endswith("(no test)")

    def never(*_: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(mutants, "verdict", never)
    mutants.main(["--count", "99", "-o", str(out)])
    assert sorted(capsys.readouterr().out.splitlines()) == sorted(answer)


@pytest.mark.slow
def test_a_run_without_end_is_seen_and_one_without_tests_is_not_a_pass(tmp_path: Path) -> None:
    here = tree(
        tmp_path / "tree",
        {
            "tests/test_x": "def test_endless():\n    while True: ...\n",
            "tests/test_y": "import pytest\n\n\n@pytest.mark.skip\ndef test_skipped(): ...\n",
        },
    )
    assert mutants.verdict(here, ["tests/test_x.py"], 1.0) == "too long"
    assert mutants.verdict(here, ["tests/test_y.py"], None) == "status 0"
    with pytest.raises(ValueError, match="test_none are there"):
        mutants.verdict(here, ["tests/test_x.py::test_none"], None)


@pytest.mark.parametrize(
    ("line", "span", "alone"),
    [(1, (1, 5), False), (3, (1, 5), False), (7, (7, 10), False), (10, (10, 11), True), (11, (11, 14), True)],
)
def test_a_statement_is_whole_and_a_head_without_its_body(
    line: int, span: tuple[int, int], alone: bool
) -> None:
    head, body = (
        "T = (\n    1,\n    2,\n)\n\n\ndef f(\n    x=1,\n):\n",
        "    if x:\n        return (\n            x\n        )\n",
    )
    assert covered.statement(head + body, line) == (range(*span), alone)
