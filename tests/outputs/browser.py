"""Pages as a browser without a network shows them: Chromium, driven from outside."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from skincad.base.arrays import Array

CHROMIUM = "/usr/bin/chromium"
# WebGL by the processor, and no name of a host is ever found
ARGUMENTS = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--host-resolver-rules=MAP * ~NOTFOUND",
]


@dataclass
class Seen:
    """A page, and what it has asked for and complained of so far."""

    page: Page
    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)

    def picture(self, selector: str = "#stage canvas") -> Array:
        """What an element shows, `(height, width, 3)` from 0 to 255."""
        shot = self.page.locator(selector).screenshot()
        return np.asarray(Image.open(io.BytesIO(shot)).convert("RGB"), dtype=float)

    def drawn(self) -> float:
        """Which share of the stage is not background."""
        return float((self.picture().min(axis=2) < 250).mean())


@contextmanager
def shown(file: Path) -> Iterator[Seen]:
    """Open a file in Chromium."""
    with (
        sync_playwright() as driver,
        driver.chromium.launch(executable_path=CHROMIUM, args=ARGUMENTS) as browser,
    ):
        page = browser.new_context(offline=True, viewport={"width": 900, "height": 700}).new_page()
        seen = Seen(page)
        page.on("request", lambda asked: seen.requests.append(asked.url))
        page.on("console", lambda said: seen.complaints.append(f"{said.type}: {said.text}"))
        page.on("pageerror", lambda failure: seen.complaints.append(str(failure)))
        page.goto(file.as_uri())
        yield seen
