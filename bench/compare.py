"""What a change changed: files and JSON of every template by this tree and by another revision, byte by byte.

`python -m bench.compare REVISION` (or another checkout's folder) runs `make` on every design, `simulate` on
every scene and `circuit` on every circuit in both, and prints each difference on a line; exit status 1 if
there is one. One that is meant is named by `--allow REGEX REASON` and printed all the same, with its reason.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path
from typing import Any

HERE = Path(__file__).parents[1]
KINDS = {"circuit": "circuits", "simulate": "scenes", "make": "designs"}  # cheapest first
TIMED = {"seconds", "manifest_sha256", "sha256"}  # a manifest's hashes say again which files differ
NUMBER = re.compile(r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?")


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


def main(arguments: Sequence[str] | None = None) -> int:
    """Print every difference; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m bench.compare")
    parser.add_argument("revision", help="a git revision, or the folder of another checkout")
    parser.add_argument("--only", choices=KINDS, help="only this command")
    parser.add_argument("--name", action="append", default=[], help="only this template; repeatable")
    parser.add_argument("--allow", nargs=2, action="append", default=[], metavar=("REGEX", "REASON"))
    options = parser.parse_args(arguments)
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
