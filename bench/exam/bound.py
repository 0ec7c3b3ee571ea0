"""The share of gross slips that no detector can warn of: what noise and delay leave of a slip's signal.

Beside each scene that slips as a whole stands its twin whose friction of STICKS holds it (all but ridges
that hardly touch), with the same history. A detector that knew both signals exactly, and had to tell one from
the other before gross slip, could do no better than the matched filter: its distance d is the root of the sum
of the difference's power over the noise's (Van Trees, Detection, Estimation, and Modulation Theory I, sec.
4.2). With false alarms allowed at FALSE a minute, one decision a window, it warns in a share Phi(d - z) of
the noises. A detector that does not know friction, skin and history has less; how much less is not told.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import ndtr, ndtri

from bench.exam.cases import Case, case
from bench.exam.scenes import Drawn, SceneRun, drawn, kept, marched

STICKS = 3.0
FALSE = 0.1  # a minute


def twin(seed: int, folder: Path) -> SceneRun | None:
    """Return the march of a seed that sticks, kept on disk, None where it leaves the model's range first."""
    one, path = drawn(seed), folder / f"{seed}-sticks.npz"
    answer = kept(seed, folder)
    if not path.exists():
        friction = {**one.scene.effects["friction"], "coefficient": STICKS}
        same: Drawn = replace(one, scene=one.scene.with_(effects={"friction": friction}))
        np.savez_compressed(path, stress=marched(same).stress)
    with np.load(path) as data:
        stress = data["stress"]
    if answer.gross is None or stress.shape[0] <= answer.gross:
        return None
    return replace(answer, stress=stress[: answer.time.size])


def distance(one: Case, other: Case) -> float:
    """Return the matched filter's d between two cases, before the last sample, of all told strips."""
    difference = (one.outputs - other.outputs)[:-1].reshape(one.outputs.shape[0] - 1, -1)
    size = 2 * (one.density.size - 1)
    period = np.fft.irfft(one.density**2, size)[:: one.fine] * size
    covariance = 4 * period[: difference.shape[0]] / size**2 / 2
    return float(np.sqrt(max(0.0, _power(covariance, difference))))


def _power(covariance: np.ndarray, signal: np.ndarray) -> float:
    """Return the sum of s' C^-1 s over columns, C the Toeplitz matrix of `covariance`, a little louder so
    that rounding cannot make noise-free directions of it."""
    from scipy.linalg import cho_factor, cho_solve, toeplitz

    whole = toeplitz(covariance) + 1e-6 * covariance[0] * np.eye(covariance.size)
    return float(np.sum(signal * cho_solve(cho_factor(whole), signal)))


def warned(d: float, window: float) -> float:
    """Return the largest share of noises in which one may warn, FALSE a minute, `window` s a decision."""
    return float(ndtr(d + ndtri(FALSE / 60 * window)))


def bound(seed: int, circuit: str, folder: Path, window: float, told: tuple[int, ...]) -> float | None:
    """Return that share of a seed that slips behind a circuit, of some told ridges; None without a twin."""
    scene, sticks = kept(seed, folder / "scenes"), twin(seed, folder / "scenes")
    if sticks is None:
        return None
    outputs = folder / "outputs"
    one = case(scene, circuit, outputs).told(told)
    return warned(distance(one, case(sticks, circuit, outputs / "sticks").told(told)), window)
