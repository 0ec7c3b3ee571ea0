"""What `skincad listen` takes of a core by number of channels.

`python -m bench.listening [pipe|port] [SECONDS]`. A process of its own writes lines at RATE into a pipe, or
into a pseudo-terminal as a board does: seven digits a value, noise of three times the detector's. `skincad
listen` reads them for SECONDS, 20 if not given, and Ctrl-C ends it. Its last line says what it took: seconds
of the processor, from the first line read, over seconds of the stream. Starting it is left out. A core whose
other thread is busy takes up to twice as long. Where a machine has no time for the listener, the writer loses
samples as a board does, which are counted.
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
BUFFERED = 500  # samples, of the board


def write(descriptor: int, ridges: int) -> None:
    """Write lines in real time until nobody reads."""
    detector = Detector(DESIGN, "single-supply", RATE, range(1, ridges + 1))
    sigma, size = LOUD * detector.tuning.noise / np.sqrt(2), round(RATE)
    volts = 1.65 + np.random.default_rng(1).normal(0, sigma, (size, 2 * ridges))
    tails = ["".join(f",{value:.7f}" for value in row) for row in volts.tolist()]
    head = ",".join(["sample", *(column_name(*channel) for channel in detector.channels)])
    whole = f"{head}\n" + "".join(f"{k}{tails[k]}\n" for k in range(size))
    with os.fdopen(os.dup(descriptor), "wb") as file:
        file.write(whole.encode())  # more than waits in any buffer: it is read from now on
    began, sent = time.monotonic(), size
    while True:
        due = size + round((time.monotonic() - began) * RATE)
        header = f"{head}\n" if sent // size != due // size else ""
        sent = max(sent, due - BUFFERED)  # what a board cannot hand on for longer is lost
        lines = "".join(f"{k}{tails[k % size]}\n" for k in range(sent, due))
        data = memoryview((header + lines).encode())
        while data:
            data = data[os.write(descriptor, data) :]
        sent = due
        time.sleep(EVERY_SECONDS)


def listened(channels: int, seconds: float, line: str = "pipe") -> dict[str, float]:
    """Return the last line of `skincad listen` after `seconds` of so many channels."""
    there, here = os.pipe() if line == "pipe" else os.openpty()[::-1]
    if line == "port":
        tty.setraw(there)
    ridges = channels // 2
    me = [sys.executable, "-m"]
    writer = subprocess.Popen([*me, "bench.listening", "write", str(here), str(ridges)], pass_fds=[here])
    os.close(here)
    select.select([there], [], [])
    wired = ",".join(map(str, range(1, ridges + 1)))
    words = ["skincad", "listen", DESIGN, "--ridges", wired, "--rate", f"{RATE:g}"]
    words += ["-"] if line == "pipe" else ["--port", os.ttyname(there)]
    pipes = {"stdin": there, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([*me, *words], text=True, **pipes) as listener:
        assert listener.stderr is not None
        listener.stderr.readline()  # it has heard half a second
        time.sleep(seconds)
        listener.send_signal(signal.SIGINT)
        lines, said = listener.communicate()
    writer.kill()
    writer.wait()
    os.close(there)
    end: dict[str, float] = json.loads(lines.splitlines()[-1]) if lines else {}
    if end.get("why") != "interrupted":
        raise RuntimeError(said)
    return end


def main() -> None:
    if sys.argv[1:2] == ["write"]:
        write(int(sys.argv[2]), int(sys.argv[3]))
    line = sys.argv.pop(1) if sys.argv[1:2] in (["pipe"], ["port"]) else "pipe"
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 20.0
    print("| channels | us a sample | share of a core at 5 kHz | samples | lost |\n|---|---|---|---|---|")
    for channels in CHANNELS:
        end = listened(channels, seconds, line)
        share = end["share_of_core"]
        row = [channels, f"{share / RATE * 1e6:.0f}", f"{share:.1%}", end["samples"], end["lost"]]
        print("| " + " | ".join(map(str, row)) + " |", flush=True)


if __name__ == "__main__":
    main()
