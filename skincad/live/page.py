"""The page in the browser, by viser: sliders beside it, the skin and its mold in it, verdicts on its left.

All browsers that look at a page see the same design and may all move it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from html import escape
from io import StringIO
from traceback import print_exc
from typing import Any

import numpy as np
import viser

from skincad.inputs.design import Design
from skincad.live.controls import Panel
from skincad.live.desk import Desk
from skincad.live.guard import own_pages_only
from skincad.live.plots import history_plot, signals_plot, with_point, without_point
from skincad.live.session import Editable
from skincad.live.shapes import DesignView, Piece
from skincad.live.words import findings_html, making_html, signals_html, state_html, text_html, verdict_html
from skincad.scenes.scene import Scene

STALE = (184, 184, 189)  # colour of a skin that does not have the wanted values
BESIDE = 0.35  # of the mold's width, between skin and mold
LEFT, RIGHT = 380, 340  # px, of the panels
PLOT_HEIGHT = 200  # px


class Page:
    """A desk's page on a server that listens at `host` and `port`."""

    def __init__(self, subject: Editable, source: str, host: str, port: int) -> None:
        with redirect_stdout(StringIO()), own_pages_only(host):  # without viser's own banner
            self.server = viser.ViserServer(host, port, label=f"skincad live: {subject.name}", verbose=False)
        self.desk = Desk(subject, source, self._changed)
        self._pieces: dict[str, Any] = {}
        self._mold_x = 0.0  # mm along x, where the mold stands
        self._saved = ""
        self._colour: tuple[int, int, int] | None = None
        with self.desk.lock:
            self._lay_out()
        self.desk.begin()

    def close(self) -> None:
        """End the page and what runs beside it."""
        self.desk.close()
        with redirect_stdout(StringIO()):
            self.server.stop()

    def _lay_out(self) -> None:
        gui, scene = self.server.gui, self.server.scene
        gui.configure_theme(show_logo=False, show_share_button=False, control_width="large")
        scene.set_up_direction("+z")
        scene.world_axes.visible = False
        self._state = gui.add_html("", order=1.0)  # the main panel: a telephone shows it first
        self._section = gui.add_html("", order=2.0)
        self._plots: dict[str, Any] = {}
        self._verdict = gui.add_html("", order=5.0)
        self._findings = gui.add_html("", order=6.0)
        gui.main_panel.dock_left()
        gui.main_panel.set_width(LEFT)
        beside = gui.add_panel()
        sliders = beside.add_tab("Sliders")
        beside.dock_right()
        beside.set_width(RIGHT)
        with sliders:
            self._add_buttons(gui)
            if isinstance(self.desk.session.subject, Design):
                self._add_view(gui)
            else:
                self._add_points(gui)
        self._panel = Panel(gui, sliders, self.desk, self.guarded)
        self._changed("session")

    def _add_buttons(self, gui: Any) -> None:
        back = gui.add_button_group("", ("Undo", "Redo"), order=-9.0)
        back.on_click(self.guarded(lambda: self.desk.undo() if back.value == "Undo" else self.desk.redo()))
        design = isinstance(self.desk.session.subject, Design)
        folder = gui.add_folder("Save and make" if design else "Save", order=-8.0, expand_by_default=False)
        with folder:
            self._file = gui.add_text("file", f"{self.desk.session.subject.name}-live.toml")
            gui.add_button("Save as TOML").on_click(self.guarded(self._save))
            if design:
                gui.add_button("Make its files").on_click(self.guarded(self.desk.make))
            self._making = gui.add_html("")

    def _add_view(self, gui: Any) -> None:
        with gui.add_folder("View", order=-7.0):
            self._with_mold = gui.add_checkbox("mold", True, hint="Show the mold beside the skin.")
            self._apart = gui.add_slider("taken apart", 0.0, 1.0, 0.01, 0.5)
        for shown in (self._with_mold, self._apart):
            shown.on_update(self.guarded(self._place))

    def _add_points(self, gui: Any) -> None:
        with gui.add_folder("Points of the history", order=-7.0):
            points = gui.add_button_group("", ("Add a point", "Remove the last"))

        def edit() -> None:
            scene = self.desk.session.subject
            assert isinstance(scene, Scene)
            self.desk.move((with_point if points.value == "Add a point" else without_point)(scene.history))

        points.on_click(self.guarded(edit))

    def guarded(self, call: Callable[[], None]) -> Callable[[Any], None]:
        """Return what a button or slider calls when somebody, not this program, moved it: one at a time, so
        that the newest value is the last; its failure is said on the page."""

        def called(event: Any) -> None:
            if event.client is None:
                return
            try:
                with self.desk.lock:
                    call()
            except Exception as failure:  # no click may end a page
                self._tell(self._state, f"<b>{type(failure).__name__}</b>: {escape(str(failure))}")
                print_exc(file=sys.stderr)

        return called

    def _save(self) -> None:
        self._saved = self.desk.save(self._file.value)
        self._changed("making")

    def _changed(self, kind: str) -> None:
        """Show what changed; the desk calls one at a time."""
        desk = self.desk
        if kind == "session":
            self._panel.refresh()
            self._tell(self._state, state_html(desk.session))
            self._tint()
        if kind == "view" and desk.view is not None:
            self._show(desk.view.what)
        if kind == "quiet":
            self._panel.widen()
        if kind == "findings":
            self._tell(self._findings, findings_html(desk))
        if kind == "making":
            self._tell(self._making, making_html(desk, self._saved))
        if kind in ("session", "view", "signals"):
            self._plot()
        if isinstance(desk.session.subject, Design):
            self._tell(self._verdict, verdict_html(desk))
            if kind in ("session", "view"):
                self._tell(self._findings, findings_html(desk))
        else:
            self._tell(self._verdict, signals_html(desk))

    def _plot(self) -> None:
        """Plot a scene's history as it is, and the newest signals."""
        scene, signals = self.desk.session.subject, self.desk.signals
        if isinstance(scene, Scene):
            self._draw("history", history_plot(scene.history), 3.0)
            if signals is not None and signals.what.stress:
                self._draw("S1 - S2", signals_plot(signals.what, fresh=self.desk.is_current(signals)), 4.0)

    def _draw(self, title: str, plot: dict[str, Any], order: float) -> None:
        if title in self._plots:
            for key, value in plot.items():
                setattr(self._plots[title], key, value)
        else:
            gui = self.server.gui
            self._plots[title] = gui.add_uplot(**plot, title=title, height=PLOT_HEIGHT, order=order)

    def _tell(self, place: Any, text: str) -> None:
        place.content = text_html(text)

    def _show(self, shown: DesignView) -> None:
        first = not self._pieces
        self._tell(self._section, shown.section)
        wide = max((float(np.abs(piece.corners[:, 0]).max()) for piece in shown.mold), default=0.0)
        self._mold_x = shown.design.skin.width / 2 + wide * (1 + BESIDE)
        with self.server.atomic():
            for name in set(self._pieces) - {"skin", *(piece.name for piece in shown.mold)}:
                self._pieces.pop(name)[1].remove()
            for piece in (shown.skin, *shown.mold):
                self._put(piece)
            self._place()
            self._tint()
        if first:
            self._look()

    def _put(self, piece: Piece) -> None:
        if piece.name in self._pieces:
            handle = self._pieces[piece.name][1]
            handle.vertices, handle.faces = piece.corners, piece.faces
        else:
            handle = self.server.scene.add_mesh_simple(
                f"/{piece.name.replace(' ', '-')}",
                piece.corners,
                piece.faces,
                color=piece.colour,
                flat_shading=True,
                opacity=0.55 if piece.label in ("carrier", "cover") else None,
                side="double",
            )
        self._pieces[piece.name] = piece, handle

    def _place(self) -> None:
        """Put the mold's parts where they are shown."""
        for piece, handle in self._pieces.values():
            if piece.name != "skin":  # a design's alone
                handle.visible = self._with_mold.value
                away = self._apart.value * np.array(piece.offset)
                handle.position = away + np.array([self._mold_x, 0.0, 0.0])

    def _tint(self) -> None:
        """Grey the skin while it does not have the wanted values."""
        if "skin" in self._pieces:
            piece, handle = self._pieces["skin"]
            colour = STALE if self.desk.session.refusal is not None else piece.colour
            if colour != self._colour:
                self._colour = handle.color = colour

    def _look(self) -> None:
        """Let a browser that opens the page see all of it."""
        corners = np.vstack(
            [piece.corners + np.array(handle.position) for piece, handle in self._pieces.values()]
        )
        low, high = corners.min(axis=0), corners.max(axis=0)
        middle, away = (low + high) / 2, float(np.linalg.norm(high - low)) * np.array([-0.35, -1.0, 0.55])
        camera = self.server.initial_camera
        camera.look_at, camera.position = tuple(middle), tuple(middle + away)
