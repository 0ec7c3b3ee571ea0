"""What other programs' settings say, in the working directory or the environment, changes no file of ours."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import pytest

from skincad.circuit import gain, load_circuit
from skincad.outputs import gain_figure, save
from tests.processes import python

FILES = {
    "matplotlibrc": "savefig.dpi: 30\ntext.usetex: True\nfont.size: 20\nbackend: nonsense\n",
    "ezdxf.ini": "[core]\nwrite_fixed_meta_data_for_testing = false\ndisable_c_ext = true\n",
    "XSTEP.us": "write.step.unit : INCH\n",
}
WRITERS = """
from pathlib import Path
import skincad
from skincad.circuit.bode import gain
from skincad.circuit.model import load_circuit
from skincad.outputs.figures.canvas import save
from skincad.outputs.figures.results import gain_figure
from skincad.outputs.drawing.flat import write_section_dxf
from skincad.outputs.solid_files import write_step
from skincad.solids.occ import workplane
from skincad.solids.skin import skin_part
design = skincad.load("plain-ridges").with_(ridge={"count": 1}, skin={"width": 3.0})
save(gain_figure(gain(load_circuit("yamada-2002"))), Path("gain.png"))
write_section_dxf(design, Path("section.dxf"))
write_step(workplane(skin_part(design)), Path("skin.step"))
"""


def written(folder: Path, **environment: str) -> dict[str, bytes]:
    """What a process of its own writes, in a folder and environment."""
    done = python(WRITERS, cwd=folder, **environment)
    assert done.returncode == 0, done.stderr
    return contents(folder)


def contents(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in ("gain.png", "section.dxf", "skin.step")}


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["module://matplotlib_inline.backend_inline"])
def test_same_bytes_whatever_rc_files_and_backends_say(
    backend: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
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
    assert written(hostile, MPLBACKEND=backend, EZDXF_CONFIG_FILE=ini) == contents(clean)


def test_the_process_keeps_its_own_settings(tmp_path: Path) -> None:
    circuit_gain = gain(load_circuit("yamada-2002"))
    save(gain_figure(circuit_gain), tmp_path / "before.png")
    with matplotlib.rc_context({"savefig.dpi": 30, "font.size": 20.0, "backend": "svg"}):
        before = dict(matplotlib.rcParams)
        save(gain_figure(circuit_gain), tmp_path / "after.png")
        assert dict(matplotlib.rcParams) == before
        assert matplotlib.get_backend() == "svg"
    assert (tmp_path / "after.png").read_bytes() == (tmp_path / "before.png").read_bytes()


@pytest.mark.slow
@pytest.mark.xdist_group("group")
def test_tests_of_a_group_run_on_one_worker(request: pytest.FixtureRequest) -> None:
    """pytest-xdist sorts by a node id that it wrote the group to; pytest 9.2 let it write and forgot."""
    if not request.config.getoption("loadgroup", default=False):
        pytest.skip("only --dist loadgroup has groups")
    assert request.node.nodeid.endswith("@group")
