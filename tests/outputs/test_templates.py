"""What `skincad templates` lists: by kind, with the values, ranges and sources of silicones and processes."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from skincad.base import InputError
from skincad.inputs import KINDS, Kind, table_text, template_names
from skincad.outputs import listing
from tests.conftest import run_skincad, skincad_process

EVERY = (*KINDS, "studies", "silicones", "processes", "grippers")


def test_all_kinds_are_listed_with_what_each_is() -> None:
    data, lines = listing(None)
    assert tuple(data) == EVERY
    assert lines[0].split()[:3] == ["design", "name", "ridges"]
    assert [(row.split()[0], row.split()[1]) for row in lines[1:]] == [
        ({"processes": "process", "studies": "study"}.get(kind, kind[:-1]), name)
        for kind in EVERY
        for name in data[kind]
    ]
    assert all(len(row.split()) > 3 for row in lines)
    for kind in (*KINDS, "studies"):
        assert data[kind] == template_names(kind)


@pytest.mark.parametrize("kind", EVERY)
def test_one_kind_has_the_same_names(kind: str) -> None:
    data, _ = listing(kind)
    assert data["kind"] == kind
    assert list(data["entries"]) == listing(None)[0][kind]


@pytest.mark.parametrize("kind", KINDS)
def test_templates_say_what_they_are(kind: Kind) -> None:
    data, lines = listing(kind)
    assert lines == [row for row in listing(None)[1] if row.startswith(f"{kind[:-1]} ")]
    for row, (name, entry) in zip(lines[kind == "designs" :], data["entries"].items(), strict=True):
        assert name in row
        assert row.endswith(entry["about"])


def test_silicones_come_with_values_ranges_and_sources() -> None:
    data, lines = listing("silicones")
    assert data["entries"] == tomllib.loads(table_text("silicones"))
    assert data["units"]["young_modulus"] == "MPa"
    row = next(i for i, line in enumerate(lines) if line.startswith("dragon-skin-30 "))
    assert re.split(r"\s{2,}", lines[row]) == [
        *("dragon-skin-30", "0.8 (0.44 to 1.5)", "0.499", "1080", "1:1", "45", "16", "364", "20")
    ]
    assert lines[row + 1] == f"  {data['entries']['dragon-skin-30']['source']}"
    assert lines[row + 2].startswith("    0.504 MPa: bar pulled to 100 %")
    assert lines[row + 2].endswith("ogden, mu 0.1682, alpha 3.06")
    assert lines[row + 3].startswith("    1.02 MPa: 100 % modulus of 86 psi")
    heads = re.split(r"\s{2,}", lines[0].strip()), re.split(r"\s{2,}", lines[1].strip())
    assert heads == (
        ["modulus", "Poisson", "density", "A:B", "pot", "cure", "breaks", "visc."],
        ["MPa", "kg/m3", "min", "h", "at %", "Pa s"],
    )
    assert "All are platinum-cured." in lines


def test_processes_come_with_meaning_values_and_sources() -> None:
    data, lines = listing("processes")
    assert data["entries"] == tomllib.loads(table_text("processes"))
    at = lines.index("gap: narrowest groove or slit, mm")
    assert lines[at + 1] == "  fdm  0.4      assumption: one line of a 0.4 mm nozzle"
    assert data["sources"]["fdm"]["gap"] == "assumption: one line of a 0.4 mm nozzle"
    assert data["units"]["overhang"] == "deg"
    assert "sla: printed from liquid resin" in lines
    for name, table in data["entries"].items():
        assert table.keys() == data["sources"][name].keys()
        assert all(re.match("assumption|source: ", source) for source in data["sources"][name].values())
        assert sum(line.startswith(f"  {name}  ") for line in lines) == len(table)


def test_a_kind_that_is_none_is_told() -> None:
    with pytest.raises(InputError, match=r"^kind: no such kind, got 'silicon'; did you mean 'silicones'\?$"):
        listing("silicon")


def test_the_command_lists_a_kind(tmp_path: Path) -> None:
    process = run_skincad("templates", "silicones", cwd=tmp_path)
    assert process.stdout.splitlines() == listing("silicones")[1]
    data = json.loads(run_skincad("templates", "processes", "--json", cwd=tmp_path).stdout)
    assert data == listing("processes")[0]
    wrong = run_skincad("templates", "silicon", cwd=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert wrong.stderr == "skincad: KIND: no such kind, got 'silicon'; did you mean 'silicones'?\n"


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("skincad templates s", ["scenes", "studies", "silicones"]),
        ("skincad new x.toml --template circ", ["circuits/yamada-2002"]),
        ("skincad new x.toml --template ho", ["home-printer", "hold"]),
        ("skincad new x.toml --template silic", ["silicones"]),
    ],
)
def test_a_shell_completes_kinds_and_templates(words: str, wanted: list[str], tmp_path: Path) -> None:
    shell = {"_SKINCAD_COMPLETE": "complete_bash", "COMP_WORDS": words}
    process = skincad_process(cwd=tmp_path, COMP_CWORD=str(len(words.split()) - 1), **shell)
    assert process.stdout.split() == wanted
