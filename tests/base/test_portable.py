"""Errors and results cross processes: pickled, copied or copied deeply they tell a reader the same."""

from __future__ import annotations

import copy
import multiprocessing
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

import pytest

import skincad
from skincad.base import Estimate, InputError, RefusedError, UnclearError
from skincad.circuit import gain, load_circuit
from skincad.fabrication import MakeResult, PartReport, warning
from skincad.material import fit_material
from skincad.mechanics import GrossSlip, LateError, film_stress
from skincad.scenes import LEVELS, March, at_level, load_scene
from skincad.solids import KernelError
from skincad.studies import Accuracy, ErrorMeasure, Ladder, Measurement
from tests.small_scene import THIRD, small_scene

WAYS: tuple[Callable[[Any], Any], ...] = (
    copy.copy,
    copy.deepcopy,
    *(lambda value, p=p: pickle.loads(pickle.dumps(value, p)) for p in range(2, pickle.HIGHEST_PROTOCOL + 1)),
)
WORDS = {"key": "ridge.height", "rule": "must be below 1", "value": 1.5, "remedy": "take less", "others": ()}
FILMED = ("ridge.count=1", "skin.width=3.0")
FEW = ("history.steps=2", "readout.ridges=[2]", THIRD)
VALUES: dict[str, Any] = {"str": "words", "float": 2.5, "object": 1.5, "Any": (1, 2)}


def kinds() -> list[type[Exception]]:
    """All errors of the package: InputError, RefusedError, UnclearError and what is derived from them."""
    for module in walk_packages(skincad.__path__, "skincad."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
    classes: list[type[Exception]] = [InputError, RefusedError, UnclearError]
    for kind in classes:
        classes += [subclass for subclass in kind.__subclasses__() if subclass not in classes]
    return [kind for kind in classes if kind.__module__.startswith("skincad")]


def example(kind: type[Exception]) -> Exception:
    """An error of this kind, its arguments by their names or types."""
    names = getattr(kind.__init__, "__annotations__", {"words": "str"})
    return kind(*(WORDS.get(name, VALUES.get(str(of))) for name, of in names.items() if name != "return"))


def test_every_error_pickles_and_copies() -> None:
    every = kinds()
    assert {InputError, RefusedError, LateError, GrossSlip, KernelError} <= set(every)
    for kind in every:
        error = example(kind)
        for way in WAYS:
            other = way(error)
            assert type(other) is kind
            assert (str(other), other.args, vars(other)) == (str(error), error.args, vars(error)), kind


def load_bad(height: float) -> object:
    return skincad.load("yamada-2002", [f"ridge.height={height}"])


@pytest.mark.slow
def test_a_bad_design_in_a_process_is_an_input_error_in_the_parent() -> None:
    spawn = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(1, mp_context=spawn) as pool, pytest.raises(InputError, match=r"ridge\.height"):
        pool.submit(load_bad, -1.0).result(timeout=120)
    with spawn.Pool(1) as workers, pytest.raises(InputError, match=r"ridge\.height") as caught:
        workers.apply_async(load_bad, (-1.0,)).get(timeout=120)
    assert caught.value.key == "ridge.height"


def told(result: Any) -> Any:
    """What a reader sees of a result."""
    return result.as_json() if hasattr(result, "as_json") else repr(result)


def results(folder: Path) -> dict[str, Any]:
    design = skincad.load("plain-ridges").with_(ridge={"count": 1}, skin={"width": 3.0})
    scene = small_scene(folder, "yamada-2002-press", *FEW)
    circuit = load_circuit("yamada-2002")
    check = skincad.check(design, force=1.0, model="linear", tol=0.3)
    rows = [f"{strain},{0.8 * strain}" for strain in (0.01 * i for i in range(12))]
    (folder / "bar.csv").write_text("\n".join(["strain,stress_MPa", *rows]))
    part = PartReport("skin", 1.0, 2.0, 6, True, True, 0, 1e-3, 2e-3)
    finding = warning("sag", "strip 1", 0.2, 0.1, "mm", "take a thicker film")
    measure = ErrorMeasure("rms", "of the gain", "1", "the finest", "by a closed form")
    ladder = Ladder(
        "circuit", "a title", (Measurement("exact", "10", 10, (0.1, 0.2), {"rms": 1e-3}),), (measure,)
    )
    return {
        "estimate": Estimate(1.0, 0.1, "N"),
        "design": design,
        "scene": load_scene("hold"),
        "circuit": circuit,
        "gain": gain(circuit),
        "check": check,
        "make": MakeResult(
            name="a",
            strict=False,
            parts=(part,),
            findings=(finding,),
            check=check,
            cavity_volume=1.0,
            seconds={"total": 1.0},
        ),
        "accuracy": Accuracy(name="a", ladders=(ladder,), machine={"cores": 2}, repeats=2, seconds=0.3),
        "fit": fit_material(folder / "bar.csv"),
        "film stress": film_stress(skincad.load("yamada-2002", FILMED), 0.4, tol=0.5),
        "simulation": at_level(scene, LEVELS[0]),
    }


@pytest.mark.slow
def test_every_result_pickles_and_copies(tmp_path: Path) -> None:
    for name, result in results(tmp_path).items():
        for way in WAYS:
            other = way(result)
            assert type(other) is type(result), name
            assert str(told(other)) == str(told(result)), name


def test_a_march_leaves_the_fe_library_behind(tmp_path: Path) -> None:
    run = at_level(small_scene(tmp_path, "yamada-2002-press", *FEW), LEVELS[0]).march
    other = pickle.loads(pickle.dumps(run))
    assert isinstance(other, March)
    assert run.pad is not None
    assert other.pad is None
    assert not other.states
