"""Files that mean harm: designs, scenes, circuits and printers; only skincad's own error leaves, in one line.

Hypothesis writes them: as bytes, as templates with bytes changed, and as tables with any value at any key.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import tomlkit
from hypothesis import given, settings
from hypothesis import strategies as st

from skincad.catalog import LARGEST_FILE, load, read_table, template_text
from skincad.circuit.model import load_circuit
from skincad.errors import InputError
from skincad.scene import load_scene

LOADERS: dict[str, tuple[Callable[[Path], object], str, str]] = {
    "design": (load, "yamada-2002", "designs"),
    "scene": (load_scene, "yamada-2002-slip", "scenes"),
    "circuit": (load_circuit, "yamada-2002", "circuits"),
    "printer": (lambda path: load("yamada-2002", printer=path), "yamada-2002", "designs"),
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


def told(read: Callable[[], object]) -> str:
    """The words of a refusal, "" where there is none; anything else that is raised leaves."""
    try:
        read()
    except InputError as refusal:
        return str(refusal)
    return ""


def attacked(kind: str, data: bytes) -> None:
    """Load a file of these bytes: a refusal is one line, of a length that a terminal bears."""
    read, _, _ = LOADERS[kind]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "evil.toml"
        file.write_bytes(data)
        words = told(lambda: read(file))
        assert "\n" not in words
        assert len(words) < 2000
        assert [p.name for p in Path(folder).iterdir()] == ["evil.toml"]


@kinds
@given(data=st.binary(max_size=400))
@settings(max_examples=60, deadline=None)
def test_any_bytes(kind: str, data: bytes) -> None:
    attacked(kind, data)


@kinds
@given(data=st.data())
@settings(max_examples=60, deadline=None)
def test_a_template_with_bytes_changed(kind: str, data: st.DataObject) -> None:
    _, name, folder = LOADERS[kind]
    text = bytearray(template_text(name, folder).encode())  # type: ignore[arg-type]
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(text) - 1))
        text[at : at + data.draw(st.integers(0, 3))] = data.draw(st.binary(max_size=4))
    attacked(kind, bytes(text))


def paths(table: dict[str, Any], at: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    found: list[tuple[str, ...]] = []
    for key, value in table.items():
        found += [(*at, key), *(paths(value, (*at, key)) if isinstance(value, dict) else [])]
    return found


@kinds
@given(data=st.data())
@settings(max_examples=150, deadline=None)
def test_any_value_at_any_key(kind: str, data: st.DataObject) -> None:
    _, name, folder = LOADERS[kind]
    table = read_table(name, folder)  # type: ignore[arg-type]
    if kind == "printer":
        table = {"sla": {"gap": 0.1, "layer": 0.05}, "my-mill": {"based_on": "cnc", "chord": 0.01}}
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
    "1e5 unknown keys": b"\n".join(b"k%d = 1" % i for i in range(100_000))[:LARGEST_FILE],
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
    if (kind, name) == ("printer", "nothing"):
        return  # no processes of one's own: nothing is wrong with that
    read, _, _ = LOADERS[kind]
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "evil.toml"
        file.write_bytes(BAD[name])
        with pytest.raises(InputError) as refusal:
            read(file)
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 2000


@pytest.mark.parametrize("text", ["9" * 6000, "0x" + "f" * 6000, "[" * 5000, "{a=" * 5000, "\x00", "1e400"])
def test_bad_overrides(text: str) -> None:
    with pytest.raises(InputError):
        load("yamada-2002", [f"ridge.count={text}"])
    with pytest.raises(InputError):
        load("yamada-2002", [f"ridge.height={text}"])


@given(text=st.text(max_size=60))
@settings(max_examples=200, deadline=None)
def test_any_override(text: str) -> None:
    for key in ("", "ridge.height=", "material.young_modulus=", "printer.sla="):
        assert "\n" not in told(lambda key=key: load("yamada-2002", [key + text]))  # type: ignore[misc]


@pytest.mark.parametrize(
    "override",
    ["ridge.count=1000000000", "ridge.count=1000", "skin.width=1e9", "mold.cavities=1000000000"],
)
def test_huge_counts_of_a_design_are_refused_before_any_work(override: str) -> None:
    with pytest.raises(InputError, match="less than or equal"):
        load("yamada-2002", [override])


@pytest.mark.parametrize(
    "override", ["history.steps=1000000000", "history.steps=1000001", "readout.ridges=" + str([1] * 1000)]
)
def test_huge_counts_of_a_scene_are_refused_before_any_work(override: str) -> None:
    with pytest.raises(InputError):
        load_scene("yamada-2002-slip", [override])


def test_huge_counts_of_a_circuit_are_refused_before_any_work() -> None:
    with pytest.raises(InputError, match=r"sweep\.points"):
        load_circuit("yamada-2002", ["sweep.points=1000000000"])
