"""What `skincad new` writes and `skincad templates` lists: keys explained, values with their sources."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

import jsonschema
import pytest
from pydantic import BaseModel
from pydantic.fields import FieldInfo

import skincad
from skincad.base import InputError, NumberWithRange, fresh, table_of
from skincad.circuit import Circuit, load_circuit
from skincad.effects import EFFECTS, effect
from skincad.inputs import (
    FAMILY_TABLES,
    KINDS,
    Design,
    Kind,
    processes,
    silicones,
    table_text,
    template_names,
    template_text,
)
from skincad.outputs import listing, schema_of, tomls, write_new
from skincad.scenes import Scene, load_scene
from tests.conftest import run_skincad, skincad_process
from tests.designs import OF_FAMILIES
from tests.refusals import refused

EACH = [(kind, name) for kind in KINDS for name in template_names(kind)]
LOADERS = {"designs": skincad.load, "scenes": load_scene, "circuits": load_circuit}


def explained(text: str) -> dict[str, str]:
    """The line above each key, by `table.key`; where its value is from may lie between."""
    meanings, table, rows = {}, "", text.splitlines()
    for i, row in enumerate(rows):
        bare = row.removeprefix("# ")
        if bare.startswith("["):
            table = bare[1 : bare.index("]")] + "."
        elif key := re.match(r"(# )?(\w+) = ", row):
            above = rows[i - 2] if rows[i - 1].startswith("#   ") else rows[i - 1]
            meanings[table + key[2]] = above
    return meanings


@pytest.mark.parametrize(("kind", "name"), EACH)
def test_a_new_file_is_its_template_with_every_key_explained(kind: Kind, name: str, tmp_path: Path) -> None:
    path, schema = write_new(tmp_path / "mine.toml", f"{kind}/{name}")
    text, shipped = path.read_text(), tomllib.loads(template_text(name, kind))
    data = tomllib.loads(text)
    assert data == {**shipped, "name": "mine"}
    assert text.startswith(f"#:schema ./{schema.name}\n")
    family = next((key for key in FAMILY_TABLES if kind == "designs" and key in data), "")
    assert schema.read_text() == schema_of(kind, family)
    jsonschema.validate(shipped, json.loads(schema_of(kind)))
    assert LOADERS[kind](path) == LOADERS[kind](name).with_(name="mine")
    meanings = explained(text)
    assert all(meaning.startswith("# ") for meaning in meanings.values())
    for key in ("skin.curvature_radius", "mold.clearance", "contact.plate.tilt") if kind == "designs" else ():
        assert "[" in meanings[key], key


@pytest.mark.parametrize("name", OF_FAMILIES)
def test_a_design_and_its_schema_show_the_keys_of_its_family(name: str) -> None:
    design = OF_FAMILIES[name]()
    family, others = design.features.family, {*FAMILY_TABLES} - {design.features.family}
    schema = json.loads(schema_of("designs", family))
    text = tomls.commented_toml("designs", design.to_toml(), name, "x.json")
    tables = {
        line.strip("# []").partition(".")[0] for line in text.splitlines() if re.match(r"^(# )?\[", line)
    }
    assert tables & {*others, "slot", "film"} == set()
    assert {*schema["properties"]} & {*others, "slot", "film"} == set()
    assert family in tables & {*schema["properties"]}
    jsonschema.validate(tomllib.loads(text), schema)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({key: value for key, value in design if key != family}, schema)


def keys(model: type[BaseModel], path: str = "") -> Iterator[tuple[str, FieldInfo]]:
    for key, field in model.model_fields.items():
        inner = table_of(model, key)
        if key in ("printer", "silicones", "grippers", "effects"):
            continue
        if inner is None or inner is NumberWithRange:
            yield path + key, field
        else:
            yield from keys(inner, f"{path}{key}.")


@pytest.mark.parametrize("kind", KINDS)
def test_every_key_is_there_with_meaning_unit_and_range(kind: Kind, tmp_path: Path) -> None:
    path, _ = write_new(tmp_path / "mine.toml", f"{kind}/{template_names(kind)[0]}")
    meanings = explained(path.read_text())
    wanted = dict(keys({"designs": Design, "scenes": Scene, "circuits": Circuit}[kind]))
    if kind == "designs":  # of ridges: those of other families are in their own files
        others = {*FAMILY_TABLES} - {"ridge"} | {"magnetometer"}
        wanted = {key: field for key, field in wanted.items() if key.partition(".")[0] not in others}
    if kind == "scenes":
        wanted |= {f"effects.{name}.{key}": field for name in EFFECTS for key, field in keys(effect(name))}
    assert set(meanings) == set(wanted)
    for key, field in wanted.items():
        assert field.description, key
        assert meanings[key].startswith(f"# {field.description}"), key
        extra = field.json_schema_extra
        unit = extra.get("unit", "1") if isinstance(extra, dict) else "1"
        assert unit == "1" or f"[{unit}" in meanings[key], key
        for rule in field.metadata:
            for bound in ("gt", "ge", "lt", "le"):
                assert f"{getattr(rule, bound):.8g}" in meanings[key] if hasattr(rule, bound) else True, key


def test_defaults_and_effects_that_a_template_lacks_are_comments(tmp_path: Path) -> None:
    text = write_new(tmp_path / "mine.toml", "hold")[0].read_text()
    assert "# [effects.film]" not in text
    assert '# bond = "bonded"\n' in text
    assert "# [plate]  # optional\n" in text
    assert "# frames = 0\n" in text
    assert "# [at most" not in text
    assert "# of each point, from 0 [s, from 2 to 10000 values]\n" in text
    voltages = "# Voltages of the strips in the ridges of the readout. Needs film."
    assert f"\n{voltages}\n# [effects.piezo]  # optional\n" in text
    text = text.replace("# [effects.finite_strain]", "[effects.finite_strain]")
    text = text.replace('# creases = "pass"', 'creases = "stop"')
    (tmp_path / "other.toml").write_text(text)
    assert load_scene(tmp_path / "other.toml").effects["finite_strain"] == {"creases": "stop"}


@pytest.mark.parametrize(
    "text", ["[effects.frictoin]", "[effects.friction]\nmu = 1", "[effects.friction]\ncoefficient = -1"]
)
def test_a_scenes_schema_knows_the_effects(text: str) -> None:
    data = tomllib.loads(template_text("hold", "scenes"))
    for table, values in tomllib.loads(text).items():
        data[table].update(values)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data, json.loads(schema_of("scenes")))


def test_own_grippers_are_written_and_load(tmp_path: Path) -> None:
    lab, _ = write_new(tmp_path / "mine.toml", "grippers")
    design = skincad.load("plain-ridges", ["mold.mount=my-gripper"], grippers=lab)
    assert design.mounting is not None
    assert (design.mounting.thread, design.mounting.pitch_x) == ("M2", 10.0)


def test_own_silicones_and_processes_are_written_and_load(tmp_path: Path) -> None:
    lab, schema = write_new(tmp_path / "lab.toml", "silicones")
    design = skincad.load("lab-bench", ["material.name=my-silicone"], silicones=lab)
    silicone, base = silicones(design.silicones)["my-silicone"], silicones()["dragon-skin-30"]
    assert silicone.name == "my-silicone"
    assert silicone.source == "assumption"
    for key in type(base).model_fields.keys() - {"name", "source", "sources"}:
        assert getattr(silicone, key) == getattr(base, key), key
    jsonschema.validate(tomllib.loads(lab.read_text()), json.loads(schema.read_text()))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate({"lab-10": {"viscosty": 1.0}}, json.loads(schema.read_text()))

    printer, schema = write_new(tmp_path / "printer.toml", "processes")
    design = skincad.load("lab-bench", ["mold.process=my-printer"], printer=printer)
    assert processes(design.printer)["my-printer"] == processes()["sla"]
    jsonschema.validate(tomllib.loads(printer.read_text()), json.loads(schema.read_text()))
    every = printer.read_text().replace("\n# ", "\n")
    rows = [row for row in every.splitlines() if " = " in row and row[0].islower()]
    uncommented = tmp_path / "all.toml"
    uncommented.write_text("\n".join(["[my-printer]", *rows]))
    assert (
        processes(skincad.load("lab-bench", printer=uncommented).printer)["my-printer"] == processes()["sla"]
    )


@pytest.mark.parametrize(
    ("template", "message"),
    [
        ("yamada-2002", "got 'yamada-2002'; say designs/yamada-2002 or circuits/yamada-2002"),
        ("lab-benc", "template: no such template, got 'lab-benc'; did you mean 'lab-bench'?"),
        ("silicone", "template: no such template, got 'silicone'; did you mean 'silicones'?"),
        ("scenes/lab-bench", "template: no such template, got 'scenes/lab-bench'; did you mean 'lab-bench'?"),
        ("../designs/lab-bench", "template: no such template, got '../designs/lab-bench'; did you mean"),
    ],
)  # fmt: skip
def test_a_template_that_is_none_or_two_is_told(template: str, message: str, tmp_path: Path) -> None:
    with refused(message):
        write_new(tmp_path / "mine.toml", template)
    assert not list(tmp_path.iterdir())


def test_the_command_writes_any_kind(tmp_path: Path) -> None:
    for template, key in (
        ("hold", "skin"),
        ("transimpedance", "[amplifier]"),
        ("silicones", "[my-silicone]"),
    ):
        process = run_skincad("new", f"{template}.toml", "--template", template, cwd=tmp_path)
        assert process.stdout.splitlines() == [f"{template}.toml", f"{template}.schema.json"], process.stderr
        assert key in (tmp_path / f"{template}.toml").read_text()
    assert run_skincad("new", "mine.toml", cwd=tmp_path).returncode == 0
    assert skincad.load(tmp_path / "mine.toml") == skincad.load("home-printer").with_(name="mine")


@pytest.mark.parametrize(
    "text",
    [
        "[ridge]\nheigth = 1.0",
        "[ridge]\nheight = 'x'",
        "[ridge]\nheight = -1.0",
        "[mold]\nprocess = 'x'",
        "[material]\nyoung_modulus = 800000.0",
        "[silicones.lab-10]\nviscosty = 1.0",
    ],
)
def test_the_schema_refuses_what_the_model_refuses(text: str) -> None:
    data = skincad.load("yamada-2002").model_dump(exclude_none=True)
    for table, values in tomllib.loads(text).items():
        data.setdefault(table, {}).update(values)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data, json.loads(schema_of("designs")))


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("precious")
    with pytest.raises(InputError, match="exists already"):
        write_new(tmp_path / "mine.toml")
    assert (tmp_path / "mine.toml").read_text() == "precious"
    assert not (tmp_path / "mine.schema.json").exists()


def test_a_name_that_is_no_design_name_is_made_one(tmp_path: Path) -> None:
    path, _ = write_new(tmp_path / "my skin.v2.toml")
    assert skincad.load(path).name == "my-skin-v2"


@pytest.mark.parametrize(
    "name", ['n\nname="evil"\n.toml', "a\rb.toml", "a\x1b[31m.toml", "a\x00.toml", "\u202egnp.toml"]
)
def test_a_name_that_no_comment_can_hold_is_refused_and_nothing_is_written(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"^FILE: must have a name of printable characters") as refusal:
        write_new(tmp_path / name)
    assert str(refusal.value).isprintable()
    assert not list(tmp_path.iterdir())


def test_a_file_that_would_be_no_design_never_takes_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tomls, "commented_toml", lambda *_: "name = 'x'\n[ridge]\nheight = -1\n")
    with pytest.raises(InputError):
        write_new(tmp_path / "mine.toml")
    assert not list(tmp_path.iterdir())


def test_a_file_that_appears_meanwhile_is_not_written_over(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="exists already"), fresh(tmp_path / "a.png", "--stress") as staging:
        staging.write_text("ours")
        (tmp_path / "a.png").write_text("mine")
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"a.png": "mine"}


EVERY = (*KINDS, "studies", "silicones", "processes", "grippers", "films")
listed = cache(listing)


@pytest.mark.parametrize("kind", EVERY)
def test_a_kind_is_listed_alone_as_among_all(kind: str) -> None:
    """Lines and words are golden."""
    data, lines = listed(kind)
    every, rows = listed(None)
    assert tuple(every) == EVERY
    assert data["kind"] == kind
    assert list(data["entries"]) == every[kind]
    if kind in (*KINDS, "studies"):
        assert every[kind] == template_names(kind)
    if kind in KINDS:
        assert lines == [row for row in rows if row.startswith(f"{kind[:-1]} ")]
        for row, (name, entry) in zip(lines[kind == "designs" :], data["entries"].items(), strict=True):
            assert name in row
            assert row.endswith(entry["about"])
    if kind in ("silicones", "processes"):
        assert data["entries"] == tomllib.loads(table_text(kind))


def test_each_number_of_a_process_has_a_source() -> None:
    data, lines = listed("processes")
    for name, table in data["entries"].items():
        assert table.keys() == data["sources"][name].keys()
        assert all(re.match("assumption|source: ", source) for source in data["sources"][name].values())
        assert sum(line.startswith(f"  {name}  ") for line in lines) == len(table)


def test_a_kind_that_is_none_is_told() -> None:
    with pytest.raises(InputError, match=r"^kind: no such kind, got 'silicon'; did you mean 'silicones'\?$"):
        listed("silicon")


def test_the_command_lists_a_kind(tmp_path: Path) -> None:
    process = run_skincad("templates", "silicones", cwd=tmp_path)
    assert process.stdout.splitlines() == listed("silicones")[1]
    data = json.loads(run_skincad("templates", "processes", "--json", cwd=tmp_path).stdout)
    assert data == listed("processes")[0]
    wrong = run_skincad("templates", "silicon", cwd=tmp_path)
    assert (wrong.returncode, wrong.stdout) == (2, "")
    assert wrong.stderr == "skincad: KIND: no such kind, got 'silicon'; did you mean 'silicones'?\n"


@pytest.mark.slow
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
