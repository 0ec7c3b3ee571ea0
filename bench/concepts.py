"""How much a reader must know of mechanics, effects and scenes.

`python -m bench.concepts` counts classes, pads, states and lines of code of these rooms, the functions and
modules that one default check of yamada-2002 runs, and the stations of the scene in `simulate` of
yamada-2002-press: functions that are given it, and how often it comes back to a module that it had left.
A minute.
"""

from __future__ import annotations

import ast
import io
import sys
import tokenize
from collections.abc import Callable
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import skincad
from skincad.scenes import Scene

ROOMS = "mechanics", "effects", "scenes"
HOME = Path(skincad.__file__).parent
PASSED_OVER = {tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT}


def files(room: str) -> list[Path]:
    return sorted((HOME / room).rglob("*.py"))


def classes(room: str) -> list[str]:
    """Return the names of a room's classes."""
    trees = (ast.parse(path.read_text("utf-8")) for path in files(room))
    return [node.name for tree in trees for node in ast.walk(tree) if isinstance(node, ast.ClassDef)]


def lines_of_code(path: Path) -> int:
    """Return a file's lines without comments, docstrings and blank ones."""
    text = path.read_text("utf-8")
    lines: set[int] = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in PASSED_OVER:
            lines.update(range(token.start[0], token.end[0] + 1))
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node):
            words = node.body[0]
            lines -= set(range(words.lineno, (words.end_lineno or 0) + 1))
    return len(lines)


def called(work: Callable[[], object], seen: Callable[[FrameType], None]) -> None:
    """Do some work; `seen` is told of each call of a function of the package."""
    ours = str(HOME)

    def profile(frame: FrameType, event: str, _: Any) -> None:
        if event == "call" and frame.f_code.co_filename.startswith(ours):
            seen(frame)

    sys.setprofile(profile)
    try:
        work()
    finally:
        sys.setprofile(None)


def run_by_check(name: str) -> tuple[int, int]:
    """Return how many functions and modules a check runs."""
    codes: set[CodeType] = set()
    called(lambda: skincad.check(name), lambda frame: codes.add(frame.f_code))
    functions = {code for code in codes if not code.co_name.startswith("<")}
    return len(functions), len({code.co_filename for code in functions})


def stations(name: str) -> tuple[int, int]:
    """Return how many functions are given the scene, and how often it comes back to a module."""
    scene, functions, modules = skincad.load_scene(name), set[CodeType](), list[str]()

    def seen(frame: FrameType) -> None:
        code = frame.f_code
        given = code.co_varnames[: code.co_argcount + code.co_kwonlyargcount]
        if any(isinstance(frame.f_locals.get(argument), Scene) for argument in given if argument != "self"):
            if code not in functions and (not modules or modules[-1] != code.co_filename):
                modules.append(code.co_filename)
            functions.add(code)

    called(lambda: skincad.simulate(scene), seen)
    return len(functions), len(modules) - len(set(modules))


def main() -> None:
    """Print a figure a line."""
    for room in ROOMS:
        names = classes(room)
        print(f"{room}: {len(names)} classes, {sum(map(lines_of_code, files(room)))} lines of code")
    names = [name for room in ROOMS for name in classes(room)]
    for ending in ("Pad", "State"):
        print(f"...{ending}: {sum(name.endswith(ending) for name in names)}")
    print("a default check of yamada-2002: {} functions in {} modules".format(*run_by_check("yamada-2002")))
    print("the scene in simulate: {} stations, {} returns".format(*stations("yamada-2002-press")), flush=True)


if __name__ == "__main__":
    main()
