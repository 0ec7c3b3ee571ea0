"""Small changes of a text, the tests that they are given to, a run's records: on what is written here."""

from __future__ import annotations

import ast
import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from bench import mirrored, mutants
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


def test_every_change_of_a_file_of_ours_is_another_program() -> None:
    text = (HERE / "skincad" / "scenes" / "slip.py").read_text("utf-8")
    found = [mutated(text, site, after) for site in sites(text) for after in site.after]
    assert len(found) > 100
    programs = {ast.dump(ast.parse(each)) for each in [text, *found]}
    assert len(programs) == len(found) + 1


def tree(path: Path, files: dict[str, str]) -> Path:
    for name, text in files.items():
        file = path / f"{name}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text)
    return path


def test_a_files_tests_are_its_mirror_or_the_nearest_that_import_it(tmp_path: Path) -> None:
    here = tree(
        tmp_path,
        {
            "skincad/a/one": "",
            "skincad/a/two": "",
            "skincad/a/lazy": 'PLACE = "skincad.a.two:there"',
            "skincad/b/three": "from skincad.a import two",
            "tests/a/test_one": "",
            "tests/test_both": "import skincad.a.two, skincad.b.three",
            "tests/test_two": "from skincad.a.two import there",
            "tests/a/test_here": "from skincad.a import two, one",
            "tests/test_far": "from skincad.b.three import two",
            "tests/test_lazy": "from skincad.a import lazy",
            "tests/test_none": "import skincad",
        },
    )
    assert mirrored.covering(here, "skincad/a/one.py") == ["tests/a/test_one.py"]
    found = mirrored.covering(here, "skincad/a/two.py")
    assert found[:3] == ["tests/a/test_here.py", "tests/test_two.py", "tests/test_both.py"]
    assert set(found[3:]) == {"tests/test_far.py", "tests/test_lazy.py"}


def test_drawing_is_the_same_of_the_same_seed() -> None:
    one, two, other = (
        [mutant for mutant, _ in mutants.drawn(HERE, "skincad/base/*.py", seed, 20)] for seed in (1, 1, 2)
    )
    assert one == two != other
    assert len(one) == 20
    assert {Path(mutant.file).parent.as_posix() for mutant in one} == {"skincad/base"}


def test_a_run_tells_what_is_seen_and_goes_on_where_it_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    here = tree(
        tmp_path / "tree",
        {
            "skincad/__init__": "",
            "skincad/x": "SEEN = 3\nUNSEEN = 4\n",
            "tests/test_x": "from skincad.x import SEEN\n\n\ndef test_seen():\n    assert SEEN == 3\n",
        },
    )
    monkeypatch.setattr(mutants, "HERE", here)
    monkeypatch.setattr(mutants, "copy", shutil.copytree)
    out = tmp_path / "records.jsonl"
    mutants.main(["--count", "9", "-o", str(out)])
    said = capsys.readouterr().out.splitlines()
    assert said[0] == "1 of 2 seen (50%), not seen:"
    assert said[1].startswith("skincad/x.py:2:9  '4' -> ")
    records = [json.loads(line) for line in out.read_text().splitlines()]
    assert [each["by"] for each in records if each.get("seen")] == ["tests/test_x.py::test_seen"]
    assert (here / "skincad" / "x.py").read_text() == "SEEN = 3\nUNSEEN = 4\n"

    def never(*_: Any) -> None:
        raise AssertionError

    monkeypatch.setattr(mutants, "verdict", never)
    mutants.main(["--count", "9", "-o", str(out)])
    assert capsys.readouterr().out.splitlines() == said
    assert [json.loads(line) for line in out.read_text().splitlines()] == records


def test_a_run_without_end_is_seen_and_one_without_tests_is_not_a_pass(tmp_path: Path) -> None:
    here = tree(
        tmp_path / "tree",
        {
            "tests/test_x": "def test_endless():\n    while True: ...\n",
            "tests/test_y": "import pytest\n\n\n@pytest.mark.skip\ndef test_skipped(): ...\n",
        },
    )
    assert mutants.verdict(here, "tests/test_x.py", 1.0)[0] == "tests/test_x.py:too-long"
    assert mutants.verdict(here, "tests/test_y.py", None)[0] == "tests/test_y.py:0"
