"""The page of `skincad listen`: channels and alarms as they come, in a browser of this machine alone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest

from skincad.base import InputError
from skincad.detector import Block, Detector, Listener, Wire, wire_of
from skincad.live import ChannelsPage, channels, envelope
from tests.live.browser import looking

RATE, RIDGES = 1000.0, (3, 4)


def blocks(count: int) -> tuple[Listener, Wire, list[Block]]:
    """Blocks of 100 samples of two ridges: each strip at its own bias, and one peak of a volt in S2 of 4."""
    detector = Detector("yamada-2002", "transimpedance", RATE, RIDGES)
    wire = wire_of(detector, "board")
    values = np.full((count, 4), 1.65) + np.arange(4) / 10
    values[max(0, count - 700), 3] += 1.0
    head = "sample,ridge_3_S1_V,ridge_3_S2_V,ridge_4_S1_V,ridge_4_S2_V\n"
    rows = [f"{k},{','.join(map(repr, row))}\n" for k, row in enumerate(values.tolist())]
    pieces = [head, *("".join(rows[k : k + 100]) for k in range(0, count, 100))]
    return Listener(detector), wire, [block for piece in pieces for block in wire.push(piece.encode())]


def test_an_envelope_has_few_points_and_each_peak() -> None:
    time, values = np.arange(10_000) / RATE, np.zeros((10_000, 2))
    values[[1234, 7777], [0, 1]] = 5.0, -3.0
    stamps, ends = envelope(time, values)
    assert stamps.shape == (ends.shape[0],) == (channels.POINTS,)
    assert (ends.max(axis=0).tolist(), ends.min(axis=0).tolist()) == ([5.0, 0.0], [0.0, -3.0])
    assert abs(stamps[np.argmax(ends[:, 0])] - 1.234) < 2 * 10 / channels.POINTS
    assert (np.diff(stamps) > 0).all()
    np.testing.assert_array_equal(envelope(time[:300], values[:300])[1], values[:300])


def test_the_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(channels, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"page: needs the package viser; pip install 'skincad\[live\]'"):
        ChannelsPage(blocks(100)[0], "board")


@pytest.fixture
def page() -> Iterator[ChannelsPage]:
    listener, _, parts = blocks(8000)
    page = ChannelsPage(listener, "my <skin>")
    for block in parts:
        page.update(block, listener.hear(block))
    page.draw()
    yield page
    page.close()


@pytest.mark.slow
def test_the_last_seconds_less_their_rest_are_shown(page: ChannelsPage) -> None:
    assert [*page.plots] == [*RIDGES]
    time, s1, s2 = page.plots[4].data
    assert time[-1] - time[0] <= channels.SPAN
    assert time[-1] == pytest.approx(8.0, abs=channels.SPAN / channels.POINTS * 4)
    np.testing.assert_allclose(s1, 0.0, atol=1e-9)
    assert (s2.max(), np.abs(page.plots[3].data[2]).max()) == (
        pytest.approx(1.0),
        pytest.approx(0.0, abs=1e-9),
    )
    assert "<b>my &lt;skin&gt;</b>: 4 channels at 1000 Hz" in page.words
    assert "8.0 s, 0 alarms, 0 samples lost" in page.words


@pytest.mark.slow
def test_events_are_listed_newest_first(page: ChannelsPage) -> None:
    _, _, (block, *_) = blocks(100)
    slip = {"kind": "incipient slip", "ridge": 3, "sample": 7, "time_s": 0.007}
    ahead = {"kind": "gross slip ahead", "ridge": None, "sample": 9, "time_s": 0.009}
    page.update(block, [slip, ahead])
    page.draw()
    assert page.words.index("0.009 s: gross slip ahead") < page.words.index(
        "0.007 s: incipient slip, ridge 3"
    )


@pytest.mark.slow
@pytest.mark.dear("a browser draws by software")
def test_a_browser_shows_it(page: ChannelsPage) -> None:
    with looking(page.address) as (seen,):
        seen.wait_for("4 channels at 1000 Hz")
        seen.wait_for("ridge 4")
        assert seen.page.locator(".u-over").count() == len(RIDGES)
        assert not seen.complaints
