"""The live page: from a slider's move to section and solid, and to the first verdict, in a browser.

python -m bench.bench_live [template] [moves]

Times are the server's own clock, from the browser's message to the last word handed to the browser; ratios
are to one section with its meshes, computed alone in the same process. The browser draws by the processor, so
it is timed twice: once it gives way to the server, as where a graphics card draws, once it does not.
"""

from __future__ import annotations

import random
import statistics
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter, sleep

import skincad
from skincad.inputs import Design
from skincad.live import Page, ReplyTiming, free_port, preload, view
from skincad.studies import changed
from tests.live.browser import looking
from tests.outputs.browser import CHROMIUM

HOST, BETWEEN = "127.0.0.1", 0.4  # s between two moves, as a hand clicks


def alone(design: Design, repeats: int = 15) -> float:
    """Return the median seconds of one section and its meshes; each design is a new one."""
    spent = []
    for number in range(repeats):
        other = changed(design, {"skin.thickness": design.skin.thickness * (1 + 1e-4 * (number + 1))})
        assert isinstance(other, Design)
        began = perf_counter()
        view(other)
        spent.append(perf_counter() - began)
    return statistics.median(spent)


def line(what: str, values: list[float], unit: float) -> str:
    """Return a row: median and 95th percentile, s, and the latter's ratio to `unit` s."""
    tail = statistics.quantiles(values, n=20)[-1]
    return f"  {what:32} {statistics.median(values):8.3f} {tail:8.3f} {tail / unit:8.2f}"


def moved(design: Design, template: str, moves: int, program: str) -> list[ReplyTiming]:
    """Return what a page took for random moves in this browser."""
    dice = random.Random(1)
    page = Page(design, template, HOST, free_port(HOST, 0))
    try:
        page.desk.wait_until_drawn(60.0)
        with looking(f"http://{HOST}:{page.server.get_port()}", program=program) as (seen,):
            page.desk.wait_until_settled(300.0)
            before = len(page.desk.timings)
            for _ in range(moves):
                seen.anything(dice)
                sleep(BETWEEN)
                if page.desk.session.refusal is not None:
                    seen.press("Undo")
            page.desk.wait_until_settled(300.0)
        return list(page.desk.timings)[before:]
    finally:
        page.close()


def main() -> None:
    """Print the tables."""
    template = sys.argv[1] if len(sys.argv) > 1 else "yamada-2002"
    moves = int(sys.argv[2]) if len(sys.argv) > 2 else 40
    design = skincad.load(template)
    preload()
    unit = alone(design)
    print(f"{template}: one section and its meshes alone {unit:.3f} s")
    with TemporaryDirectory() as folder:
        patient = Path(folder) / "chromium"
        patient.write_text(f'#!/bin/sh\nexec nice -n 19 {CHROMIUM} "$@"\n')
        patient.chmod(0o755)
        for browser, program in (("gives way", str(patient)), ("does not", CHROMIUM)):
            taken = moved(design, template, moves, program)
            print(f"browser {browser}: {moves} moves, {len(taken)} valid ones that no newer one overtook")
            print(f"  {'':32} {'median':>8} {'95 %':>8} {'ratio':>8}")
            print(
                line("move to section and solid, s", [each.drawn_at - each.moved_at for each in taken], unit)
            )
            print(line("move to first verdict, s", [each.verdict_at - each.moved_at for each in taken], unit))


if __name__ == "__main__":
    main()
