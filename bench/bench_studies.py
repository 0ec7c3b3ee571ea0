"""What a study costs beside its evaluations, and what a second worker saves: ratios of one run.

`python -m bench.bench_studies 40` sweeps 40 designs by the linear model with one worker and with two, and
prints the ratio of the times, an evaluation's time against a check's of its own process, and the bookkeeping.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import skincad
from skincad.studies import Log, Query, evaluate

DESIGN, LENGTHS = "yamada-2002", (8.0, 14.0)


def swept(count: int, workers: int) -> float:
    """Return the seconds of a sweep of `count` lengths."""
    with TemporaryDirectory() as folder:
        vary = {"skin.length": (*LENGTHS, count)}
        return skincad.sweep(skincad.load_design(DESIGN), vary, folder=folder, workers=workers).seconds


def bookkeeping(count: int = 200) -> float:
    """Return the seconds that an evaluation's key, claim and line take."""
    design, question = skincad.load_design(DESIGN), Query("check", "winkler")
    evaluation = evaluate(design, {}, question)
    with TemporaryDirectory() as folder:
        log, began = Log(Path(folder)), perf_counter()
        for number in range(count):
            key = question.key(design)[:-8] + f"{number:08x}"
            log.claim(key)
            log.read()
            log.append(replace(evaluation, key=key))
            log.release(key)
        return (perf_counter() - began) / count


def main() -> None:
    """Print the ratios."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("count", type=int)
    count = parser.parse_args().count
    command = [sys.executable, "-m", "skincad", "check", DESIGN, "--tier", "linear", "--no-advice", "--json"]
    began = perf_counter()
    subprocess.run(command, check=False, stdout=subprocess.DEVNULL, timeout=3600)
    alone = perf_counter() - began
    one, two = swept(count, 1), swept(count, 2)
    print(f"{count} linear evaluations: {one:.1f} s by one worker, {two:.1f} s by two: {two / one:.2f}")
    print(f"an evaluation {one / count:.2f} s, a check as a command {alone:.2f} s: {one / count / alone:.2f}")
    print(f"key, claim and line of an evaluation: {1e3 * bookkeeping():.2f} ms")


if __name__ == "__main__":
    main()
