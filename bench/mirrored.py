"""Which tests belong to a source file: its mirror in tests/, or else those that import it, nearest first."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path


@cache
def imported(path: Path) -> frozenset[str]:
    """Return the modules that a file names: in imports wherever they stand, and in text as lazy tables do."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found.update(name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.update([node.module, *(f"{node.module}.{name.name}" for name in node.names)])
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            found.update(re.findall(r"^skincad\.[\w.]+", node.value))
    return frozenset(found)


@cache
def covering(tree: Path, file: str, most: int = 12) -> list[str]:
    """Return the test files of a source file: its mirror if there is one, else those that import it.

    At most so many; those that import the file itself come before those that do so through others, of those
    equally near the ones of the same room, and then those that import the least of the package.
    """
    inside = Path(file).relative_to("skincad")
    mirror = Path("tests") / inside.parent / f"test_{inside.name}"
    if (tree / mirror).exists():
        return [mirror.as_posix()]
    tests = sorted(tree.glob("tests/**/test_*.py"))
    code = {path: module(path.relative_to(tree)) for path in sorted(tree.glob("skincad/**/*.py"))}
    room, ours = tree / "tests" / inside.parent, set(code.values())
    near, reached, found = {module(Path(file))}, set[str](), list[Path]()
    while near and len(found) < most:
        new = [path for path in tests if path not in found and imported(path) & near]
        found += sorted(new, key=lambda path: (path.parent != room, len(imported(path) & ours)))
        reached |= near
        near = {name for path, name in code.items() if imported(path) & near} - reached
    return [path.relative_to(tree).as_posix() for path in found[:most]]


def module(path: Path) -> str:
    """Return the name by which a file, from the tree's top, is imported."""
    parts = path.with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
