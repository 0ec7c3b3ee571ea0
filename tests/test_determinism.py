"""Same input, same bytes: on one thread or two, in any folder, whatever the order of Python's sets, whatever
other programs' settings say in the working directory or the environment, and by another numpy.

What is told of time differs: `seconds` in simulate.json. Step files name no time. Another numpy has another
OpenBLAS: then the last digits of forces in make.json differ too, and no other file (2.4.6 and 2.2.6).
SKINCAD_OTHER_NUMPY names a folder with another numpy (`pip install --target FOLDER numpy==...`).
"""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import matplotlib
import pytest

from skincad.base import files_below
from skincad.circuit import gain, load_circuit
from skincad.outputs import gain_figure, save
from tests.conftest import skincad_process
from tests.processes import python

SMALL = ("--set", "ridge.count=1", "--set", "skin.width=3.0", "--set", "contact.force=0.4")
PRESS = (  # of three ridges, on coarse meshes: no film asks for finer ones
    *("--set", "skin=steep-fingertip", "--set", "history.normal_force_N=[0.0, 0.5]"),
    *("--set", "history.steps=6", "--set", "readout.ridges=[]", "--set", "effects.film=none"),
)
JOBS = {
    "make": ("make", "plain-ridges", *SMALL, "--model", "winkler"),
    "make yamada-2002": ("make", "yamada-2002", "--model", "corrected"),  # auto goes by the clock
    "simulate": ("simulate", "yamada-2002-press", *PRESS),
    "simulate yamada-2002": ("simulate", "yamada-2002-press-and-pull", "--set", "history.steps=20"),
    "circuit": ("circuit", "yamada-2002", "--set", "sweep.points=50"),
}
EVIDENCE = pytest.mark.evidence(subject="same bytes")
OTHER_NUMPY = os.environ.get("SKINCAD_OTHER_NUMPY", "")
FIRST = os.pathsep.join([OTHER_NUMPY, *filter(None, [os.environ.get("PYTHONPATH")])])
# a tenth of the last digit that a table prints; rounding in BLAS, which another build sums in another order
SAME = 1e-6


def run(job: str, folder: str, cwd: Path, **environment: str) -> Path:
    done = skincad_process(*JOBS[job], "-o", folder, cwd=cwd, **environment)
    assert done.returncode == 0, done.stderr
    return cwd / folder


def told(path: Path) -> Any:
    """A file's bytes, or without the time that it tells."""
    if path.name != "simulate.json":
        return path.read_bytes()
    data = json.loads(path.read_text("utf-8"))
    assert data.pop("seconds")
    return data


@pytest.mark.dear("whole runs in two processes, whose imports alone take some seconds")
@pytest.mark.parametrize(
    "job", [pytest.param(job, marks=EVIDENCE if "yamada" in job else pytest.mark.slow) for job in JOBS]
)
def test_same_bytes_on_one_thread_and_on_two(job: str, tmp_path: Path) -> None:
    one, two = (
        run(job, name, tmp_path, PYTHONHASHSEED=name, OPENBLAS_NUM_THREADS=name, OMP_NUM_THREADS=name)
        for name in ("1", "2")
    )
    names = list(files_below(one))
    assert names == list(files_below(two))
    for name in names:
        assert told(one / name) == told(two / name), name


def other_version() -> str:
    program = "import numpy; print(numpy.__version__)"
    done = python(program, PYTHONPATH=FIRST)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.slow
@pytest.mark.skipif(not OTHER_NUMPY, reason="SKINCAD_OTHER_NUMPY names no folder")
@pytest.mark.parametrize("job", ["make yamada-2002", "simulate yamada-2002", "circuit"])
def test_same_bytes_by_another_numpy(job: str, tmp_path: Path, record_property: Any) -> None:
    """Files that differ are told; their numbers differ by rounding at most."""
    import numpy as np

    assert other_version() != np.__version__
    one, two = run(job, "one", tmp_path), run(job, "two", tmp_path, PYTHONPATH=FIRST)
    names = list(files_below(one))
    assert names == list(files_below(two))
    differ = [name for name in names if told(one / name) != told(two / name)]
    record_property("summary", f"numpy {np.__version__} and {other_version()}: differ {differ or 'nothing'}")
    for name in differ:
        here, there = (_numbers(folder / name) for folder in (one, two))
        assert len(here) == len(there), name
        assert here == pytest.approx(there, rel=SAME, abs=SAME), name


def _numbers(path: Path) -> list[float]:
    """All numbers of a text file but those of a time and of hashes."""
    import re

    text = json.dumps(told(path)) if path.name == "simulate.json" else path.read_text("utf-8")
    text = re.sub(r"[0-9a-f]{64}", "", text)
    return [float(n) for n in re.findall(r"-?\d+\.?\d*(?:e[-+]?\d+)?", text)]


FILES = {
    "matplotlibrc": "savefig.dpi: 30\ntext.usetex: True\nfont.size: 20\nbackend: nonsense\n",
    "ezdxf.ini": "[core]\nwrite_fixed_meta_data_for_testing = false\ndisable_c_ext = true\n",
    "XSTEP.us": "write.step.unit : INCH\n",
}
BACKEND = "module://matplotlib_inline.backend_inline"
WRITERS = """
from pathlib import Path
import skincad
from skincad.circuit import gain, load_circuit
from skincad.outputs import gain_figure, save, write_step
from skincad.outputs.drawing.flat import write_section_dxf
from skincad.solids import skin_part, workplane
design = skincad.load("plain-ridges").with_(ridge={"count": 1}, skin={"width": 3.0})
save(gain_figure(gain(load_circuit("yamada-2002"))), Path("gain.png"))
write_section_dxf(design, Path("section.dxf"))
write_step(workplane(skin_part(design)), Path("skin.step"))
"""


def written_by(folder: Path, **environment: str) -> dict[str, bytes]:
    """What a process of its own writes, in a folder and environment."""
    done = python(WRITERS, cwd=folder, **environment)
    assert done.returncode == 0, done.stderr
    return contents(folder)


def contents(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in ("gain.png", "section.dxf", "skin.step")}


@pytest.mark.slow
@pytest.mark.dear("another process imports all that writes")
def test_same_bytes_whatever_rc_files_and_backends_say(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As this process writes them, which no file of settings reached."""
    clean, hostile = tmp_path / "clean", tmp_path / "hostile"
    for folder in (clean, hostile):
        folder.mkdir()
    for name, text in FILES.items():
        (hostile / name).write_text(text)
    ini = str(hostile / "ezdxf.ini")
    monkeypatch.chdir(clean)
    exec(WRITERS, {})
    assert written_by(hostile, MPLBACKEND=BACKEND, EZDXF_CONFIG_FILE=ini) == contents(clean)


@pytest.mark.slow
def test_the_process_keeps_its_own_settings(tmp_path: Path) -> None:
    circuit_gain = gain(load_circuit("yamada-2002"))
    save(gain_figure(circuit_gain), tmp_path / "before.png")
    with matplotlib.rc_context({"savefig.dpi": 30, "font.size": 20.0, "backend": "svg"}):
        before = dict(matplotlib.rcParams)
        save(gain_figure(circuit_gain), tmp_path / "after.png")
        assert dict(matplotlib.rcParams) == before
        assert matplotlib.get_backend() == "svg"
    assert (tmp_path / "after.png").read_bytes() == (tmp_path / "before.png").read_bytes()
