"""Free text of other people's files: in a table, a sheet and a page it stays text, whatever its letters."""

from __future__ import annotations

import csv
import io
import random
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from markdown_it import MarkdownIt

import skincad
from skincad.base import csv_text, markdown_text, shown
from skincad.fabrication import Build, Job, coupon_sheet, design_findings
from skincad.fabrication.coupon import coupon
from skincad.inputs import Design
from skincad.outputs import Package, links, makes, markdown, sweep_csv, sweep_page
from skincad.outputs.report import report

PIECES = (
    *"=+-@\t\r\n'\",;|`*_#>\\&",
    "~~",
    *("<b>", "<script>alert(1)</script>", "<img src=x onerror=alert(1)>", "[a](http://b.c)", "![a](b)"),
    *("http://a.bc", "www.a.bc", "<a@b.cd>", "&lt;", "&#106;", "1. ", "2) ", "---", "===", "```", "    "),
    *("a", "b", " ", "5", "0.5", "é", "日", "\u202e", "\x1b[2J", "cmd|'/c calc'!A1", "HYPERLINK(A1)", "$x$"),
)
texts = st.lists(st.sampled_from(PIECES), min_size=1, max_size=6).map("".join) | st.text(max_size=12)
READER = (
    MarkdownIt("commonmark", {"html": True}).enable("table").enable("strikethrough")
)  # takes all there is


class Text(HTMLParser):
    """A page's tags and its text."""

    def __init__(self, page: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[str] = []
        self.text = ""
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, _: object) -> None:
        self.tags.append(tag)

    def handle_data(self, data: str) -> None:
        self.text += data


@settings(max_examples=200, deadline=None, derandomize=True)
@given(texts)
def test_markdown_shows_any_text_as_it_is(text: str) -> None:
    """At the head of a paragraph, in a list, in a head and in a table's cell."""
    markdown, plain = markdown_text(text), shown(text).strip()
    for head, tail, tags in (("", ", 5", ["p"]), ("- ", " x", ["ul", "li"]), ("# ", " y", ["h1"])):
        page = Text(READER.render(f"{head}{markdown}{tail}\n"))
        assert page.tags == tags
        assert page.text.strip() == f"{plain}{tail}".strip()
    cells = Text(READER.render(f"| a | b |\n|---|---|\n| {markdown} | 1 |\n"))
    assert (cells.tags.count("td"), {*cells.tags}) == (2, {"table", "thead", "tbody", "tr", "th", "td"})
    assert "".join(cells.text.split()) == "ab" + "".join(f"{plain}1".split())


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.lists(texts, min_size=1, max_size=3), st.floats(allow_nan=False, allow_infinity=False))
def test_csv_shows_any_text_and_keeps_numbers(row: list[str], number: float) -> None:
    numbers = [f"{number:.4g}", repr(number), number]
    *read, formatted, written, as_number = read_back(csv_text([[*row, *numbers]]))[0]
    assert (float(formatted), float(written), float(as_number)) == (float(numbers[0]), number, number)
    for cell, text in zip(read, row, strict=True):
        assert cell.replace("\r\n", "\n").removeprefix("'") == text.replace("\r\n", "\n").removeprefix("'")
        assert not cell.startswith(("=", "+", "-", "@", "\t", "\r")) or float(cell) == float(text)


def read_back(text: str) -> list[list[str]]:
    return [*csv.reader(io.StringIO(text, newline=""))]


def hostile_names(count: int) -> Iterator[str]:
    """Names of silicones, 64 letters at most, each of which would do something somewhere."""
    yield from (
        '=HYPERLINK("http://a.bc","x")',
        "<img src=x onerror=alert(1)>",
        "-1+1|x",
        "\n# head\n![a](b)",
    )
    dice = random.Random(18)
    for _ in range(count):
        yield "".join(dice.choices(PIECES, k=dice.randint(2, 6)))[:64]


@pytest.fixture(scope="module")
def build() -> Build:
    """Three ridges, printed in resin of which the sheet warns: the silicone's name is in a finding too."""
    settings = [
        "ridge.count=3",
        "skin.width=5",
        "mold.process=sla",
        "silicones.own={based_on='ecoflex-00-30'}",
    ]
    design = skincad.load("yamada-2002", settings)
    design = design.with_(material={"name": "own"})
    job = Job(design)
    return Build(job, {}, None, tuple(design_findings(job)), None, ())


def called(design: Design, name: str) -> Design:
    return design.with_(silicones={"own": {"based_on": "ecoflex-00-30", "name": name}})


HOSTILE = pytest.mark.evidence(subject="hostile names")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[] if i < 2 or "|" in name else [HOSTILE])
        for i, name in enumerate(hostile_names(20))
    ],
)
def test_a_silicones_name_stays_text_in_every_file(name: str, build: Build, tmp_path: Path) -> None:
    design = called(build.design, name)
    renamed = Job(design, build.closed)
    build = replace(build, job=renamed, findings=tuple(design_findings(renamed)))
    assert any(name in finding.where for finding in build.findings)
    plain = shown(name).strip()
    writers = makes.writers(design, build.closed, solids=False)
    written = {file: tmp_path / file for file in ("casting-sheet.md", "casting-sheet.html", "parts-list.csv")}
    for file, path in written.items():
        writers[file](build, path)

    sheet = written["casting-sheet.md"].read_text("utf-8")
    kit = coupon("sla", "own", silicones={"own": {"based_on": "ecoflex-00-30", "name": name}})
    card = Package(
        design=design,
        kinds=("urdf",),
        weighs=links(design),
        surfaces={},
        **dict.fromkeys(("springs", "taxels", "response", "mesh", "heights")),
        notes=(name,),
        seconds={},
    )
    for text in (sheet, coupon_sheet(kit), markdown(card)):
        page, usual = (Text(READER.render(t)) for t in (text, text.replace(markdown_text(name), "own")))
        assert page.tags == usual.tags
        assert plain in page.text

    pages = written["casting-sheet.html"].read_text("utf-8"), report(build, lambda: b"\x89PNG", sheet, "")
    for page in pages:
        assert "<img src=x" not in page
        assert "<script>alert" not in page
        assert plain in Text(page).text

    rows = read_back(written["parts-list.csv"].read_bytes().decode())
    (cell,) = [row[3] for row in rows if row[2:3] == ["silicone"]]
    assert cell.removeprefix("'") == name.removeprefix("'")
    assert not any(cell.startswith(("=", "+", "-", "@", "\t", "\r")) for row in rows for cell in row)


def test_a_choice_of_a_sweep_stays_text() -> None:
    names = [*hostile_names(2)][:5]
    design = skincad.load("plain-ridges", ["silicones.own={based_on='ecoflex-00-30'}", "material.name=own"])
    sweep = skincad.sweep(design, {"silicones.own.name": names}, model="winkler")
    head, *rows = read_back(sweep_csv(sweep))
    cells = [row[head.index("silicones.own.name")] for row in rows]
    assert [cell.removeprefix("'") for cell in cells] == names
    assert not any(cell.startswith(("=", "+", "-", "@", "\t", "\r")) for cell in cells)
    assert Text(sweep_page(sweep)).tags.count("img") == 0
    assert "<script>alert" not in sweep_page(sweep)
