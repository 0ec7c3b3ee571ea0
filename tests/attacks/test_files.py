"""Files that mean harm, TOML and CSV: only skincad's own error leaves, in one line.

Hypothesis writes them: as bytes, as templates with bytes changed, and as tables with any value at any key.
"""

from __future__ import annotations

import os
import signal
import tempfile
import tomllib
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from skincad.base import DEEPEST, MOST_PARTS, InputError, read_columns, tables_of
from skincad.base import LARGEST_FILE as LARGEST_TABLE
from skincad.circuit import COLUMNS, load_circuit
from skincad.inputs import LARGEST_FILE, load, material_test, read_table, template_text
from skincad.scenes import load_scene
from skincad.shape import crest_drops
from tests.refusals import assert_a_line, refused

LOADERS: dict[str, tuple[Callable[[Path], object], str, str]] = {
    "design": (load, "yamada-2002", "designs"),
    "scene": (load_scene, "yamada-2002-slip", "scenes"),
    "circuit": (load_circuit, "yamada-2002", "circuits"),
    "printer": (lambda path: load("yamada-2002", printer=path), "yamada-2002", "designs"),
    "silicones": (lambda path: load("yamada-2002", silicones=path), "yamada-2002", "designs"),
}
OWN: dict[str, dict[str, Any]] = {  # files of one's own tables, which have no template
    "printer": {"sla": {"gap": 0.1, "layer": 0.05}, "my-mill": {"based_on": "cnc", "chord": 0.01}},
    "silicones": {
        "dragon-skin-30": {"young_modulus": 0.9, "source": "ours"},
        "lab-10": {"based_on": "dragon-skin-10", "mix": [1.0, 2.0], "platinum_cure": False},
    },
}
kinds = pytest.mark.parametrize("kind", LOADERS)
EVIL = [
    0, -1, 10**18, 10**400, -(10**400), 2**63, 1e308, -1e308, 5e-324, -0.0, float("inf"), float("nan"),
    True, "", "x" * 5000, "../../x", "/etc/passwd", "a\x00b", "\U0010ffff", "\u202e", "{}", "%s%n",
    "__class__", [], {}, [[]], [{}], [0.0] * 1000, {"value": 1.0}, {"a": {"b": {"c": {}}}},
]  # fmt: skip
values = st.sampled_from(EVIL) | st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=20),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=6,
)


def refusal_words(read: Callable[[], object]) -> str:
    """The words of a refusal, "" where there is none; anything else that is raised leaves."""
    try:
        read()
    except InputError as refusal:
        return str(refusal)
    return ""


@contextmanager
def evil(data: bytes, name: str = "evil.toml") -> Iterator[Path]:
    """A file of these bytes, alone in its folder, to be read: no other is there afterwards."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / name
        file.write_bytes(data)
        yield file
        assert [p.name for p in Path(folder).iterdir()] == [name]


def attacked(kind: str, data: bytes) -> None:
    """Load a file of these bytes: a refusal is one line, of a length that a terminal bears."""
    with evil(data) as file:
        assert_a_line(refusal_words(lambda: LOADERS[kind][0](file)))


@kinds
@given(data=st.binary(max_size=400))
@settings(max_examples=30, deadline=None)
def test_any_bytes(kind: str, data: bytes) -> None:
    attacked(kind, data)


@kinds
@given(data=st.data())
@settings(max_examples=30, deadline=None)
def test_a_template_with_bytes_changed(kind: str, data: st.DataObject) -> None:
    _, name, folder = LOADERS[kind]
    text = bytearray(template_text(name, folder).encode())  # type: ignore[arg-type]
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at : at + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=4))
    attacked(kind, bytes(text))


def paths(table: dict[str, Any], at: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    rows: list[tuple[str, ...]] = []
    for key, value in table.items():
        rows += [(*at, key), *(paths(value, (*at, key)) if isinstance(value, dict) else [])]
    return rows


@kinds
@given(data=st.data())
@settings(max_examples=40, deadline=None)
def test_any_value_at_any_key(kind: str, data: st.DataObject) -> None:
    _, name, folder = LOADERS[kind]
    table = read_table(name, folder)  # type: ignore[arg-type]
    table = deepcopy(OWN.get(kind, table))
    path, value = data.draw(st.sampled_from(paths(table))), data.draw(values)
    inner = table
    for key in path[:-1]:
        inner = inner[key]
    if data.draw(st.booleans()):
        inner[path[-1]] = value
    else:
        inner[data.draw(st.text(max_size=12))] = value
    try:
        text = tomlkit.dumps(table)
    except (ValueError, TypeError, tomlkit.exceptions.TOMLKitError, UnicodeEncodeError):
        return  # not to be written as TOML
    attacked(kind, text.encode("utf-8", "surrogatepass"))


BAD = {
    "a deep array": b"name = " + b"[" * 100_000,
    "deep tables": b"[" + b"a." * 50_000 + b"a]",
    "a long integer": b"name = 'x'\n[ridge]\ncount = " + b"9" * 6000,
    "a long hexadecimal integer": b"name = 'x'\n[ridge]\ncount = 0x" + b"f" * 6000,
    "a long hexadecimal height": b"name = 'x'\n[ridge]\nheight = 0x" + b"f" * 6000,
    "a list of 1e5 numbers": b"name = 'x'\n[skin]\nwidth = [" + b"1.0," * 100_000 + b"]",
    "a key of 1e5 letters": b"a" * 100_000 + b" = 1",
    "1e3 unknown keys": b"\n".join(b"k%d = 1" % i for i in range(1000)),  # 90,000: BOMBS
    "a NUL": b"name = 'a\x00b'",
    "an escaped NUL": b'name = "a\\u0000b"',
    "half of a letter": b"name = '\xc3'",
    "UTF-16": "name = 'x'".encode("utf-16"),
    "a date": b"name = 1979-05-27T07:32:00Z",
    "one byte too many": b"#" * (LARGEST_FILE + 1),
    "nothing": b"",
}


@kinds
@pytest.mark.parametrize("name", BAD)
def test_bad_files(kind: str, name: str) -> None:
    if kind in OWN and name == "nothing":
        return  # no tables of one's own: nothing is wrong with that
    with evil(BAD[name]) as file, refused():
        LOADERS[kind][0](file)


CPU_S = 20  # of one bomb, which takes about 1 s at most; unbounded, the dotted key alone takes twice that
SCENE = template_text("hold", "scenes")


def full(unit: str, head: str = "", tail: str = "") -> str:
    """As large as a file may be."""
    return head + unit * ((LARGEST_FILE - len(head) - len(tail)) // len(unit)) + tail


BOMBS = {
    "a key of 40,000 parts": "a" + ".a" * 40_000 + " = 1",
    "a key as long as the file": full(".a", "a", " = 1"),
    "a key of empty parts": full(".''", "a", " = 1"),
    "a key with spaces": full(" . a", "a", " = 1"),
    "a table's name as long as the file": full(".a", "[a", "]"),
    "a list of tables' name": full(".a", "[[a", "]]"),
    "3000 tables deep": f"{SCENE}\n[effects.friction{'.a' * 3000}]",
    "3000 inline tables deep": "a = " + "{a=" * 3000 + "1" + "}" * 3000,
    "300 inline tables deep": f"{SCENE}\n[effects.x]\na = {'{a=' * 300}1{'}' * 300}",
    "3000 lists deep": "a = " + "[" * 3000 + "]" * 3000,
    "lists as deep as the file": "a = " + "[" * 499_000 + "]" * 499_000,
    "lists that never end": full("[", "a = "),
    "tables and lists in turn": "a = " + "[{a.a.a=" * 3000 + "1" + "}]" * 3000,
    "80,000 tables": "\n".join(f"[t{i}]" for i in range(80_000)),
    "80,000 tables in one": "\n".join(f"[a.b{i}]" for i in range(80_000)),
    "a list of 160,000 tables": "[[a]]\n" * 160_000,
    "half a million numbers": full("1,", "a = [", "1]"),
    "texts for numbers": SCENE.replace("[history]", f"[history]\nrotation_deg = [''{', 0' * 90_000}]"),
    "empty tables": full("{},", "a = [", "]"),
    "a key of a million letters": full("a", "", "=1"),
    "a quoted key of a million letters": full("a", '"', '"=1'),
    "long keys alike": "\n".join(f"{'a' * 29}{i} = 1" for i in range(25_000)),
    "dotted keys alike": "\n".join(f"a.a.a.a.a.a.a.k{i} = 1" for i in range(40_000)),
    "90,000 unknown keys": "[ridge]\n" + "\n".join(f"k{i}=1" for i in range(90_000)),
    "50,000 machines": "\n".join(f"[printer.a{i}]" for i in range(50_000)),
    "50,000 silicones": "\n".join(f"[silicones.a{i}]" for i in range(50_000)),
    "escapes": full("\\u0041", 'a = "', '"'),
    "lines that go on": full("\\\n", 'a = """', '"""'),
    "quotes": full('"', "a = "),
    "apostrophes": full("'", "a = "),
    "backslashes": full("\\", 'a = "'),
    "dots": full("."),
    "digits": full("9", "a = ", ".0"),
    "blanks": full(" ", "", "a=1"),
    "comments": full("#\n"),
}  # fmt: skip


@contextmanager
def bounded() -> Iterator[None]:
    """End the block, by an error that nothing catches, when this process has used CPU_S in it."""

    class TooMuchWorkError(BaseException):
        pass

    def ended(*_: object) -> None:
        raise TooMuchWorkError

    before = signal.signal(signal.SIGPROF, ended)
    signal.setitimer(signal.ITIMER_PROF, CPU_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


QUICK = {  # one of each kind that takes least; the others are slow
    *("a key of 40,000 parts", "a key with spaces", "3000 tables deep", "300 inline tables deep"),
    *("3000 lists deep", "a key of a million letters", "quotes", "dots", "blanks", "1e3 unknown keys"),
}


def bombs(names: Iterable[str]) -> list[Any]:
    return [pytest.param(name, marks=[] if name in QUICK else [pytest.mark.slow]) for name in names]


@pytest.mark.parametrize("name", bombs(BOMBS))
def test_no_table_takes_work_out_of_proportion(name: str, tmp_path: Path) -> None:
    file, read = tmp_path / "bomb.toml", load_scene if BOMBS[name].startswith(SCENE[:40]) else load
    file.write_text(BOMBS[name])
    assert file.stat().st_size <= LARGEST_FILE
    with bounded(), refused():
        read(file)


@pytest.mark.parametrize("key", ["ridge.height", "printer"])  # a value and a table
@pytest.mark.parametrize("name", bombs(name for name, text in BOMBS.items() if text.startswith("a = ")))
def test_no_override_does_either(name: str, key: str) -> None:
    with bounded(), refused():
        load("yamada-2002", [f"{key}={BOMBS[name].removeprefix('a = ')}"])


@kinds
@pytest.mark.parametrize(
    "overrides",
    [["a" + ".a" * 100_000 + "=1"], [f"a.k{i}=1" for i in range(20_000)], ["a.a={" + "a." * 40_000 + "a=1}"]],
    ids=["a key of 100,000 parts", "20,000 keys of one table", "a key within a value"],
)
def test_no_overrides_keys_do(kind: str, overrides: list[str]) -> None:
    read, name, _ = LOADERS[kind]
    if kind in OWN:
        return  # takes none
    with bounded(), pytest.raises(InputError):
        read(name, overrides)  # type: ignore[call-arg]


def depth(value: object) -> int:
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else None
    return 0 if inner is None else 1 + max(map(depth, inner), default=0)


@given(text=st.text(alphabet="\"'[]{}=.,#\n\\ a1", max_size=60))
@settings(max_examples=200, deadline=None, derandomize=True)
def test_the_bounds_change_no_answer(text: str) -> None:
    """Texts so short nest less than the bounds allow, but for keys of many parts."""
    try:
        wanted = tomllib.loads(text)
    except ValueError:
        with pytest.raises(InputError, match="is not TOML"):
            tables_of(text, "file")
        return
    if depth(wanted) <= min(DEEPEST, MOST_PARTS):
        assert tables_of(text, "file") == wanted


@given(
    text=st.lists(st.sampled_from(["[", "]", "{", "}", "a.a=", "a=", "a.a.a", "'", '"', "\n", "1", ",", "#"]),
                  max_size=300).map("".join)
)  # fmt: skip
@settings(max_examples=150, deadline=None, derandomize=True)
def test_whatever_is_read_is_shallow(text: str) -> None:
    try:
        table = tables_of(f"{text}\nx = {'{a=' * (len(text) % 12)}1{'}' * (len(text) % 12)}", "file")
    except InputError:
        return
    assert depth(table) <= 2 * MOST_PARTS + DEEPEST * (MOST_PARTS + 1)


@given(
    table=st.dictionaries(
        st.text(max_size=8),
        st.text(alphabet=st.sampled_from("\"'[]{}=.,#\n\\ ab"), max_size=40)
        | st.lists(st.floats(), max_size=20),
        max_size=8,
    )
)
@settings(max_examples=100, deadline=None, derandomize=True)
def test_signs_within_texts_are_not_counted(table: dict[str, Any]) -> None:
    try:
        text = tomlkit.dumps(table)
        wanted = tomllib.loads(text)
    except (ValueError, tomlkit.exceptions.TOMLKitError):
        return  # not to be written as TOML
    assert repr(tables_of(text, "file")) == repr(wanted)  # nan differs from itself


@pytest.mark.parametrize("quotes", ['"""', "'''"])
def test_long_texts_may_hold_anything(quotes: str) -> None:
    inner = "[" * 50 + "{" * 50 + "a.b.c.d.e.f.g.h.i.j.k = 1 # ' it\n" + "=," * 100_000
    text = f"a = {quotes}{inner}{quotes}\nb = [1.5, 2.5] # {'.' * 50}{'[' * 50}\n'{'.' * 50}' = 1"
    assert tables_of(text, "file") == tomllib.loads(text)


def test_the_longest_history_is_read(tmp_path: Path) -> None:
    points = 10_000
    ramp = ", ".join(f"{i / 7 / points:.12f}" for i in range(points))
    lists = "".join(
        f"{key} = [{ramp}]\n" for key in ("time_s", "normal_force_N", "tangential_force_N", "rotation_deg")
    )
    file = tmp_path / "long.toml"
    file.write_text(
        f'name = "long"\nskin = "yamada-2002"\n[history]\n{lists}steps = 3\n[effects.friction]\n'
        "coefficient = 1\n"
    )
    assert len(load_scene(file).history.time_s) == points


@pytest.mark.parametrize("text", ["9" * 6000, "0x" + "f" * 6000, "[" * 5000, "{a=" * 5000, "\x00", "1e400"])
def test_bad_overrides(text: str) -> None:
    with pytest.raises(InputError):
        load("yamada-2002", [f"ridge.count={text}"])
    with pytest.raises(InputError):
        load("yamada-2002", [f"ridge.height={text}"])


@given(text=st.text(max_size=60))
@settings(max_examples=50, deadline=None)
def test_any_override(text: str) -> None:
    numbers, tables = ("ridge.height=", "material.young_modulus="), ("printer.sla=", "silicones.lab-10=")
    for key in ("", *numbers, *tables, "grippers.mine="):
        assert "\n" not in refusal_words(lambda key=key: load("yamada-2002", [key + text]))  # type: ignore[misc]


@pytest.mark.parametrize("override", ["slot=none", "film=none", "contact.film=none", "material.name=x"])
@pytest.mark.parametrize("value", ["'x'", "1", "[]", "[[]]", "true", "{}"])
def test_an_override_of_a_table_that_is_none(override: str, value: str, tmp_path: Path) -> None:
    file = tmp_path / "evil.toml"
    for key in ("slot", "film", "contact", "material"):
        file.write_text(f"{key} = {value}")
        assert refusal_words(lambda: load(file, [override]))


@pytest.mark.parametrize(
    "override", ["ridge.count=1000000000", "ridge.count=1000", "skin.width=1e9", "mold.cavities=1000000000"]
)
def test_huge_counts_of_a_design_are_refused_before_any_work(override: str) -> None:
    with pytest.raises(InputError, match="less than or equal"):
        load("yamada-2002", [override])


@pytest.mark.parametrize(
    "override", ["history.steps=1000000000", "history.steps=1000001", "readout.ridges=" + str([1] * 1000)]
)
def test_huge_counts_of_a_scene_and_a_circuit_are_refused_before_any_work(override: str) -> None:
    with pytest.raises(InputError):
        load_scene("yamada-2002-slip", [override])
    with pytest.raises(InputError, match=r"sweep\.points"):
        load_circuit("yamada-2002", ["sweep.points=1000000000"])


DESIGN = load("plain-ridges")
READERS: dict[str, Callable[[Path], object]] = {
    "crests": lambda path: crest_drops(path, DESIGN),
    "material test": material_test,
    "gain curve": lambda path: read_columns(path, COLUMNS),
}
readers = pytest.mark.parametrize("kind", READERS)
HEADS = st.sampled_from(
    ["ridge,crest_mm", "approach_mm,force_N", "strain,stress_MPa", "frequency_Hz,gain_dB"]
)
EVIL_CELLS = [
    "0", "1", "-1", "1e400", "nan", "inf", "-inf", "", '"', "'", "1,2", "1_0", "0x10", "9" * 400, "\x00",
    "=1+1",
]  # fmt: skip
CELLS = st.sampled_from(EVIL_CELLS) | st.floats().map(repr)


def attacked_table(kind: str, data: bytes) -> None:
    with evil(data, "evil.csv") as file:
        assert_a_line(refusal_words(lambda: READERS[kind](file)))


@readers
@given(data=st.binary(max_size=300))
@settings(max_examples=50, deadline=None)
def test_any_bytes_of_a_table(kind: str, data: bytes) -> None:
    attacked_table(kind, data)


@readers
@given(head=HEADS, rows=st.lists(st.lists(CELLS, min_size=1, max_size=3).map(",".join), max_size=12))
@settings(max_examples=100, deadline=None)
def test_any_cells(kind: str, head: str, rows: list[str]) -> None:
    attacked_table(kind, "\n".join([head, *rows]).encode())


BAD_TABLES = {
    "a cell of 1e6 digits": b"ridge,crest_mm\n1," + b"9" * 1_000_000,
    "a quote that never ends": b'ridge,crest_mm\n1,"' + b"9\n" * 200_000,
    "1e6 columns": b"ridge," * 1_000_000,
    "a column twice": b"ridge,crest_mm,crest_mm\n1,2,3",
    "only NULs": b"\x00" * 1000,
    "half of a letter": b"ridge,crest_mm\n\xc3,1",
    "lone carriage returns": b"ridge,crest_mm\r1,2\r" * 3,
    "a row of 1e6 cells": b"ridge,crest_mm\n" + b"1," * 1_000_000,
}


@readers
@pytest.mark.parametrize("name", BAD_TABLES)
def test_bad_tables(kind: str, name: str) -> None:
    with evil(BAD_TABLES[name], "evil.csv") as file, refused():
        READERS[kind](file)


@readers
def test_what_is_no_file_is_not_waited_for(kind: str, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.csv")
    loop = tmp_path / "loop.csv"
    loop.symlink_to(loop)
    for path in (tmp_path / "pipe.csv", Path("/dev/zero"), tmp_path, loop, Path("a\x00b"), Path("x" * 5000)):
        with refused():
            READERS[kind](path)


@readers
def test_a_file_too_large_is_not_read(kind: str, tmp_path: Path) -> None:
    file = tmp_path / "large.csv"
    with file.open("wb") as sparse:
        sparse.truncate(LARGEST_TABLE + 1)
    with pytest.raises(InputError, match="must be at most"):
        READERS[kind](file)
