"""What is loaded when: `--help` no kernel and no FE library, a check never the CAD kernel; no circles."""

from __future__ import annotations

import re
import subprocess
import sys
from collections import Counter
from functools import cache
from graphlib import CycleError, TopologicalSorter
from importlib import import_module
from pathlib import Path

import grimp
import pytest

from skincad.effects import EFFECTS

CAD = ("OCP", "cadquery", "vtkmodules")
FE = ("ngsolve", "netgen")
PACKAGE = Path(__file__).parents[1] / "skincad"
ONE_RIDGE = ("--set", "ridge.count=1", "--set", "skin.width=3.0")
FEW_ELEMENTS = ("--tier", "linear", "--force", "0.2", "--tol", "0.3")
MESHES = ("manifold3d", "pymeshlab", "trimesh", "matplotlib")


def loaded_after(*steps: str) -> list[set[str]]:
    """The libraries loaded after each step of one process."""
    tell = "\nprint(*{m.split('.')[0] for m in sys.modules})\n"
    program = "import sys\n" + tell.join((*steps, ""))
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr
    return [set(line.split()) for line in done.stdout.splitlines()]


def run(*arguments: str) -> str:
    return (
        "import contextlib, io\n"
        f"sys.argv = ['skincad', *{list(arguments)!r}]\n"
        "from skincad.cli import main\n"
        "with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):\n"
        "    main()\n"
    )


HEAVY = (*CAD, *FE, *MESHES)
# What one process does, and what is not loaded after each step: nor was it by that step alone.
PROCESSES: dict[str, list[tuple[str, tuple[str, ...]]]] = {
    "ever more of the command line": [
        ("import skincad", (*HEAVY, "scipy", "numpy", "pydantic")),
        (run("--help"), (*HEAVY, "scipy", "numpy", "pydantic")),
        # pydantic comes by typer itself, for the help of any command with typed options
        (run("simulate", "--help"), (*HEAVY, "scipy", "numpy")),
        (run("accuracy", "--help"), (*HEAVY, "scipy", "numpy")),
        (run("make", "--help"), (*HEAVY, "scipy")),
        (run("templates"), (*HEAVY, "scipy")),
        ("from skincad.scenes.scene import load_scene; load_scene('yamada-2002-slip')", HEAVY),
        (run("check", "plain-ridges", "--tier", "winkler"), HEAVY),
    ],
    "finite elements": [
        (run("check", "plain-ridges", *ONE_RIDGE, *FEW_ELEMENTS), (*CAD, *MESHES)),
        # words are printed without what draws
        ("import skincad.outputs.measurements, skincad.outputs.simulations", (*CAD, "matplotlib")),
    ],
    "solids": [
        (
            "from skincad.shape.skin import section; import skincad; section(skincad.load('yamada-2002'))",
            (*CAD, *FE),
        ),
        (f"skincad.skin_solid(skincad.load('yamada-2002', {ONE_RIDGE[1::2]}))", FE),
    ],
}
LOADED = {
    "ever more of the command line": "pydantic",
    "finite elements": "ngsolve",
    "solids": "OCP",
}  # by the last step: it was really taken


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [name if "line" in name else pytest.param(name, marks=pytest.mark.slow) for name in PROCESSES]
)
def test_nothing_is_loaded_that_is_not_used(name: str) -> None:
    steps = PROCESSES[name]
    data = loaded_after(*(code for code, _ in steps))
    for (code, absent), loaded in zip(steps, data, strict=True):
        assert loaded & set(absent) == set(), code
    assert LOADED[name] in data[-1]


def test_every_public_name_is_there_and_stays_callable() -> None:
    import skincad

    for name in skincad.__all__:
        assert getattr(skincad, name) is getattr(skincad, name)
    assert callable(skincad.make)
    assert callable(skincad.check)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = skincad.nonsense


@cache
def arrows() -> dict[str, set[str]]:
    """What each module imports anywhere: in functions and for type checking too."""
    graph = grimp.build_graph("skincad", cache_dir=None)
    return {module: graph.find_modules_directly_imported_by(module) for module in graph.modules}


def test_no_modules_import_each_other() -> None:
    assert len(arrows()) > 200
    try:
        TopologicalSorter(arrows()).prepare()
    except CycleError as circle:
        pytest.fail(" <- ".join(circle.args[1]))


def test_effects_do_not_know_each_other() -> None:
    """Nor need a new one be named anywhere but in its table, which this reads."""
    homes = {where.partition(":")[0] for where in EFFECTS.values()}
    for home in homes:
        assert arrows()[home] & homes <= {home}


def test_a_class_name_means_one_thing() -> None:
    texts = [path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")]
    names = Counter(
        name for text in texts for name in re.findall(r"^ *class ([A-Za-z]\w*)", text, re.MULTILINE)
    )
    assert {name for name, times in names.items() if times > 1} == set()


ROOMS = sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py"))
FACES = [room for room in ROOMS if "face(" in (PACKAGE / room / "__init__.py").read_text("utf-8")]
IMPORT = re.compile(r"^ *from (skincad\.[\w.]+) import (?:\(([^)]*)\)|(.*)$)", re.MULTILINE)
# a helper that patches a module, and where a name of the face would hide a module of the same name
BESIDE_FACES = {"tests/clock.py", "tests/shared_pads.py", "tests/shared.py"}


MOST_DEEP_NAMES = 20  # as many as there are


@cache
def imports() -> list[tuple[str, str, str]]:
    """File, module and name of each import from skincad in the package, its tests and benches."""
    root = PACKAGE.parent
    files = [path for folder in ("skincad", "tests", "bench") for path in (root / folder).rglob("*.py")]
    return [
        (path.relative_to(root).as_posix(), module, name.split(" as ")[0])
        for path in files
        for module, many, one in IMPORT.findall(path.read_text("utf-8"))
        for name in re.findall(r"[A-Za-z_]\w*(?: as \w+)?", re.sub(r"#.*", "", many or one))
    ]


def room_of(file: str) -> str:
    """The room that a file of the package or of tests belongs to; "" for files of tests directly."""
    parts = file.split("/")
    return parts[1] if parts[0] in ("skincad", "tests") and len(parts) > 2 else ""


@pytest.mark.parametrize("room", FACES)
def test_a_face_holds_what_others_use(room: str) -> None:
    """Each name of the table is there, and another room, the package, a bench or a test uses it."""
    face = import_module(f"skincad.{room}")
    names = set(dir(face))
    assert all(getattr(face, name) is not None for name in names)
    used = {
        name
        for file, module, name in imports()
        if not file.startswith(f"skincad/{room}/") and f"{module}.".startswith(f"skincad.{room}.")
    }
    public = re.findall(r"\w+", (PACKAGE / "__init__.py").read_text("utf-8"))
    assert names - used - set(public) == set()


def test_tests_of_other_rooms_enter_by_faces() -> None:
    """But for modules that are patched, and names that their own modules would hide in the face."""
    deep = {
        f"{module}.{name}"
        for file, module, name in imports()
        if file.startswith("tests/") and file not in BESIDE_FACES
        if module.count(".") > 1 and room_of(file) != module.split(".")[1]
        if module.rpartition(".")[2] != name
    }
    assert len(deep) <= MOST_DEEP_NAMES, sorted(deep)
