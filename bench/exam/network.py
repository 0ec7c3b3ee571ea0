"""Fit the detector's network, one hidden layer, to weighted samples: logistic loss, by Adam.

Kingma and Ba, Adam: a method for stochastic optimization, arXiv:1412.6980, with its usual constants; the rate
falls as half a cosine. By cross-validation 24 hidden units are worse, two layers and more epochs no better.
"""

from __future__ import annotations

import math

import numpy as np

from skincad.scenes import detector

Parts = tuple[np.ndarray, np.ndarray, np.ndarray]
Layers = list[np.ndarray]  # into `(features, hidden)`, bias `(hidden,)`, out `(hidden,)`, base `(1,)`

HIDDEN, EPOCHS = 96, 8
RATE, DECAY, BATCH = 3e-3, 1e-5, 2048
MEAN, SQUARE, SMALL = 0.9, 0.999, 1e-8


def fitted(parts: Parts, seed: int = 0) -> detector.Weights:
    """Return the network that fits samples: features `(m, features)`, labels `(m,)`, weights `(m,)`."""
    x, y, w = parts
    middle, spread = x.mean(axis=0), x.std(axis=0) + 1e-3
    z, label, weight = ((x - middle) / spread).astype(np.float32), y.astype(np.float32), w / w.mean()
    into, bias, out, base = (p.astype(float) for p in layers(z, label, weight.astype(np.float32), seed))
    into = into / spread[:, None]
    return detector.Weights(into, bias - middle @ into, out, float(base[0]))


def layers(z: np.ndarray, label: np.ndarray, weight: np.ndarray, seed: int) -> Layers:
    """Return the fitted layers, from a seeded start."""
    draw, (count, width) = np.random.default_rng(seed), z.shape
    rows = [
        draw.normal(0, 1 / math.sqrt(width), (width, HIDDEN)), np.zeros(HIDDEN),
        draw.normal(0, 1 / math.sqrt(HIDDEN), HIDDEN), np.zeros(1),
    ]  # fmt: skip
    rows = [p.astype(np.float32) for p in rows]
    means, squares = ([np.zeros_like(p) for p in rows] for _ in range(2))
    size = min(BATCH, count)
    last, step = EPOCHS * (count // size), 0
    for _ in range(EPOCHS):
        order = draw.permutation(count)
        for k in range(count // size):
            at = order[k * size : (k + 1) * size]
            step += 1
            rate = RATE / 2 * (1 + math.cos(math.pi * step / last))
            slopes = gradient(rows, z[at], label[at], weight[at])
            for i, g in enumerate(slopes):
                means[i] = MEAN * means[i] + (1 - MEAN) * g
                squares[i] = SQUARE * squares[i] + (1 - SQUARE) * g * g
                size_of = np.sqrt(squares[i] / (1 - SQUARE**step)) + SMALL
                rows[i] = rows[i] - (rate * means[i] / (1 - MEAN**step) / size_of).astype(np.float32)
    return rows


def loss(now: Layers, z: np.ndarray, label: np.ndarray, weight: np.ndarray) -> float:
    """Return the mean weighted logistic loss, with the decay of the two layers' weights."""
    into, bias, out, base = now
    odds = np.tanh(z @ into + bias) @ out + base
    value = np.mean(weight * (np.logaddexp(0, odds) - label * odds))
    return float(value + DECAY / 2 * (np.sum(into**2) + np.sum(out**2)))


def gradient(now: Layers, z: np.ndarray, label: np.ndarray, weight: np.ndarray) -> Layers:
    """Return the loss's gradient, by layer."""
    into, bias, out, base = now
    hidden = np.tanh(z @ into + bias)
    odds = np.clip(hidden @ out + base, -30, 30)
    wrong = weight * (1 / (1 + np.exp(-odds)) - label) / label.size
    back = (wrong[:, None] * out) * (1 - hidden * hidden)
    return [
        z.T @ back + DECAY * into, back.sum(axis=0), hidden.T @ wrong + DECAY * out,
        wrong.sum(keepdims=True),
    ]  # fmt: skip
