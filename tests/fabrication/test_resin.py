"""Exposure of a print of resin, counted layer by layer."""

from __future__ import annotations

import pytest

from skincad.fabrication.estimates import exposure_time
from skincad.inputs import processes

SLA = processes()["sla"]


def counted(layers: int) -> float:
    """As PrusaSlicer counts: three layers at the first exposure, then each by a step less."""
    usual, first = SLA.exposure, SLA.first_exposure
    step, total, exposure = (first - usual) / (SLA.fading + 1), 0.0, first
    for layer in range(layers):
        if layer >= SLA.first_layers:
            exposure = max(usual, exposure - step)
        total += exposure + SLA.lift
    return total


@pytest.mark.parametrize("layers", [1, 2, 3, 4, 12, 13, 14, 80, 461])
def test_layers_fade_to_the_usual_exposure(layers: int) -> None:
    assert exposure_time(layers * SLA.layer, SLA) == pytest.approx(counted(layers))


def test_the_least_print_is_one_layer() -> None:
    assert exposure_time(0.01, SLA) == SLA.first_exposure + SLA.lift
