"""`skincad circuit` as a user meets it."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from annotated_types import Gt
from scipy.optimize import least_squares

from skincad.base import InputError, Table
from skincad.circuit import bode, constants, gain, load_circuit, paper_target
from skincad.circuit.calibrate import Calibration, calibrate
from skincad.circuit.model import (
    SHORT,
    Amplifier,
    Cable,
    FilmCapacitor,
    ForceSensor,
    Indenter,
    Motional,
    Noise,
    Sampling,
    Sweep,
    noise_sources,
)
from skincad.inputs import template_names
from tests.circuit.sets import exact_calibration
from tests.conftest import run_skincad
from tests.refusals import refused_by, refused_command

KEYS = {
    *("name", "constants", "frequency_Hz", "gain_dB"),
    *("cutoff_Hz", "slope_below_dB_per_dec", "slope_above_dB_per_dec"),
}
FILES = {"gain.csv", "gain.png", "netlist.cir", "circuit.json"}


def write_curve(path: Path, level: float = 0.0) -> None:
    """A measured curve of 42 points: the shipped network's own at another damping, 0.1 dB of noise."""
    curve = gain(load_circuit("yamada-2002-motional", ["motional.resistance=40000.0", "indenter=none"]))
    noise = np.random.default_rng(1).normal(0.0, 0.1, curve.gain.size)
    rows = [f"{f},{g + level}" for f, g in zip(curve.frequency, curve.gain + noise, strict=True) if f < 8000]
    path.write_text("\n".join(["frequency_Hz,gain_dB", *rows[::8]]) + "\n")


def test_it_prints_the_contracts_json_and_writes_what_it_lists(tmp_path: Path) -> None:
    process = run_skincad("circuit", "yamada-2002", "--json", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert process.stderr == ""
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


def test_the_papers_curve_is_told_with_its_rig_and_the_films_signal_without(tmp_path: Path) -> None:
    text = run_skincad("circuit", "yamada-2002", cwd=tmp_path).stdout
    first, *_ = text.splitlines()
    assert first.startswith("yamada-2002: the gain rises by 19.8")
    assert first.endswith("as measured with its rig.")
    assert "  own signal     by the load on the film the gain rises by 19.998" in text
    assert "not the film's, by the indenter at 9000 Hz and the force sensor at 1200 Hz" in text
    plain = run_skincad("circuit", "transimpedance", cwd=tmp_path).stdout
    assert "rig" not in plain
    assert "own signal" not in plain


def test_the_film_feels_the_probes_inertia_that_its_force_sensor_does_not_read() -> None:
    """A mass and a damped spring in numbers: the film's force is m a + c v + k x, the sensor's k x; a filter
    between, of the same two poles, is the sensor's amplifier."""
    circuit = load_circuit("yamada-2002", ["indenter=none", "force_sensor={resonance=1000.0,damping=0.25}"])
    curve = gain(circuit)
    assert curve.own is not None
    k, m = 4e6, 4e6 / (2 * np.pi * 1000.0) ** 2  # N/m, kg
    c = 2 * 0.25 * np.sqrt(k * m)
    jw = 2j * np.pi * curve.frequency
    assert curve.gain - curve.own.gain == pytest.approx(20 * np.log10(np.abs(m * jw**2 + c * jw + k) / k))


def test_a_branch_larger_than_the_film_is_a_warning() -> None:
    by_circuit = [gain(load_circuit(name)).warnings for name in ("yamada-2002-motional", "yamada-2002")]
    assert [any("motional capacitance" in w for w in warnings) for warnings in by_circuit] == [True, False]


@pytest.mark.parametrize("name", ["yamada-2002", "yamada-2002-motional"])
def test_both_readings_stay_within_what_they_say_of_the_papers_statements(name: str) -> None:
    """20 dB/dec to 1.2 kHz, then 60, level free: their first lines say it, the network's without indenter."""
    curve = gain(load_circuit(name))
    frequency, wanted = paper_target()
    rest = np.interp(np.log(frequency), np.log(curve.frequency), curve.gain) - wanted
    deviation = {"yamada-2002": 0.26, "yamada-2002-motional": 1.73}[name]
    assert np.std(rest) == pytest.approx(deviation, abs=0.01)


def test_the_papers_rig_is_the_nearest_to_its_statements() -> None:
    """Both dampings, the resonances being the paper's 1.2 and 9 kHz, over 20 dB/dec: to the template's
    digits."""
    frequency, wanted = paper_target()

    def misfit(point: np.ndarray) -> np.ndarray:
        sensor, indenter = (
            1 - r**2 + 2j * z * r
            for r, z in zip((frequency / 1200.0, frequency / 9000.0), point, strict=True)
        )
        rest = 20 * np.log10(frequency * np.abs(sensor / indenter)) - wanted
        return np.asarray(rest - rest.mean())

    circuit = load_circuit("yamada-2002")
    assert circuit.force_sensor is not None
    assert circuit.indenter is not None
    dampings = least_squares(misfit, [0.3, 0.9]).x
    assert dampings == pytest.approx([circuit.force_sensor.damping, circuit.indenter.damping], abs=0.01)


@pytest.mark.slow
def test_same_input_same_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        assert run_skincad("circuit", "yamada-2002", "-o", name, cwd=tmp_path).returncode == 0
    for name in FILES:
        assert (tmp_path / "one" / name).read_bytes() == (tmp_path / "two" / name).read_bytes(), name


@pytest.mark.slow
def test_a_designs_files_in_the_same_folder_stay(tmp_path: Path) -> None:
    run_skincad("make", "plain-ridges", "--format", "md", "-o", "here", cwd=tmp_path)
    before = {p.name for p in (tmp_path / "here").iterdir()}
    assert "make.json" in before
    assert run_skincad("circuit", "yamada-2002", "-o", "here", cwd=tmp_path).returncode == 0
    assert {p.name for p in (tmp_path / "here").iterdir()} == before | FILES
    run_skincad("make", "plain-ridges", "--format", "md", "-o", "here", cwd=tmp_path)
    assert {p.name for p in (tmp_path / "here").iterdir()} == before | FILES


def test_measured_data_are_calibrated_to_and_the_result_is_a_circuit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By ten starts: how many end at the best is test_calibrate's."""
    monkeypatch.setattr(bode, "calibrate", partial(calibrate, starts=10))
    write_curve(tmp_path / "m.csv", level=-166.0)
    arguments = (
        "circuit", "yamada-2002-motional", "--measured", "m.csv", "-o", "o", "--set", "indenter=none",
    )  # fmt: skip
    process = run_skincad(*arguments, "--json", cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    data = json.loads(process.stdout)
    assert data["calibration"]["rms_dB"] == pytest.approx(0.1, abs=0.03)  # the noise, and no more
    again = run_skincad("circuit", "o/calibrated.toml", "-o", "p", "--json", cwd=tmp_path)
    assert again.returncode == 0, again.stderr
    np.testing.assert_allclose(json.loads(again.stdout)["gain_dB"], data["gain_dB"], atol=1e-6)
    assert "  calibrated     " in run_skincad(*arguments, cwd=tmp_path).stdout


def test_a_measured_curve_is_calibrated_to_less_its_rig(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The network's own curve comes out, whatever the rig makes of it; drawn again with the rig it is the
    measured one."""
    calls = []

    def calibrated(frequency: np.ndarray, level: np.ndarray, **_: object) -> Calibration:
        calls.append((frequency, level))
        return exact_calibration(constants(circuit))

    circuit = load_circuit("yamada-2002")
    monkeypatch.setattr(bode, "calibrate", calibrated)
    curve = gain(circuit)
    rows = [f"{f:.17g},{g:.17g}" for f, g in zip(curve.frequency, curve.gain, strict=True)]
    (tmp_path / "m.csv").write_text("\n".join(["frequency_Hz,gain_dB", *rows]))
    again = gain(circuit, tmp_path / "m.csv")
    ((frequency, level),) = calls
    assert curve.own is not None
    assert level == pytest.approx(curve.own.gain[: frequency.size], abs=1e-9)
    assert again.gain == pytest.approx(curve.gain, abs=1e-9)


@pytest.mark.parametrize("name", template_names("circuits"))
def test_every_template_runs(name: str) -> None:
    curve = gain(load_circuit(name))
    assert np.isfinite(curve.gain).all()
    assert curve.slopes.below.value is not None


def test_the_indenters_resonance_is_an_option() -> None:
    with_it, without = (gain(load_circuit("yamada-2002-motional", s)) for s in ([], ["indenter=none"]))
    drop = with_it.gain - without.gain
    assert drop[0] == pytest.approx(0.0, abs=1e-4)  # (10 / 9000)^2
    nearest = int(np.argmin(np.abs(with_it.frequency - 9000.0)))
    assert drop[nearest] == pytest.approx(-20 * np.log10(2 * 0.5), abs=0.2)  # 1 / (2 damping), by the grid
    assert drop[-1] < -10.0  # at 20 kHz, 40 dB/dec above 9 kHz


def test_a_rate_sensor_has_no_cutoff() -> None:
    curve = gain(load_circuit("transimpedance"))
    assert curve.slopes.cutoff.value is None
    assert curve.slopes.below.value == pytest.approx(20.0, abs=0.01)


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("motional.capacitance=0.0", "motional.capacitance: must be greater than 0 (F)"),
        ("amplifier.series_resistance=-1.0", "amplifier.series_resistance: must be greater than 0 (ohm)"),
        ("amplifier.gain=nan", "amplifier.gain: must be a finite number"),
        ("amplifier.gain=0.0", "amplifier.gain: must be greater than 0"),
        ("film.area=0.0", "film.area: must be greater than 0 (mm2)"),
        ("film.d33=0.0", "film.d33: must not be 0 pC/N"),
        ("film.aera=1.0", "film.aera: unknown key; did you mean 'area'?"),
        ("motional=none", "motional: is missing"),
        ("sampling.rate=15.0", "sampling.rate: must be above 20 Hz (twice sweep.low)"),
        ("sweep.fit_high=50.0", "sweep.fit_high: must be from 100 Hz (10 times low)"),
        ("sweep.points=20", "sweep.points: must give at least 20"),
    ],
)
def test_bad_constants_are_told(setting: str, words: str) -> None:
    with refused_by(words):
        gain(load_circuit("yamada-2002", [setting]))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("frequency_Hz,gain\n1,2\n", "m.csv, column 'gain': unknown"),
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


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--set", "motional.capacitance=0.0"], "motional.capacitance: must be greater than 0"),
        (["--measured", "none.csv"], "none.csv: cannot be read"),
        (["-o", "file"], "-o: file is a file"),
    ],
)
def test_bad_input_is_one_line_and_exit_2_and_no_file(
    tmp_path: Path, arguments: list[str], words: str
) -> None:
    (tmp_path / "file").write_text("")
    assert refused_command("circuit", "yamada-2002", *arguments, cwd=tmp_path).startswith(words)


def test_a_sampling_rate_below_the_cutoff_is_a_warning() -> None:
    def warns(rate: float) -> bool:
        curve = gain(load_circuit("yamada-2002", [f"sampling.rate={rate}"]))
        return any("sampled at" in warning for warning in curve.warnings)

    assert warns(650.0)
    assert not warns(20_000.0)


def test_an_unknown_circuit_is_told_with_the_known_ones(tmp_path: Path) -> None:
    message = refused_command("circuit", "yamada-2003", cwd=tmp_path)
    assert "no such template among circuits" in message


@pytest.mark.parametrize(
    "table",
    [FilmCapacitor, Cable, Motional, Amplifier, Noise, Sweep, Indenter, ForceSensor, Sampling],
    ids=lambda t: t.__name__,
)
def test_what_must_be_above_zero_may_be_as_small_as_one_likes(table: type[Table]) -> None:
    for name, field in table.model_fields.items():
        for rule in field.metadata:
            assert not isinstance(rule, Gt) or rule.gt == 0.0, name


def test_the_sweeps_defaults_are_the_papers_and_it_may_be_as_slow_as_one_likes() -> None:
    paper = load_circuit("yamada-2002").sweep
    assert Sweep().model_dump() == {**paper.model_dump(), "offset": 0.0}
    slow = Sweep(low=1e-3, high=1e-1, fit_high=1e-2)  # the fit's range: from a decade, to all of it
    assert Sweep(low=1e-3, high=1e-1, fit_high=1e-1).low == slow.low
    for end in (0.99e-2, 1.01e-1):
        with pytest.raises(InputError, match=r"fit_high: must be from 0\.01 Hz \(10 times low\) to 0\.1 Hz"):
            Sweep(low=1e-3, high=1e-1, fit_high=end)


def test_a_resistor_too_small_to_reckon_with_is_told() -> None:
    settings = "amplifier.output_resistance={:g}".format
    assert load_circuit("yamada-2002", [settings(SHORT)]).amplifier.output_resistance == SHORT
    with pytest.raises(InputError, match=r"amplifier\.output_resistance: must be at least 1e-12 ohm"):
        load_circuit("yamada-2002", [settings(0.99 * SHORT)])
    assert load_circuit("yamada-2002", ["sampling.rate=20.1"]).sampling is not None
    with pytest.raises(InputError, match=r"sampling\.rate: must be above 20 Hz"):
        load_circuit("yamada-2002", ["sampling.rate=20.0"])


def test_film_and_lead_are_parallel_and_only_the_film_loses() -> None:
    bare, long = (load_circuit("yamada-2002", [f"cable.capacitance={c:g}"]) for c in (0.0, 3e-10))
    # eps0 eps A / d: 8.8542e-12 F/m x 12 x 11.95 mm2 / 0.028 mm
    assert constants(bare).capacitance == pytest.approx(8.8542e-12 * 12 * 11.95e-6 / 0.028e-3, rel=1e-4)
    assert constants(long).capacitance - constants(bare).capacitance == pytest.approx(3e-10, rel=1e-9)
    assert constants(bare).d33 == pytest.approx(-33e-12, rel=1e-12)
    assert noise_sources(long).film_capacitance == constants(bare).capacitance
