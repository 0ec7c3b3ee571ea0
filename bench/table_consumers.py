"""Every template by every process, made and read: `python -m bench.table_consumers [names]`.

A row: parts, findings (errors!warnings/notes), seconds of `make`, the worst mesh deviation against what was
asked (mm), and consumers without a complaint of those that are installed. Complaints follow the table.
The process makes cavity and end plates; `own` is the template as it ships. With --own only that.
"""

from __future__ import annotations

import sys
import tempfile
import time
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import NamedTuple

import skincad
from bench.table_processes import by, counts
from skincad.inputs import PROCESSES, Design, template_names
from tests.conftest import Made
from tests.consumers import CONSUMERS, Job

FORMATS = ("step", "stl", "3mf", "dxf", "md", "toml")


class Row(NamedTuple):
    """What came of one design: a refusal, or files and what was said of them."""

    template: str
    process: str
    cells: tuple[str, ...]
    complaints: tuple[str, ...]


def row(template: str, process: str, folder: Path) -> Row:
    """Make a template by a process and have every consumer read it."""
    design = skincad.load(template)
    design = design if process == "own" else by(design, process)
    started = time.perf_counter()
    try:
        made = Made(result := skincad.make(design), skincad.write(result, folder, formats=FORMATS))
    except (skincad.InputError, RuntimeError) as refusal:
        return Row(template, process, ("refused",), (str(refusal),))
    seconds = time.perf_counter() - started
    passing, installed, told = _read(design, Job(design, made))
    worst = max(made.parts, key=lambda part: part.deviation / part.asked_deviation)
    cells = (
        str(len(made.parts)),
        counts(list(made.result.findings)),
        f"{seconds:.1f}",
        f"{worst.deviation:.5f}",
        f"{worst.asked_deviation:g}",
        f"{passing}/{installed}",
    )
    return Row(template, process, cells, tuple(told))


def _read(design: Design, job: Job) -> tuple[int, int, list[str]]:
    passing, told = 0, []
    readers = {name: import_module(f"tests.consumers.{name}") for name in CONSUMERS}
    readers = {name: reader for name, reader in readers.items() if not reader.missing()}
    for name, reader in readers.items():
        try:
            answer = reader.complaints(job)
        except Exception as failure:  # a reader that breaks on a file is one that does not pass
            answer = [f"{type(failure).__name__}: {failure}"]
        passing += not answer
        told += [f"{name}: {complaint}" for complaint in answer]
    return passing, len(readers), told


def rows(templates: list[str], processes: tuple[str, ...]) -> Iterator[Row]:
    """Yield the table's rows as they are made."""
    for template in templates:
        for process in processes:
            with tempfile.TemporaryDirectory() as folder:
                yield row(template, process, Path(folder) / template)


def main() -> None:
    """Print the table as it grows, then what was complained of."""
    names = [name for name in sys.argv[1:] if not name.startswith("--")] or list(template_names())
    processes = ("own",) if "--own" in sys.argv else (*PROCESSES, "own")
    print(f"{'template':20}{'by':6}{'parts':>7}{'e!w/n':>8}{'s':>8}{'worst':>10}{'asked':>8}{'readers':>9}")
    told = []
    for found in rows(names, processes):
        widths = (7, 8, 8, 10, 8, 9)
        cells = "".join(f"{cell:>{width}}" for cell, width in zip(found.cells, widths, strict=False))
        print(f"{found.template:20}{found.process:6}{cells}", flush=True)
        told += [f"{found.template} by {found.process}: {text}" for text in found.complaints]
    print("\n".join(told) if told else "no complaint")


if __name__ == "__main__":
    main()
