"""The detector as C: what is written, that it compiles and says what Python's says, and what it costs."""

from __future__ import annotations

import json
import math
import re
import shutil
import struct
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import lfilter

import skincad
from bench.detector_cost import COMPILER, EMULATOR, counted, emulated
from skincad.base import files_below
from skincad.circuit import INPUTS
from skincad.detector import AHEAD, GRIPPER, RIDGES, SKIN, Alarm, Detector, Tuning, features, weights
from skincad.outputs import CLOCK, fitting_every, instructions
from tests.conftest import run_skincad
from tests.processes import LIMIT
from tests.refusals import refused, refused_command
from tests.scenes.test_slip import small

HERE = Path(__file__).parent / "c"
STRICT = ("-Wall", "-Wextra", "-Werror", "-pedantic", "-O2")
SANITIZED = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
RATE = 5000.0
COMMAND = ("export", "yamada-2002", "--rate", "5000", "--alarms", "early")

compiled = pytest.mark.skipif(shutil.which("gcc") is None, reason="gcc is not installed")
on_target = pytest.mark.skipif(
    shutil.which(COMPILER) is None or shutil.which(EMULATOR) is None,
    reason=f"{COMPILER} or {EMULATOR} is not installed",
)


def detector(
    ridges: int = 4,
    window: int = 3,
    noise: float = 1e-4,
    every: int = 1,
    network: str = SKIN,
    change: float | None = None,
) -> Detector:
    tuning = Tuning(window, noise, 2.5, 1.25, every, network, change)
    return Detector.of(tuning, range(2, ridges + 2), RATE)


def code(folder: Path, made: Detector) -> Path:
    """The folder of a detector's code."""
    skincad.write(skincad.export(made), folder)
    return folder / "skincad_detector"


def built(folder: Path, sources: list[Path], *flags: str, compiler: str = "gcc") -> Path:
    """A program that compiles without a warning."""
    program = folder / "program"
    standard = "-std=c++17" if compiler in ("g++", "clang++") else "-std=c99"
    words = [compiler, standard, *STRICT, *flags, *map(str, sources), "-lm", "-o", str(program)]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=LIMIT)
    assert done.returncode == 0, done.stderr
    return program


def printed(program: Path, *arguments: str, given: bytes = b"") -> str:
    done = subprocess.run(
        [str(program), *arguments], input=given, capture_output=True, check=False, timeout=LIMIT
    )
    assert done.returncode == 0, (done.stdout[-2000:], done.stderr[-2000:])
    return done.stdout.decode()


def test_what_is_written_is_the_same_twice(tmp_path: Path) -> None:
    for name in ("one", "other"):
        code(tmp_path / name, detector())
    one, other = (files_below(tmp_path / name) for name in ("one", "other"))
    assert set(one) == {
        *("README.md", "export.json", "test_detector.c", "test_vectors.h"),
        *(f"skincad_detector/skincad_detector.{end}" for end in ("c", "h", "ino")),
        "skincad_detector/skincad_weights.h",
    }
    assert all(one[name].read_bytes() == other[name].read_bytes() for name in one if name != "export.json")


def test_weights_are_those_of_the_networks(tmp_path: Path) -> None:
    """To float32; by six hidden units, which the other way round are Python's rows."""
    text = (code(tmp_path / "code", detector()) / "skincad_weights.h").read_text()
    assert max(map(len, text.splitlines())) <= 120
    arrays = {
        name: np.array(re.findall(r"[-+.\de]+(?=f)", body), dtype=np.float32)
        for name, body in re.findall(r"float skincad_(\w+)\[.*?\] = \{(.*?)\};", text, re.DOTALL)
    }
    both = [weights(RIDGES), weights(SKIN)]
    for key in ("bias", "out"):
        right = np.concatenate([getattr(w, key) for w in both]).astype(np.float32)
        np.testing.assert_array_equal(arrays[key], right)
    np.testing.assert_array_equal(arrays["base"], np.float32([w.base for w in both]))
    count, hidden = both[0].into.shape
    blocks = arrays["into"].reshape(2, hidden // 6, count, 6)
    rows = np.moveaxis(blocks, 2, 1).reshape(2, count, hidden)
    np.testing.assert_array_equal(rows, np.float32([w.into for w in both]))


def test_by_default_it_decides_as_often_as_half_of_600_mhz_allows() -> None:
    assert instructions(8, 5) * RATE < CLOCK / 2  # 16 channels at 5 kHz
    for ridges in range(1, 14):
        for rate in (1000.0, 5000.0, 20_000.0):
            every = fitting_every(ridges, rate)
            assert every is not None
            assert instructions(ridges, every) * rate <= CLOCK / 2
            assert every == 1 or instructions(ridges, every - 1) * rate > CLOCK / 2
    assert fitting_every(9, 50_000.0) is None  # the running means alone take more


def test_the_command_says_what_it_wrote(tmp_path: Path) -> None:
    done = run_skincad(*COMMAND, "--ridges", "3,4,5,6", "--detector", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "ridges 3, 4, 5, 6, 8 channels at 5000 Hz" in done.stdout
    assert "at one of 3 samples: an alarm comes up to 0.4 ms later" in done.stdout
    table = json.loads((tmp_path / "out" / "export.json").read_text())
    assert (table["every"], table["channels"], table["delay_ms"]) == (3, 8, 0.4)
    head = (tmp_path / "out" / "skincad_detector" / "skincad_detector.h").read_text()
    defines = dict(re.findall(r"#define SKINCAD_(\w+) (\S+)", head))
    right = skincad.Detector("yamada-2002", "single-supply", RATE, (3, 4, 5, 6), alarms="early").tuning
    assert float(defines["NOISE_V"][:-1]) == np.float32(right.noise)
    assert (defines["THRESHOLD"], defines["WARNING"], defines["EVERY"]) == ("2.5f", "1.25f", "3")


def test_of_a_stress_the_command_says_what_it_hears(tmp_path: Path) -> None:
    """The firmware hears changes too: their noise is a constant of its own, which no other detector has."""
    words = ("export", "yamada-2002", "--rate", "2000", "--alarms", "grip", "--ridges", "3,4", "--circuit")
    done = run_skincad(*words, "charge-amplifier", "--detector", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    right = skincad.Detector("yamada-2002", "charge-amplifier", 2000.0, (3, 4), alarms="grip").tuning
    assert right.change is not None
    assert f"with {right.change:.3g} V rms of noise: the outputs are the stress itself" in done.stdout
    table = json.loads((tmp_path / "out" / "export.json").read_text())
    assert (table["noise_V"], table["change_V"]) == pytest.approx((right.noise, right.change))
    head = (tmp_path / "out" / "skincad_detector" / "skincad_detector.h").read_text()
    defines = dict(re.findall(r"#define SKINCAD_(\w+) (\S+)", head))
    volts = [np.float32(defines[name][:-1]) for name in ("NOISE_V", "CHANGE_V")]
    assert volts == [np.float32(right.noise), np.float32(right.change)]
    assert "hears what they change by" in (tmp_path / "out" / "README.md").read_text()
    done = run_skincad(*words, "single-supply", "--detector", "other", cwd=tmp_path)
    assert "the stress itself" not in done.stdout
    assert "CHANGE" not in (tmp_path / "other" / "skincad_detector" / "skincad_detector.h").read_text()


@pytest.mark.parametrize("more", [(), ("--every", "4")])
def test_the_sketch_turns_the_counts_of_an_inverting_amplifier(more: tuple[str, ...], tmp_path: Path) -> None:
    done = run_skincad(*COMMAND, "--ridges", "4,5", *more, "--detector", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    sketch = (tmp_path / "out" / "skincad_detector" / "skincad_detector.ino").read_text()
    assert "INVERTED = true;" in sketch


def test_the_sketch_reads_the_pins_of_a_board(tmp_path: Path) -> None:
    sketch = (code(tmp_path, detector()) / "skincad_detector.ino").read_text()
    listed = re.search(r"PINS\[\] = \{(.*?)\}", sketch)
    assert listed is not None
    pins = listed[1].split(", ")
    assert pins[: len(INPUTS)] == [name for name, *_ in INPUTS]


def test_a_scene_has_its_own_circuit_ridges_and_alarms(tmp_path: Path) -> None:
    settings = ("effects.piezo.circuit=yamada-2002", "readout.ridges=[2, 5]", "readout.alarms=early")
    words = [word for setting in settings for word in ("--set", setting)]
    done = run_skincad("export", "yamada-2002-slip", *words, "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    table = json.loads(done.stdout)
    right = skincad.Detector("yamada-2002", "yamada-2002", ridges=(2, 5), alarms="early")
    assert (table["ridges"], table["rate_Hz"]) == ([2, 5], 650.0)
    assert table["noise_V"] == pytest.approx(right.tuning.noise)
    assert (tmp_path / "out" / "yamada-2002" / "detector" / "export.json").is_file()
    more = (
        "--circuit",
        "transimpedance",
        "--ridges",
        "4",
        "--rate",
        "2000",
        "--noise",
        "0.001",
        "--every",
        "2",
    )
    done = run_skincad("export", "yamada-2002-slip", *words, *more, "--json", cwd=tmp_path)
    table = json.loads(done.stdout)
    assert table["name"] == "yamada-2002 behind transimpedance"
    assert [table[key] for key in ("ridges", "rate_Hz", "noise_V", "every")] == [[4], 2000.0, 1e-3, 2]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("transimpedance",), "is a circuit, not a design or a scene; give it to --circuit"),
        (
            ("yamada-2002", "--circuit", "transimpedance"),
            "--rate: is too fast for 9 ridges on a Cortex-M7 of 600 MHz, got 50000;",
        ),
        (("yamada-2002", "--ridges", "3,x"), "--ridges: must be numbers, got '3,x'; as in 3,4,5,6"),
        (("yamada-2002", "--ridges", "4,3"), "--ridges: must be one or more, each once, in their order"),
        (("yamada-2002", "--every", "0"), "--every: must be at least 1 sample"),
        (("yamada-2002", "--alarms", "erly"), "--alarms: must be one of sure, early"),
        (("yamada-2002", "--noise", "-1"), "--noise: must be above 0 V"),
        (("yamada-2002", "--circuit", "nope"), "nope: no such template among circuits"),
        (("plain-ridges",), "design: needs a skin with a"),
        (("yamada-2002", "--rate", "5000", "--detector", "."), "--detector: . is the folder you are in"),
    ],
)
def test_what_cannot_be_exported_is_refused(arguments: tuple[str, ...], words: str, tmp_path: Path) -> None:
    assert words in refused_command("export", *arguments, cwd=tmp_path)


def test_from_python_too(tmp_path: Path) -> None:
    with refused("detector: must be a Detector"):
        skincad.export("yamada-2002")  # type: ignore[arg-type]
    with refused("name: must be a line without */"):
        skincad.export(detector(), name="*/ int x;")
    result = skincad.export(detector(every=2), name="mine")
    assert str(result).startswith("mine: a slip detector in C for ridges 2, 3, 4, 5, 8 channels")


@compiled
@pytest.mark.slow
@pytest.mark.parametrize("ridges", [1, 2, 3, 4, 9])
@pytest.mark.parametrize("flags", [(), SANITIZED, ("-O3",)], ids=["plain", "sanitized", "O3"])
@pytest.mark.parametrize(("network", "change"), [(SKIN, None), (GRIPPER, None), (GRIPPER, 1e-5)])
def test_it_passes_its_own_vectors(
    ridges: int, network: str, change: float | None, flags: tuple[str, ...], tmp_path: Path
) -> None:
    inner = code(tmp_path / "code", detector(ridges, every=ridges, network=network, change=change))
    for compiler in filter(shutil.which, ("gcc", "clang")):
        sources = [inner.parent / "test_detector.c", inner / "skincad_detector.c"]
        words = printed(built(tmp_path, sources, *flags, compiler=compiler))
        assert re.fullmatch(r"passed: \d+ alarms in 600 samples, odds within [\d.e-]+\n", words), words
    assert int(words.split()[1]) >= (2 if network == SKIN else 1)  # a gripper's names no ridge


@compiled
@pytest.mark.slow
@pytest.mark.parametrize("rate", [500.0, 2000.0, 50_000.0])
@pytest.mark.parametrize("circuit", ["charge-amplifier", "voltage-follower"])
def test_it_passes_its_vectors_of_a_stress(circuit: str, rate: float, tmp_path: Path) -> None:
    """At 50 kHz with a low-pass of 500 Hz its windows are long, and changes small."""
    band = min(500.0, 0.4 * rate)
    made = skincad.Detector("yamada-2002", circuit, rate, (3, 4, 5), alarms="grip", bandwidth=band)
    assert made.tuning.change is not None
    result = skincad.export(made)
    assert np.abs(result.vectors["rows"]).max() < 2**15
    inner = code(tmp_path / "code", made)
    sources = [inner.parent / "test_detector.c", inner / "skincad_detector.c"]
    words = printed(built(tmp_path, sources, *SANITIZED))
    assert re.fullmatch(r"passed: \d+ alarms in \d+ samples, odds within [\d.e-]+\n", words), words
    assert int(words.split()[1]) >= 1


@compiled
@pytest.mark.slow
def test_vectors_fail_where_the_code_is_wrong(tmp_path: Path) -> None:
    inner = code(tmp_path / "code", detector())
    source = inner / "skincad_detector.c"
    source.write_text(source.read_text().replace("0.0625f", "0.0635f"))
    program = built(tmp_path, [inner.parent / "test_detector.c", source])
    done = subprocess.run([program], capture_output=True, text=True, check=False, timeout=LIMIT)
    assert done.returncode == 1
    assert "failed: " in done.stdout


@compiled
@pytest.mark.slow
def test_its_parts(tmp_path: Path) -> None:
    """Its tanh, its logarithm, what it refuses, its size; and its means, which are those of a recursion in
    double to float32's last digit where a step is a millionth of the mean: float32 alone stands still."""
    made, rows = detector(2, window=6000, noise=1e-3), 20_000
    inner = code(tmp_path / "code", made)
    program = built(tmp_path, [HERE / "parts.c"], f"-I{inner}", *SANITIZED)
    lines = [line.split() for line in printed(program, str(rows)).splitlines()]
    table = {line[0]: line[1:] for line in lines}
    assert float(table["tanh"][0]) < 5e-7
    assert [float(value) for value in table["tanh"][1:]] == pytest.approx([1, -1], abs=5e-7)
    assert float(table["log"][0]) < 2e-7
    assert table["no-rows"] == ["-1"]
    assert [line[1:] for line in lines if line[0] == "refused"] == [["-1", "-1", "0"]] * 4
    assert int(table["bytes"][0]) == skincad.export(made).state_bytes
    (tmp_path / "stress").mkdir()
    for ridges in (2, 3, 4):  # flags are padded to whole words
        stress = detector(ridges, change=1e-5)
        inner_of_stress = code(tmp_path / "stress" / f"{ridges}", stress)
        program_of_stress = built(tmp_path / "stress", [HERE / "parts.c"], f"-I{inner_of_stress}", *SANITIZED)
        said = re.match(r"bytes (\d+)", printed(program_of_stress, "1"))
        assert said is not None
        assert int(said[1]) == skincad.export(stress).state_bytes
    rest = np.float32(1.65)
    ramp = np.float32(1e-6) * (np.arange(4) + 1).astype(np.float32) * (np.arange(rows) % 4096)[:, None]
    volts = (rest + ramp.astype(np.float32)).astype(float)
    values = (volts - (float(rest) + float(np.nextafter(rest, np.float32(2)))) / 2) / made.tuning.noise
    pair, total = values[:, ::2] - values[:, 1::2], values[:, ::2] + values[:, 1::2]
    raw = np.concatenate([pair, total, pair[:, ::-1], total[:, ::-1]], axis=1)
    raw = np.concatenate([raw, raw**2, pair * pair[:, ::-1], pair * total], axis=1)
    right = []
    for column in raw.T:
        for span in features.SPANS:
            share = 1.0 / (1.0 + span * made.tuning.window)
            right.append(lfilter([share], [1.0, share - 1.0], column)[-1])
    means = np.array([line[1:] for line in lines if line[0] == "mean"], float).sum(axis=1)
    np.testing.assert_allclose(means, right, rtol=5e-7)  # rounding of the share, the value and its square


Record = tuple[Detector, np.ndarray]
SETUPS = (  # ridges, window, noise V, every
    (1, 3, 1e-4, 1), (1, 18, 1e-3, 2), (2, 3, 3e-5, 1), (2, 45, 1e-4, 3), (3, 5, 8e-5, 1), (4, 3, 8e-5, 3),
    (5, 10, 1e-3, 4), (6, 4, 1e-2, 2), (7, 3, 1e-5, 5), (8, 3, 8e-5, 5), (8, 7, 5e-4, 1),
)  # fmt: skip
EACH, ROWS, MARCHED = 25, 600, 25


def recordings(setup: int) -> Iterator[Record]:
    """Detectors and float32 rows: pulls and presses that run and stop, ridge after ridge, quiet and loud, in
    noise, behind the low-pass, at rest at half a supply or not."""
    ridges, window, noise, every = SETUPS[setup]
    for number in range(EACH):
        draw = np.random.default_rng((setup, number))
        hold, size = int(window * draw.uniform(3, 30)), noise * 10 ** draw.uniform(0.0, 3.5)
        pull, press = (np.repeat(draw.normal(0, s, ROWS // hold + 1), hold)[:ROWS] for s in (size, size / 3))
        late = [np.roll(pull, int(lag)) for lag in draw.integers(0, 4 * window, ridges)]
        pair = np.stack(late, axis=1) * draw.uniform(0.2, 1.2, ridges)
        total = press[:, None] * draw.uniform(0.5, 1.2, ridges) * draw.choice([0.0, 1.0, 3.0])
        strips = np.stack([total + pair, total - pair], axis=2).reshape(ROWS, 2 * ridges) / 2
        pole = math.exp(-7 / window)
        strips = lfilter([1 - pole], [1, -pole], strips, axis=0)
        strips = lfilter([1 - pole], [1, -pole], strips, axis=0)
        rest = draw.choice([0.0, 1.65]) + 0.01 * draw.normal(size=2 * ridges)
        strips += draw.normal(0, noise / math.sqrt(2), strips.shape) + rest
        first = np.broadcast_to(rest, (10, 2 * ridges))
        yield detector(ridges, window, noise, every), np.concatenate([first, strips]).astype(np.float32)


def marched() -> Iterator[Record]:
    """Of a scene, in noise of other seeds and sizes: ridges 2 and 3 slip."""
    outputs = small()[0].reshape(-1, 4)
    for number in range(MARCHED):
        draw = np.random.default_rng((99, number))
        felt = outputs * 10 ** draw.uniform(-0.5, 1.0) + draw.normal(0, 1e-3 / math.sqrt(2), outputs.shape)
        yield detector(2, 18, 1e-3), np.concatenate([np.zeros((10, 4)), felt]).astype(np.float32) + 1.65


def of_stress(setup: int) -> Iterator[Record]:
    """Recordings as the rates of outputs that fade, from their rest."""
    for made, rows in recordings(setup):
        tuning = replace(made.tuning, noise=10 * made.tuning.noise, network=GRIPPER, change=made.tuning.noise)
        rate = rows[10:] - rows[:10].mean(axis=0)
        stress = lfilter([1], [1, -0.99], rate / math.sqrt(2), axis=0) + rows[0]
        yield Detector.of(tuning, made.ridges, RATE), np.concatenate([rows[:10], stress]).astype(np.float32)


def cut(rows: np.ndarray, number: int) -> list[np.ndarray]:
    """The rows at rest, and the others in blocks of any size, empty ones too."""
    draw = np.random.default_rng(number)
    return [rows[:10], *np.split(rows[10:], np.sort(draw.integers(0, rows.shape[0] - 10, 6)))]


def as_python_says(made: Detector, blocks: list[np.ndarray]) -> list[list[tuple[int, int, int]]]:
    def numbers(alarm: Alarm) -> tuple[int, int, int]:
        return alarm.index, int(alarm.kind == AHEAD), alarm.ridge or 0

    made.rest(blocks[0])
    return [[numbers(alarm) for alarm in made.feed(block)] for block in blocks[1:]]


@compiled
@pytest.mark.slow
@pytest.mark.parametrize("setup", [*range(len(SETUPS)), "marched", "stress, 1", "stress, 5", "stress, 9"])
def test_its_alarms_are_pythons_block_by_block(setup: int | str, tmp_path: Path) -> None:
    """300 recordings in all, a twelfth each, and 75 of a stress. Odds differ by 1e-5, so that some alarm of
    very many would be a sample apart: none of these is."""
    if isinstance(setup, int):
        records = list(recordings(setup))
    else:
        records = list(marched() if setup == "marched" else of_stress(int(setup.rpartition(" ")[2])))
    assert len(records) == 25
    inner = code(tmp_path / "code", records[0][0])
    sources = [HERE / "record.c", inner / "skincad_detector.c"]
    given, right = b"", []
    for number, (made, rows) in enumerate(records):
        blocks = cut(rows, number)
        given += struct.pack("I", len(blocks))
        given += b"".join(struct.pack("I", len(block)) + block.tobytes() for block in blocks)
        right.append(as_python_says(made, blocks))
    said = printed(built(tmp_path, sources, f"-I{inner}", *SANITIZED), given=given).split("end\n")[:-1]
    found = [
        [[tuple(map(int, word.split(","))) for word in line.split()] for line in record.splitlines()]
        for record in said
    ]
    assert found == right
    assert sum(len(block) for record in right for block in record) > 10


@on_target
@pytest.mark.slow
@pytest.mark.parametrize(("ridges", "every"), [(1, 1), (3, 4), (8, 5)])
def test_it_passes_its_vectors_on_a_cortex_m7(ridges: int, every: int, tmp_path: Path) -> None:
    inner = code(tmp_path / "code", detector(ridges, every=every))
    done = emulated(tmp_path, [inner.parent / "test_detector.c", inner / "skincad_detector.c"], *STRICT)
    assert done.returncode == 0, done.stdout + done.stderr
    assert re.match(r"passed: \d+ alarms in 600 samples", done.stdout)


@on_target
@pytest.mark.slow
def test_16_channels_at_5_khz_fit_in_half_of_600_mhz() -> None:
    """By instructions; as many as are said to 5 %, by which compilers differ."""
    cases = [(8, 5, SKIN), (1, 1, SKIN), (2, 2, SKIN), (7, 1, SKIN), (8, 2, GRIPPER), (3, 1, GRIPPER)]
    for ridges, every, network in cases:
        count = counted(ridges, every, network)
        assert count == pytest.approx(instructions(ridges, every, network), rel=0.05)
        assert ridges < 8 or count * RATE < CLOCK / 2


@compiled
@pytest.mark.slow
@pytest.mark.parametrize(
    ("ridges", "round", "inverted", "heard"),
    [(2, 1, True, {}), (9, 30, False, {}), (3, 7, True, {"network": GRIPPER, "change": 1e-3})],
)
def test_the_sketch_prints_samples_and_alarms(
    ridges: int, round: int, inverted: bool, heard: dict[str, Any], tmp_path: Path
) -> None:
    """On a stand-in for Arduino's library: what it prints is the wire's form, and what Python hears in it are
    its alarms."""
    made = detector(ridges, noise=2e-3, every=3, **heard)
    made.inverted = inverted
    inner = code(tmp_path / "code", made)
    object_file = tmp_path / "detector.o"
    words = ["gcc", "-std=c99", *STRICT, "-c", str(inner / "skincad_detector.c"), "-o", str(object_file)]
    subprocess.run(words, check=True, timeout=LIMIT)
    flags = (f"-I{inner}", f"-I{HERE}", "-include", "Arduino.h", *SANITIZED)
    program = built(tmp_path, [HERE / "board.cpp", object_file], *flags, compiler="g++")
    draw, rest = np.random.default_rng(1), int(RATE)
    pull = np.repeat(draw.normal(0, 100, 50), 24)[:, None] * draw.uniform(0.3, 1.2, ridges)
    late = np.stack([np.roll(column, 5 * k) for k, column in enumerate(pull.T)], axis=1)
    strips = np.concatenate([np.zeros((rest, 2 * ridges)), np.stack([late, -late], axis=2).reshape(1200, -1)])
    counts = np.clip(np.rint(strips + draw.normal(2048, 1.0, strips.shape)), 0, 4095).astype(np.uint16)
    given = 4095 - counts if inverted else counts
    lines = printed(program, str(round), given=given.tobytes()).splitlines()
    head = ",".join(["sample", *(f"ridge_{ridge}_{side}_V" for ridge, side in made.channels)])
    assert lines[0] == head
    assert lines.count(head) == 2  # once a second
    rows = [line.split(",") for line in lines if line[0].isdigit()]
    assert [int(row[0]) for row in rows] == list(range(rest + 1200))
    volts = np.array([row[1:] for row in rows], float)
    np.testing.assert_allclose(volts, counts * (3.3 / 4096), atol=1e-6)  # a microvolt is the last digit
    (remark,) = (line for line in lines if line.startswith("#"))
    noise = re.match(r"# at rest S1 - S2 has ([\d.]+) V rms; the detector was made for 0.002000 V$", remark)
    assert noise is not None
    assert float(noise[1]) == pytest.approx(3.3 / 4096 * math.sqrt(2), rel=0.1)  # of the noisiest ridge
    alarms = [line for line in lines if line.startswith("alarm")]
    made.rest(volts[:rest])
    right = [
        f"alarm,{alarm.index + rest},{alarm.kind},{alarm.ridge or ''}" for alarm in made.feed(volts[rest:])
    ]
    assert alarms == right
    assert len(right) > 5


@compiled
@pytest.mark.slow
def test_the_sketch_counts_what_it_loses(tmp_path: Path) -> None:
    made = detector(1, noise=2e-3)
    inner = code(tmp_path / "code", made)
    flags = (f"-I{inner}", f"-I{HERE}", "-include", "Arduino.h")
    object_file = tmp_path / "detector.o"
    words = ["gcc", "-std=c99", *STRICT, "-c", str(inner / "skincad_detector.c"), "-o", str(object_file)]
    subprocess.run(words, check=True, timeout=LIMIT)
    program = built(tmp_path, [HERE / "board.cpp", object_file], *flags, compiler="g++")
    lines = printed(program, "400", given=np.full((1200, 2), 2048, np.uint16).tobytes()).splitlines()
    samples = [int(line.partition(",")[0]) for line in lines if line[0].isdigit()]
    lost = [int(line.rpartition(" ")[2]) for line in lines if line.startswith("# samples lost")]
    assert samples[0] == 400 - 32
    assert sorted(set(samples)) == samples
    assert lost[-1] == 1200 - len(samples)
