"""The board on which a history is drawn by hand."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from skincad.base.arrays import Array
from skincad.inputs.design import Design
from skincad.live.desk import Desk
from skincad.live.words import text_html
from skincad.scenes.scene import History, Scene
from skincad.shape.skin import section
from skincad.studies.subject import Setting

CURVES = ("normal_force_N", "tangential_force_N", "displacement_mm", "rotation_deg")
HEAD = 1.3  # times its largest value, that an axis reaches: one may draw beyond what is there
DIGITS = 3  # of a value that is drawn by hand


@dataclass(frozen=True)
class Board:
    """A rectangle behind the skin, upright in the plane y = `y`, mm: history above, signals below."""

    left: float
    right: float
    y: float
    below: tuple[float, float]  # z of the signals' axis, mm
    above: tuple[float, float]  # z of the history's

    def line(self, times: Array, values: Array, ends: tuple[float, float], *, above: bool) -> Array:
        """Return points `(n, 3)` mm for shares of time from 0 to 1 and values on an axis with these ends."""
        low, high = self.above if above else self.below
        shares = (values - ends[0]) / (ends[1] - ends[0])
        x = self.left + times * (self.right - self.left)
        return np.stack([x, np.full_like(x, self.y), low + shares * (high - low)], axis=1)

    def hit(self, eye: Array, target: Array) -> tuple[float, float]:
        """Return the share of time and of the history's axis at which a look from `eye` past `target`, mm,
        meets the board; both may lie outside 0 to 1."""
        along = target - eye
        far = (self.y - eye[1]) / (along[1] or 1e-12)
        x, _, z = eye + far * along
        low, high = self.above
        return float((x - self.left) / (self.right - self.left)), float((z - low) / (high - low))


def board_of(design: Design) -> Board:
    """Return the board behind a design's skin, as wide as it takes to draw on."""
    wide, top = max(design.skin.width, 0.6 * design.skin.length), section(design).top
    levels = [top + share * wide for share in (0.25, 0.85, 1.05, 1.85)]
    return Board(-1.1 * wide, 1.1 * wide, 0.5 * design.skin.length + 0.2 * wide, *pairs(levels))


def pairs(levels: Sequence[float]) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return four numbers as two pairs."""
    a, b, c, d = levels
    return (a, b), (c, d)


def axes(history: History) -> dict[str, tuple[float, float]]:
    """Return the ends of each given curve's axis, by its key; both forces share one."""
    values = {key: curve for key in CURVES if (curve := getattr(history, key)) is not None}
    groups: dict[str, list[float]] = {}
    for key, curve in values.items():
        groups.setdefault(key.rpartition("_")[2], []).extend(curve)
    ends = {}
    for key in values:
        every = groups[key.rpartition("_")[2]]
        low, high = min(0.0, *every), max(0.0, *every)
        if low == high:
            high = 1.0
        ends[key] = (HEAD * low, HEAD * high)
    return ends


def drag_changes(
    history: History, curve: str, place: int, share: tuple[float, float], ends: tuple[float, float]
) -> Mapping[str, Setting]:
    """Return what changes in a scene when a curve's point, from 1 on, is dragged to a share of the board.

    Its time stays between its neighbours'; the last point may not leave the board, nor any its axis.
    """
    times, whole = history.time_s, history.time_s[-1]
    step = whole / 100
    first = times[place - 1] + step
    last = times[place + 1] - step if place + 1 < len(times) else whole
    time = min(max(share[0] * whole, min(first, times[place])), max(last, times[place]))
    value = ends[0] + min(max(share[1], 0.0), 1.0) * (ends[1] - ends[0])
    fine = 10.0 ** (np.floor(np.log10(ends[1] - ends[0])) - DIGITS + 1)
    return {
        f"history.time_s.{place + 1}": float(f"{time:.{DIGITS + 1}g}"),
        f"history.{curve}.{place + 1}": float(f"{round(value / fine) * fine:.6g}"),
    }


def with_point(history: History) -> Mapping[str, Setting]:
    """Return the history's lists with one point more, in the middle of its longest straight line."""
    times = history.time_s
    after = int(np.argmax(np.diff(times))) + 1
    changes: dict[str, Setting] = {"history.time_s": _with(times, after)}
    for key in CURVES:
        if (values := getattr(history, key)) is not None:
            changes[f"history.{key}"] = _with(values, after)
    return changes


def without_point(history: History, place: int) -> Mapping[str, Setting]:
    """Return the history's lists without the point at a place, from 1 on; a history keeps two points."""
    keys = ("time_s", *(key for key in CURVES if getattr(history, key) is not None))
    return {
        f"history.{key}": [value for i, value in enumerate(getattr(history, key)) if i != place]
        for key in keys
    }


def _with(values: Sequence[float], after: int) -> list[float]:
    middle = float(f"{(values[after - 1] + values[after]) / 2:.6g}")
    return [*values[:after], middle, *values[after:]]


Colour = tuple[int, int, int]
COLOURS: dict[str, Colour] = {
    "normal_force_N": (31, 95, 168),
    "tangential_force_N": (193, 83, 31),
    "displacement_mm": (193, 83, 31),
    "rotation_deg": (110, 60, 150),
}
NAMES = {
    "normal_force_N": "normal force (blue)",
    "tangential_force_N": "tangential force (orange)",
    "displacement_mm": "displacement (orange)",
    "rotation_deg": "rotation (violet)",
}
SIGNALS: tuple[Colour, ...] = ((27, 110, 60), (193, 83, 31), (31, 95, 168), (110, 60, 150))
OLDER: Colour = (190, 192, 198)
FRAME: Colour = (120, 124, 132)
HANDLE = 0.03  # of the board's width: radius of a point that is dragged
THICK = 2.0  # px
NOTHING = 1e-3  # of the largest stress: what is no stress of the other sign


class HistoryBoard:
    """The board of a scene on a page; nothing of a design."""

    def __init__(self, server: Any, desk: Desk, guarded: Callable[..., Callable[..., None]]) -> None:
        self._server, self._desk, self._guarded = server, desk, guarded
        self._lines: dict[str, Any] = {}
        self._handles: dict[tuple[str, int], Any] = {}
        self._labels: dict[str, Any] = {}
        self._ends: dict[str, tuple[float, float]] = {}
        self._last = 1  # the point that was dragged last
        self._dragging = False
        if not isinstance(desk.session.subject, Scene):
            return
        gui = server.gui
        with gui.add_folder("Draw the history", order=-7.0):
            gui.add_html(text_html("Drag the points on the board behind the skin."))
            points = gui.add_button_group("", ("Add a point", "Remove the last moved"))
            points.on_click(guarded(self._edit, points))

    def refresh(self) -> None:
        """Draw the history as it is, and the newest signals."""
        scene = self._desk.session.subject
        if not isinstance(scene, Scene):
            return
        board, history = board_of(scene.design), scene.history
        if not self._dragging or self._ends.keys() != axes(history).keys():
            self._ends = axes(history)
        times = np.array(history.time_s) / history.time_s[-1]
        with self._server.atomic():
            self._frame(board, scene)
            wanted = set()
            for key, ends in self._ends.items():
                path = board.line(times, np.array(getattr(history, key)), ends, above=True)
                self._line(f"/history/{key}", path, COLOURS[key])
                wanted |= {(key, place) for place in range(1, len(path))}
                for place in range(1, len(path)):
                    self._handle(key, place, path[place], board)
            for stale in self._handles.keys() - wanted:
                self._handles.pop(stale).remove()
            self._signals(board)

    def _frame(self, board: Board, scene: Scene) -> None:
        flat, unit = np.array([0.0, 1.0]), (0.0, 1.0)
        for name, above in (("above", True), ("below", False)):
            self._line(f"/board/{name}/time", board.line(flat, np.zeros(2), unit, above=above), FRAME)
            self._line(f"/board/{name}/value", board.line(np.zeros(2), flat, unit, above=above), FRAME)
        corner = board.line(np.zeros(1), np.ones(1), (0.0, 1.0), above=True)[0]
        named = [
            f"{NAMES[key]} to {ends[1]:.3g} {key.rpartition('_')[2]}" for key, ends in self._ends.items()
        ]
        self._label("/board/high", ", ".join(named), corner)
        end = board.line(np.ones(1), np.zeros(1), (0.0, 1.0), above=True)[0]
        self._label("/board/end", f"{scene.history.time_s[-1]:g} s", end)

    def _signals(self, board: Board) -> None:
        reply = self._desk.answers.signals
        if reply is None or not reply.what.stress:
            return
        signals, fresh = reply.what, self._desk.is_current(reply)
        every = np.concatenate(list(signals.stress.values()))
        largest = float(np.abs(every).max()) or 1.0
        low = 0.0 if every.min() > -NOTHING * largest else float(every.min())
        high = float(every.max()) if every.max() > NOTHING * largest or low == 0.0 else 0.0
        high = high if high > low else largest
        whole = reply.of.history.time_s[-1] if isinstance(reply.of, Scene) else signals.time[-1]
        for number, (ridge, stress) in enumerate(signals.stress.items()):
            path = board.line(signals.time / whole, stress, (low, high), above=False)
            colour = SIGNALS[number % len(SIGNALS)] if fresh else OLDER
            self._line(f"/signals/{ridge}", path, colour)
        for name in [n for n in self._lines if n.startswith("/signals/")]:
            if int(name.rpartition("/")[2]) not in signals.stress:
                self._lines.pop(name).remove()
        top = board.line(np.zeros(1), np.ones(1), (0.0, 1.0), above=False)[0]
        older = "" if fresh else " (older)"
        named = ", ".join(f"ridge {ridge}" for ridge in signals.stress)
        self._label("/board/stress", f"S1 - S2 of {named}: {low:.2g} to {high:.2g} MPa{older}", top)

    def _line(self, name: str, path: Array, colour: Colour) -> None:
        points = np.stack([path[:-1], path[1:]], axis=1).astype(np.float32)
        if name in self._lines:
            self._lines[name].points, self._lines[name].colors = points, np.array(colour, dtype=np.uint8)
        else:
            self._lines[name] = self._server.scene.add_line_segments(
                name, points, colour, thickness=THICK, thickness_units="screen"
            )

    def _label(self, name: str, text: str, place: Array) -> None:
        if name not in self._labels:
            self._labels[name] = self._server.scene.add_label(name, text, anchor="bottom-left")
        self._labels[name].text, self._labels[name].position = text, place

    def _handle(self, key: str, place: int, at: Array, board: Board) -> None:
        if (key, place) in self._handles:
            self._handles[key, place].position = at
            return
        radius = HANDLE * (board.right - board.left) / 2
        shown = self._server.scene.add_icosphere(
            f"/history/{key}/{place}", radius, color=COLOURS[key], position=at, cast_shadow=False
        )
        self._handles[key, place] = shown

        async def on_drag(event: Any) -> None:
            self._guarded(self._drag, event, key, place)(event)

        shown.on_drag(on_drag)

    def _drag(self, event: Any, key: str, place: int) -> None:
        scene = self._desk.session.subject
        if not isinstance(scene, Scene) or place >= len(scene.history.time_s):
            return
        self._dragging, self._last = event.phase != "end", place
        eye, target = np.array(event.client.camera.position), np.array(event.end_position)
        share = board_of(scene.design).hit(eye, target)
        self._desk.move(drag_changes(scene.history, key, place, share, self._ends[key]))

    def _edit(self, buttons: Any) -> None:
        scene = self._desk.session.subject
        assert isinstance(scene, Scene)
        if buttons.value == "Add a point":
            self._desk.move(with_point(scene.history))
        elif len(scene.history.time_s) > 2:
            self._desk.move(without_point(scene.history, min(self._last, len(scene.history.time_s) - 1)))
