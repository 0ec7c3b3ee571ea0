"""What a change changed: files and JSON of every template by this tree and by another revision, byte by byte.

`python -m bench.compare REVISION` (or another checkout's folder) runs `make` on every design, `simulate` on
every scene and `circuit` on every circuit in both, and prints each difference on a line; exit status 1 if
there is one. One that is meant is named by `--allow REGEX REASON` and printed all the same, with its reason.

`python -m bench.compare --numbers FILE` checks every design by every model and simulates every scene. If
there is no such file it writes there all that was printed; else it prints each number that differs from it by
more than 1e-9 of the largest in its list.

`python -m bench.compare --golden` writes `tests/golden` anew: papers and words of four designs that differ in
kind. tests/golden/test_golden.py compares them by `text_differences`; git shows what a change changed.
"""

from __future__ import annotations

import argparse
import html
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from itertools import zip_longest
from pathlib import Path
from typing import Any

import skincad
from skincad.inputs import Design
from skincad.mechanics import MODELS

HERE = Path(__file__).parents[1]
KINDS = {"circuit": "circuits", "simulate": "scenes", "make": "designs"}  # cheapest first
SAME = 1e-9  # relative, of a number that only rounding changed
TIMED = {"seconds", "manifest_sha256", "sha256"}  # a manifest's hashes say again which files differ
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")

GOLDEN = HERE / "tests" / "golden"
LISTINGS = ("designs", "scenes", "circuits", "studies", "silicones", "processes", "grippers")
# The model that judges a design, and how it differs from its template: metal cut by wire, films on prints of
# resin with a mount, a mill's parts with a mount on pins, pillars in layers.
GOLDEN_DESIGNS: dict[str, tuple[str, dict[str, Any]]] = {
    "yamada-2002": ("winkler", {}),
    "lab-bench": (
        "winkler",
        {"mount": {"thread": "M3", "pattern": "rectangle", "pitch_x": 14.0, "pitch_y": 8.0}},
    ),
    "milled-pad": ("winkler", {"mount": {"thread": "M3", "diameter": 20.0, "pin": 2.0, "fiducials": 4}}),
    "pillars-9": ("reduced", {"shot": ({"name": "dragon-skin-30", "thickness": 1.0},)}),
}
# The fourth digit may be rounded elsewhere; numbers of fewer digits, whole ones too, must be the same.
GOLDEN_TOLERANCE = 1.0e-3
MASKS = {  # what differs by machine, version or random points of a mesh
    r"\b\d[\d.]* m?s\b": "TIME",
    r"mesh within [\d.]+ um": "mesh within DEVIATION",
    r"\b[\d.]+ [kM]B\b": "SIZE",
    r"skincad \d+\.\d+\.\d+\w*": "skincad VERSION",
    r"\b[0-9a-f]{8}\b": "REVISION",
}
NOT_TEXT = re.compile(r"<(style|script|math)\b.*?</\1>|<path\b[^>]*>|<[^>]+>", re.DOTALL)


@contextmanager
def tree(revision: str) -> Iterator[Path]:
    """Give a checkout of a revision: a folder that is one, or a worktree for as long as it is needed."""
    if (Path(revision) / "skincad").is_dir():
        yield Path(revision).resolve()
        return
    with tempfile.TemporaryDirectory() as folder:
        git = ["git", "-C", str(HERE), "worktree"]
        subprocess.run(
            [*git, "add", "--quiet", "--detach", f"{folder}/tree", revision], check=True, timeout=3600
        )
        try:
            yield Path(folder) / "tree"
        finally:
            subprocess.run([*git, "remove", "--force", f"{folder}/tree"], check=True, timeout=3600)


def jobs(trees: Sequence[Path], only: str | None, names: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Yield command and template of each run; a template of one tree alone is run too, and differs."""
    for command, kind in KINDS.items():
        if only in (None, command):
            found = {path.stem for each in trees for path in (each / "templates" / kind).glob("*.toml")}
            yield from ((command, name) for name in sorted(found) if not names or name in names)


def run(checkout: Path, folder: Path, command: str, name: str) -> None:
    """Leave in a folder what a command writes, and as `run.json` what it prints and its exit status."""
    folder.mkdir(parents=True)
    words = [sys.executable, "-m", "skincad", command, name, "--json", "-o", "out"]
    environment = {**os.environ, "PYTHONPATH": str(checkout), "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        words, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=3600
    )
    table = {"status": done.returncode, "printed": json.loads(done.stdout) if done.stdout else done.stderr}
    (folder / "run.json").write_text(json.dumps(table), encoding="utf-8")


def differences(before: Path, now: Path) -> Iterator[str]:
    """Yield a line for each file, and each key of a JSON file, that two folders tell differently."""
    one, two = ({p.relative_to(f).as_posix(): p for p in f.rglob("*") if p.is_file()} for f in (before, now))
    for name in sorted(one.keys() | two.keys()):
        if name not in one or name not in two:
            yield f"{name}: only {'before' if name in one else 'now'}"
        elif name.endswith(".json"):
            rows = [json.loads(path[name].read_text("utf-8")) for path in (one, two)]
            yield from (f"{name} {line}" for line in keys(*rows))
        elif (a := one[name].read_bytes()) != (b := two[name].read_bytes()):
            yield f"{name}: {content(a, b)}"


def keys(before: Any, now: Any) -> Iterator[str]:
    """Yield a line for each key that differs; a list's entries are one key, told by the first of them."""
    table: dict[str, list[tuple[str, Any, Any]]] = {}
    for path, a, b in leaves(before, now):
        table.setdefault(re.sub(r"\[\d+\]", "[]", path), []).append((path, a, b))
    for pairs in table.values():
        path, a, b = pairs[0]
        many = f", and {len(pairs) - 1} more such" if pairs[1:] else ""
        yield f"{path}: {a!r:.60} -> {b!r:.60}{relative([(x, y) for _, x, y in pairs])}{many}"


def leaves(a: Any, b: Any, path: str = "$") -> Iterator[tuple[str, Any, Any]]:
    """Yield path and values of each difference but of wall times, and of a manifest's size: it holds some."""
    if isinstance(a, dict) and isinstance(b, dict):
        skipped = {*TIMED, *(["bytes"] if str(a.get("path")).endswith(".json") else [])}
        for key in [key for key in {**a, **b} if key not in skipped]:
            yield from leaves(a.get(key, "(no key)"), b.get(key, "(no key)"), f"{path}.{key}")
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from leaves(x, y, f"{path}[{i}]")
    elif type(a) is not type(b) or a != b:
        yield path, a, b


def relative(pairs: Sequence[tuple[Any, Any]]) -> str:
    """Return the largest relative difference in words, if all pairs are numbers."""
    if any(isinstance(x, bool) or not isinstance(x, int | float) for pair in pairs for x in pair):
        return ""
    return f" (relative {max(abs(a - b) / (max(abs(a), abs(b)) or 1.0) for a, b in pairs):.1e})"


def content(a: bytes, b: bytes) -> str:
    """Return where two files' bytes first differ: a line of text, or a byte."""
    try:
        texts = a.decode(), b.decode()
    except UnicodeDecodeError:
        first = next((i for i, (x, y) in enumerate(zip(a, b, strict=False)) if x != y), "the end")
        return f"byte {first} of {len(a)} -> {len(b)} bytes"
    lines = [(*text.splitlines(keepends=True), "") for text in texts]
    first, (x, y) = next((i, pair) for i, pair in enumerate(zip(*lines, strict=False)) if pair[0] != pair[1])
    numbers: list[tuple[Any, Any]] = []
    if NUMBER.sub("#", texts[0]) == NUMBER.sub("#", texts[1]):
        numbers = list(zip(*(map(float, NUMBER.findall(text)) for text in texts), strict=True))
    return f"line {first + 1}: {x!r:.60} -> {y!r:.60}{relative(numbers) if numbers else ''}"


def numbers(names: Sequence[str]) -> Iterator[tuple[str, Any]]:
    """Yield what each model says of each design, and each scene's simulation; of a refusal its words."""
    for kind, run_one in (("designs", _checked), ("scenes", _simulated)):
        for path in sorted((HERE / "templates" / kind).glob("*.toml")):
            if not names or path.stem in names:
                yield from run_one(path.stem)


def _checked(name: str) -> Iterator[tuple[str, Any]]:
    for model in MODELS:
        yield f"check {name} {model}", _said(lambda model=model: skincad.check(name, model=model))


def _simulated(name: str) -> Iterator[tuple[str, Any]]:
    yield f"simulate {name}", _said(lambda: skincad.simulate(skincad.load_scene(name)))


def _said(run_one: Callable[[], Any]) -> Any:
    try:
        return json.loads(json.dumps(run_one().as_json()))
    except skincad.InputError as refusal:
        return str(refusal)


def far_apart(a: Any, b: Any, path: str = "$", scale: float = 0.0) -> Iterator[str]:
    """Yield a line for each leaf that differs by more than SAME, of the largest number in its list."""
    if isinstance(a, dict) and isinstance(b, dict):
        for key in [key for key in {**a, **b} if key not in TIMED]:
            least = 1.0 if key.startswith("residual") else 0.0  # they are rounding errors themselves
            yield from far_apart(a.get(key, "(no key)"), b.get(key, "(no key)"), f"{path}.{key}", least)
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        largest = max((abs(x) for x in (*a, *b) if isinstance(x, int | float)), default=scale)
        for i, (x, y) in enumerate(zip(a, b, strict=True)):
            yield from far_apart(x, y, f"{path}[{i}]", largest)
    elif isinstance(a, float) and isinstance(b, float):
        if abs(a - b) > SAME * max(abs(a), abs(b), scale):
            yield f"{path}: {a!r} -> {b!r} (relative {abs(a - b) / max(abs(a), abs(b), scale):.1e})"
    elif masked(str(a), timed=True) != masked(str(b), timed=True):
        yield f"{path}: {a!r:.100} -> {b!r:.100}"


def compare_numbers(file: Path, names: Sequence[str]) -> int:
    """Write a file of all numbers, or print what differs from it; return the exit status."""
    before = json.loads(file.read_text("utf-8")) if file.exists() else None
    now, left = dict[str, Any](), 0
    for name, said in numbers(names):
        now[name] = said
        lines = [] if before is None else list(far_apart(before.get(name, "(no key)"), said))
        left += bool(lines)
        print(
            *(f"{name}: {line}" for line in lines or ["written" if before is None else "same"]),
            sep="\n",
            flush=True,
        )
    if before is None:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(now), encoding="utf-8")
    return 1 if left else 0


def golden_design(name: str) -> Design:
    return skincad.load(name).with_(**GOLDEN_DESIGNS[name][1])


def golden_make(name: str, folder: Path) -> skincad.MakeResult:
    """Make a golden design by its model, and write its papers into a folder."""
    result = skincad.make(golden_design(name), model=GOLDEN_DESIGNS[name][0])
    skincad.write(result, folder, formats=("md", "csv", "svg", "html"))
    return result


def golden_texts(result: skincad.MakeResult, folder: Path) -> dict[str, str]:
    """Return a made design's papers, the words of `make -v` and `check -v`, and the texts of its drawings."""
    drawings = {path.stem: page_text(path) for path in sorted((folder / "drawings").glob("*.svg"))}
    return {
        **golden_papers(result, folder),
        "drawings.txt": masked("".join(f"== {name}\n{text}" for name, text in drawings.items())),
        "report.txt": masked(page_text(folder / "report.html"), timed=True),
        "make.txt": masked(f"{result.details()}\n", timed=True),
    }


def golden_papers(result: skincad.MakeResult, folder: Path) -> dict[str, str]:
    """Return those that need no exact solid: casting sheet, parts list, orders, the words of `check -v`."""
    papers = [
        *sorted((folder / "orders").glob("*.md")),
        folder / "casting-sheet.md",
        folder / "parts-list.csv",
    ]
    check = f"{result.check.details()}\n" if result.check else ""
    texts = {path.name: masked(path.read_text("utf-8")) for path in papers}
    return {**texts, "check.txt": masked(check, timed=True)}


def golden_listings() -> dict[str, str]:
    """Return what `skincad templates` prints, of all kinds together and of each."""
    from skincad.outputs.tomls import listing

    kinds = {"templates": None, **{kind: kind for kind in LISTINGS}}
    return {f"{name}.txt": "\n".join(listing(kind)[1]) + "\n" for name, kind in kinds.items()}


def page_text(path: Path) -> str:
    """Return the words of an HTML or SVG page, one element a line, without scripts, styles and formulas."""
    rows = (
        re.sub(r"\s+", " ", row).strip() for row in NOT_TEXT.sub("\n", path.read_text("utf-8")).split("\n")
    )
    return "".join(f"{html.unescape(row)}\n" for row in rows if row)


def masked(text: str, *, timed: bool = False) -> str:
    """Return a text without what differs from machine to machine; seconds of a casting sheet are its own."""
    for pattern, word in MASKS.items():
        if timed or word != "TIME":
            text = re.sub(pattern, word, text)
    return text


def text_differences(golden: Mapping[str, str], now: Mapping[str, str]) -> Iterator[str]:
    """Yield the lines in which texts differ by more than the rounding of a fourth digit."""
    for name in sorted(golden.keys() | now.keys()):
        one, two = (texts.get(name, "(no such text)").splitlines() for texts in (golden, now))
        for number, (a, b) in enumerate(zip_longest(one, two, fillvalue="(no line)"), 1):
            if not same_line(a, b):
                yield f"{name}: line {number}: {a!r} -> {b!r}"


def same_line(a: str, b: str) -> bool:
    """Whether words are the same and numbers as near as GOLDEN_TOLERANCE."""
    if a == b:
        return True
    pairs = zip(*(map(float, NUMBER.findall(line)) for line in (a, b)), strict=False)
    return NUMBER.sub("#", a) == NUMBER.sub("#", b) and all(
        abs(x - y) <= GOLDEN_TOLERANCE * max(abs(x), abs(y)) for x, y in pairs
    )


def kept(folder: str) -> dict[str, str]:
    """Return the golden texts of a folder."""
    return {path.name: path.read_text("utf-8") for path in (GOLDEN / folder).iterdir()}


def write_golden(names: Sequence[str]) -> None:
    """Write the golden texts anew: the listings, and those of some or all designs."""
    with tempfile.TemporaryDirectory() as scratch:
        designs = [name for name in GOLDEN_DESIGNS if not names or name in names]
        made = {n: golden_texts(golden_make(n, Path(scratch) / n), Path(scratch) / n) for n in designs}
    for folder, texts in {"templates": golden_listings(), **made}.items():
        shutil.rmtree(GOLDEN / folder, ignore_errors=True)
        (GOLDEN / folder).mkdir(parents=True)
        for name, text in texts.items():
            (GOLDEN / folder / name).write_text(text, "utf-8")


def main(arguments: Sequence[str] | None = None) -> int:
    """Print every difference; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m bench.compare")
    parser.add_argument("revision", nargs="?", help="a git revision, or the folder of another checkout")
    parser.add_argument("--numbers", type=Path, metavar="FILE", help="every model's numbers, against a file")
    parser.add_argument("--golden", action="store_true", help="write tests/golden anew")
    parser.add_argument("--only", choices=KINDS, help="only this command")
    parser.add_argument("--name", action="append", default=[], help="only this template; repeatable")
    parser.add_argument("--allow", nargs=2, action="append", default=[], metavar=("REGEX", "REASON"))
    options = parser.parse_args(arguments)
    if options.golden:
        write_golden(options.name)
        return 0
    if options.numbers:
        return compare_numbers(options.numbers, options.name)
    if options.revision is None:
        parser.error("name a revision, --numbers or --golden")
    left = 0
    with tree(options.revision) as other, tempfile.TemporaryDirectory() as out, ThreadPoolExecutor(2) as pool:
        if not (todo := list(jobs((other, HERE), options.only, options.name))):
            parser.error("no template has this name")
        for command, name in todo:
            folders = [Path(out) / side / command / name for side in ("before", "now")]
            list(pool.map(run, (other, HERE), folders, [command] * 2, [name] * 2))
            lines = [f"{command} {name}: {line}" for line in differences(*folders)]
            for line in lines or [f"{command} {name}: same"]:
                reason = next((why for regex, why in options.allow if re.search(regex, line)), None)
                left += bool(lines) and reason is None
                print(line if reason is None or not lines else f"{line} [allowed: {reason}]", flush=True)
    return 1 if left else 0


if __name__ == "__main__":
    sys.exit(main())
