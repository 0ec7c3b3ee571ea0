"""A live page in Chromium that finds no host but this one, and hands that move its sliders."""

from __future__ import annotations

import random
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import Any

from playwright.sync_api import BrowserContext, Locator, Page, sync_playwright

from tests.outputs.browser import ARGUMENTS as ALONE
from tests.outputs.browser import CHROMIUM

ARGUMENTS = [*ALONE[:-1], f"{ALONE[-1]} , EXCLUDE 127.0.0.1"]  # no other host is ever found
PATIENCE = 120_000  # ms, for a page on a machine with much else to do


@dataclass
class Looking:
    """A browser's view of a page, with what it asked for and complained of."""

    page: Page
    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def row(self, label: str, place: int = 0) -> Locator:
        """The row of an input by its label; several tables may have one of the same name."""
        return self.page.locator(f"label:text-is('{label}')").nth(place).locator("xpath=../../..")

    def write(self, label: str, value: str, place: int = 0) -> None:
        """Write a value into the field beside a slider."""
        box = self.row(label, place).locator("input[type=text]")
        box.fill(value)
        box.press("Enter")

    def slide(self, label: str, share: float, place: int = 0) -> None:
        """Click on a slider at a share of its length."""
        slid(self.row(label, place).locator(".mantine-Slider-trackContainer"), share)

    def value(self, label: str, place: int = 0) -> str:
        return self.row(label, place).locator("input[type=text]").input_value()

    def press(self, words: str) -> None:
        self.page.get_by_role("button", name=words, exact=True).click()

    def fold(self, words: str) -> None:
        """Open or close a folder by its name."""
        self.page.get_by_text(words, exact=True).first.click()

    def wait_for(self, words: str) -> None:
        self.page.get_by_text(words).first.wait_for(timeout=PATIENCE)

    def anything(self, dice: random.Random) -> None:
        """Click somewhere on some slider that is in sight."""
        every = self.page.locator(".mantine-Slider-trackContainer:visible")
        slid(every.nth(dice.randrange(1, every.count())), dice.random())


def slid(slider: Locator, share: float) -> None:
    slider.scroll_into_view_if_needed()
    box: Any = slider.bounding_box()
    slider.page.mouse.click(box["x"] + share * box["width"], box["y"] + 0.5 * box["height"])


@contextmanager
def looking(
    address: str, count: int = 1, program: str = CHROMIUM, first: str = "Section:"
) -> Iterator[list[Looking]]:
    """Open a page in so many browsers at once, until it has the words `first`."""
    with (
        sync_playwright() as driver,
        driver.chromium.launch(executable_path=program, args=ARGUMENTS) as browser,
    ):
        yield [
            _opened(browser.new_context(viewport={"width": 1000, "height": 600}), address, first)
            for _ in range(count)
        ]


def _opened(context: BrowserContext, address: str, first: str) -> Looking:
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    seen = Looking(page)
    context.on("request", lambda asked: seen.requests.append(asked.url))
    page.on("pageerror", lambda failure: seen.complaints.append(str(failure)))
    page.on("console", lambda said: seen.complaints.append(said.text) if said.type == "error" else None)
    page.goto(address)
    seen.wait_for(first)
    return seen
