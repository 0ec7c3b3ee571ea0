"""The gallery: each shipped design's all-touch force, and its picture. mkdocs makes the page that shows them.

    python -m bench.gallery [--pictures]

Writes templates/gallery.toml for designs that have changed since. With --pictures all pictures in
docs/gallery are drawn too.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

import tomlkit
from PIL import Image

import skincad
from skincad.inputs import template_names
from skincad.outputs import forces
from skincad.studies import first_able

ROOT = Path(__file__).parent.parent
FILE = ROOT / "templates" / "gallery.toml"
MODELS = "corrected-finite-strain", "finite-strain", "reduced"  # the first that takes the design
WIDTH, COLOURS = 900, 96  # pixels of a picture, and its palette
HEAD = "# All-touch forces of the shipped designs, by revision: python -m bench.gallery writes them\n\n"


def main(pictures: bool) -> None:
    rows = {}
    for name in template_names("designs"):
        design, known = skincad.load_design(name), forces().get(name, {})
        if known.get("revision") != design.revision:
            verdict = skincad.check(design, model=first_able(MODELS, design))
            force = verdict.all_touch_force
            known = {"revision": design.revision, "model": verdict.model}
            if force.value is not None and force.error is not None:
                known |= {
                    "all_touch_force": float(f"{force.value:.4g}"),
                    "error": float(f"{force.error:.2g}"),
                }
            print(verdict)
        rows[name] = known
    FILE.write_text(HEAD + tomlkit.dumps(rows), encoding="utf-8")
    forces.cache_clear()
    if pictures:
        for name in rows:
            draw(name, ROOT / "docs" / "gallery" / f"{name}.png")


def draw(name: str, path: Path) -> None:
    """Write a design's picture, scaled and with few colours."""
    path.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        made = skincad.make(skincad.load_design(name), preview=True)
        skincad.write(made, Path(folder) / "out", formats=("png",))
        with Image.open(Path(folder) / "out" / "picture.png") as whole:
            image = whole.convert("RGB")
        image.thumbnail((WIDTH, WIDTH), Image.Resampling.LANCZOS)
        few = image.quantize(COLOURS, Image.Quantize.MAXCOVERAGE, kmeans=2, dither=Image.Dither.NONE)
        few.save(path, optimize=True)
        print(path.name, path.stat().st_size)


if __name__ == "__main__":
    main("--pictures" in sys.argv[1:])
