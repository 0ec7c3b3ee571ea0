"""What is loaded when: `--help` no kernel and no FE library, a check never the CAD kernel."""

from __future__ import annotations

import subprocess
import sys

import pytest

CAD = ("OCP", "cadquery", "vtkmodules")
FE = ("ngsolve", "netgen")
MESHES = ("manifold3d", "pymeshlab", "trimesh", "matplotlib")


def loaded_after(code: str) -> set[str]:
    program = f"import sys\n{code}\nprint(*{{m.split('.')[0] for m in sys.modules}})"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return set(done.stdout.split()[-2000:])


def run(*arguments: str) -> str:
    return (
        "import contextlib, io\n"
        f"sys.argv = ['skincad', *{list(arguments)!r}]\n"
        "from skincad.cli import main\n"
        "with contextlib.redirect_stdout(io.StringIO()), contextlib.suppress(SystemExit):\n"
        "    main()\n"
    )


@pytest.mark.parametrize(
    ("code", "absent"),
    [
        (run("--help"), (*CAD, *FE, *MESHES, "scipy", "numpy", "pydantic")),
        (run("make", "--help"), (*CAD, *FE, *MESHES, "scipy")),
        (run("templates"), (*CAD, *FE, *MESHES, "scipy")),
        (run("check", "plain-ridges"), (*CAD, *MESHES)),
        (run("check", "plain-ridges", "--tier", "winkler"), (*CAD, *FE, *MESHES)),
        # pydantic comes by typer itself, for the help of any command with typed options
        (run("simulate", "--help"), (*CAD, *FE, *MESHES, "scipy", "numpy")),
        (run("accuracy", "--help"), (*CAD, *FE, *MESHES, "scipy", "numpy")),
        ("from skincad.scenes.scene import load_scene; load_scene('yamada-2002-slip')", (*CAD, *FE, *MESHES)),
        ("import skincad", (*CAD, *FE, *MESHES, "scipy", "numpy", "pydantic")),
        (
            "from skincad.shape.cross_section import section; import skincad; "
            "section(skincad.load('yamada-2002'))",
            (*CAD, *FE),
        ),
        ("import skincad; skincad.skin_solid(skincad.load('yamada-2002'))", FE),
    ],
)
def test_nothing_is_loaded_that_is_not_used(code: str, absent: tuple[str, ...]) -> None:
    assert loaded_after(code) & set(absent) == set()


def test_every_public_name_is_there_and_stays_callable() -> None:
    import skincad

    for name in skincad.__all__:
        assert getattr(skincad, name) is getattr(skincad, name)
    assert callable(skincad.make)
    assert callable(skincad.check)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = skincad.nonsense
