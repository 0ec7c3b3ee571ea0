"""Which tests run a line: one run of the fast tests under coverage, and what each of them takes.

What runs while a file is imported (a constant, a table) has the tests that run its functions or import from
it, or else those of its room.
"""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

from coverage import CoverageData

SETTINGS = "[run]\nrelative_files = true\n"


@dataclass(frozen=True)
class Covered:
    """A run's coverage by test, files from the tree's top, and each passed test's seconds."""

    tree: Path
    data: CoverageData
    seconds: dict[str, float]

    def tests(self, file: str, line: int, budget: float) -> list[str]:
        """Return tests that run a line: the nearest to its file first, then the shortest, `budget` s of them
        at the most, one at the least."""
        text, inside = (self.tree / file).read_text("utf-8"), Path(file).relative_to("skincad")
        room, mirror = Path("tests") / inside.parent, Path("tests") / inside.parent / f"test_{inside.name}"
        by_line = self.data.contexts_by_lineno(file)
        span, alone = statement(text, line)
        if alone:
            answer = {name for at in span for name in self._named(by_line.get(at, []))}
        else:
            answer = {n for at, all_ in by_line.items() if statement(text, at)[1] for n in self._named(all_)}
            answer |= {name for name in self.seconds if self._names(name.partition("::")[0], file)}
            answer = answer or {name for name in self.seconds if Path(name.partition("::")[0]).parent == room}

        def rank(name: str) -> tuple[bool, bool, float]:
            path = Path(name.partition("::")[0])
            return path != mirror, path.parent != room, self.seconds[name]

        rows: list[str] = []
        for name in sorted(answer, key=rank):
            if rows and self.spent([*rows, name]) > budget:
                continue
            rows.append(name)
        return rows

    def spent(self, tests: list[str]) -> float:
        """Return what these tests took, s."""
        return sum(self.seconds[name] for name in tests)

    def _names(self, test: str, file: str) -> bool:
        """Whether a test file imports from a file by its name."""
        module = file.removesuffix(".py").replace("/", ".")
        return f"from {module} import " in _text(self.tree / test)

    def _named(self, contexts: list[str]) -> set[str]:
        """The passed tests among the contexts of a line, as `tests/a/test_b.py::test_c|run`."""
        return {name for context in contexts if (name := context.rpartition("|")[0]) in self.seconds}


@cache
def _text(path: Path) -> str:
    return path.read_text("utf-8")


@cache
def statement(text: str, line: int) -> tuple[range, bool]:
    """Return the lines of the statement at a line, of one with a body its head's, and whether it is in a
    function, and so runs by itself."""
    inner, within = range(line, line + 1), False

    def visit(node: ast.AST, function: bool) -> None:
        nonlocal inner, within
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.stmt) and child.lineno <= line <= (child.end_lineno or child.lineno):
                body = getattr(child, "body", None)
                end = (child.end_lineno or child.lineno) + 1
                head = range(child.lineno, max(child.lineno + 1, body[0].lineno) if body else end)
                inner, within = (head if line in head else range(line, line + 1)), function
            named = isinstance(child, ast.FunctionDef)
            visit(child, (function or named) and not isinstance(child, ast.ClassDef))

    visit(ast.parse(text), False)
    return inner, within


def recorded(tree: Path, kept: Path, texts: Path) -> Covered:
    """Return what the fast tests run of a tree, whose files are read from its copy `texts`; the folder `kept`
    holds it from one call to the next."""
    told, data = kept / "tests.xml", kept / "coverage"
    if not told.exists():
        print("the fast tests once, under coverage: some minutes", file=sys.stderr)
        kept.mkdir(parents=True, exist_ok=True)
        (kept / "coveragerc").write_text(SETTINGS, "utf-8")
        fast = ["-m", "not slow and not evidence", "-o", "addopts=", "-n", "2", "--dist", "loadfile"]
        told_to = [
            "-p",
            "no:cacheprovider",
            f"--junitxml={told}",
            "--cov=skincad",
            "--cov-context=test",
            "--cov-report=",
        ]
        subprocess.run(
            [sys.executable, "-m", "pytest", "-q", *fast, *told_to, f"--cov-config={kept / 'coveragerc'}"],
            cwd=tree,
            env={**os.environ, "PYTHONPATH": str(tree), "COVERAGE_FILE": str(data)},
            check=False,  # a test that fails sees nothing
            stdout=subprocess.DEVNULL,
            timeout=14400,
        )
    coverage_data = CoverageData(str(data))
    coverage_data.read()
    return Covered(texts, coverage_data, _seconds(told))


def _seconds(report: Path) -> dict[str, float]:
    """Each passed test's seconds, by its name as pytest takes it."""
    table = {}
    for case in ElementTree.parse(report).iter("testcase"):
        if not len(case) or all(part.tag in ("properties", "system-out") for part in case):
            file = case.get("classname", "").replace(".", "/")
            table[f"{file}.py::{case.get('name')}"] = float(case.get("time", "0"))
    return table
