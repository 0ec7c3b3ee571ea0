"""The whole `make` against `import cadquery` alone, both as processes of their own, and by stage.

python -m bench.bench_make [template] [repeats]
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
from time import perf_counter


def run(code: str, *arguments: str) -> tuple[float, str]:
    """Return a Python process's wall time, s, and what it printed."""
    begin = perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True,
        text=True,
        check=True,
        timeout=3600,
    )
    return perf_counter() - begin, done.stdout


def main() -> None:
    """Print the table."""
    template = sys.argv[1] if len(sys.argv) > 1 else "yamada-2002"
    repeats = int(sys.argv[2]) if len(sys.argv) > 2 else 5
    imports, wholes, stages = [], [], []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(repeats):
            imports.append(run("import cadquery")[0])
            arguments = ("make", template, "--json", "-o", f"{folder}/out")
            seconds, printed = run("from skincad.cli import main; main()", *arguments)
            wholes.append(seconds)
            stages.append(json.loads(printed)["seconds"])
    reference = statistics.median(imports)
    print(f"import cadquery: {reference:.2f} s; all below as multiples of it, medians of {repeats} runs")
    print(f"  {'make ' + template + ', whole process':40} {statistics.median(wholes) / reference:6.2f}")
    for stage in stages[0]:
        median = statistics.median(row[stage] for row in stages)
        name = "total without interpreter and imports" if stage == "total" else stage
        print(f"  {name:40} {median / reference:6.2f}")


if __name__ == "__main__":
    main()
