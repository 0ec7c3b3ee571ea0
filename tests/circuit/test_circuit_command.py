"""`skincad circuit` as a user meets it, and the rig of a frequency test, none of which is in use."""

from __future__ import annotations

import json
import math
from functools import cache, partial
from pathlib import Path
from types import SimpleNamespace
from typing import get_args

import numpy as np
import pytest
from annotated_types import Gt
from scipy.optimize import least_squares

from skincad.base import Table
from skincad.circuit import (
    Circuit,
    CircuitGain,
    bode,
    circuit_network,
    constants,
    film_load,
    gain,
    load_circuit,
    netlist,
    told_rig,
    without_rig,
)
from skincad.circuit.calibrate import calibrate
from skincad.inputs import retyped, template_names
from tests.circuit.paper import paper_target
from tests.conftest import run_skincad
from tests.refusals import refused_by, refused_command

KEYS = {"name", "constants", "frequency_Hz", "gain_dB"}
KEYS |= {"cutoff_Hz", "slope_below_dB_per_dec", "slope_above_dB_per_dec"}
FILES = {"gain.csv", "gain.png", "netlist.cir", "circuit.json"}


@cache
def gain_of(name: str, *settings: str) -> CircuitGain:
    """The gain of a shipped circuit."""
    return gain(load_circuit(name, list(settings)))


def test_it_prints_the_contracts_json_and_writes_what_it_lists(tmp_path: Path) -> None:
    process = run_skincad("circuit", "yamada-2002", "--json", cwd=tmp_path)
    assert (process.returncode, process.stderr) == (0, "")
    data = json.loads(process.stdout)
    assert data.keys() >= KEYS
    assert len(data["frequency_Hz"]) == len(data["gain_dB"]) == 400
    assert (data["frequency_Hz"][0], data["frequency_Hz"][-1]) == (10.0, pytest.approx(20_000.0))
    assert all(data[key].keys() == {"value", "error"} for key in KEYS if "_per_dec" in key or "cut" in key)
    assert data["cutoff_Hz"]["value"] == pytest.approx(1200.0, rel=0.05)
    assert {p.name for p in (tmp_path / "out/yamada-2002").iterdir()} == FILES
    assert all((tmp_path / f["path"]).stat().st_size == f["bytes"] for f in data["files"])
    assert any("650 Hz" in w for w in data["warnings"])
    own_signal = data["own_signal"]
    assert len(own_signal["gain_dB"]) == 400
    assert own_signal["cutoff_Hz"]["value"] is None
    # 1e5 of gain behind 100 pF: 20 dB/dec but for the film's resonance at 57 kHz
    assert own_signal["slope_below_dB_per_dec"]["value"] == pytest.approx(20.0, abs=0.01)
    head, *rows = (tmp_path / "out/yamada-2002/gain.csv").read_text().splitlines()
    assert head == "frequency_Hz,gain_dB,gain_less_offset_dB,own_gain_dB"
    assert [float(row.split(",")[3]) for row in rows] == pytest.approx(own_signal["gain_dB"], abs=1e-6)


@pytest.mark.slow
def test_the_papers_curve_is_told_with_its_rig_and_the_films_signal_without(tmp_path: Path) -> None:
    text = run_skincad("circuit", "yamada-2002", "-o", "one", cwd=tmp_path).stdout
    first, *_ = text.splitlines()
    assert first.startswith("yamada-2002: the gain rises by 19.8")
    assert first.endswith("as measured with its rig.")
    assert "  own signal     by the load on the film the gain rises by 19.998" in text
    assert "not the film's, by the indenter at 9000 Hz and the force sensor at 1200 Hz" in text
    plain = run_skincad("circuit", "transimpedance", cwd=tmp_path).stdout
    assert "rig" not in plain
    assert "own signal" not in plain
    assert run_skincad("circuit", "yamada-2002", "-o", "two", cwd=tmp_path).returncode == 0
    for name in FILES:  # the same bytes again
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes(), name


MAKE = ("make", "plain-ridges", "--set", "ridge.count=3", "--no-check", "--format", "md")


@pytest.mark.slow
def test_a_designs_files_in_the_same_folder_stay(tmp_path: Path) -> None:
    for command in (("circuit", "yamada-2002"), MAKE):
        before = {p.name for p in (tmp_path / "here").glob("*")}
        assert run_skincad(*command, "-o", "here", cwd=tmp_path).returncode == 0
        assert {p.name for p in (tmp_path / "here").iterdir()} >= before | FILES
    before = {p.name for p in (tmp_path / "here").iterdir()}
    assert "make.json" in before
    assert run_skincad("circuit", "yamada-2002", "-o", "here", cwd=tmp_path).returncode == 0
    assert {p.name for p in (tmp_path / "here").iterdir()} == before


@pytest.mark.slow
def test_a_calibration_to_measured_data_is_a_circuit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The shipped network's curve at another damping, 0.1 dB of noise. By ten starts: how many end at the
    best is test_calibrate's."""
    monkeypatch.setattr(bode, "calibrate", partial(calibrate, starts=10))
    curve = gain(load_circuit("yamada-2002-motional", ["motional.resistance=40000.0", "indenter=none"]))
    noise = np.random.default_rng(1).normal(0.0, 0.1, curve.gain.size) - 166.0
    rows = [f"{f},{g}" for f, g in zip(curve.frequency, curve.gain + noise, strict=True) if f < 8000]
    (tmp_path / "m.csv").write_text("\n".join(["frequency_Hz,gain_dB", *rows[::8]]) + "\n")
    measured = ("yamada-2002-motional", "--measured", "m.csv", "-o", "o", "--set", "indenter=none")
    assert "  calibrated     " in run_skincad("circuit", *measured, cwd=tmp_path).stdout
    process = run_skincad("circuit", *measured, "--json", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    data = json.loads(process.stdout)
    assert data["calibration"]["rms_dB"] == pytest.approx(0.1, abs=0.03)  # the noise, and no more
    again = run_skincad("circuit", "o/calibrated.toml", "-o", "p", "--json", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    np.testing.assert_allclose(json.loads(again.stdout)["gain_dB"], data["gain_dB"], atol=1e-6)


def measured_gain(monkeypatch: pytest.MonkeyPatch, file: Path, frequency: np.ndarray, level: np.ndarray):
    """The paper's gain against a measured curve to which its own constants are calibrated, and what they
    are calibrated to."""
    targets = []

    def calibrated(*target: np.ndarray, **_: object) -> SimpleNamespace:
        targets.append(target)
        return SimpleNamespace(constants=constants(circuit))

    circuit = load_circuit("yamada-2002")
    monkeypatch.setattr(bode, "calibrate", calibrated)
    rows = [f"{f:.17g},{g:.17g}" for f, g in zip(frequency, level, strict=True)]
    file.write_text("\n".join(["frequency_Hz,gain_dB", *rows]))
    curve = gain(circuit, file)
    ((target, wanted),) = targets
    return curve, target, wanted


def test_a_rig_is_taken_off_a_measured_curve(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The network's own curve comes out, whatever the rig makes of it; drawn again with the rig it is the
    measured one."""
    curve = gain_of("yamada-2002")
    again, _, level = measured_gain(monkeypatch, tmp_path / "m.csv", curve.frequency, curve.gain)
    assert level == pytest.approx(curve.own.gain[: level.size], abs=1e-9)
    assert again.gain == pytest.approx(curve.gain, abs=1e-9)


@pytest.mark.parametrize(("last", "fitted"), [(20_000.0, 8000.0), (4000.0, 4000.0)])
def test_a_measured_curve_is_fitted_to_its_end_or_the_sweeps(
    last: float, fitted: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beyond 8 kHz a curve may drop, as the paper's does, which is no slope of the network."""
    frequency = np.append(np.geomspace(10.0, 8000.0, 200), np.geomspace(8001.0, 20_000.0, 50))
    level = np.where(frequency < 1200.0, 20.0, 60.0) * np.log10(frequency / 1200.0)
    level[frequency > 8000.0] -= 60.0
    used = frequency <= last
    curve, target, _ = measured_gain(monkeypatch, tmp_path / "m.csv", frequency[used], level[used])
    assert curve.measured.slopes.cutoff.value == pytest.approx(1200.0, rel=2e-3)  # the minimiser's tolerance
    assert curve.measured.slopes.above.value == pytest.approx(60.0, abs=0.1)
    assert target[-1] == frequency[frequency <= fitted][-1]


@pytest.mark.slow
def test_the_noise_the_rest_and_the_rails_are_told(tmp_path: Path) -> None:
    text = run_skincad("circuit", "single-supply", "-o", "one", cwd=tmp_path).stdout
    assert "  noise          0.11 mV rms at the output, 10 to 2500 Hz\n" in text
    assert "  rest           the amplifier rests at 1.65 V and 0.05 mV by its input bias current" in text
    assert "  rails          the output stops at -1.63 and 1.63 V\n" in text
    data = json.loads(run_skincad("circuit", "single-supply", "--json", cwd=tmp_path).stdout)
    assert data["output_swing_V"] == pytest.approx([-1.63, 1.63], abs=1e-3)
    assert data["output_offset_V"] == pytest.approx(5e-5, rel=1e-3)
    assert data["noise_band_Hz"] == [10.0, 2500.0]
    plain = gain_of("transimpedance")
    assert (plain.output_swing, plain.output_offset) == ((None, None), 0.0)
    # up to 20 kHz, V/sqrt(Hz) there: 100 Mohm's own noise is even; the voltage noise over 33 pF and the 13 nV
    # of 10 kohm over the film's 22 pF rise as f; the film's loss, 11 pF times 0.02, as its root
    charge_way = 2 * np.pi * 2e4 * 1e8  # V at 20 kHz by V and F
    parts = [
        1.27e-6 * math.sqrt(2e4),
        10e-9 * charge_way * 32.5e-12 * math.sqrt(2e4 / 3),
        12.7e-9 * charge_way * 22.5e-12 * math.sqrt(2e4 / 3),
        math.sqrt(4 * 1.38e-23 * 293 * 2 * np.pi * 2e4 * 11.4e-12 * 0.02) * 1e8 * math.sqrt(2e4 / 2),
    ]
    assert plain.output_noise == pytest.approx(math.hypot(*parts), rel=0.05)  # and the film's resonance
    told = run_skincad("circuit", "transimpedance", "-o", "two", cwd=tmp_path).stdout
    assert "rails" not in told
    assert "rest " not in told


def test_a_branch_larger_than_the_film_and_a_slow_sampling_are_warnings() -> None:
    def warns(words: str, name: str, *settings: str) -> bool:
        return any(words in warning for warning in gain_of(name, *settings).warnings)

    assert warns("motional capacitance", "yamada-2002-motional")
    assert not warns("motional capacitance", "yamada-2002")
    assert warns("sampled at", "yamada-2002", "sampling.rate=650.0")
    assert not warns("sampled at", "yamada-2002", "sampling.rate=20000.0")


@pytest.mark.parametrize(("name", "deviation"), [("yamada-2002", 0.26), ("yamada-2002-motional", 1.73)])
def test_both_readings_are_as_near_to_the_paper_as_they_say(name: str, deviation: float) -> None:
    """20 dB/dec to 1.2 kHz, then 60, level free: their first lines say it, the network's without indenter."""
    curve = gain_of(name)
    frequency, wanted = paper_target()
    rest = np.interp(np.log(frequency), np.log(curve.frequency), curve.gain) - wanted
    assert np.std(rest) == pytest.approx(deviation, abs=0.01)


def test_the_papers_rig_is_the_nearest_to_its_statements() -> None:
    """Both dampings, the resonances being the paper's 1.2 and 9 kHz, over 20 dB/dec: to the template's
    digits."""
    frequency, wanted = paper_target()

    def misfit(point: np.ndarray) -> np.ndarray:
        ratios = zip((frequency / 1200.0, frequency / 9000.0), point, strict=True)
        sensor, indenter = (1 - r**2 + 2j * damping * r for r, damping in ratios)
        rest = 20 * np.log10(frequency * np.abs(sensor / indenter)) - wanted
        return np.asarray(rest - rest.mean())

    circuit = load_circuit("yamada-2002")
    dampings = least_squares(misfit, [0.3, 0.9]).x
    assert dampings == pytest.approx([circuit.force_sensor.damping, circuit.indenter.damping], abs=0.01)


@pytest.mark.parametrize("name", template_names("circuits"))
def test_every_template_runs(name: str) -> None:
    curve = gain_of(name)
    assert np.isfinite(curve.gain).all()
    assert curve.slopes.below.value is not None
    if name == "transimpedance":  # a rate sensor without a rig
        assert curve.slopes.cutoff.value is None
        assert curve.slopes.below.value == pytest.approx(20.0, abs=0.01)
        assert curve.own is None
        assert "own_signal" not in curve.as_json()


FREQUENCY = np.geomspace(1.0, 1e5, 51)
INDENTER, SENSOR = "indenter={resonance=9000.0,damping=0.5}", "force_sensor={resonance=1000.0,damping=0.25}"


def test_an_indenter_keeps_load_from_the_film_and_a_sensor_from_the_reading() -> None:
    """Far above either resonance, the square of the ratio, by mass alone; both below, all of the load."""
    plain, with_indenter, with_sensor, both = (
        load_circuit("transimpedance", list(parts))
        for parts in ((), (INDENTER,), (SENSOR,), (INDENTER, SENSOR))
    )
    far, low = np.array([1e7]), np.array([1.0])
    np.testing.assert_array_equal(film_load(plain, FREQUENCY), np.ones(51))
    assert np.abs(film_load(with_indenter, far)) == pytest.approx((9000.0 / 1e7) ** 2, rel=1e-3)
    assert np.abs(film_load(with_sensor, far)) == pytest.approx((1e7 / 1000.0) ** 2, rel=1e-3)
    product = film_load(with_indenter, FREQUENCY) * film_load(with_sensor, FREQUENCY)
    np.testing.assert_allclose(film_load(both, FREQUENCY), product, rtol=1e-12)
    assert np.abs(film_load(both, low)) == pytest.approx(1.0, abs=2e-6)  # (1 / 1000)^2
    words = "the indenter at 9000 Hz", "the force sensor at 1000 Hz"
    rigs = [told_rig(circuit) for circuit in (with_indenter, with_sensor, both)]
    assert rigs == [*words, " and ".join(words)]


def test_the_film_feels_the_probes_inertia_that_its_force_sensor_does_not_read() -> None:
    """A mass and a damped spring in numbers: the film's force is m a + c v + k x, the sensor's k x; a filter
    between, of the same two poles, is the sensor's amplifier."""
    circuit = load_circuit("yamada-2002", ["indenter=none", "force_sensor={resonance=1000.0,damping=0.25}"])
    curve = gain(circuit)
    k, m = 4e6, 4e6 / (2 * np.pi * 1000.0) ** 2  # N/m, kg
    c = 2 * 0.25 * np.sqrt(k * m)
    jw = 2j * np.pi * curve.frequency
    assert curve.gain - curve.own.gain == pytest.approx(20 * np.log10(np.abs(m * jw**2 + c * jw + k) / k))


def test_the_circuit_in_use_is_the_same_film_and_amplifier_an_indenter_an_option() -> None:
    circuit = load_circuit("yamada-2002")
    used = without_rig(circuit)
    whole, alone = gain_of("yamada-2002"), gain(used)
    np.testing.assert_array_equal(alone.gain, whole.own.gain)
    assert alone.own is None
    assert circuit_network(used) == circuit_network(circuit)
    assert netlist(alone.network, "x") == netlist(whole.network, "x")
    words = retyped(used, "circuits", load_circuit)
    assert words == "yamada-2002 --set indenter=none --set force_sensor=none"
    with_it, without = gain_of("yamada-2002-motional"), gain_of("yamada-2002-motional", "indenter=none")
    drop = with_it.gain - without.gain
    assert drop[0] == pytest.approx(0.0, abs=1e-4)  # (10 / 9000)^2
    nearest = int(np.argmin(np.abs(with_it.frequency - 9000.0)))
    assert drop[nearest] == pytest.approx(-20 * np.log10(2 * 0.5), abs=0.2)  # 1 / (2 damping), by the grid
    assert drop[-1] < -10.0  # at 20 kHz, 40 dB/dec above 9 kHz


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("motional.capacitance=0.0", "motional.capacitance: must be greater than 0 (F)"),
        ("amplifier.series_resistance=-1.0", "amplifier.series_resistance: must be greater than 0 (ohm)"),
        ("amplifier.gain=nan", "amplifier.gain: must be a finite number"),
        ("amplifier.gain=0.0", "amplifier.gain: must be greater than 0"),
        ("amplifier.output_resistance=0.99e-12", "amplifier.output_resistance: must be at least 1e-12 ohm"),
        ("film.area=0.0", "film.area: must be greater than 0 (mm2)"),
        ("film.d33=0.0", "film.d33: must not be 0 pC/N"),
        ("film.aera=1.0", "film.aera: unknown key; did you mean 'area'?"),
        ("motional=none", "motional: is missing"),
        ("sampling.rate=15.0", "sampling.rate: must be above 20 Hz (twice sweep.low)"),
        ("sampling.rate=20.0", "sampling.rate: must be above 20 Hz"),
        ("sweep.fit_high=50.0", "sweep.fit_high: must be from 100 Hz (10 times low)"),
        ("sweep.points=20", "sweep.points: must give at least 20"),
    ],
)
def test_bad_constants_are_told(setting: str, words: str) -> None:
    with refused_by(words):
        gain(load_circuit("yamada-2002", [setting]))


def test_constants_at_their_limits_are_taken() -> None:
    circuit = load_circuit("yamada-2002", ["amplifier.output_resistance=1e-12", "sampling.rate=20.1"])
    assert circuit.amplifier.output_resistance == 1e-12
    assert circuit.sampling.rate == 20.1
    kinds = [kind for f in Circuit.model_fields.values() for kind in (f.annotation, *get_args(f.annotation))]
    tables = [kind for kind in kinds if isinstance(kind, type) and issubclass(kind, Table)]
    assert len(tables) == 9
    for table in tables:
        for name, field in table.model_fields.items():
            for rule in field.metadata:
                assert not isinstance(rule, Gt) or rule.gt == 0.0, (table, name)


def test_the_sweeps_defaults_are_the_papers_and_it_may_be_as_slow_as_one_likes() -> None:
    paper = load_circuit("yamada-2002").sweep
    sweep = type(paper)
    assert sweep().model_dump() == {**paper.model_dump(), "offset": 0.0}
    for end in (1e-2, 1e-1):  # the fit's range: from a decade, to all of it
        assert sweep(low=1e-3, high=1e-1, fit_high=end).low == 1e-3
    for end in (0.99e-2, 1.01e-1):
        with refused_by("fit_high: must be from 0.01 Hz (10 times low) to 0.1 Hz"):
            sweep(low=1e-3, high=1e-1, fit_high=end)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("frequency_Hz,level\n1,2\n", "m.csv: must have the columns frequency_Hz and gain_dB, got"),
        ("frequency_Hz\n1\n", "m.csv: must have the columns frequency_Hz and gain_dB"),
        ("frequency_Hz,gain_dB\n10,2\n20,4\n", "m.csv: must give at least 20"),
        ("frequency_Hz,gain_dB\n" + "10,2\n" * 30, "m.csv, column 'frequency_Hz': must be above 0 Hz"),
        ("frequency_Hz,gain_dB\nnan,2\n", "m.csv, row 1: must be a finite number"),
    ],
)
def test_bad_data_are_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, words: str) -> None:
    monkeypatch.chdir(tmp_path)
    Path("m.csv").write_text(text)
    with refused_by(words):
        gain(load_circuit("yamada-2002"), "m.csv")


def test_bad_input_is_one_line_and_no_file(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for words, said in (
        ("yamada-2002 --set film.d33=0.0", "film.d33: must not be 0 pC/N"),
        ("yamada-2002 --measured none.csv", "none.csv: cannot be read"),
        ("yamada-2002 -o file", "-o: file is a file"),
        ("yamada-2003", "yamada-2003: no such template among circuits"),
    ):
        assert refused_command("circuit", *words.split(), cwd=tmp_path).startswith(said)
