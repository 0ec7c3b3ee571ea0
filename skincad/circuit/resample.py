"""The recording: a signal at the simulation's rate, filtered and sampled as an experiment samples it."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

import numpy as np
from scipy.signal import firwin, kaiserord, resample_poly

from skincad.base.errors import InputError
from skincad.circuit.elements import Real

PASS = 0.8  # of the Nyquist frequency: kept within 0.01 %; from there to Nyquist the filter falls
ATTENUATION = 80.0  # dB beyond the Nyquist frequency: what folds back is below 1e-4
LARGEST_FACTOR = 10_000
LOST = 0.01  # share of the signal's power that may vanish unsaid


@dataclass(frozen=True)
class Recording:
    """Samples `(m,)` at `rate` Hz, the first at the signal's first; true up to `passband` Hz.

    `lost` is the share of the signal's power (its mean left out) that lies above the passband.
    """

    values: Real
    rate: float
    passband: float
    lost: float
    warnings: tuple[str, ...]


def recorded(signal: Real, rate: float, wanted: float) -> Recording:
    """Return a signal `(n,)` at `rate` Hz as a recording at `wanted` Hz.

    A linear-phase FIR low-pass (Kaiser window, 80 dB, passband 0.8 of the new Nyquist frequency) without
    delay: it looks ahead, so no detector may use it. Each end holds its last value. Raises InputError for
    rates that are not above 0, go up, or whose ratio has no small numerator.
    """
    signal = np.asarray(signal, float)
    if signal.ndim != 1 or signal.size < 2 or not np.isfinite(signal).all():
        raise InputError("signal", "must be a row of at least two finite numbers")
    for key, value in (("rate", rate), ("sampling.rate", wanted)):
        if not (np.isfinite(value) and value > 0):
            raise InputError(key, "must be above 0 Hz and finite", value)
    if wanted > rate:
        raise InputError("sampling.rate", f"must be at most {rate:g} Hz, the signal's", wanted)
    passband = PASS * wanted / 2
    lost = power_above(signal, rate, passband)
    note = f"{lost:.0%} of the signal's power lies above {passband:.4g} Hz, which {wanted:g} Hz cannot show"
    return Recording(_filtered(signal, rate, wanted), wanted, passband, lost, (note,) if lost > LOST else ())


def _filtered(signal: Real, rate: float, wanted: float) -> Real:
    ratio = Fraction(wanted / rate).limit_denominator(LARGEST_FACTOR)
    if ratio == 0 or abs(float(ratio) * rate / wanted - 1) > 1e-9:
        rule = f"must be a ratio of whole numbers up to {LARGEST_FACTOR} of {rate:g} Hz"
        raise InputError("sampling.rate", rule, wanted)
    if ratio == 1:
        return signal.copy()
    up, down = ratio.numerator, ratio.denominator
    taps, beta = kaiserord(ATTENUATION, (1 - PASS) / down)
    window = firwin(taps | 1, (1 + PASS) / 2 / down, window=("kaiser", beta))
    return np.asarray(resample_poly(signal, up, down, window=window, padtype="edge"))


def power_above(signal: Real, rate: float, frequency: float) -> float:
    """Return the share of a signal's power above a frequency, by its Hann-windowed spectrum."""
    spectrum = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(signal.size))) ** 2
    total = float(spectrum.sum())
    above = np.fft.rfftfreq(signal.size, 1 / rate) > frequency
    return float(spectrum[above].sum()) / total if total > 0 else 0.0
