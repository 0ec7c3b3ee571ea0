"""Papers and words of four designs as they were: `python -m bench.compare --golden` writes them anew."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import skincad
from bench import compare
from skincad.inputs import Design
from tests.conftest import Made

OTHERS = [name for name in compare.GOLDEN_DESIGNS if name != "yamada-2002"]


@pytest.mark.dear("meshes and their interference; all words of a design's papers hang on it")
def test_papers_of_yamada(yamada: Design, tmp_path: Path) -> None:
    """Of a preview, to which the check is added: solids, which these papers don't show, take seconds."""
    preview = skincad.make(yamada, preview=True)
    check = skincad.check(yamada, model="winkler")
    build = replace(preview.built(), check=check)
    result = replace(preview, check=check, preview=False, solids=True, build=build)
    skincad.write(result, tmp_path / "out", formats=("md", "csv"))
    texts = compare.golden_papers(result, tmp_path / "out")
    golden = {name: text for name, text in compare.kept("yamada-2002").items() if name in texts}
    assert [*compare.text_differences(golden, texts)] == []
    assert {"casting-sheet.md", "parts-list.csv", "order-edm.md", "check.txt"} <= texts.keys()


@pytest.mark.slow
def test_drawings_and_report_of_yamada(made: Made) -> None:
    texts = compare.golden_texts(made.result, made.folder)
    assert [*compare.text_differences(compare.kept("yamada-2002"), texts)] == []


@pytest.mark.evidence(subject="{name}")
@pytest.mark.parametrize("name", OTHERS)
def test_papers_of_other_kinds(name: str, tmp_path: Path) -> None:
    texts = compare.golden_texts(compare.golden_make(name, tmp_path), tmp_path)
    assert [*compare.text_differences(compare.kept(name), texts)] == []


def test_listings_of_templates() -> None:
    assert [*compare.text_differences(compare.kept("templates"), compare.golden_listings())] == []


@pytest.mark.parametrize(
    ("now", "same"),
    [
        ("a sheet of 1.5 mm, 6214.65 mm3", True),
        ("a sheet of 1.5 mm, 6220.00 mm3", True),  # 0.9 in a thousand
        ("a sheet of 1.5 mm, 6222.00 mm3", False),  # 1.2
        ("a sheet of 1.6 mm, 6214.65 mm3", False),
        ("one sheet of 1.5 mm, 6214.65 mm3", False),
        ("a sheet of 1.5 mm, 6214.65 mm3, more 1", False),
    ],
)
def test_words_and_all_but_a_fourth_digit_count(now: str, same: bool) -> None:
    golden = {"sheet": "a sheet of 1.5 mm, 6214.65 mm3\nend"}
    assert (not [*compare.text_differences(golden, {"sheet": f"{now}\nend"})]) == same


def test_missing_lines_and_texts_are_seen() -> None:
    (line,) = compare.text_differences({"sheet": "a\nb\n"}, {"sheet": "a\n"})
    assert line == "sheet: line 2: 'b' -> '(no line)'"
    assert [*compare.text_differences({"sheet": "a"}, {})] == ["sheet: line 1: 'a' -> '(no such text)'"]


def test_machines_and_versions_are_masked_and_curing_times_are_not() -> None:
    text = "by skincad 1.2.3, revision 0c920867; mesh within 0.93 um; 48 h, 97 s each"
    assert compare.masked(text) == (
        "by skincad VERSION, revision REVISION; mesh within DEVIATION; 48 h, 97 s each"
    )
    assert compare.masked("about 1.3 s", timed=True) == "about TIME"


def test_pages_are_read_without_scripts_and_pictures(tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    page.write_text("<style>a</style><p>1 &lt; 2</p>\n<script>b</script><svg><text>R  25</text></svg>")
    assert compare.page_text(page) == "1 < 2\nR 25\n"
