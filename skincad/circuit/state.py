"""The network in time: state equations, their exact step for piecewise linear charge, and the output.

States: the film's voltage less its charge's share, the motional current and capacitor voltage, the input
node's voltage, and with a feedback capacitor its voltage. The film's charge is the input, so that no
derivative is taken. Exact first-order hold by the matrix exponential (Van Loan 1978): stable at any step for
any passive network, however stiff.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import schur
from scipy.signal import lfilter

from skincad.base.errors import InputError, RefusedError
from skincad.circuit.exponential import exponential
from skincad.circuit.network import Complex, Constants, Real

ROUNDING = 1e-12  # of a step's largest factor above 1


@dataclass(frozen=True)
class StateSpace:
    """x' = a x + b q, vout = c x: a `(n, n)` 1/s, b and c `(n,)`; q the charge in C, vout in V. n is 4, or 5
    with a feedback capacitor."""

    a: Real
    b: Real
    c: Real


@dataclass(frozen=True)
class Stepper:
    """One exact step in a triangular basis: z+ = step z + now q + then q+; vout = Re(out z)."""

    rate: float  # Hz
    step: Complex  # (n, n), upper triangular
    now: Complex  # (n,)
    then: Complex  # (n,)
    out: Complex  # (n,)
    rest: Complex  # (n,), the state at rest under a charge of 1 C


def state_space(c: Constants) -> StateSpace:
    """Return the network's state equations."""
    cp, co, r12 = c.capacitance, c.input_capacitance, c.series_resistance
    leak, lm = _leak(c), c.motional_inductance
    a = np.array(
        [
            [-1 / (r12 * cp), -1 / cp, 0.0, 1 / (r12 * cp)],
            [1 / lm, -c.motional_resistance / lm, -1 / lm, 0.0],
            [0.0, 1 / c.motional_capacitance, 0.0, 0.0],
            [1 / (r12 * co), 0.0, 0.0, -(1 / r12 + leak) / co],
        ]
    )
    b = np.array([-1 / (r12 * cp), 1 / lm, 0.0, 1 / (r12 * co)]) / cp
    if not c.feedback_capacitance:
        behind = c.feedback_resistance + c.output_resistance
        factor = (c.gain * c.feedback_resistance - c.output_resistance) / behind  # vout / vd of (9)
        return StateSpace(a, b, np.array([0.0, 0.0, 0.0, factor]))
    # the feedback's current is ((1 + A) vd - vf) / Ropo; vout = vf - vd
    cf, ro = c.feedback_capacitance, c.output_resistance
    a = np.pad(a, (0, 1))
    a[3, 4] = 1 / (ro * co)
    a[4, 3], a[4, 4] = (1 + c.gain) / (ro * cf), -(1 / ro + 1 / c.feedback_resistance) / cf
    return StateSpace(a, np.append(b, 0.0), np.array([0.0, 0.0, 0.0, -1.0, 1.0]))


def _leak(c: Constants) -> float:
    """The input node's conductance by its own resistance and the amplifier's feedback, S."""
    back = c.output_resistance + (0.0 if c.feedback_capacitance else c.feedback_resistance)
    return 1 / c.input_resistance + (1 + c.gain) / back


def stepper(c: Constants, rate: float) -> Stepper:
    """Return the exact step of the network at `rate` Hz.

    Raises InputError for a rate that is not above 0, RefusedError where the step cannot be had in double
    precision.
    """
    if not (np.isfinite(rate) and rate > 0):
        raise InputError("rate", "must be above 0 Hz and finite", rate)
    system, size = state_space(c), sizes(c)
    order = size.size
    whole = np.zeros((order + 2, order + 2))
    with np.errstate(over="ignore"):  # the exponential refuses what is not finite
        whole[:order, :order] = system.a * size[None, :] / size[:, None] / rate
        whole[:order, order] = system.b / size / rate
    whole[order, order + 1] = 1.0
    powers = exponential(whole)
    triangle, basis = schur(powers[:order, :order], output="complex")
    if not np.abs(np.diag(triangle)).max() <= 1.0 + ROUNDING:
        raise RefusedError(f"the network's step at {rate:g} Hz grows: its constants are too far apart")
    back, slope = basis.conj().T, powers[:order, order + 1]
    rest = np.zeros(order)
    rest[0] = -1 / c.capacitance  # no voltage: the state takes the charge's off
    return Stepper(
        rate,
        triangle,
        back @ (powers[:order, order] - slope),
        back @ slope,
        (system.c * size) @ basis,
        back @ (rest / size),
    )


def sizes(c: Constants) -> Real:
    """The states' units, so that all are of one size: those of equal energy, and of the input its share.

    In these the lossless part of the network only turns the state, and rounding stays relative.
    """
    current = np.sqrt(c.capacitance / c.motional_inductance)
    voltage = np.sqrt(c.capacitance / c.motional_capacitance)
    sizes = [1.0, current, voltage, 1 / (1 + c.series_resistance * _leak(c))]
    return np.array([*sizes, *([np.sqrt(c.capacitance / cf)] if (cf := c.feedback_capacitance) else [])])


def run(s: Stepper, charge: Real, state: Complex | None = None) -> tuple[Real, Complex]:
    """Return the output `(n,)` V and the last state, for a charge `(n,)` C at the stepper's rate.

    Without a state the network has been at rest under the first charge for ever: vout starts at 0. With one
    the charge begins with the last sample of the piece before, whose output is repeated. Charge runs straight
    between samples, so that an output that follows its rate comes half a sample late.
    """
    charge = _checked(charge)
    if state is None:
        state = s.rest * charge[0]
    found = recursion(s.step, lambda k: s.now[k] * charge[:-1] + s.then[k] * charge[1:], state, charge.size)
    return np.asarray((s.out @ found).real), found[:, -1].copy()


def recursion(step: Complex, forced: Callable[[int], Complex], state: Complex, count: int) -> Complex:
    """Return z `(n, count)` of z+ = step z + forcing from `state` `(n,)`; `forced` gives a row's.

    A triangular step is n scalar recursions, the last state first.
    """
    found = np.empty((state.size, count), complex)
    for k in range(state.size - 1, -1, -1):
        forcing = forced(k)
        for j in range(k + 1, state.size):
            forcing = forcing + step[k, j] * found[j, :-1]
        found[k, 0] = state[k]
        pole = step[k, k]
        found[k, 1:] = lfilter([1.0], [1.0, -pole], forcing, zi=[pole * state[k]])[0]
    return found


def output(c: Constants, charge: Real, rate: float) -> Real:
    """Return the output `(n,)` V for a charge `(n,)` C sampled at `rate` Hz, at rest before."""
    return run(stepper(c, rate), charge)[0]


def _checked(charge: Real) -> Real:
    array = np.asarray(charge, float)
    if array.ndim != 1 or array.size == 0 or not np.isfinite(array).all():
        raise InputError("charge", "must be a row of finite numbers, one at least")
    return array
