"""The page in the browser, by viser: sliders beside it, the skin and its mold in it, verdicts on its left.

All browsers that look at a page see the same design and may all move it.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from html import escape
from io import StringIO
from time import perf_counter
from traceback import print_exc
from typing import Any

import numpy as np
import viser

from skincad.inputs.design import Design
from skincad.live.board import HistoryBoard, board_of
from skincad.live.controls import Panel
from skincad.live.desk import Desk
from skincad.live.guard import own_pages_only
from skincad.live.session import Editable
from skincad.live.shapes import DesignView, Piece
from skincad.live.words import findings_html, making_html, signals_html, state_html, text_html, verdict_html
from skincad.scenes.scene import Scene

STALE = (0.72, 0.72, 0.74)  # colour of a skin that does not have the wanted values
BESIDE = 0.35  # of the mold's width, between skin and mold
LEFT, RIGHT = 380, 340  # px, of the panels


class Page:
    """A desk's page on a server that listens at `host` and `port`."""

    def __init__(self, subject: Editable, source: str, host: str, port: int) -> None:
        with redirect_stdout(StringIO()), own_pages_only(host):  # without viser's own banner
            self.server = viser.ViserServer(host, port, label=f"skincad live: {subject.name}", verbose=False)
        self.desk = Desk(subject, source, self._changed)
        self._pieces: dict[str, Any] = {}
        self._mold_x = 0.0  # mm along x, where the mold stands
        self._saved = ""
        self._colour: tuple[float, float, float] | None = None
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
        self._state = gui.add_html("")  # the main panel: a telephone shows it first, the others folded
        self._section = gui.add_html("")
        self._verdict = gui.add_html("")
        self._findings = gui.add_html("")
        gui.main_panel.dock_left()
        gui.main_panel.set_width(LEFT)
        beside = gui.add_panel()
        sliders = beside.add_tab("Sliders")
        beside.dock_right()
        beside.set_width(RIGHT)
        with sliders:
            self._add_buttons(gui)
            self._add_view(gui)
            self._drawn = HistoryBoard(self.server, self.desk, self.guarded)
        self._panel = Panel(gui, sliders, self.desk, self.guarded)
        self._changed("session")

    def _add_buttons(self, gui: Any) -> None:
        back = gui.add_button_group("", ("Undo", "Redo"), order=-9.0)
        back.on_click(self.guarded(self._back, back))
        design = isinstance(self.desk.session.subject, Design)
        folder = gui.add_folder("Save and make" if design else "Save", order=-8.0, expand_by_default=False)
        with folder:
            self._file = gui.add_text("file", f"{self.desk.session.subject.name}-live.toml")
            gui.add_button("Save as TOML").on_click(self.guarded(self._save))
            if design:
                gui.add_button("Make its files").on_click(self.guarded(self.desk.make))
            self._making = gui.add_html("")

    def _add_view(self, gui: Any) -> None:
        if not isinstance(self.desk.session.subject, Design):
            self._with_mold = None
            return
        with gui.add_folder("View", order=-7.0):
            self._with_mold = gui.add_checkbox("mold", True, hint="Show the mold beside the skin.")
            self._apart = gui.add_slider("taken apart", 0.0, 1.0, 0.01, 0.5)
        for shown in (self._with_mold, self._apart):
            shown.on_update(self.guarded(self._place))

    def guarded(self, call: Callable[..., None], *arguments: Any) -> Callable[..., None]:
        """Return what a button or slider calls when somebody, not this program, moved it: one at a time, so
        that the newest value is the last; its failure is said on the page."""

        def called(event: Any) -> None:
            if event.client is None:
                return
            move_time = perf_counter()
            try:
                with self.desk.lock:
                    self.desk.move_time = move_time
                    call(*arguments)
            except Exception as failure:  # no click may end a page
                self._tell(self._state, f"<b>{type(failure).__name__}</b>: {escape(str(failure))}")
                print_exc(file=sys.stderr)

        return called

    def _back(self, buttons: Any) -> None:
        (self.desk.undo if buttons.value == "Undo" else self.desk.redo)()

    def _save(self) -> None:
        self._saved = self.desk.save(self._file.value)
        self._changed("making")

    def _changed(self, kind: str) -> None:
        """Show what changed; the desk calls one at a time."""
        desk, answers = self.desk, self.desk.answers
        if kind == "session":
            self._panel.refresh()
            self._tell(self._state, state_html(desk.session))
            self._tint()
        if kind == "view" and answers.view is not None:
            self._show(answers.view.what)
        if kind == "quiet":
            self._panel.widen()
        if kind == "findings":
            self._tell(self._findings, findings_html(desk))
        if kind == "making":
            self._tell(self._making, making_html(answers, self._saved))
        if kind in ("session", "view", "signals"):
            self._drawn.refresh()
        if isinstance(desk.session.subject, Design):
            self._tell(self._verdict, verdict_html(desk))
            if kind in ("session", "view"):
                self._tell(self._findings, findings_html(desk))
        else:
            self._tell(self._verdict, signals_html(desk))

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
                color=_rgb(piece.colour),
                flat_shading=True,
                opacity=0.55 if piece.label in ("carrier", "cover") else None,
                side="double",
            )
        self._pieces[piece.name] = piece, handle

    def _place(self) -> None:
        """Put the mold's parts where they are shown."""
        for piece, handle in self._pieces.values():
            if piece.name != "skin" and self._with_mold is not None:
                handle.visible = self._with_mold.value
                away = self._apart.value * np.array(piece.offset)
                handle.position = away + np.array([self._mold_x, 0.0, 0.0])

    def _tint(self) -> None:
        """Grey the skin while it does not have the wanted values."""
        if "skin" in self._pieces:
            piece, handle = self._pieces["skin"]
            colour = STALE if self.desk.session.refusal is not None else piece.colour
            if colour != self._colour:
                self._colour = handle.color = _rgb(colour)

    def _look(self) -> None:
        """Let a browser that opens the page see all of it."""
        boxes = [_bounds(piece, self._mold_x) for piece, _ in self._pieces.values()]
        subject, way = self.desk.session.subject, np.array([-0.35, -1.0, 0.55])
        if isinstance(subject, Scene):
            board = board_of(subject.design)
            ends = (board.left, board.right), (board.y, board.y), (board.below[0], board.above[1])
            boxes.append((np.array([low for low, _ in ends]), np.array([high for _, high in ends])))
            way = np.array([-0.1, -1.0, 0.25])
        low, high = np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)
        middle, size = (low + high) / 2, float(np.linalg.norm(high - low))
        camera = self.server.initial_camera
        camera.look_at, camera.position = tuple(middle), tuple(middle + size * way)


def _rgb(colour: tuple[float, float, float]) -> tuple[int, int, int]:
    red, green, blue = (round(255 * part) for part in colour)
    return red, green, blue


def _bounds(piece: Piece, mold_x: float) -> tuple[np.ndarray, np.ndarray]:
    """The box round a piece as it is shown at first, mm."""
    away = (
        np.zeros(3) if piece.name == "skin" else np.array([mold_x, 0.0, 0.0]) + 0.5 * np.array(piece.offset)
    )
    return piece.corners.min(axis=0) + away, piece.corners.max(axis=0) + away
