"""What the package's code never does: run text as code, unpickle, read archives or meshes, start programs.

Nor does it take a name by `match`, whose `$` lets a line end pass.

skincad reads TOML and CSV alone. It writes 3MF, STL, STEP and DXF and reads none, so no archive that bursts
when it is opened can be given to it.
"""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from pydantic import ValidationError

import skincad
from skincad.base import Table
from skincad.circuit import Circuit
from skincad.inputs import Design
from skincad.scenes import Scene

FILES = sorted(Path(skincad.__file__).parent.rglob("*.py"))
CALLS = {"eval", "exec", "compile", "__import__", "system", "popen", "execv", "execve", "spawnv"}
MODULES = {
    "pickle", "marshal", "shelve", "dill", "joblib", "yaml", "zipfile", "tarfile", "gzip", "bz2", "lzma",
    "subprocess", "socket", "urllib", "http", "requests", "ctypes",
}  # fmt: skip
READERS = {
    "load_mesh", "load_scene_mesh", "QueryReader", "ReadFromFile", "load_new_mesh", "importStep", "importDXF",
    "readfile", "load_path", "allow_pickle", "memmap", "fromfile", "genfromtxt",
}  # fmt: skip


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.name)
def test_no_text_becomes_code_and_no_archive_is_read(file: Path) -> None:
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        if isinstance(node, ast.Import | ast.ImportFrom):
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else [a.name for a in node.names]
            served = {"socket"} if file.parts[-2:] == ("live", "serve.py") else set()  # looks for a free port
            assert not {name.split(".")[0] for name in names} & (MODULES - served), f"{file}:{node.lineno}"
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            assert node.func.id not in CALLS, f"{file}:{node.lineno}"
        if isinstance(node, ast.Attribute):
            assert node.attr not in READERS, f"{file}:{node.lineno}"
            assert node.attr != "match", f"{file}:{node.lineno}"
            of_os = isinstance(node.value, ast.Name) and node.value.id == "os"
            assert not (of_os and node.attr in CALLS), f"{file}:{node.lineno}"
        if isinstance(node, ast.keyword):
            assert node.arg != "allow_pickle", f"{file}:{node.lineno}"


def test_the_search_would_see_them() -> None:
    text = FILES[0].read_text("utf-8") + "\nimport pickle\n"
    names = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Import)]
    assert any(alias.name in MODULES for node in names for alias in node.names)
    assert len(FILES) > 100


@pytest.mark.parametrize("end", ["\n", "\r", "\x00", "\u2028", " "])
@pytest.mark.parametrize("model", [Design, Scene, Circuit])
def test_no_name_of_a_pattern_may_end_in_more(model: type[Table], end: str) -> None:
    """Every field with a pattern takes "abc" and not "abc" with a line end behind it."""
    patterned = {key for key, rule in model.model_json_schema()["properties"].items() if "pattern" in rule}
    assert patterned == {"name"}
    for key in patterned:
        for name in ("abc", f"abc{end}"):
            with pytest.raises(ValidationError) as failure:
                model.model_validate({key: name})
            assert any(error["loc"] == (key,) for error in failure.value.errors()) == (name != "abc")
