"""What is loaded when: `--help` no kernel and no FE library, a check never the CAD kernel; no circles."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections import Counter
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

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
        (run("check", "plain-ridges", *ONE_RIDGE, *FEW_ELEMENTS), (*CAD, *MESHES)),
        # words are printed without what draws
        ("import skincad.outputs.fits, skincad.outputs.simulations", (*CAD, "matplotlib")),
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
    "ever more of the command line": "ngsolve",
    "solids": "OCP",
}  # by the last step: it was really taken


@pytest.mark.parametrize("name", PROCESSES)
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
def modules() -> dict[str, ast.Module]:
    """Every module of the package, parsed, by name."""
    files = {path.relative_to(PACKAGE.parent).with_suffix(""): path for path in PACKAGE.rglob("*.py")}
    return {
        ".".join(name.parts).removesuffix(".__init__"): ast.parse(path.read_text(encoding="utf-8"))
        for name, path in files.items()
    }


def imported(tree: ast.Module, known: set[str]) -> set[str]:
    """The known modules that a module imports anywhere: in functions and for type checking too."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in known else node.module for name in names}
    return found & known


def test_no_modules_import_each_other() -> None:
    trees = modules()
    arrows = {name: imported(tree, set(trees)) - {name} for name, tree in trees.items()}
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as circle:
        pytest.fail(" <- ".join(circle.args[1]))


def test_a_class_name_means_one_thing() -> None:
    defined = Counter(
        node.name
        for tree in modules().values()
        for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    )
    assert {name for name, times in defined.items() if times > 1} == set()


def test_effects_do_not_know_each_other() -> None:
    """Nor need a new one be named anywhere but in its table, which this reads."""
    homes = {row.where.partition(":")[0] for row in EFFECTS.values()}
    trees = modules()
    for home in homes:
        assert imported(trees[home], set(trees)) & homes <= {home}
