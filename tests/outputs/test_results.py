"""Every result has one shape: words, JSON, figures and files, and writes nothing before it is asked to."""

from __future__ import annotations

import base64
import copy
import json
import re
import sys
from collections.abc import Callable
from html import escape
from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.base import LONGEST_REPR, InputError, RefusedError, Result, files_below
from skincad.outputs import ACCURACY_FILES, makes, simulations
from skincad.scenes import LEVELS, at_level
from skincad.studies.accuracy import circuit
from tests.base.test_portable import FILMED
from tests.small_scene import small_scene

PACKAGE = Path(skincad.__file__).parent
DEAR = {"make", "accuracy", "film_stress"}  # to compute


def one_ridge() -> skincad.Design:
    """With film, so that all files of a make are there."""
    return skincad.load("yamada-2002").with_(ridge={"count": 1}, skin={"width": 3.0})


def short_accuracy(_: Path) -> Result:
    with pytest.MonkeyPatch.context() as patch:  # a short ladder
        patch.setattr(circuit, "PER_PERIOD", circuit.PER_PERIOD[:2])
        return skincad.accuracy(skincad.load("plain-ridges"), ["circuit"], repeats=1)


def fitted(folder: Path) -> Result:
    rows = [f"{strain},{0.8 * strain}" for strain in (0.01 * i for i in range(12))]
    (folder / "bar.csv").write_text("\n".join(["strain,stress_MPa", *rows]))
    return skincad.fit_material(folder / "bar.csv")


def simulated(folder: Path) -> Result:
    few = "history.steps=4", "readout.ridges=[2]", "history.normal_force_N=[0.0, 0.3]"
    return at_level(small_scene(folder, "yamada-2002-press", *few), LEVELS[0])


COMPUTATIONS: dict[str, Callable[[Path], Result]] = {
    "make": lambda _: skincad.make(one_ridge(), model="winkler"),  # its shape is that of all verdicts
    "check": lambda _: skincad.check(one_ridge(), model="winkler"),
    "gain": lambda _: skincad.gain(skincad.load_circuit("yamada-2002", ["sweep.points=50"])),
    "simulate": simulated,
    "accuracy": short_accuracy,
    "fit_material": fitted,
    "film_stress": lambda _: skincad.film_stress(skincad.load("yamada-2002", FILMED), 0.4, 0.1, tol=0.5),
}
ENTERED = {*COMPUTATIONS}
every_kind = pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=pytest.mark.slow if k in DEAR else ()) for k in sorted(ENTERED)]
)


class Results(dict[str, Any]):
    """A result of each kind, computed when a test first asks for it."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __missing__(self, kind: str) -> Result:
        self[kind] = COMPUTATIONS[kind](self.folder)
        return self[kind]


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Results:
    return Results(tmp_path_factory.mktemp("results"))


TABLES = {  # a column with its unit, by kind, and how many rows there are
    "make": ("value", lambda result: len(result.numbers())),
    "check": ("ridge_force_N.error", lambda result: result.ridges),
    "simulate": ("normal_force_N", lambda result: result.steps + 1),
    "gain": ("gain_dB", lambda result: len(result.frequency)),
    "accuracy": ("seconds", lambda result: len(result.rows)),
    "fit_material": ("model_stress_MPa", lambda result: result.rows_used),
    "film_stress": ("differential_stress_MPa.error", lambda result: 2 * result.states[0].ridges),
}


@every_kind
def test_a_result_has_words_json_and_a_frame(results: Results, kind: str) -> None:
    result = results[kind]
    assert isinstance(result, Result)
    assert len(repr(result)) <= LONGEST_REPR
    assert "\n" not in repr(result)
    assert repr(result).startswith(f"<{type(result).__name__} ")
    json.dumps(result.as_json(), allow_nan=False)
    words, long = str(result).splitlines(), result.details().splitlines()
    assert len(words) > 1
    assert long[: len(words)] == words  # details begin with what is printed
    assert not {*words} & {*long[len(words) :]} - {""}
    column, rows = TABLES[kind]
    frame = result.to_frame()
    assert len(frame[column]) == len(frame) == rows(result) > 0
    assert set(result.presenter().figures(result)) <= set(result.files())
    with pytest.raises(KeyError, match="no figure nothing; there are: "):
        result.figure("nothing")


@every_kind
def test_a_notebook_shows_words_and_figure(results: Results, kind: str) -> None:
    page = results[kind]._repr_html_()
    assert escape(str(results[kind]).splitlines()[0]) in page
    # a check's bars are drawn in the page
    assert ('src="data:image/png;base64,iVBOR' in page) == (kind != "check")


def test_a_frame_has_the_numbers_of_the_result(results: Results) -> None:
    check = results["check"]
    assert list(check.to_frame()["ridge_force_N"]) == [share.value for share in check.ridge_force]


@pytest.mark.slow
def test_a_frame_of_a_make_has_each_number_with_its_unit(results: Results) -> None:
    numbers = results["make"].to_frame().set_index("name")
    skin = results["make"].parts[0]
    assert numbers.loc["parts.skin.volume_mm3", ["value", "unit"]].tolist() == [skin.volume, "mm3"]


def test_without_pandas_one_line_says_so(results: Results, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match=r"^to_frame: needs the package pandas"):
        results["check"].to_frame()


def test_a_notebook_shows_a_design_by_its_section(yamada: skincad.Design) -> None:
    page = yamada._repr_html_()
    assert "yamada-2002: 9 ridges on 11 x 12 x" in page
    (data,) = re.findall(r'src="data:image/svg\+xml;base64,([^"]+)"', page)
    drawn = base64.b64decode(data).decode()
    (slots,) = re.findall(r'<g id="SLOTS"[^>]*>(.*?)</g>', drawn, re.DOTALL)
    assert slots.count("<path") == 2 * 9
    assert "<script" not in drawn


@every_kind
def test_write_writes_the_files_and_their_manifest(results: Results, kind: str, tmp_path: Path) -> None:
    result = results[kind]
    written = skincad.write(result, tmp_path / "out")
    manifest = f"{result.presenter().COMMAND}.json"
    assert {*files_below(tmp_path / "out")} == {*result.files(), manifest}
    assert [name for name, _ in written.files] == sorted(result.files())
    assert str(tmp_path / "out") in str(written)
    assert json.loads((tmp_path / "out" / manifest).read_text())["files"] == sorted(result.files())


@pytest.mark.slow
def test_what_will_be_written_is_known_before(results: Results) -> None:
    assert makes.names(one_ridge()) == list(results["make"].files())
    assert simulations.gain_names(measured=False) == list(results["gain"].files())
    assert set(simulations.names(results["simulate"].scene)) == set(results["simulate"].files())
    assert list(ACCURACY_FILES) == list(results["accuracy"].files())


def test_formats_choose_and_are_told(results: Results, tmp_path: Path) -> None:
    written = skincad.write(results["gain"], tmp_path / "out", formats="csv")
    assert [name for name, _ in written.files] == ["gain.csv"]
    with pytest.raises(InputError, match="formats: unknown format, got 'svc'; did you mean 'csv'"):
        skincad.write(results["gain"], tmp_path / "other", formats=["svc"])
    assert not (tmp_path / "other").exists()


@pytest.mark.slow
def test_a_copy_of_a_make_says_that_it_has_no_solids(results: Results) -> None:
    with pytest.raises(RefusedError, match="a copy has no solids"):
        copy.copy(results["make"]).files()


def test_every_public_name_is_completed_and_no_module_takes_it() -> None:
    assert set(skincad.__all__) <= set(dir(skincad))
    assert ENTERED | {"section", "write", "load_scene", "load_circuit", "load_design"} <= set(skincad.__all__)
    modules = {path.stem for path in PACKAGE.iterdir()}  # what lies deeper is no attribute of the package
    assert not modules & set(skincad.__all__)


def test_errors_raised_to_python_name_arguments() -> None:
    """No error has a flag as its key: the command line alone names flags."""
    flag = re.compile(r"""InputError\(\s*f?["']-""")
    assert flag.search('raise InputError("--tol", "must")')
    assert [path for path in PACKAGE.rglob("*.py") if flag.search(path.read_text("utf-8"))] == []


@pytest.mark.parametrize(
    ("name", "value"), [("force", "2 N"), ("force", True), ("tol", "5 %"), ("budget", [1.0])]
)
def test_an_argument_of_another_type_is_told(yamada: skincad.Design, name: str, value: object) -> None:
    with pytest.raises(InputError, match=f"^{name}: must be a number, got "):
        skincad.check(yamada, **{name: value})
