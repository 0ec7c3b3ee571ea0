"""The exam's scenes behind an amplifier: outputs of every strip without noise, and noise of any seed.

Both are Chain's, for all strips at once: what the chain makes of one step's change of charge is asked of it
once, and the rest follows by superposition; noise has its density, drawn as one period of all strips.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from scipy.signal import fftconvolve

from bench.exam.scenes import SceneRun
from skincad.circuit import circuit_network, corner, load_circuit, total_density
from skincad.effects import Chain, fitted, strip_charges
from skincad.scenes import intervals


@dataclass(frozen=True, eq=False)
class Case:
    """Outputs `(n, ridges, 2)` V of the told ridges; `slipping` `(n, ridges)` of them; `gross` the step at
    which all slip, which ends it; `noise` V rms of a strip; `density` V of a strip's noise by rfft's bins."""

    scene: SceneRun
    circuit: str
    rate: float
    outputs: np.ndarray
    slipping: np.ndarray
    noise: float
    density: np.ndarray
    fine: int

    @property
    def gross(self) -> int | None:
        """The step of gross slip."""
        return self.scene.gross

    @cached_property
    def runs(self) -> list[list[list[int]]]:
        """When each told ridge slips, [from, to]."""
        return [intervals(column) for column in self.slipping.T]

    def noises(self, seed: int) -> np.ndarray:
        """Return noise as `outputs`, V, of a seed."""
        n, ridges, _ = self.outputs.shape
        draw = np.random.default_rng((seed, abs(self.scene.seed)))
        shape = (2, self.density.size, 2 * ridges)
        parts = draw.standard_normal(shape) * self.density[:, None]
        size = 2 * (self.density.size - 1)
        found = np.fft.irfft(parts[0] + 1j * parts[1], size, axis=0)[:: self.fine][:n]
        return found.reshape(n, ridges, 2)

    def differenced(self) -> Case:
        """Return the case with its outputs' rate, V/s, by the sample before; so for what tells the stress."""
        count = self.density.size - 1
        turn = np.pi * np.arange(count + 1) * self.fine / (2 * count)
        sizes = self.density * 2 * np.abs(np.sin(turn)) * self.rate
        outputs = np.diff(self.outputs, axis=0, prepend=self.outputs[:1]) * self.rate
        return replace(self, outputs=outputs, density=sizes, noise=rms(sizes))

    def told(self, ridges: tuple[int, ...]) -> Case:
        """Return the case of some of its ridges, from 1."""
        at = np.array(ridges) - 1
        return replace(self, outputs=self.outputs[:, at], slipping=self.slipping[:, at])


def case(scene: SceneRun, circuit: str, folder: Path) -> Case:
    """Return a scene behind a circuit, all ridges told, up to its gross slip; outputs are kept on disk."""
    end = scene.time.size if scene.gross is None else scene.gross + 1
    time = scene.time[:end]
    own = fitted(load_circuit(circuit), scene.skin.design)
    network = circuit_network(own)
    chain = Chain.of(network, time, scene.bandwidth)
    path = folder / f"{scene.seed}-{circuit}.npz"
    if not path.exists():
        charges = strip_charges(own, scene.skin.design, scene.stress[:end])
        folder.mkdir(parents=True, exist_ok=True)
        np.savez(path, outputs=_outputs(chain, charges), density=density(chain))
    with np.load(path) as data:
        outputs, sizes = data["outputs"], data["density"]
    return Case(
        scene, circuit, 1 / float(time[1]), outputs.reshape(end, -1, 2), scene.slipping[:end], rms(sizes),
        sizes, chain.fine,
    )  # fmt: skip


def rms(sizes: np.ndarray) -> float:
    """Return the V rms of noise of a density by rfft's bins, as Case has it."""
    return float(np.sqrt(2 * np.sum(sizes[1:] ** 2))) * np.sqrt(2) / (2 * (sizes.size - 1))


def _outputs(chain: Chain, charges: np.ndarray) -> np.ndarray:
    """Return `chain.output` of each column of `charges` `(n, strips)` C."""
    hat = np.zeros(charges.shape[0])
    hat[1] = 1.0
    answer = chain.output(hat)[1:]
    moved = charges - charges[0]
    return np.asarray(fftconvolve(moved, answer[:, None], axes=0)[: charges.shape[0]])


def density(chain: Chain) -> np.ndarray:
    """Return the size of each rfft bin's real and imaginary part, behind the low-pass, of a period."""
    size = max(1024, 2 * ((chain.count * chain.fine + 1) // 2))
    frequency = np.fft.rfftfreq(size, 1 / chain.step.rate)
    power = total_density(chain.network, frequency[1:])
    passed = 1 / (1 + (2 * np.pi * frequency[1:] / corner(chain.bandwidth)) ** 2)
    answer = np.zeros(frequency.size)
    answer[1:] = np.sqrt(power * chain.step.rate * size / 4) * passed
    return answer
