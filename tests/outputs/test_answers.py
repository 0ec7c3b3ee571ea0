"""What commands say, as texts of templates/answers: each asks for nothing that it is not given."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from jinja2 import meta

import skincad
from skincad.base import imported
from skincad.fabrication import environment
from skincad.inputs import templates_folder

ANSWERS = templates_folder() / "answers"
HOMES = sorted(
    home
    for path in Path(skincad.__file__).parent.rglob("*.py")
    for home in re.findall(r'^    shown_by = "([\w.]+:\w+)"', path.read_text("utf-8"), re.MULTILINE)
)


def names_of(text: str) -> tuple[set[str], set[str], set[str]]:
    """Its macros, what it asks for from outside, and the texts that it imports with it."""
    source = (ANSWERS / text).read_text("utf-8")
    tree = environment().parse(source)
    imported = {Path(name).name for name in meta.find_referenced_templates(tree) if name}
    macros = set(re.findall(r"{% macro (\w+)\(", source))
    sets = re.findall(r"{% set ([\w, ]+) =", source)
    asked = meta.find_undeclared_variables(tree) - macros - environment().globals.keys()
    asked -= {name for names in sets for name in names.split(", ")}  # in one branch alone, perhaps
    for other in imported:
        asked |= names_of(other)[1]
    return macros, asked, imported


def test_each_text_is_a_presentations_or_one_that_others_import() -> None:
    texts = {imported(home).words for home in HOMES}
    others = {other for text in texts for other in names_of(text)[2]}
    assert texts | others == {path.name for path in ANSWERS.iterdir()}


@pytest.mark.parametrize("home", HOMES)
def test_a_text_asks_for_facts_that_its_presentation_gives(home: str) -> None:
    presentation = imported(home)
    macros, asked, _ = names_of(presentation.words)
    assert "lines" in macros
    assert asked <= presentation.facts.keys()
