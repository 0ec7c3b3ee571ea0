"""The pictures of docs/ that skincad draws: `python -m bench.docs_pictures`, a minute or two.

Each is a file of a command that the page shows; `docs/understand/geometry.png` is of `bench.geometry_plot`.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

DOCS = Path(__file__).parents[1] / "docs"
WISH = (
    "new pad.toml --size 24x30 --touch 1N --silicone ecoflex-00-50 --process sla --gripper franka-hand"
    " --film pvdf-28um"
)
PICTURES = {  # in docs/ -> the commands that draw it, and its file
    "start/pictures/first-skin.png": (("make yamada-2002 --format png",), "out/yamada-2002/picture.png"),
    "start/pictures/own-design.png": (
        (WISH, "make pad.toml --format png"),
        "out/pad/picture.png",
    ),
    "start/pictures/first-scene.png": (
        ("simulate yamada-2002-slip",),
        "out/yamada-2002-slip/signals.png",
    ),
    "howto/pictures/solve.png": (
        ("solve plain-ridges --target all_touch_force=1.5 --vary ridge.levelling=0:1 --picture solve.png",),
        "solve.png",
    ),
    "howto/pictures/sweep.png": (
        ("sweep plain-ridges --vary ridge.levelling=0:1:3 --vary ridge.height=0.5,0.6",),
        "out/plain-ridges/effects.png",
    ),
    "howto/pictures/gain.png": (("circuit transimpedance",), "out/transimpedance/gain.png"),
    "howto/pictures/alarms.png": (
        ("simulate yamada-2002-slip --set effects.piezo.circuit=transimpedance --set readout.ridges=[2,3]",),
        "out/yamada-2002-slip/recording.png",
    ),
}


def draw(name: str) -> None:
    """Draw one picture into docs/."""
    commands, file = PICTURES[name]
    with tempfile.TemporaryDirectory() as folder:
        for command in commands:
            line = [sys.executable, "-m", "skincad", *command.split()]
            subprocess.run(line, cwd=folder, check=True, stdout=subprocess.DEVNULL, timeout=600)
        (DOCS / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(Path(folder) / file, DOCS / name)


if __name__ == "__main__":
    for picture in sys.argv[1:] or PICTURES:
        draw(picture)
        print(f"{picture} {(DOCS / picture).stat().st_size / 1000:.0f} kB")
