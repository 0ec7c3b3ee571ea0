import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

import skincad
from skincad.base.errors import InputError
from skincad.base.freshfile import fresh
from skincad.inputs.catalog import template_names
from skincad.outputs.newfile import design_schema, write_new


@pytest.mark.parametrize("name", template_names())
def test_a_new_file_is_its_template_with_every_key_explained(tmp_path: Path, name: str) -> None:
    path, schema = write_new(tmp_path / "mine.toml", name)
    assert skincad.load(path) == skincad.load(name).with_(name="mine")
    text = path.read_text()
    assert text.startswith(f"#:schema ./{schema.name}\n")
    for key in ("curvature_radius", "tip_fillet", "d33", "clearance", "tilt", "radius"):
        line = next(i for i, row in enumerate(text.splitlines()) if row.lstrip("# ").startswith(f"{key} ="))
        assert any(row.startswith("# ") and "[" in row for row in text.splitlines()[line - 2 : line]), key


@pytest.mark.parametrize("name", template_names())
def test_the_schema_accepts_every_template(name: str) -> None:
    from skincad.inputs.catalog import template_text

    jsonschema.validate(tomllib.loads(template_text(name)), json.loads(design_schema()))


@pytest.mark.parametrize(
    "text",
    ["[ridge]\nheigth = 1.0", "[ridge]\nheight = 'x'", "[ridge]\nheight = -1.0", "[mold]\nprocess = 'x'"],
)
def test_the_schema_refuses_what_the_model_refuses(text: str) -> None:
    data = skincad.load("yamada-2002").model_dump(exclude_none=True)
    for table, values in tomllib.loads(text).items():
        data[table].update(values)
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(data, json.loads(design_schema()))


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    (tmp_path / "mine.toml").write_text("precious")
    with pytest.raises(InputError, match="is there already"):
        write_new(tmp_path / "mine.toml")
    assert (tmp_path / "mine.toml").read_text() == "precious"
    assert not (tmp_path / "mine.schema.json").exists()


def test_a_name_that_is_no_design_name_is_made_one(tmp_path: Path) -> None:
    path, _ = write_new(tmp_path / "my skin.v2.toml")
    assert skincad.load(path).name == "my-skin-v2"


@pytest.mark.parametrize(
    "name",
    ['n\nname="evil"\n.toml', "a\rb.toml", "a\x1b[31m.toml", "a\x00.toml", "\u202egnp.toml"],
)
def test_a_name_that_no_comment_can_hold_is_refused_and_nothing_is_written(tmp_path: Path, name: str) -> None:
    with pytest.raises(InputError, match=r"^FILE: must have a name of printable characters") as told:
        write_new(tmp_path / name)
    assert str(told.value).isprintable()
    assert not list(tmp_path.iterdir())


def test_a_file_that_would_be_no_design_never_takes_its_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "skincad.outputs.newfile.commented_toml", lambda *_: "name = 'x'\n[ridge]\nheight = -1\n"
    )
    with pytest.raises(InputError):
        write_new(tmp_path / "mine.toml")
    assert not list(tmp_path.iterdir())


def test_a_file_that_appears_meanwhile_is_not_written_over(tmp_path: Path) -> None:
    with (
        pytest.raises(InputError, match="is there already"),
        fresh(tmp_path / "a.png", "--stress") as staging,
    ):
        staging.write_text("ours")
        (tmp_path / "a.png").write_text("mine")
    assert {p.name: p.read_text() for p in tmp_path.iterdir()} == {"a.png": "mine"}
