"""Response of a network over frequency: gain, slopes and noise.

Node by node, currents add up to 0 and each source holds its own node (modified nodal analysis: Ho, Ruehli,
Brennan 1975). Determinants are expanded once a topology, in the elements' names: products of which an element
appears twice cancel there and not in floating point, and every term that is left has its own set of elements.
What digits are lost are those that the elements' own values leave open, also where a system of numbers has
none left (an amplifier's gain near Ropo / Rf).

Noise of film and amplifier at the output. Thermal noise of each resistor and of the film's dielectric loss
(Johnson 1928, Nyquist 1928), the amplifier's input voltage noise, white with a 1/f corner (Horowitz and Hill,
The Art of Electronics, 3rd ed., sec. 8.1.3), and its input current noise, white. Each source goes through the
network alone; their powers add. The network itself is without the film's loss.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import NDArray
from scipy.constants import Boltzmann
from scipy.optimize import minimize_scalar

from skincad.base.errors import InputError
from skincad.base.estimate import Estimate
from skincad.base.result import Record, item, record
from skincad.circuit.network import GROUND, KINDS, LOAD, OUT, SOURCE, Complex, Network, Real, Wiring

Products = dict[int, int]  # elements, as bits of a number, to how often their product counts
Drive = tuple[tuple[str, int, int], ...]  # to which nodes' equations what product is added, how often
BY_LOAD: Drive = ((LOAD, 0, 1),)
SLOPE = 10.0, 20.0  # Hz: an output that hardly rises between them is the stress, not its rate


def checked_frequencies(frequency: Real) -> Real:
    """Return the frequencies as an array, Hz; raises InputError unless all are finite and above 0."""
    array = np.atleast_1d(np.asarray(frequency, float))
    bad = array[~(np.isfinite(array) & (array > 0))]
    if bad.size:
        raise InputError("frequency", "must be above 0 Hz and finite", float(bad[0]))
    return array


def decibels(ratio: Complex) -> Real:
    """Return 20 log10 of the magnitude (1)."""
    return np.asarray(20 * np.log10(np.abs(ratio)))


def response(network: Network, frequency: Real) -> Complex:
    """Return the output by the load, `(n,)` V/N, at frequencies `(n,)` Hz.

    Raises InputError for a frequency that is not above 0.
    """
    return transfers(network, [BY_LOAD], frequency)[0]


def tells_stress(network: Network) -> bool:
    """Return whether the output is the stress itself, as a charge amplifier's, and not its rate."""
    slow, fast = np.abs(response(network, np.array(SLOPE)))
    return bool(fast / slow < math.sqrt(SLOPE[1] / SLOPE[0]))


def transfers(network: Network, drives: Sequence[Drive], frequency: Real) -> list[Complex]:
    """Return the output `(n,)` V by each drive of 1 A, or of 1 V in series with an element, at `(n,)` Hz."""
    s = np.asarray(2j * np.pi * checked_frequencies(frequency), np.complex128)
    parts = [polynomial(network, drive) for drive in (None, *drives)]
    (whole, size), *driven = [(polyval(s, part.astype(float)), twos) for part, twos in parts]
    return [part / whole * np.exp2(float(twos - size)) for part, twos in driven]


def polynomial(network: Network, drive: Drive | None) -> tuple[NDArray[np.longdouble], int]:
    """Return the determinant with a drive in the output's column, or without, by powers of s `(k,)`, and the
    power of two that it is to be multiplied by: no product overflows."""
    chosen, of_power = _determinant(network.wiring, drive)
    if not chosen.size:
        return np.zeros(1, np.longdouble), 0
    mantissa, exponent = np.frexp([e.value for e in network.elements])
    # in extended precision, where the machine has it: near a null two products leave their rounding
    size = np.where(chosen, mantissa[:, None].astype(np.longdouble), 1.0).prod(axis=0)
    twos = np.where(chosen, exponent[:, None], 0).sum(axis=0)
    return (of_power * np.ldexp(size, twos - twos.max())).sum(axis=1), int(twos.max())


@cache
def _determinant(wiring: Wiring, drive: Drive | None) -> tuple[NDArray[np.bool_], Real]:
    """The determinant of the node equations, with a drive in the output's column by Cramer's rule.

    Products of the chosen elements, `(elements, m)`, and how often each counts at a power of s, `(k, m)`.
    Source and load hold their nodes; elsewhere the currents add up to 0. All is multiplied by every
    impedance, so that no value is divided by.
    """
    fixed = {LOAD, *(nodes[0] for kind, nodes in wiring if kind == SOURCE)}
    nodes = [node for node in dict.fromkeys(node for _, ends in wiring for node in ends) if node != GROUND]
    rows: list[list[Products]] = [[{0: 1} if a == b and a in fixed else {} for b in nodes] for a in nodes]
    for k, (kind, ends) in enumerate(wiring):
        drop = {ends[-2]: 1, ends[-1]: -1}
        of_equation = {ends[0]: -1} if kind == SOURCE else {n: x for n, x in drop.items() if n not in fixed}
        for node, sign in of_equation.items():
            for other, more in drop.items():
                if GROUND not in (node, other):
                    rows[nodes.index(node)][nodes.index(other)][1 << k] = sign * more
    if drive is not None:
        driven = {node: {product: times} for node, product, times in drive}
        for node, row in zip(nodes, rows, strict=True):
            row[nodes.index(OUT)] = driven.get(node, {})
    products = _expanded(rows)
    chosen = np.array([[bool(product >> k & 1) for product in products] for k in range(len(wiring))], bool)
    inverse, powers = np.array([KINDS[kind] for kind, _ in wiring]).T
    chosen[inverse.astype(bool)] ^= True
    power = chosen[powers > 0].sum(axis=0)
    of_power = np.array([(power == k) * list(products.values()) for k in range(power.max(initial=0) + 1)])
    return chosen, of_power.astype(float)


def _expanded(rows: list[list[Products]]) -> Products:
    """Laplace's expansion, row by row, each minor once."""
    count = len(rows)

    @cache
    def minor(columns: int) -> Products:
        if not columns:
            return {0: 1}
        row, terms = rows[count - columns.bit_count()], dict[int, int]()
        for place, j in enumerate(j for j in range(count) if columns >> j & 1):
            for one, times in row[j].items():
                for other, more in minor(columns ^ 1 << j).items():
                    if not one & other:  # an element's square: it cancels in the whole
                        terms[one | other] = terms.get(one | other, 0) + (-1) ** place * times * more
        return {product: times for product, times in terms.items() if times}

    return minor((1 << count) - 1)


GRID = 200  # corners that are tried before the best is refined
EDGE = 0.1  # of the span in log f: nearer to an end a corner has no line of its own to stand on
RANGES = ((0.0, 0.0), (0.1, 0.0), (0.0, 0.1), (0.1, 0.1))  # left out at either end, of the span in log f
BEND = 3.0  # slopes must differ by this many dB/dec and this many errors, else there is no corner
FEWEST = 20


@record()
class Slopes(Record):
    """The fitted corner; `cutoff` is none for a curve without one. `rms` is the curve's distance, dB."""

    cutoff: Estimate = item("Hz", "where both lines meet")
    below: Estimate = item("dB/dec", "below it", key="slope_below_dB_per_dec")
    above: Estimate = item("dB/dec", "above it", key="slope_above_dB_per_dec")
    level: float  # dB, of the lines at the cut-off, or of the one line at its middle
    rms: float


def fit_slopes(frequency: Real, gain: Real, low: float, high: float, source: str = "sweep.points") -> Slopes:
    """Return corner and slopes from `low` to `high` Hz of a gain `(n,)` in dB at `(n,)` Hz, rising.

    Least squares over level, corner and two slopes, points weighted evenly in log f. The error is the root
    of squares of twice the fit's standard error (its residuals run together: each run of one sign counts as
    one point) and the largest change when a tenth of the range is left out at either end or both. A curve
    without a corner has one slope, its error the largest change over those ranges.
    Raises InputError, in the name of `source`, for fewer than 20 points in the range.
    """
    inside = (frequency >= low) & (frequency <= high)
    x, y = np.log10(frequency[inside]), gain[inside]
    if x.size < FEWEST:
        raise InputError(source, f"must give at least {FEWEST} from {low:g} to {high:g} Hz", x.size)
    if (np.diff(x) <= 0).any():
        raise InputError("frequency", "must rise")
    span = x[-1] - x[0]
    within = [(x >= x[0] + first * span) & (x <= x[-1] - last * span) for first, last in RANGES]
    parts = [(x[part], y[part]) for part in within]
    fits = [_two_lines(*part) for part in parts]
    (_, level, below, above), fitted, rms = fits[0]
    corners = np.array([[10**corner, *slopes] for (corner, _, *slopes), *_ in fits])
    scale = [np.log(10) * corners[0, 0], 1.0, 1.0]
    errors = np.hypot(2 * fitted * scale, np.abs(corners - corners[0]).max(axis=0))
    cutoff = Estimate(float(corners[0, 0]), float(errors[0]), "Hz")
    slopes = [
        Estimate(value, float(e), "dB/dec") for value, e in zip((below, above), errors[1:], strict=True)
    ]
    if abs(above - below) < max(BEND, float(np.hypot(errors[1], errors[2]))):
        lines = [np.polyfit(*part, 1, w=_weights(part[0])) for part in parts]
        values = [float(line[0]) for line in lines]
        slopes = [Estimate(values[0], max(abs(v - values[0]) for v in values), "dB/dec")] * 2
        cutoff, level = Estimate(None, None, "Hz"), float(np.polyval(lines[0], 0.5 * (x[0] + x[-1])))
        rms = float(np.sqrt(((y - np.polyval(lines[0], x)) ** 2).mean()))
    return Slopes(cutoff=cutoff, below=slopes[0], above=slopes[1], level=level, rms=rms)


def _weights(x: Real) -> Real:
    """Square roots of each point's share of the range, mean square 1."""
    share = np.gradient(x)
    return np.asarray(np.sqrt(share / share.mean()))


def _two_lines(x: Real, y: Real) -> tuple[list[float], Real, float]:
    """The nearest corner (log10 of Hz), level and slopes; the errors of corner and slopes; the rms."""
    weight = _weights(x)

    def columns(corner: float) -> Real:
        sides = np.minimum(x - corner, 0.0), np.maximum(x - corner, 0.0)
        return np.column_stack([np.ones_like(x), *sides])

    def solved(corner: float) -> tuple[Real, Real]:
        part = np.asarray(
            np.linalg.lstsq(weight[:, None] * columns(corner), weight * y, rcond=None)[0], float
        )
        return part, y - columns(corner) @ part

    def cost(corner: float) -> float:
        return float(((weight * solved(corner)[1]) ** 2).sum())

    span = x[-1] - x[0]
    grid = np.linspace(x[0] + EDGE * span, x[-1] - EDGE * span, GRID)
    nearest = grid[np.argmin([cost(c) for c in grid])]
    step = grid[1] - grid[0]
    corner = float(minimize_scalar(cost, bounds=(nearest - step, nearest + step), method="bounded").x)
    (level, below, above), rest = solved(corner)
    # the corner's own column of the Jacobian, for the joint covariance
    slope = np.where(x < corner, -below, -above)
    jacobian = weight[:, None] * np.column_stack([slope, columns(corner)])
    runs = max(5, 1 + int((np.diff(np.sign(rest)) != 0).sum()))  # 5: one more than what is fitted
    square = float((weight**2 * rest**2).mean())
    covariance = square * x.size / runs * np.linalg.pinv(jacobian.T @ jacobian)
    deviations = np.sqrt(np.clip(np.diag(covariance), 0.0, None))[[0, 2, 3]]
    return [corner, float(level), float(below), float(above)], deviations, float(np.sqrt(square))


def noise_density(network: Network, frequency: Real) -> dict[str, Real]:
    """Return the one-sided power density at the output by source, `(n,)` V2/Hz each, at `(n,)` Hz."""
    frequency = checked_frequencies(frequency)
    sources = list(_sources(network, frequency))
    ways = transfers(network, [drive for _, drive, _ in sources], frequency)
    terms = zip(sources, ways, strict=True)
    return {name: np.asarray(power * np.abs(way) ** 2, float) for (name, _, power), way in terms}


def _sources(network: Network, frequency: Real) -> Iterator[tuple[str, Drive, Real | float]]:
    """Each noise source: its name, where it drives the network, and its own density, V2/Hz or A2/Hz."""
    fixed = {GROUND, LOAD, *(e.nodes[0] for e in network.elements if e.kind == SOURCE)}
    thermal = 4 * Boltzmann * network.temperature
    for i, e in enumerate(network.elements):
        if e.voltage_density:
            power = e.voltage_density**2 * (1 + e.voltage_corner / frequency)
            yield f"{e.name} voltage", ((e.nodes[0], 1 << i, 1),), power
        if e.current_density:
            for node in sorted({*e.nodes[1:]} - fixed):
                yield f"{e.name} current into {node}", ((node, 0, 1),), e.current_density**2
        ends = [(node, sign) for node, sign in zip(e.nodes, (1, -1), strict=False) if node not in fixed]
        if e.kind == "R":
            yield e.name, tuple((node, 1 << i, sign) for node, sign in ends), thermal * e.value
        if e.loss:
            power = thermal * (2 * np.pi * frequency * e.loss)
            yield f"{e.name} loss", tuple((node, 0, sign) for node, sign in ends), power


def total_density(network: Network, frequency: Real) -> Real:
    """Return the one-sided power density at the output of all sources, `(n,)` V2/Hz."""
    return np.asarray(sum(noise_density(network, frequency).values()))


def noise_samples(network: Network, rate: float, count: int, seed: int | tuple[int, ...]) -> Real:
    """Return noise at the output, `(count,)` V at `rate` Hz, normal, with the density up to rate / 2.

    Periodic over `count`, without a mean; the same seed gives the same noise.
    """
    if count < 2 or not (np.isfinite(rate) and rate > 0):
        raise InputError("rate", "must be above 0 Hz, with at least two samples", rate)
    frequency = np.asarray(np.fft.rfftfreq(count, 1 / rate), float)
    draw = np.random.default_rng(seed)
    parts = draw.standard_normal((2, frequency.size))
    amplitude = np.zeros(frequency.size)
    amplitude[1:] = np.sqrt(total_density(network, frequency[1:]) * rate * count / 4)
    spectrum = amplitude * (parts[0] + 1j * parts[1])
    if count % 2 == 0:
        spectrum[-1] = np.sqrt(2) * amplitude[-1] * parts[0, -1]
    return np.asarray(np.fft.irfft(spectrum, count))
