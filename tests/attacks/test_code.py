"""What the package's code never does: run text, unpickle, read archives, start programs, catch everything.

Nor does it take a name by `match`, whose `$` lets a line end pass. skincad reads TOML and CSV alone. It
writes 3MF, STL, STEP and DXF and reads none: no archive that bursts as it is opened can be given to it.
"""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest
from pydantic import ValidationError

import skincad
from skincad.base import Table
from skincad.circuit import Circuit
from skincad.inputs import Design
from skincad.scenes import Scene

PACKAGE = Path(skincad.__file__).parent
TEXTS = {
    path.relative_to(PACKAGE).as_posix(): path.read_text("utf-8") for path in sorted(PACKAGE.rglob("*.py"))
}
IMPORTS = r"^ *(?:import|from)\s+(?:[\w.]+,\s*)*(?:{})\b.*"
FORBIDDEN = {
    "text becomes code": r"(?<![.\w])(?:eval|exec|compile|__import__)\(",
    "a program is started": r"\bos\.(?:system|popen|exec\w+|spawn\w+)\b",
    "what unpickles, unpacks or connects": IMPORTS.format(
        "pickle|marshal|shelve|dill|joblib|yaml|zipfile|tarfile|gzip|bz2|lzma|socket|urllib|http|requests|ctypes"
    ),
    "a mesh or an array is read": r"\b(?:load_mesh|load_scene_mesh|QueryReader|ReadFromFile|load_new_mesh"
    r"|importStep|importDXF|readfile|load_path|memmap|fromfile|genfromtxt|allow_pickle)\b",
    "`match` lets a line end pass": r"\.match\b",
    # none can die alone, but for a study's, which says so and loses nothing that was finished
    # (tests/studies/test_running.py), and a live page's, which says so and takes another (tests/live)
    "a worker": IMPORTS.format("multiprocessing|concurrent|subprocess|threading|asyncio"),
}
ALLOWED = {
    "live/serve.py": ("import socket",),  # looks for a free port
    "studies/running.py": ("from concurrent.futures", "from multiprocessing import get_context"),
    "live/worker.py": ("from multiprocessing import get_context", "from threading import"),
}
STARTS_NOTHING = re.compile(r"from threading import (?:(?:Lock|RLock|current_thread|main_thread)(?:, )?)+$")
SAMPLES = (
    *("x = eval(text)", "exec(text, {})", "os.popen(words)", "import json, pickle"),
    *(
        "from zipfile import ZipFile",
        "    import subprocess",
        "from concurrent.futures import wait",
        "trimesh.load_mesh(file)",
    ),
    *("np.load(file, allow_pickle=True)", "re.match(pattern, name)", "from threading import Thread, Lock"),
)


def violations(text: str) -> list[str]:
    lines = [hit[0].strip() for rule in FORBIDDEN.values() for hit in re.finditer(rule, text, re.MULTILINE)]
    return [line for line in lines if not STARTS_NOTHING.match(line)]


@pytest.mark.parametrize("sample", SAMPLES)
def test_a_violation_is_seen(sample: str) -> None:
    assert violations(f"import re\n{sample}\n")


def test_no_text_becomes_code_no_archive_is_read_and_no_worker_started() -> None:
    assert len(TEXTS) > 100
    rows = {name: violations(text) for name, text in TEXTS.items()}
    seen = {
        name: lines
        for name, hits in rows.items()
        if (lines := [line for line in hits if not line.startswith(ALLOWED.get(name, ()))])
    }
    assert seen == {}


def test_nothing_catches_everything_but_the_command_lines_end() -> None:
    """What catches every exception hides faults, and memory that ran out, behind another word."""
    names = []
    for name, text in TEXTS.items():
        if not re.search(r"except\s*:|except.*\b(?:Base)?Exception\b", text):
            continue
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.ExceptHandler):
                kinds = {part.id for part in ast.walk(node.type or node) if isinstance(part, ast.Name)}
                wide = node.type is None or {"Exception", "BaseException"} & kinds
                if wide and not isinstance(node.body[-1], ast.Raise):
                    names.append(Path(name).name)
    # a page of sliders stays, whatever a design leads to: it shows the failure and prints its traceback
    assert sorted(names) == ["desk.py", "page.py", "process.py", "worker.py"]


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
