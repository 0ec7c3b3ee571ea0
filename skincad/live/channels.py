"""The page of `skincad listen`: what the films' channels say now, and the alarms, in the browser."""

from __future__ import annotations

from collections import deque
from contextlib import redirect_stdout
from importlib.util import find_spec
from io import StringIO
from time import monotonic
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.base.errors import InputError
from skincad.detector.listening import Listener
from skincad.detector.wire import Block
from skincad.live.guard import own_pages_only
from skincad.live.plots import channels_plot
from skincad.live.serve import PORT, free_port
from skincad.live.words import listening_html, text_html

HOST = "127.0.0.1"
SPAN = 5.0  # s shown
POINTS = 400  # of a curve: the least and the largest of each of half as many stretches
REDRAW = 0.25  # s of the clock between two pictures
LATEST = 12  # alarms listed
WIDTH, HEIGHT = 760, 130  # px, of the panel and of a ridge's plot


class ChannelsPage:
    """A page of the last SPAN of all channels, less their resting voltage, and of what was heard.

    `plots` are by ridge. `update` takes blocks as they come and redraws every REDRAW. Raises InputError
    without the package viser.
    """

    def __init__(self, listener: Listener, name: str) -> None:
        if find_spec("viser") is None:
            raise InputError("page", "needs the package viser", remedy="pip install 'skincad[live]'")
        import viser

        self.listener, self.name, self.port = listener, name, free_port(HOST, PORT)
        with redirect_stdout(StringIO()), own_pages_only(HOST):  # without viser's own banner
            self.server = viser.ViserServer(HOST, self.port, label=f"skincad listen: {name}", verbose=False)
        self._latest = deque[dict[str, Any]](maxlen=LATEST)
        self._parts, self._drawn = deque[tuple[Array, Array]](), 0.0
        self.plots = dict[int, Any]()
        gui = self.server.gui
        gui.configure_theme(show_logo=False, show_share_button=False)
        self.server.scene.world_axes.visible = False
        self._html = gui.add_html("", order=0.0)
        gui.main_panel.dock_left()
        gui.main_panel.set_width(WIDTH)
        self._tell()

    @property
    def address(self) -> str:
        """Where it is served."""
        return f"http://{HOST}:{self.port}"

    def update(self, block: Block, events: list[dict[str, Any]]) -> None:
        """Take a block and its events."""
        if block.begins:
            self._parts.clear()
        self._parts.append((block.times, block.values))
        self._latest.extend(events)
        while self._parts[-1][0][-1] - self._parts[0][0][-1] > SPAN:
            self._parts.popleft()
        if monotonic() - self._drawn > REDRAW:
            self.draw()

    def draw(self) -> None:
        """Show what is there now."""
        self._drawn = monotonic()
        self._tell()
        if not self._parts or self.listener.rest is None:
            return
        time, values = (np.concatenate(part) for part in zip(*self._parts, strict=True))
        recent = time > time[-1] - SPAN
        stamps, curves = envelope(time[recent], values[recent] - self.listener.rest)
        with self.server.atomic():
            for place, ridge in enumerate(self.listener.detector.ridges):
                plot = channels_plot(stamps, *curves[:, 2 * place : 2 * place + 2].T)
                if ridge in self.plots:
                    self.plots[ridge].data = plot["data"]
                else:
                    gui = self.server.gui
                    self.plots[ridge] = gui.add_uplot(
                        **plot, title=f"ridge {ridge}", height=HEIGHT, order=float(place + 1)
                    )

    @property
    def words(self) -> str:
        """Return its text, HTML."""
        return str(self._html.content)

    def close(self) -> None:
        """End the page."""
        with redirect_stdout(StringIO()):
            self.server.stop()

    def _tell(self) -> None:
        self._html.content = text_html(listening_html(self.name, self.listener, list(self._latest)[::-1]))


def envelope(time: Array, values: Array) -> tuple[Array, Array]:
    """Return at most POINTS times and values `(n, channels)` that show each peak: of stretches of equal
    length the least and then the largest value."""
    size = -(-time.size // (POINTS // 2))
    if size <= 2:
        return time, values
    whole = time.size // size * size
    stretches = values[:whole].reshape(-1, size, values.shape[1])
    ends = np.stack([stretches.min(axis=1), stretches.max(axis=1)], axis=1)
    stamps = time[:whole].reshape(-1, size)[:, [0, size // 2]]
    return stamps.ravel(), ends.reshape(-1, values.shape[1])
