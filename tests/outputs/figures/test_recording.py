"""The recorder's picture: what is recorded and where not, phases, and what the caption says is not seen."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from skincad.outputs import save
from skincad.outputs.figures import scenes


def scene(rate: float = 1300.0, sampling: float | None = 650.0, **changes: Any) -> Any:
    """A second of outputs of ridges 2 and 3: a slow sine, and a fast one that 650 Hz does not show."""
    time = np.arange(int(rate) + 1) / rate
    slow, fast = np.sin(2 * np.pi * 5.0 * time), np.sin(2 * np.pi * 600.0 * time)
    outputs = {
        r: {"S1": slow.tolist(), "S2": (-slow).tolist(), "pair": (2 * slow + fast).tolist()} for r in "23"
    }
    read = {
        "output_V": outputs,
        "sampling_Hz": sampling,
        "circuit": "mine",
        "signal_to_noise_dB": {"3": 20.0},
    }
    half = int(rate / 2)
    fields = {
        "read": read,
        "march": SimpleNamespace(time=time, column=lambda _: np.maximum(time - 0.2, 0.0)),
        "scene": SimpleNamespace(name="made-up", readout=SimpleNamespace(bandwidth_Hz=160.0)),
        "slip_steps": [None, half - 100, half, *6 * [None]],
        "gross_slip_step": half + 200,
    }
    return SimpleNamespace(**{**fields, **changes})


def test_it_is_ridge_3_at_the_recorders_rate_without_what_would_fold_back() -> None:
    seen = scenes.recording(scene())
    assert seen is not None
    assert (seen.ridge, seen.pair.rate) == (3, 650.0)
    at = np.arange(seen.pair.values.size) / 650.0
    middle = slice(65, -65)  # beyond the filter's ends
    exact = 2 * np.sin(2 * np.pi * 5.0 * at)
    # 600 Hz would fold to 50 Hz at full size; 80 dB of filter leave 1e-4, its ripple 1e-3
    assert np.abs(seen.pair.values - exact)[middle].max() < 3e-3


@pytest.mark.parametrize(
    "simulation",
    [
        scene(sampling=None),
        scene(rate=500.0),  # the march's steps are coarser than the recorder's
        scene(sampling=40.0),  # a second has 40 samples
        scene(sampling=649.99999),
        scene(read={}),
    ],
)
def test_where_there_is_nothing_to_record_nothing_is_drawn(simulation: Any) -> None:
    assert scenes.recording(simulation) is None


def test_the_phases_are_the_papers() -> None:
    spans = scenes.phases(scene(), 3)
    assert list(spans) == ["$P_A$", "$P_B$"]
    (start, slip), (again, end) = spans.values()
    assert start == pytest.approx(0.2, abs=2e-3)  # a thousandth of the largest pull
    assert slip == again == pytest.approx(0.5)
    assert end == pytest.approx(0.5 + 200 / 1300)
    assert scenes.phases(scene(slip_steps=9 * [None]), 3) == {}


def test_the_caption_says_what_is_not_seen() -> None:
    simulation = scene()
    seen = scenes.recording(simulation)
    assert seen is not None
    text = scenes.caption(simulation, seen)
    assert "True up to 160 Hz: neither the cut-off at 1.2 kHz" in text
    assert "Samples are 1.54 ms apart: no shorter lead time is claimed." in text
    assert "20 dB" in text
    assert "of the signal's power lies above 260 Hz" in text
    wide = scene(rate=20000.0, sampling=10000.0)
    wide.scene.readout.bandwidth_Hz = 2000.0
    record = scenes.recording(wide)
    assert record is not None
    assert "1.2 kHz" not in scenes.caption(wide, record)


@pytest.mark.slow
def test_the_picture_is_drawn(tmp_path: Path) -> None:
    simulation = scene()
    seen = scenes.recording(simulation)
    assert seen is not None
    save(scenes.recording_figure(simulation, seen), tmp_path / "one.png")
    assert (tmp_path / "one.png").read_bytes().startswith(b"\x89PNG")
    save(
        scenes.recording_figure(scene(gross_slip_step=None, slip_steps=9 * [None]), seen),
        tmp_path / "other.png",
    )
