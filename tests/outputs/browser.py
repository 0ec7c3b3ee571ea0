"""Pages as a browser without a network shows them: Chromium, driven from outside."""

from __future__ import annotations

import io
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from playwright.sync_api import Page, sync_playwright

from skincad.base import Array

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

    def overflow(self) -> int:
        """By how many pixels the page is wider than its window."""
        root = "document.documentElement"
        return int(self.page.evaluate(f"{root}.scrollWidth - {root}.clientWidth"))

    def touch(self, *strokes: tuple[tuple[float, float], tuple[float, float]]) -> None:
        """Move a finger for each stroke, from its start to its end, all at once."""
        session = self.page.context.new_cdp_session(self.page)

        def send(kind: str, share: float) -> None:
            places = [np.array(start) * (1 - share) + np.array(end) * share for start, end in strokes]
            points = [{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)]
            event = {"type": kind, "touchPoints": [] if kind == "touchEnd" else points}
            session.send("Input.dispatchTouchEvent", event)

        send("touchStart", 0.0)
        for step in range(1, 9):
            send("touchMove", step / 8)
            self.page.wait_for_timeout(30)
        send("touchEnd", 1.0)
        self.page.wait_for_timeout(100)

    def drawn(self) -> float:
        """Which share of the stage is not background."""
        return float((self.picture().min(axis=2) < 250).mean())


@contextmanager
def shown(
    file: Path, size: tuple[int, int] = (900, 700), *, touch: bool = False, flat: bool = False
) -> Iterator[Seen]:
    """Open a file in Chromium, in a window of `size` pixels; `flat` without WebGL."""
    arguments = ["--no-sandbox", "--disable-3d-apis"] if flat else ARGUMENTS
    with (
        sync_playwright() as driver,
        driver.chromium.launch(executable_path=CHROMIUM, args=arguments) as browser,
    ):
        window: dict[str, Any] = {"viewport": {"width": size[0], "height": size[1]}, "has_touch": touch}
        page = browser.new_context(offline=True, **window).new_page()
        seen = Seen(page)
        page.on("request", lambda asked: seen.requests.append(asked.url))
        page.on("console", lambda said: seen.complaints.append(f"{said.type}: {said.text}"))
        page.on("pageerror", lambda failure: seen.complaints.append(str(failure)))
        page.goto(file.as_uri())
        yield seen
