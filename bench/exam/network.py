"""Fit a network of the detector, one hidden layer, to weighted samples: logistic loss, by Adam.

A sample is one ridge, or all ridges that are told at a time, whose odds' logarithms are averaged: what is
fitted is their mean. Kingma and Ba, Adam: a method for stochastic optimization, arXiv:1412.6980, with its
usual constants; the rate falls as half a cosine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from skincad.detector import Weights

Samples = tuple[np.ndarray, np.ndarray, np.ndarray]
Layers = list[np.ndarray]  # into `(features, hidden)`, bias `(hidden,)`, out `(hidden,)`, base `(1,)`

HIDDEN, EPOCHS = 96, 12
RATE, DECAY, BATCH = 3e-3, 1e-5, 1024
MEAN, SQUARE, SMALL = 0.9, 0.999, 1e-8


@dataclass(frozen=True, eq=False)
class Stack:
    """Samples one after the other: rows of features `(rows, features)`, by sample its `first` row and their
    `count`, its label and weight."""

    rows: np.ndarray
    first: np.ndarray
    count: np.ndarray
    label: np.ndarray
    weight: np.ndarray

    def some(self, at: np.ndarray) -> Stack:
        """Return the samples `at` these places."""
        count = self.count[at]
        first = np.concatenate([[0], np.cumsum(count)[:-1]])
        rows = np.repeat(self.first[at] - first, count) + np.arange(count.sum())
        return Stack(self.rows[rows], first, count, self.label[at], self.weight[at])


def stacked(parts: list[Samples]) -> Stack:
    """Return the samples of parts: features `(m, ridges, features)`, labels and weights `(m,)` each."""
    count = np.concatenate([np.full(x.shape[0], x.shape[1]) for x, _, _ in parts])
    rows = np.concatenate([x.reshape(-1, x.shape[2]) for x, _, _ in parts])
    first = np.concatenate([[0], np.cumsum(count)[:-1]])
    label, weight = (np.concatenate([part[k] for part in parts]).astype(np.float32) for k in (1, 2))
    return Stack(rows, first, count, label, weight / weight.mean())


def fitted(parts: list[Samples], seed: int = 0, hidden: int = HIDDEN) -> Weights:
    """Return the weights of a network of so many hidden units."""
    samples = stacked(parts)
    middle, spread = samples.rows.mean(axis=0), samples.rows.std(axis=0) + 1e-3
    samples = replace(samples, rows=((samples.rows - middle) / spread).astype(np.float32))
    into, bias, out, base = (p.astype(float) for p in layers(samples, seed, hidden))
    into = into / spread[:, None]
    return Weights(into, bias - middle @ into, out, float(base[0]))


def layers(samples: Stack, seed: int, hidden: int = HIDDEN) -> Layers:
    """Return the fitted layers, from a seeded start."""
    draw, count, width = np.random.default_rng(seed), samples.label.size, samples.rows.shape[1]
    rows = [
        draw.normal(0, 1 / math.sqrt(width), (width, hidden)), np.zeros(hidden),
        draw.normal(0, 1 / math.sqrt(hidden), hidden), np.zeros(1),
    ]  # fmt: skip
    rows = [p.astype(np.float32) for p in rows]
    means, squares = ([np.zeros_like(p) for p in rows] for _ in range(2))
    size = min(BATCH, count)
    last, step = EPOCHS * (count // size), 0
    for _ in range(EPOCHS):
        order = draw.permutation(count)
        for k in range(count // size):
            step += 1
            rate = RATE / 2 * (1 + math.cos(math.pi * step / last))
            slopes = gradient(rows, samples.some(order[k * size : (k + 1) * size]))
            for i, g in enumerate(slopes):
                means[i] = MEAN * means[i] + (1 - MEAN) * g
                squares[i] = SQUARE * squares[i] + (1 - SQUARE) * g * g
                size_of = np.sqrt(squares[i] / (1 - SQUARE**step)) + SMALL
                rows[i] = rows[i] - (rate * means[i] / (1 - MEAN**step) / size_of).astype(np.float32)
    return rows


def _odds(now: Layers, some: Stack) -> tuple[np.ndarray, np.ndarray]:
    """The hidden layer by row, and the mean of each sample's odds' logarithms."""
    into, bias, out, base = now
    hidden = np.tanh(some.rows @ into + bias)
    return hidden, np.add.reduceat(hidden @ out, some.first) / some.count + base


def loss(now: Layers, some: Stack) -> float:
    """Return the mean weighted logistic loss, with the decay of the two layers' weights."""
    _, odds = _odds(now, some)
    value = np.mean(some.weight * (np.logaddexp(0, odds) - some.label * odds))
    return float(value + DECAY / 2 * (np.sum(now[0] ** 2) + np.sum(now[2] ** 2)))


def gradient(now: Layers, some: Stack) -> Layers:
    into, _, out, _ = now
    hidden, odds = _odds(now, some)
    wrong = some.weight * (1 / (1 + np.exp(-np.clip(odds, -30, 30))) - some.label) / some.label.size
    each = np.repeat(wrong / some.count, some.count)
    back = (each[:, None] * out) * (1 - hidden * hidden)
    return [
        some.rows.T @ back + DECAY * into, back.sum(axis=0), hidden.T @ each + DECAY * out,
        wrong.sum(keepdims=True),
    ]  # fmt: skip
