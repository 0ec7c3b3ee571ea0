"""Names that mean harm to the terminal: nothing that a person's file, path or option says is printed raw."""

from __future__ import annotations

import json
import math
import sys
import unicodedata
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from skincad.base import InputError, did_you_mean, shown
from skincad.inputs import read_table
from tests.attacks.test_files import LOADERS, OWN, READERS, kinds, paths, refusal_words
from tests.conftest import run_skincad

STEERING = ("Cc", "Cf", "Zl", "Zp")
EVERY = "".join(c for c in map(chr, range(sys.maxunicode + 1)) if unicodedata.category(c) in STEERING)
EVIL = "é\x1b[2J\x1b]0;角\x07\x7f\x85\x9b31m\u202eж\u2066\u2069\u200e\u200f\u2028\u2029\r\n\t\xad\U000e0041"


def plain(text: str) -> bool:
    return not any(unicodedata.category(c) in STEERING for c in text)


def test_all_that_steers_is_escaped_and_letters_stay() -> None:
    assert plain(shown(EVERY))
    assert shown("a\x1b[31m\u202e\n") == r"a\x1b[31m\u202e\n"
    letters = "éüß ŁŌ жЩ αΩ 角質 한 हि עם عر ½ € 😀"
    assert shown(letters) == letters
    assert shown(shown(EVIL)) == shown(EVIL)


@given(parts=st.tuples(*[st.text(alphabet=st.sampled_from(EVERY + "aé ")) for _ in range(4)]))
@settings(max_examples=200, deadline=None, derandomize=True)
def test_no_part_of_a_refusal_is_raw(parts: tuple[str, str, str, str]) -> None:
    key, rule, value, remedy = parts
    assert plain(str(InputError(key, rule, value, remedy)))
    assert plain(str(InputError(key, rule, [value, {remedy: Path(value)}], did_you_mean(key, parts))))


def written(table: dict[str, Any]) -> str:
    """A TOML of quoted dotted keys, a leaf a line; letters stand as they are."""

    def quoted(text: str) -> str:
        return (
            '"' + "".join(rf"\U{ord(c):08x}" if not c.isprintable() or c in '"\\' else c for c in text) + '"'
        )

    def leaf(value: Any) -> str:
        return quoted(value) if isinstance(value, str) else json.dumps(value)

    rows = []
    for path in paths(table):
        value: Any = table
        for key in path:
            value = value[key]
        if not isinstance(value, dict) or not value:
            rows.append(f"{'.'.join(map(quoted, path))} = {leaf(value)}")
    return "\n".join(rows)


def spoilt(table: dict[str, Any], path: tuple[str, ...], how: str) -> dict[str, Any]:
    """The table with the value at a path, or its key, an evil one, or an evil key beside it."""
    head, *rest = path
    if rest:
        return {**table, head: spoilt(table[head], tuple(rest), how)}
    changed = {key: value for key, value in table.items() if key != head or how != "key"}
    return {**changed, head if how == "value" else EVIL: EVIL if how == "value" else table[head]}


@kinds
@pytest.mark.parametrize("how", ["value", "key", "beside"])
def test_no_key_and_no_value_of_a_file_is_printed_raw(kind: str, how: str, tmp_path: Path) -> None:
    read, name, folder = LOADERS[kind]
    table = read_table(name, folder)  # type: ignore[arg-type]
    table = OWN.get(kind, table)
    file = tmp_path / "evil.toml"
    file.write_text(written(table))
    assert refusal_words(lambda: read(file)) == ""  # as written here it is good
    for path in paths(table):
        file.write_text(written(spoilt(table, path, how)))
        words = refusal_words(lambda: read(file))
        assert plain(words), path
        assert words or how == "value", path  # a material's name, say, may be any text to the model


@pytest.mark.parametrize("kind", READERS)
@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_no_column_and_no_cell_is_printed_raw(kind: str, separator: str, tmp_path: Path) -> None:
    evil = EVIL.replace("\n", "").replace("\r", "").replace("\t", "")
    head = {"crests": "ridge,crest_mm", "gain curve": "frequency_Hz,gain_dB"}.get(kind, "strain,stress_MPa")
    first, second = head.split(",")
    rows = {f"{evil},{second}\n1,2", f"{first},{second}{evil}\n1,2", f"{evil}\n1", f"{head}\n1,{evil}\n"}
    file = tmp_path / f"{evil}.csv".replace("/", "")
    for text in rows:
        file.write_text(text.replace(",", separator), encoding="utf-8")
        words = refusal_words(lambda: READERS[kind](file))
        assert words
        assert plain(words)


@kinds
def test_no_path_is_printed_raw(kind: str, tmp_path: Path) -> None:
    read, *_ = LOADERS[kind]
    for name in (f"{EVIL}.toml", EVIL, f"{EVIL}\0", "\udcff.toml"):
        words = refusal_words(lambda name=name: read(tmp_path / name))  # type: ignore[misc]
        assert words
        assert plain(words)


LINES = (
    "", "new", "new x.toml --template", "simulate", "coupon", "coupon sla --silicone",
    "coupon sla --measured", "fit-material", "fit-material x.csv --design", "package yamada-2002 --for",
    "make yamada-2002 --format", "circuit yamada-2002 --measured", "accuracy yamada-2002 --ladder",
    *(f"check yamada-2002 --{option}" for option in (
        "force", "tier", "set", "measured", "printer", "silicones", "stress"
    )),
)  # fmt: skip
COMMANDS = [[*line.split(), EVIL] for line in LINES]
COMMANDS += [["check", f"--{EVIL}"]]
COMMANDS += [["check", "yamada-2002", "--set", words] for words in (f"{EVIL}.a=1", f"ridge={EVIL}")]


@pytest.mark.parametrize("arguments", COMMANDS, ids=lambda arguments: " ".join(map(ascii, arguments)))
def test_no_argument_is_printed_raw(arguments: list[str], tmp_path: Path) -> None:
    done = run_skincad(*arguments, cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.endswith("\n")
    assert plain(done.stderr[:-1])


@pytest.mark.parametrize(
    "arguments", [["new", "é\u202e\u200f/mine.toml"], ["circuit", "yamada-2002", "-o", EVIL]]
)
def test_no_path_of_a_result_is_printed_raw(arguments: list[str], tmp_path: Path) -> None:
    done = run_skincad(*arguments, cwd=tmp_path)
    assert done.returncode == 0
    assert "é" in done.stdout
    assert all(map(plain, done.stdout.split("\n")))


def test_json_has_the_name_itself(tmp_path: Path) -> None:
    done = run_skincad("circuit", "yamada-2002", "-o", EVIL, "--json", cwd=tmp_path)
    assert done.returncode == 0
    assert all(file["path"].startswith(EVIL) for file in json.loads(done.stdout)["files"])
    assert plain(done.stdout[:-1])
    assert math.isfinite(json.loads(done.stdout)["cutoff_Hz"]["value"])
