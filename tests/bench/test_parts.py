"""The benchmarks' own parts: nothing is asserted of time."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from bench import calculix
from bench.costs import alone, measured
from skincad.mechanics import default_sizes, pad_of
from tests.mechanics.designs import filleted, yamada

PRINTED = """
 displacements (vx,vy,vz) for set REFERENCE and time  0.1000000E+01

      4937  0.000000E+00 -1.663271E-01  0.000000E+00

 statistics for slave set RIDGE1, master set UNDER and time  0.1000000E+01

   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)

   -1.491300E-19 -5.442007E-03 -5.308000E-19 -2.720384E-14 -2.221845E-18  2.219331E-02

 statistics for slave set RIDGE2, master set UNDER and time  0.1000000E+01

   total surface force (fx,fy,fz) and moment about the origin (mx,my,mz)

   -1.030183E-19 -3.072085E-02 -1.268648E-19  4.051365E-14  5.468852E-19  9.460409E-02
"""


def test_calculix_output_is_read() -> None:
    shares, approach = calculix.read(PRINTED, 2)
    assert shares.tolist() == [5.442007e-3, 3.072085e-2]
    assert approach == 0.1663271


def test_calculix_output_without_forces_is_refused() -> None:
    with pytest.raises(RuntimeError, match="no contact forces"):
        calculix.read(PRINTED, 3)


@pytest.mark.skipif(bool(calculix.missing()), reason=calculix.missing())
def test_quads_fill_the_section(tmp_path: Path) -> None:
    pad = pad_of(filleted())
    mesh = calculix.quads(pad, default_sizes(pad, 0.25), tmp_path)
    x, z = mesh.nodes[mesh.elements].transpose(2, 0, 1)
    ring = [0, 4, 1, 5, 2, 6, 3, 7]  # corners and middles in turn
    x, z = x[:, ring], z[:, ring]
    areas = (x * np.roll(z, -1, axis=1) - np.roll(x, -1, axis=1) * z).sum(axis=1) / 2
    assert (areas > 0).all()
    # arcs by two chords an edge: their sagittas are 2e-4 of the area at this fineness
    assert areas.sum() == pytest.approx(pad.section.area, rel=1e-3)
    assert sorted(mesh.faces) == list(pad.ridges)
    assert (mesh.nodes[mesh.back, 1] == 0).all()


def test_calculix_is_not_given_strips(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="without slots"):
        calculix.quads(pad_of(yamada()), default_sizes(pad_of(yamada()), 0.25), tmp_path)


def test_time_at_equal_error() -> None:
    seconds, errors = np.array([1.0, 4.0, 2.0, 16.0]), np.array([1e-1, 1e-2, 2e-1, 1e-3])
    # the row of 2 s is beaten by that of 1 s; between 4 s and 16 s time goes as error^(-log 4 / log 10)
    assert calculix.time_at(10**-2.5, seconds, errors) == pytest.approx(8.0)
    assert calculix.time_at(1.0, seconds, errors) == pytest.approx(1.0)
    assert math.isnan(calculix.time_at(1e-4, seconds, errors))


@pytest.mark.slow
def test_alone_measures_another_process() -> None:
    row = alone(measured, "winkler")
    assert row["unknowns"] == 9
    assert row["peak_MB"] > 10  # an interpreter with numpy
    with pytest.raises(RuntimeError, match="KeyError"):
        alone(measured, "no-such-model")
