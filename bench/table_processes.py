"""Findings of every template by every process: `python -m bench.table_processes [--all]`.

A cell is warnings/notes with every part by that process; own is the template as it ships. With
--all the warnings are printed too. No CAD kernel, no finite elements.
"""

from __future__ import annotations

import sys
import time

import skincad
from skincad.fabrication import Finding, Job, design_findings
from skincad.inputs import PROCESSES, Design, template_names


def rows() -> dict[tuple[str, str], list[Finding]]:
    """Return the findings by (template, process), and by (template, "own")."""
    table = {}
    for name in template_names():
        design = skincad.load(name)
        table[name, "own"] = design_findings(Job(design))
        for process in PROCESSES:
            table[name, process] = design_findings(Job(by(design, process)))
    return table


def by(design: Design, process: str) -> Design:
    """Return the design with cavity and end plates by one process."""
    data = design.model_dump(exclude_none=True)
    data["mold"].pop("end_plate_process", None)
    data["mold"]["process"] = process
    return Design.model_validate(data)


def counts(found: list[Finding]) -> str:
    """Return errors, if any, warnings and notes as text."""
    number = {kind: sum(f.severity == kind for f in found) for kind in ("error", "warning", "note")}
    return (f"{number['error']}!" if number["error"] else "") + f"{number['warning']}/{number['note']}"


def main() -> None:
    start = time.perf_counter()
    answer = rows()
    print(f"{'warnings/notes':22}" + "".join(f"{p:>8}" for p in (*PROCESSES, "own")))
    for name in template_names():
        cells = [counts(answer[name, p]) for p in (*PROCESSES, "own")]
        print(f"{name:22}" + "".join(f"{cell:>8}" for cell in cells))
    print(f"{time.perf_counter() - start:.1f} s")
    if "--all" in sys.argv:
        for (name, process), findings in answer.items():
            for finding in findings:
                print(f"{name} by {process}: {finding}")


if __name__ == "__main__":
    main()
