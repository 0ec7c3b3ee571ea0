"""The built site: nothing is from another host, it opens from files, and its reference is whole."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from mkdocs.commands.build import build
from mkdocs.config import load_config

import skincad
from bench.docs_reference import RESULTS
from skincad.cli.app import app
from skincad.inputs import Flat, Pin, Pocket, Ridge, Ring
from tests.outputs.browser import shown

pytestmark = pytest.mark.slow  # building it takes seconds

ROOT = Path(__file__).parent.parent
LOADED = re.compile(
    r"""<(?:script|img|iframe|source)\b[^>]*\bsrc=["']?((?:https?:)?//[^"' >]+)"""
    r"""|<link\b[^>]*\bhref=["']?((?:https?:)?//[^"' >]+)"""
    r"""|url\(["']?((?:https?:)?//[^"')]+)|@import\s+["']((?:https?:)?//[^"']+)"""
)
IN_SCRIPTS = re.compile(r"""["'`]((?:https?:)?//[\w.-]+\.\w+/[^"'`]*)["'`]""")
NEVER = (  # addresses in the theme's script for pages that this site has not
    "https://unpkg.com/mermaid",  # diagrams
    "https://unpkg.com/resize-observer-polyfill",  # browsers without ResizeObserver, before 2020
    "https://api.github.com/",  # a link to a repository
)


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    build(load_config(str(ROOT / "mkdocs.yml"), site_dir=str(folder), strict=True))
    return folder


def test_nothing_is_loaded_from_another_host(site: Path) -> None:
    files = [path for path in site.rglob("*") if path.suffix in (".html", ".css", ".js", ".svg")]
    assert len(files) > 40
    for path in files:
        text = path.read_text("utf-8")
        if path.suffix == ".js":
            found = [url for url in IN_SCRIPTS.findall(text) if not url.startswith(NEVER)]
        else:
            found = ["".join(groups) for groups in LOADED.findall(text)]
        if path.name != "search_index.js":  # text of the pages
            assert not found, (path.name, found)


def test_it_opens_and_searches_from_files(site: Path) -> None:
    with shown(site / "index.html") as seen:
        seen.page.get_by_label("Search", exact=True).first.press_sequentially("levelling")
        results = seen.page.locator(".md-search-result__item a")
        results.first.wait_for(timeout=30_000)
        seen.page.goto(results.first.evaluate("link => link.href"))
        assert "levelling" in seen.page.inner_text("article").lower()
        assert seen.complaints == []
        assert {url.split(":")[0] for url in seen.requests} <= {"file", "data", "blob"}


@pytest.mark.dear("a browser opens each page twice")
def test_no_page_is_wider_than_its_window(site: Path) -> None:
    beyond = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    with shown(site / "index.html") as seen:
        for width in (420, 1400):  # before a page is laid out: it may follow a later change slowly
            seen.page.set_viewport_size({"width": width, "height": 900})
            for file in sorted(site.rglob("*.html")):
                seen.page.goto(file.as_uri())
                assert seen.page.evaluate(beyond) <= 0, (file.name, width)


def test_reference_has_every_command_option_name_and_key(site: Path) -> None:
    pages = {
        name: (site / "reference" / f"{name}.html").read_text("utf-8")
        for name in ("cli", "python", "toml", "json")
    }
    for command in app.registered_commands:
        assert f"skincad {command.name}" in pages["cli"]
    for option in ("--grippers", "--no-advice", "--gauge-length"):
        assert option in pages["cli"]
    for name in skincad.__all__:
        assert f"skincad.{name}" in pages["python"], name
    tables = (Ridge, Ring, Pin, Flat, Pocket)
    keys = {key for table in tables for key in table.model_fields}
    for key in (*keys, "effects.piezo", "pixel"):
        assert key in pages["toml"], key
    for command in RESULTS:
        assert f"skincad {command}" in pages["json"]
    for key in ("all_touch_force_N", "ridge_slip_step", "front", "growth_mm"):
        assert f"<code>{key}</code>" in pages["json"], key
