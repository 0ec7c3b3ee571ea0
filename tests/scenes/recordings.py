"""Recordings made of a small scene's prediction, for tests of seconds."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from skincad.inputs import FilmRecording, column_name
from skincad.scenes import (
    FilmPrediction,
    Level,
    Scene,
    at_level,
    film_prediction,
    predict_films,
    varied,
    with_modulus,
)
from tests.small_scene import small_scene

SETTINGS = (
    *("history.normal_force_N=[0.0, 1.3, 1.3]", "history.tangential_force_N=[0.0, 0.0, 0.5]"),
    *("history.steps=40", "readout.ridges=[1, 2, 3]", "effects.piezo.circuit=charge-amplifier"),
)
DELAY = 0.04  # s
COARSE = Level(0.25, 2)  # the same mesh predicts and records: its error is in neither


@cache
def scene() -> Scene:
    with TemporaryDirectory() as folder:
        loaded = small_scene(Path(folder), "yamada-2002-press-and-pull", *SETTINGS)
        return loaded.with_(skin=loaded.design)


@cache
def prediction() -> FilmPrediction:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(film_prediction, "LEVELS", (COARSE,))
        return predict_films(scene(), 2, moduli=1)


@cache
def outputs() -> tuple[np.ndarray, np.ndarray]:
    """Time `(steps,)` s and outputs `(strips, steps)` V of a skin 10 % softer with other crests."""
    other = with_modulus(scene(), 0.9 * prediction().moduli[0])
    run = at_level(varied(other, np.random.default_rng(11)), COARSE)
    rows = [run.read["output_V"][str(r)][s] for r, s in prediction().strips]
    return run.march.time, np.array(rows)


def recording(dead: int = -1, reversed_: int = -1, swapped: tuple[int, int] | None = None) -> FilmRecording:
    """A recording with faults of these channels, from 0: with noise, offset, and gains 0.6 to 0.8."""
    draw = np.random.default_rng(7)
    at, volts = outputs()
    volts = volts * np.linspace(0.62, 0.78, len(volts))[:, None]
    if dead >= 0:
        volts[dead] = 0.0
    if reversed_ >= 0:
        volts[reversed_] *= -1.0
    if swapped:
        volts[list(swapped)] = volts[list(swapped)[::-1]]
    time = np.arange(0.0, DELAY + at[-1], 0.0005)
    rows = np.array([np.interp(time - DELAY, at, row) for row in volts])
    peak = np.abs(volts).max()
    noise = draw.normal(0.0, 0.002 * peak, rows.shape) + draw.uniform(-0.1, 0.1, (len(rows), 1)) * peak
    return FilmRecording(prediction().strips, time, rows + noise)


def text(made: FilmRecording, time: str = "time_s") -> str:
    """A recording as CSV."""
    scale = 1000.0 if time == "time_ms" else 1.0
    head = ",".join([time, *(column_name(*strip) for strip in made.strips)])
    rows = np.column_stack([made.time * scale, made.volts.T])
    return "\n".join([head, *(",".join(f"{value:.9g}" for value in row) for row in rows)]) + "\n"
