"""What the exported detector costs on a Cortex-M7: `python -m bench.detector_cost`.

It builds the C code of `skincad export` with arm-none-eabi-gcc -O2 and runs it under QEMU (mps2-an500). It
prints the instructions of a sample, all ridges loud, by channels and `every`: as counted, as the export says,
and their share of 600 MHz at 5 kHz if each takes one tick. QEMU counts instructions exactly, and knows
nothing of a processor's pipeline, caches and wait states.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

import skincad
from skincad.detector import GRIPPER, SKIN, Detector, Tuning
from skincad.outputs import CLOCK, instructions

HERE = Path(__file__).parent / "cortex_m7"
COMPILER, EMULATOR = "arm-none-eabi-gcc", "qemu-system-arm"
TARGET = ("-mcpu=cortex-m7", "-mfpu=fpv5-d16", "-mfloat-abi=hard", "-std=c99")
SHIFT, TIMER = 3, 25e6  # an instruction lasts 2^3 ns of the emulated clock; Hz of the board's timer
LIMIT = 120.0  # s
RATE = 5000.0
RIDGES, EVERY = (1, 2, 4, 8), (1, 2, 4, 5)


def emulated(folder: Path, sources: Sequence[Path], *flags: str) -> subprocess.CompletedProcess[str]:
    """Return what a program prints on an emulated Cortex-M7, and its status; it is built in `folder`."""
    program = folder / "program.elf"
    words = [COMPILER, *TARGET, "-O2", *flags, "--specs=rdimon.specs", "-T", str(HERE / "memory.ld")]
    built = [*words, str(HERE / "start.c"), *map(str, sources), "-lm", "-o", str(program)]
    subprocess.run(built, check=True, timeout=LIMIT)
    board = ["-M", "mps2-an500", "-nographic", "-monitor", "none", "-icount", f"shift={SHIFT}"]
    words = [EMULATOR, *board, "-semihosting-config", "enable=on,target=native", "-kernel", str(program)]
    return subprocess.run(
        words, stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False, timeout=LIMIT
    )


def counted(ridges: int, every: int, network: str = SKIN) -> float:
    """Return the instructions of a sample with the network that warns, a mean over 480."""
    tuning = Tuning(window=3, noise=1e-4, every=every, network=network)
    detector = Detector.of(tuning, range(1, ridges + 1), RATE)
    with TemporaryDirectory() as name:
        code = Path(name) / "code"
        skincad.write(skincad.export(detector), code)
        inner = code / "skincad_detector"
        tick = 1e9 / TIMER / 2**SHIFT  # instructions
        sources = [HERE / "cost.c", inner / "skincad_detector.c"]
        done = emulated(Path(name), sources, f"-I{inner}", f"-DTICK={tick}")
    count, how = done.stdout.split()
    assert how == "loud"
    return float(count)


def main() -> None:
    for network in (SKIN, GRIPPER):
        print(f"{network}\nchannels every  instructions a sample: counted, said   of 600 MHz at 5 kHz")
        for ridges in RIDGES:
            for every in EVERY:
                count, said = counted(ridges, every, network), instructions(ridges, every, network)
                print(f"{2 * ridges:8} {every:5} {count:29,.0f} {said:12,.0f} {count * RATE / CLOCK:14.0%}")
                sys.stdout.flush()


if __name__ == "__main__":
    main()
