"""What README.md and docs/*.md show, and the notebooks of examples/: commands, Python, TOML."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parent.parent
DOCUMENTS = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
NOTEBOOKS = sorted((ROOT / "examples").glob("*.ipynb"))
SHELL = ("sh", "shell", "bash", "console")
# run elsewhere, not here: .ci/run takes README's own install and test commands word for word
ELSEWHERE = (
    r"\bpip install\b",
    r"\bactivate\b",
    r"bin/pytest\b",
    r"\bapt-get install\b",
    r"^python -m bench\b",
)


@dataclass(frozen=True)
class Block:
    """A fenced block, or the indented lines that begin with `skincad`, which are a shell's."""

    document: str
    language: str
    text: str


def blocks(path: Path) -> Iterator[Block]:
    """All of a document, in its order."""
    name = path.relative_to(ROOT).as_posix()
    text = path.read_text("utf-8")
    fence = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```$|^    (skincad [^\n]*)$", re.MULTILINE | re.DOTALL)
    for found in fence.finditer(text):
        if found[3]:
            yield Block(name, "sh", re.split(r"\s{2,}", found[3])[0])
        else:
            yield Block(name, found[1], found[2])


def lines(block: Block) -> list[str]:
    """A shell block's commands, without prompts, comments and, after a prompt, what is printed."""
    text = block.text.replace("\\\n", " ")
    rows = [row.strip() for row in text.splitlines()]
    if any(row.startswith("$ ") for row in rows):
        rows = [row[2:] for row in rows if row.startswith("$ ")]
    return [re.sub(r"\s+#.*", "", row) for row in rows if row and not row.startswith("#")]


def elsewhere(line: str) -> bool:
    return any(re.search(pattern, line) for pattern in ELSEWHERE)


def commands() -> list[str]:
    """All lines of shell that are to be run here, each once."""
    shown = (line for path in DOCUMENTS for b in blocks(path) if b.language in SHELL for line in lines(b))
    return list(dict.fromkeys(line for line in shown if not elsewhere(line)))


def programs() -> dict[str, str]:
    """A document's or notebook's Python: its blocks in their order, for a later one may use an earlier's."""
    found = {}
    for path in DOCUMENTS:
        texts = [b.text for b in blocks(path) if b.language == "python"]
        if texts:
            found[path.relative_to(ROOT).as_posix()] = "\n".join(texts)
    for path in NOTEBOOKS:
        cells = json.loads(path.read_text("utf-8"))["cells"]
        texts = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
        found[path.relative_to(ROOT).as_posix()] = "\n".join(texts)
    return found
