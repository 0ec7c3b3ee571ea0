"""README.md and docs/ name what is there, the code cites pages that are there, pictures are the program's."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from bench.pictures import geometry_plot
from skincad.circuit import Circuit
from skincad.cli.app import app
from skincad.effects import EFFECTS, effect
from skincad.inputs import Design
from skincad.outputs import table_entries
from skincad.scenes import Scene
from tests.conftest import Made

ROOT = Path(__file__).parent.parent
README = (ROOT / "README.md").read_text("utf-8")
CITING = ("skincad", "templates", "tests", "bench", "examples", "README.md", "CHANGELOG.md", "pyproject.toml")
CITATION = re.compile(r"\bdocs/([\w/-]+\.\w+)(?:#([\w-]+))?")
TEXT = {".py", ".toml", ".md", ".ipynb"}
MAX_WORDS = 15_000  # of prose outside docs/evidence
MAX_WORDS_EVIDENCE = 8_000  # beside its tables
MAX_WORDS_IN_ALL = 24_000  # as `wc -w` counts: tables, code and all
MAX_WORDS_HOWTO = 600  # a page
MAX_CHANGELOG_LINES = 300
MAX_PICTURE_BYTES = 150_000
# lines in the place of pages that mkdocs makes as it builds
GENERATED = ("gallery.md", *(f"reference/{name}.md" for name in ("cli", "python", "toml", "json")))
FILES = (
    "csv",
    "glb",
    "html",
    "ipynb",
    "msh",
    "parquet",
    "png",
    "step",
    "stl",
    "toml",
    "urdf",
    "vtu",
    "usda",
    "xml",
)


def texts() -> Iterator[Path]:
    for place in (ROOT / name for name in CITING):
        yield from [place] if place.is_file() else (p for p in place.rglob("*") if p.suffix in TEXT)


@cache
def cited() -> list[tuple[str, str, str]]:
    rows = {
        (path.relative_to(ROOT).as_posix(), page, anchor)
        for path in texts()
        for page, anchor in CITATION.findall(path.read_text())
    }
    return sorted(rows)


@cache
def anchors(page: Path) -> set[str]:
    """A heading's anchor as GitHub and mkdocs make it: lower case, only letters, digits, - and _."""
    headings = re.findall(r"^#+ (.+)$", page.read_text(), re.M)
    return {re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower()) for heading in headings}


def words(page: Path, tables: bool = True) -> int:
    """Count a page's words: tables and headings count, fenced code, comments and links' targets don't."""
    text = re.sub(r"^```.*?^```$|<!--.*?-->", "", page.read_text(), flags=re.M | re.S)
    text = text if tables else re.sub(r"^\|.*$", "", text, flags=re.M)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    return sum(bool(re.search(r"\w", word)) for word in re.split(r"[\s|]+", text))


def test_the_pages_are_short() -> None:
    pages = {page: words(page) for page in (ROOT / "docs").rglob("*.md")}
    prose = {
        p: n
        for p, n in pages.items()
        if p.parent.name != "evidence" and str(p.relative_to(ROOT / "docs")) not in GENERATED
    }
    assert sum(prose.values()) <= MAX_WORDS
    long = {page.name: n for page, n in pages.items() if page.parent.name == "howto" and n > MAX_WORDS_HOWTO}
    assert not long
    evidence = (ROOT / "docs/evidence").glob("*.md")
    assert sum(words(page, tables=False) for page in evidence) <= MAX_WORDS_EVIDENCE
    assert sum(len(page.read_text().split()) for page in pages) <= MAX_WORDS_IN_ALL


def test_the_changelog_is_short() -> None:
    assert len((ROOT / "CHANGELOG.md").read_text().splitlines()) <= MAX_CHANGELOG_LINES


def test_pictures_are_small() -> None:
    pictures = list((ROOT / "docs").rglob("*.png"))
    assert len(pictures) > 5
    assert {p.name: p.stat().st_size for p in pictures if p.stat().st_size > MAX_PICTURE_BYTES} == {}


def test_the_facts_are_cited() -> None:
    assert sum(page == "evidence/facts.md" for _, page, _ in cited()) > 15


def test_what_is_cited_is_there() -> None:
    for where, page, anchor in cited():
        assert (ROOT / "docs" / page).is_file(), f"{where} cites docs/{page}"
        assert not anchor or anchor in anchors(ROOT / "docs" / page), f"{where} cites docs/{page}#{anchor}"


def test_the_files_that_pages_send_people_to_are_there() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    named = {
        name
        for page in pages
        for name in re.findall(
            r"`((?:skincad|templates|tests|bench|examples|docs)/[\w/.-]+)`", page.read_text()
        )
    }
    assert len(named) > 30
    assert [name for name in sorted(named) if not (ROOT / name).exists()] == []


def test_the_programs_that_pages_name_are_there() -> None:
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    named = {
        name
        for page in pages
        for name in re.findall(r"python -m\s+bench\.(\w+)|`((?:bench|table)_\w+)`", page.read_text())
    }
    for name in {"".join(pair) for pair in named} - {"NAME"}:
        assert list((ROOT / "bench").glob(f"{name}*")), name


def keys(model: Any, path: str = "") -> Iterator[str]:
    """Every key of a table and of the tables within, joined by dots."""
    rows, inner = table_entries(model)
    yield from (f"{path}{key}" for key, *_ in rows)
    for key, table in inner.items():
        yield f"{path}{key}"
        yield from keys(table, f"{path}{key}.")


def test_the_keys_that_pages_name_are_there() -> None:
    known = {key for model in (Design, Scene, Circuit) for key in keys(model)}
    known |= {key for name in EFFECTS for key in (f"effects.{name}", *keys(effect(name), f"effects.{name}."))}
    tables = {key.partition(".")[0] for key in known} - {"name", "film"}  # `film/` is a folder too
    named = {
        name.removeprefix("skin.") if name.removeprefix("skin.") in known else name
        for page in (ROOT / "docs").rglob("*.md")
        for name in re.findall(
            r"`(?:--set )?([a-z]+(?:\.[a-z_]+)+)(?:\.\d+)?(?: ?=[^`]*)?`", page.read_text()
        )
        if name.partition(".")[0] in tables and name.partition(".")[2] not in FILES
    }
    assert len(named) > 40
    assert {name.removeprefix("circuit.") for name in named} - known == set()


def difference(one: Path, other: Path, size: tuple[int, int]) -> float:
    """Mean difference of two pictures, grey, of 255."""
    shown, drawn = (np.asarray(Image.open(p).convert("L").resize(size), dtype=float) for p in (one, other))
    return float(np.abs(shown - drawn).mean())


@pytest.mark.slow
def test_the_labelled_section_is_what_the_program_draws(tmp_path: Path) -> None:
    geometry_plot(tmp_path / "geometry.png")
    # its font ships with matplotlib, so only rounding differs; a tilt of 20 for 14 degrees makes 0.6
    picture = ROOT / "docs/understand/geometry.png"
    assert difference(picture, tmp_path / "geometry.png", (275, 215)) < 0.2


@pytest.mark.slow
def test_readmes_picture_is_what_the_program_draws(made: Made) -> None:
    # other fonts move letters by a pixel or two: 0.3; tilted strips already make 1.1, a lower ridge 1.9
    assert difference(ROOT / "README.png", made.folder / "picture.png", (363, 203)) < 0.6


@pytest.mark.slow
def test_readme_explains_every_file_of_a_make(made: Made) -> None:
    table = README.split("## What you get")[1].split("\n## ")[0]
    written = [name for name, _ in made.written.files]
    for name in written:
        stem, _, kind = name.rpartition(".")
        of_part = f"solids/{Path(stem).name}.step" in written  # not each part is named
        assert f"`{name}`" in table or (of_part and f".{kind}`" in table), name


def test_readme_is_short_and_shows_every_command() -> None:
    assert len(README.splitlines()) <= 110
    for command in app.registered_commands:
        assert f"skincad {command.name or command.callback.__name__}" in README


def glossary() -> list[tuple[str, str]]:
    """Entries of the glossary: words, and places in the code, which follow the meaning."""
    page = (ROOT / "docs/reference/glossary.md").read_text(encoding="utf-8")
    return re.findall(r"^- \*\*(.+?)\*\*: .+?\. (`.+)$", page, re.M)


def test_the_glossary_points_to_what_is_there_and_explains_a_word_once() -> None:
    package = ROOT / "skincad"
    code = "".join(path.read_text(encoding="utf-8") for path in package.rglob("*.py"))
    classes = {*re.findall(r"^class (\w+)", code, re.MULTILINE)}
    places = [place for _, where in glossary() for place in re.findall(r"`([^`]+)`", where)]
    assert len(places) > 50
    for place in places:
        assert (package / place).exists() if "/" in place else place in classes, place
    words = [word for entry, _ in glossary() for word in entry.split(", ")]
    assert {word for word in words if words.count(word) > 1} == {"lead"}  # of a strip, and in time
