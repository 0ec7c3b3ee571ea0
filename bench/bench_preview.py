"""How long `make` and `make --preview` take as processes, as multiples of `import cadquery`.

python -m bench.bench_preview [DESIGN] [ROUNDS]
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
from statistics import median
from time import perf_counter

COMMANDS = {
    "import cadquery": ["-c", "import cadquery"],
    "make --preview": ["-m", "skincad", "make", "{design}", "--preview", "-o", "{folder}/preview"],
    "make": ["-m", "skincad", "make", "{design}", "--no-advice", "-o", "{folder}/made"],
}


def main(design: str = "yamada-2002", rounds: str = "3") -> None:
    """Print the median of each command's wall time, and its ratio to the import's."""
    table: dict[str, list[float]] = {name: [] for name in COMMANDS}
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(int(rounds)):
            for name, words in COMMANDS.items():
                rows = [word.format(design=design, folder=folder) for word in words]
                began = perf_counter()
                subprocess.run([sys.executable, *rows], capture_output=True, check=False, timeout=3600)
                table[name].append(perf_counter() - began)
    base = median(table["import cadquery"])
    for name, seconds in table.items():
        spread = f"{min(seconds):.1f} to {max(seconds):.1f}"
        print(f"{name:16} {median(seconds):6.2f} s ({spread})  {median(seconds) / base:5.2f}")


if __name__ == "__main__":
    main(*sys.argv[1:])
