"""The glossary points to what is there: every file, folder and class that it names."""

from __future__ import annotations

import re
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "skincad"
GLOSSARY = PACKAGE.parent / "docs" / "reference" / "glossary.md"


def rows() -> list[list[str]]:
    cells = [line.strip("|").split("|") for line in GLOSSARY.read_text(encoding="utf-8").splitlines()]
    return [[cell.strip() for cell in row] for row in cells if len(row) == 3 and set(row[0]) - set("- ")]


def test_what_it_points_to_is_there() -> None:
    code = "".join(path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py"))
    places = [place for row in rows() for place in re.findall(r"`([^`]+)`", row[2])]
    assert len(places) > 50
    for place in places:
        there = (
            (PACKAGE / place).exists()
            if "/" in place
            else re.search(rf"^class {place}\b", code, re.MULTILINE)
        )
        assert there, place


def test_every_word_is_explained_once() -> None:
    words = [word for row in rows() for word in row[0].split(", ") if row[0] != "word"]
    assert {word for word in words if words.count(word) > 1} == {"lead"}  # of a strip, and in time
