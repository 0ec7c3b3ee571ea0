"""One small change of a source text: where one could be made, and to what.

An operator turns into its neighbour, a number is doubled, halved or moved by one, True turns into False,
`min` into `max`; a sign or a `not` goes. Left alone is what changes no result: annotations, decorators, text
(what an f-string holds, too), `zip`'s `strict`, how many answers a cache holds, what a type checker reads.
"""

from __future__ import annotations

import ast
import io
import tokenize
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

COMPARED = {
    "<": ("<=", ">"), "<=": ("<", ">"), ">": (">=", "<"), ">=": (">", "<"), "==": ("!=",), "!=": ("==",),
    "is": ("is not",), "is not": ("is",), "in": ("not in",), "not in": ("in",),
}  # fmt: skip
REPLACED = {
    **COMPARED, "+": ("-",), "-": ("+",), "*": ("/",), "/": ("*",), "//": ("/",), "%": ("*",), "**": ("*",),
    "+=": ("-=",), "-=": ("+=",), "*=": ("/=",), "/=": ("*=",), "and": ("or",), "or": ("and",),
    "True": ("False",), "False": ("True",),
    "min": ("max",), "max": ("min",), "minimum": ("maximum",), "maximum": ("minimum",),
}  # fmt: skip
NO_RESULT = {"strict", "maxsize"}  # keyword arguments
Place = tuple[int, int]  # line from 1, column from 0 in characters


@dataclass(frozen=True)
class Site:
    """A place in a text that can be changed, and to what."""

    start: Place
    end: Place
    before: str
    after: tuple[str, ...]


class _Finder(ast.NodeVisitor):
    def __init__(self, text: str) -> None:
        self.lines = text.splitlines(keepends=True)
        self.tokens = list(tokenize.generate_tokens(io.StringIO(text).readline))
        self.sites: list[Site] = []

    def place(self, node: Any, end: bool = False) -> Place:
        """A node's start or end; the parser counts columns in bytes."""
        line, column = (node.end_lineno, node.end_col_offset) if end else (node.lineno, node.col_offset)
        return line, len(self.lines[line - 1].encode()[:column].decode())

    def between(self, start: Place, end: Place) -> None:
        """Take the one operator between two operands."""
        rows = [
            t
            for t in self.tokens
            if start <= t.start and t.end <= end and (t.string in REPLACED or t.string == "not")
        ]
        if rows:
            before = " ".join(t.string for t in rows)
            self.sites.append(Site(rows[0].start, rows[-1].end, before, REPLACED[before]))

    def visit_BinOp(self, node: ast.BinOp) -> None:
        if not any(_text_or_list(each) for each in (node.left, node.right)):
            self.between(self.place(node.left, end=True), self.place(node.right))
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        if not _text_or_list(node.value):
            self.between(self.place(node.target, end=True), self.place(node.value))
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        operands = [node.left, *node.comparators]
        for left, right in pairwise(operands):
            self.between(self.place(left, end=True), self.place(right))
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        for left, right in pairwise(node.values):
            self.between(self.place(left, end=True), self.place(right))
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        start = self.place(node)
        sign = {ast.Not: "not", ast.USub: "-"}.get(type(node.op))
        if sign:
            self.sites.append(Site(start, (start[0], start[1] + len(sign)), sign, ("",)))
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        after = other_constant(node.value)
        if after:
            start, end = self.place(node), self.place(node, end=True)
            self.sites.append(Site(start, end, self.lines[start[0] - 1][start[1] : end[1]], after))

    def visit_Name(self, node: ast.Name) -> None:
        if node.id in ("min", "max"):
            self.sites.append(Site(self.place(node), self.place(node, end=True), node.id, REPLACED[node.id]))

    def visit_Attribute(self, node: ast.Attribute) -> None:
        line, column = self.place(node, end=True)
        if node.attr in ("min", "max", "minimum", "maximum"):
            self.sites.append(
                Site((line, column - len(node.attr)), (line, column), node.attr, REPLACED[node.attr])
            )
        self.generic_visit(node)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None: ...

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value:
            self.visit(node.value)

    def visit_arg(self, node: ast.arg) -> None: ...

    def visit_keyword(self, node: ast.keyword) -> None:
        if node.arg not in NO_RESULT:
            self.visit(node.value)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        for each in (node.args, *node.body):
            self.visit(each)

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        for each in node.body:
            self.visit(each)

    def visit_If(self, node: ast.If) -> None:
        if ast.unparse(node.test) != "TYPE_CHECKING":
            self.generic_visit(node)


def other_constant(value: Any) -> tuple[str, ...]:
    """Return what a constant may turn into: another truth, a number scaled or moved by one."""
    if isinstance(value, bool):
        return REPLACED[str(value)]
    if isinstance(value, int):
        return (str(value + 1), str(value - 1)) if value else ("1",)
    if isinstance(value, float):
        return (repr(2.0 * value), repr(0.5 * value)) if value else ("1.0",)
    return ()


def _text_or_list(node: ast.expr) -> bool:
    """Whether `+` and `*` join or repeat: then another operator fails at once, which shows nothing."""
    return isinstance(node, ast.JoinedStr | ast.List | ast.Tuple | ast.ListComp) or (
        isinstance(node, ast.Constant) and isinstance(node.value, str)
    )


def sites(text: str) -> Iterator[Site]:
    """Yield each place of a source text that can be changed, from the top."""
    finder = _Finder(text)
    finder.visit(ast.parse(text))
    yield from sorted(finder.sites, key=lambda site: (site.start, site.end))


def mutated(text: str, site: Site, after: str) -> str:
    """Return the text with one place changed."""
    lines = text.splitlines(keepends=True)
    (first, start), (last, end) = site.start, site.end
    lines[first - 1 : last] = [lines[first - 1][:start] + after + lines[last - 1][end:]]
    return "".join(lines)
