"""What the comparison of two revisions says, on folders written here."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from bench import compare


def folder(path: Path, **files: Any) -> Path:
    path.mkdir()
    for name, content in files.items():
        data = content if isinstance(content, bytes) else json.dumps(content).encode()
        (path / name.replace("_", ".")).write_bytes(data)
    return path


def said(tmp_path: Path, before: dict[str, Any], now: dict[str, Any]) -> list[str]:
    return list(compare.differences(folder(tmp_path / "a", **before), folder(tmp_path / "b", **now)))


def test_wall_time_and_a_manifests_size_are_no_difference(tmp_path: Path) -> None:
    one, two = (
        {
            "a": 1.0,
            "seconds": {"total": s},
            "check": {"seconds": s},
            "files": [{"path": "make.json", "bytes": s}],
        }
        for s in (1, 2)
    )
    assert said(tmp_path, {"stdout_json": one}, {"stdout_json": two}) == []
    assert list(compare.keys({"path": "a.stl", "bytes": 3}, {"path": "a.stl", "bytes": 4}))


def test_each_key_is_a_line_and_a_list_is_one(tmp_path: Path) -> None:
    before = {"force": {"value": 2.0}, "passed": True, "series": [1.0, 2.0, 3.0], "old": 1}
    now = {"force": {"value": 2.5}, "passed": 1, "series": [1.0, 2.5, 6.0], "new": 1}
    assert said(tmp_path, {"x_json": before}, {"x_json": now}) == [
        "x.json $.force.value: 2.0 -> 2.5 (relative 2.0e-01)",
        "x.json $.passed: True -> 1",
        "x.json $.series[1]: 2.0 -> 2.5 (relative 5.0e-01), and 1 more such",
        "x.json $.old: 1 -> '(no key)'",
        "x.json $.new: '(no key)' -> 1",
    ]


@pytest.mark.parametrize(
    ("before", "now", "line"),
    [
        (
            b"t,F\n1,2.0\n2,4.0\n",
            b"t,F\n1,2.0\n2,5.0\n",
            r"x: line 3: '2,4.0\n' -> '2,5.0\n' (relative 2.0e-01)",
        ),
        (b"a\nb\n", b"a\n", "x: line 2: 'b\\n' -> ''"),
        (b"a\n", b"a\r\n", "x: line 1: 'a\\n' -> 'a\\r\\n'"),
        (b"\xff\x00\x01", b"\xff\x00\x02\x03", "x: byte 2 of 3 -> 4 bytes"),
    ],
)
def test_first_difference_of_a_file(tmp_path: Path, before: bytes, now: bytes, line: str) -> None:
    assert said(tmp_path, {"x": before}, {"x": now}) == [line]


def test_a_file_of_one_side_alone(tmp_path: Path) -> None:
    assert said(tmp_path, {"a": b"1"}, {"b": b"1"}) == ["a: only before", "b: only now"]


def test_a_meant_difference_is_printed_with_its_reason(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def run(checkout: Path, out: Path, command: str, name: str) -> None:
        out.mkdir(parents=True)
        (out / "word").write_text(f"{checkout == compare.HERE} {name}")

    monkeypatch.setattr(compare, "run", run)
    monkeypatch.setattr(compare, "HERE", tmp_path / "now")
    for side in ("before", "now"):
        (tmp_path / side / "templates" / "circuits").mkdir(parents=True)
        (tmp_path / side / "templates" / "circuits" / "one.toml").touch()
        (tmp_path / side / "skincad").mkdir()
    words = [str(tmp_path / "before"), "--only", "circuit"]
    assert compare.main(words) == 1
    assert compare.main([*words, "--allow", "one: word", "said otherwise"]) == 0
    line = "circuit one: word: line 1: 'False one' -> 'True one'"
    assert capsys.readouterr().out.splitlines() == [line, f"{line} [allowed: said otherwise]"]
    assert compare.main([*words, "--allow", "two: word", "another"]) == 1
    with pytest.raises(SystemExit):
        compare.main([*words, "--name", "two"])
    assert "no template has this name" in capsys.readouterr().err
