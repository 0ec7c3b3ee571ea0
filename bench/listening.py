"""What `skincad listen` takes of a core by number of channels: `python -m bench.listening [SECONDS]`.

A process of its own writes lines at RATE into a pseudo-terminal, as a board does: seven digits a value, noise
of three times the detector's. `skincad listen --port` reads them for SECONDS, 20 if not given, and Ctrl-C
ends it. Its last line says what it took: seconds of the processor, from the first line read, over seconds of
the stream. Starting it is left out. A core whose other thread is busy takes up to twice as long.
"""

from __future__ import annotations

import json
import os
import select
import signal
import subprocess
import sys
import time
import tty

import numpy as np

from skincad.detector import Detector
from skincad.inputs.recordings import column_name

CHANNELS = (2, 4, 8, 16)
RATE = 5000.0  # Hz
DESIGN = "yamada-2002"
LOUD = 3.0  # of the detector's noise
EVERY_SECONDS = 0.01  # a board's USB sends so often


def write(descriptor: int, ridges: int) -> None:
    """Write lines in real time until nobody reads."""
    detector = Detector(DESIGN, "transimpedance", RATE, range(1, ridges + 1))
    sigma, size = LOUD * detector.tuning.noise / np.sqrt(2), round(RATE)
    volts = 1.65 + np.random.default_rng(1).normal(0, sigma, (size, 2 * ridges))
    tails = ["".join(f",{value:.7f}" for value in row) for row in volts.tolist()]
    head = ",".join(["sample", *(column_name(*channel) for channel in detector.channels)])
    began, sent = time.monotonic(), 0
    while True:
        due = round((time.monotonic() - began) * RATE)
        header = f"{head}\n" if sent // size != due // size or not sent else ""
        lines = "".join(f"{k}{tails[k % size]}\n" for k in range(sent, due))
        data = memoryview((header + lines).encode())
        while data:
            data = data[os.write(descriptor, data) :]
        sent = due
        time.sleep(EVERY_SECONDS)


def listened(channels: int, seconds: float) -> dict[str, float]:
    """Return the last line of `skincad listen` after `seconds` of so many channels."""
    board, port = os.openpty()
    tty.setraw(port)
    ridges = channels // 2
    me = [sys.executable, "-m"]
    writer = subprocess.Popen([*me, "bench.listening", "write", str(board), str(ridges)], pass_fds=[board])
    select.select([port], [], [])
    wired = ",".join(map(str, range(1, ridges + 1)))
    words = [
        "skincad",
        "listen",
        DESIGN,
        "--ridges",
        wired,
        "--rate",
        f"{RATE:g}",
        "--port",
        os.ttyname(port),
    ]
    with subprocess.Popen(
        [*me, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as listener:
        assert listener.stderr is not None
        listener.stderr.readline()  # it has heard half a second
        time.sleep(seconds)
        listener.send_signal(signal.SIGINT)
        lines, _ = listener.communicate()
    writer.kill()
    writer.wait()
    os.close(board)
    os.close(port)
    end: dict[str, float] = json.loads(lines.splitlines()[-1])
    return end


def main() -> None:
    if sys.argv[1:2] == ["write"]:
        write(int(sys.argv[2]), int(sys.argv[3]))
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    print("| channels | us a sample | share of a core at 5 kHz | samples | lost |\n|---|---|---|---|---|")
    for channels in CHANNELS:
        end = listened(channels, seconds)
        share = end["share_of_core"]
        row = [channels, f"{share / RATE * 1e6:.0f}", f"{share:.1%}", end["samples"], end["lost"]]
        print("| " + " | ".join(map(str, row)) + " |", flush=True)


if __name__ == "__main__":
    main()
