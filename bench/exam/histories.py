"""Random histories of a plate: press, then hold, pull, ease, reverse, roll, tap, drop, vibrate; half slip.

What each phase does is drawn, how far, how long and how evenly: straight, or smooth as a hand's reach is
(minimum jerk, Flash and Hogan, J. Neurosci. 5 (1985) 1688). Pulls take 2 to 200 ms, two decades, and other
phases 0.3 to 3 times that. All ranges are assumptions.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

STEPS = 600
FEWEST = 24  # steps of a phase
PULL = 2e-3, 0.2  # s
BAND = 0.05, 0.4  # of the rate of steps; what the templates of scenes have
WIDEST = 5000.0  # Hz
GENTLE = ("hold", "pull", "ease", "reverse", "roll", "tap", "drop", "vibrate", "press")
ENDS = ("pull", "pull again", "both rise", "grip loosens", "cycles", "drag", "", "", "", "")


@dataclass(frozen=True, eq=False)
class History:
    """Forces N, travel mm where the plate is driven, angle deg at evenly spaced times; `phases` as done."""

    time: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray
    travel: np.ndarray | None
    angle: np.ndarray
    bandwidth: float
    phases: tuple[tuple[str, int], ...]  # name, first step


@dataclass
class Hand:
    """What a hand does: N of the preload and friction, its side, where it is, and what it did."""

    draw: np.random.Generator
    force: float
    friction: float
    side: float
    turn: float  # deg, most
    normal: float = 0.0
    pull: float = 0.0  # of friction times the normal force: of what holds
    angle: float = 0.0

    def smooth(self, count: int) -> np.ndarray:
        """Return from 0 to 1, `(count,)`."""
        s = np.arange(1, count + 1) / count
        return s if self.draw.random() < 0.5 else 10 * s**3 - 15 * s**4 + 6 * s**5

    def to(self, count: int, normal: float, pull: float, angle: float | None = None) -> np.ndarray:
        """Return `(count, 3)` of normal force, pull and angle on their way."""
        s = self.smooth(count)[:, None]
        here = np.array([self.normal, self.pull * self.normal, self.angle])
        there = np.array([normal, pull * normal, self.angle if angle is None else angle])
        self.normal, self.pull, self.angle = normal, pull, float(there[2])
        return here + s * (there - here)

    def around(self, count: int, key: int, size: float, cycles: float, growing: bool) -> np.ndarray:
        """Return `(count, 3)` that vibrates about where it is, in normal force (0) or pull (1)."""
        s = np.arange(1, count + 1) / count
        here = np.tile([self.normal, self.pull * self.normal, self.angle], (count, 1))
        here[:, key] += size * (s if growing else np.minimum(1, 8 * s)) * np.sin(2 * np.pi * cycles * s)
        return here


def gentle(hand: Hand, kind: str, count: int) -> np.ndarray:  # noqa: PLR0911 (one a kind)
    """Return a phase that friction holds as a whole."""
    draw, n, a = hand.draw, hand.normal, hand.pull
    level = hand.side * draw.uniform(0.2, 0.7)
    if kind == "hold":
        return hand.to(count, n, a)
    if kind == "pull":
        return hand.to(count, n, level)
    if kind == "ease":
        return hand.to(count, n, a * draw.uniform(0.0, 0.8))
    if kind == "reverse":
        return hand.to(count, n, -level)
    if kind == "roll":
        return hand.to(count, n, a, hand.turn * draw.uniform(-1, 1))
    if kind == "tap":
        half = count // 2
        top = n * draw.uniform(1.1, 1.5)
        return np.concatenate([hand.to(half, top, a * n / top), hand.to(count - half, n, a)])
    if kind == "drop":
        third = count // 3
        parts = [hand.to(third, n, 0.0), hand.to(third, 0.05 * n, 0.0), hand.to(count - 2 * third, n, 0.0)]
        return np.concatenate(parts)
    if kind == "vibrate":
        key = int(draw.integers(0, 2))
        size = draw.uniform(0.02, 0.1) * n * (hand.friction if key else 1.0)
        return hand.around(count, key, size / (hand.friction if key else 1.0), draw.integers(2, 8), False)
    return hand.to(count, hand.force * draw.uniform(0.6, 1.3), a * 0.7)  # press


def ending(hand: Hand, kind: str, count: int) -> np.ndarray:
    """Return what slips as a whole in the end."""
    draw, n = hand.draw, hand.normal
    far = hand.side * draw.uniform(1.1, 1.4)
    if kind == "pull again":
        third = count // 3
        parts = [hand.to(third, n, hand.side * 0.85), hand.to(third // 2, n, hand.side * 0.65)]
        return np.concatenate([*parts, hand.to(count - third - third // 2, n, far)])
    if kind == "both rise":
        return hand.to(count, n * draw.uniform(1.2, 1.7), far)
    if kind == "grip loosens":
        half = count // 2
        first = hand.to(half, n, hand.side * 0.5)
        s = hand.smooth(count - half)[:, None]
        end = np.array([n * 0.3, hand.pull * n, hand.angle])
        return np.concatenate([first, first[-1] + s * (end - first[-1])])
    if kind == "cycles":
        rest = hand.pull * n
        return hand.around(count, 1, far * n + abs(rest), draw.integers(2, 6) + 0.25, True)
    return hand.to(count, n, far)


def history(draw: np.random.Generator, force: float, friction: float, turn: float, reach: float) -> History:
    """Return a random history on a skin that is pressed by about `force` N, turned by at most `turn` deg.

    A driven plate goes up to `reach` mm, which about slips.
    """
    end = str(draw.choice(ENDS))
    side = float(draw.choice([-1.0, 1.0]))
    hand = Hand(draw, force, friction, side, turn)
    middle = [str(k) for k in draw.choice(GENTLE, draw.integers(1, 4))]
    if end == "drag":
        middle = [k for k in middle if k in ("hold", "pull", "ease", "reverse", "vibrate")]
    names = ["first press", *middle, *([end] if end else ["hold"])]
    pull = float(np.exp(draw.uniform(*np.log(PULL))))
    times = pull * np.exp(draw.uniform(np.log(0.3), np.log(3.0), len(names)))
    times[-1] = pull if end else times[-1]
    counts = np.maximum(FEWEST, np.round(STEPS * times / times.sum())).astype(int)
    counts[np.argmax(counts)] += STEPS - counts.sum()
    parts = [np.zeros((1, 3)), hand.to(int(counts[0]), force * draw.uniform(0.7, 1.2), 0.0)]
    parts += [gentle(hand, kind, int(n)) for kind, n in zip(middle, counts[1:-1], strict=True)]
    parts.append(ending(hand, end, int(counts[-1])) if end else gentle(hand, "hold", int(counts[-1])))
    way = np.concatenate(parts)
    step = times.sum() / STEPS
    band = min(WIDEST, float(np.exp(draw.uniform(*np.log(BAND)))) / step)
    firsts = np.concatenate([[0], np.cumsum(counts)[:-1]])
    across = way[:, 1] * friction
    travel = None
    if end == "drag":
        travel = reach * way[:, 1] / max(abs(hand.pull) * hand.normal, 1e-9)
    return History(
        np.linspace(0, STEPS * step, STEPS + 1), np.maximum(way[:, 0], 0.0), across, travel, way[:, 2], band,
        tuple(zip(names, firsts.tolist(), strict=True)),
    )  # fmt: skip
