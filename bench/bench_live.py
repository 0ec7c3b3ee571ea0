"""The live page: from a slider's move to section and solid, and to the first verdict, in a browser.

python -m bench.bench_live [template] [moves]

Times are the server's own clock, from the browser's message to the last word handed to the browser; ratios
are to one section with its meshes, computed alone in the same process. The browser draws by the processor.
"""

from __future__ import annotations

import random
import statistics
import sys
from time import perf_counter, sleep

import skincad
from skincad.inputs.design import Design
from skincad.live.jobs import warmed
from skincad.live.page import Page
from skincad.live.serve import free_port
from skincad.live.shapes import view
from skincad.studies.subject import changed
from tests.live.browser import looking

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


def main() -> None:
    """Print the table."""
    template = sys.argv[1] if len(sys.argv) > 1 else "yamada-2002"
    moves = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    design, dice = skincad.load(template), random.Random(1)
    warmed()
    unit = alone(design)
    page = Page(design, template, HOST, free_port(HOST, 0))
    try:
        page.desk.drawn(60.0)
        with looking(f"http://{HOST}:{page.server.get_port()}") as (seen,):
            page.desk.settled(300.0)
            before = len(page.desk.timings)
            for _ in range(moves):
                seen.anything(dice)
                sleep(BETWEEN)
                if page.desk.session.refusal is not None:
                    seen.press("Undo")
            page.desk.settled(300.0)
        taken = list(page.desk.timings)[before:]
    finally:
        page.close()
    print(f"{template}: {moves} moves, {len(taken)} valid ones that no newer one overtook")
    print(f"  one section and its meshes alone {unit:8.3f} s")
    print(f"  {'':32} {'median':>8} {'95 %':>8} {'ratio':>8}")
    print(line("move to section and solid, s", [each.drawn - each.asked for each in taken], unit))
    print(line("move to first verdict, s", [each.judged - each.asked for each in taken], unit))


if __name__ == "__main__":
    main()
