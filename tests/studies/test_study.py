"""What a study's file may say."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import template_names
from skincad.studies import Study, knobs, load_study
from tests.refusals import refused

PLAIN: dict[str, Any] = {
    "name": "plain",
    "about": "yamada-2002",
    "vary": {"skin.length": "8:14"},
    "objectives": [{"key": "approach"}],
}


def test_keys_may_be_quoted_or_be_tables(tmp_path: Path) -> None:
    quoted = '"skin.length" = "8:14"\n"contact.plate.tilt" = "0:1"\n'
    tables = 'skin.length = "8:14"\ncontact.plate.tilt = "0:1"\n'
    head = 'name = "s"\nabout = "yamada-2002"\n[vary]\n'
    rows = []
    for name, text in (("a", quoted), ("b", tables)):
        path = tmp_path / f"{name}.toml"
        path.write_text(head + text + '[[objectives]]\nkey = "approach"\n')
        rows.append(load_study(path))
    assert rows[0] == rows[1]
    assert dict(rows[0].vary) == {"skin.length": "8:14", "contact.plate.tilt": "0:1"}


def test_a_path_counts_from_the_studys_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mine.toml").write_text(skincad.load_design("yamada-2002").to_toml())
    path = tmp_path / "study.toml"
    path.write_text(Study(**{**PLAIN, "about": "mine.toml"}).to_toml())
    monkeypatch.chdir("/")
    assert load_study(path, ["ridge.count=7"]).subject().ridge.count == 7  # type: ignore[union-attr]


@pytest.mark.parametrize("name", template_names("studies"))
def test_what_ships_can_be_asked(name: str) -> None:
    study = load_study(name)
    assert study.name == name
    subject = study.subject()
    varied = knobs(subject, dict(study.vary))
    for knob in varied:
        assert knob.start is not None
    assert Study(**study.model_dump(exclude_none=True)) == study


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"objectives": []}, "objectives: names none"),
        ({"vary": {}}, "vary: names no key"),
        ({"form": 0}, "form: must be 1"),
        ({"tier": "lineer"}, "model: unknown model, got 'lineer'; did you mean 'linear'"),
        ({"judge": "x"}, "judge: unknown model"),
        ({"model": "auto"}, "must be one model"),
        ({"model": "winkler", "tier": "linear"}, "tier: unknown key"),
        ({"constraints": [{"key": "yield"}]}, "needs at_least or at_most"),
        ({"objectives": [{"key": "approach", "goal": "least"}]}, "goal"),
        ({"objectives": [{"key": "a"}, {"key": "b"}], "optimiser": "cma"}, "nsga2 or sobol"),
        ({"evaluations": 0}, "evaluations"),
        ({"optimizer": "cma"}, "did you mean 'optimiser'"),
    ],
)
def test_what_can_not_be_used_is_one_line(change: dict[str, Any], says: str) -> None:
    with refused(says):
        Study(**{**PLAIN, **change})


def test_a_study_is_no_design_and_a_design_no_study() -> None:
    with pytest.raises(InputError, match="is a design, not a study; give it to"):
        load_study("lab-bench")
    with pytest.raises(InputError, match="is a study, not a design; give it to optimise"):
        skincad.load_design("my-printer")
    with pytest.raises(InputError, match="did you mean 'my-printer'"):
        load_study("my-printr")
