"""Errors: a resource that ran out, an argument beyond its limits; how they and results cross processes,
pickled, copied or copied deeply."""

from __future__ import annotations

import copy
import errno
import math
import multiprocessing
import pickle
import weakref
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

import pytest

import skincad
from skincad.base import (
    Estimate,
    ExhaustedError,
    InputError,
    RefusedError,
    UnclearError,
    exhausted,
    require_goals,
    require_number,
    resource_guard,
)
from skincad.circuit import gain, load_circuit
from skincad.fabrication import MakeResult, PartReport, warning
from skincad.inputs import load_design
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
VALUES: dict[str, Any] = {"str": "words", "float": 2.5, "bool": True, "object": 1.5, "Any": (1, 2)}


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
    values = {name: WORDS.get(name, VALUES.get(str(of))) for name, of in names.items() if name != "return"}
    by_name = getattr(kind.__init__, "__kwdefaults__", None) or {}
    options = {name: values.pop(name) for name in by_name}
    return kind(*values.values(), **options)


def test_every_error_pickles_and_copies() -> None:
    every = kinds()
    assert {InputError, RefusedError, LateError, GrossSlip, KernelError} <= set(every)
    for kind in every:
        error = example(kind)
        for way in WAYS:
            other = way(error)
            assert type(other) is kind
            assert (str(other), other.args, vars(other)) == (str(error), error.args, vars(error)), kind


@pytest.mark.slow
def test_a_bad_design_in_a_process_is_an_input_error_in_the_parent() -> None:
    spawn, bad = multiprocessing.get_context("spawn"), ("yamada-2002", ["ridge.height=-1.0"])
    with ProcessPoolExecutor(1, mp_context=spawn) as pool, pytest.raises(InputError, match=r"ridge\.height"):
        pool.submit(load_design, *bad).result(timeout=120)
    with spawn.Pool(1) as workers, pytest.raises(InputError, match=r"ridge\.height") as caught:
        workers.apply_async(load_design, bad).get(timeout=120)
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
    trial = Measurement("exact", "10", 10, (0.1, 0.2), {"rms": 1e-3})
    ladder = Ladder("circuit", "a title", (trial,), (measure,))
    made = {"name": "a", "strict": False, "parts": (part,), "findings": (finding,), "check": check}
    return {
        "estimate": Estimate(1.0, 0.1, "N"),
        "design": design,
        "scene": load_scene("hold"),
        "circuit": circuit,
        "gain": gain(circuit),
        "check": check,
        "make": MakeResult(**made, cavity_volume=1.0, seconds={"total": 1.0}),
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
        if name == "simulation":  # a march leaves the library of finite elements behind
            march = pickle.loads(pickle.dumps(result.march))
            assert isinstance(march, March)
            assert result.march.pad is not None
            assert march.pad is None
            assert not march.states


RAN_OUT = [
    (MemoryError(), "memory"),
    (OSError(errno.ENOMEM, "Cannot allocate memory"), "memory"),
    (RuntimeError("std::bad_alloc"), "memory"),
    (ImportError("libTKernel.so: failed to map segment from shared object"), "memory"),
    (RuntimeError("can't start new thread"), "threads or processes"),
    (OSError(errno.EMFILE, "Too many open files"), "open files"),
    (OSError(errno.ENOSPC, "No space left on device"), "space on the disk"),
]
ELSE = [
    InputError("-o", "cannot be written (Cannot allocate memory)"),
    RefusedError("std::bad_alloc"),
    RuntimeError("Factor is exactly singular"),
    ImportError("libGL.so.1: cannot open shared object file: No such file or directory"),
    FileNotFoundError(errno.ENOENT, "No such file or directory"),
    ZeroDivisionError(),
]


@pytest.mark.parametrize(("failure", "resource"), RAN_OUT, ids=str)
def test_a_resource_that_ran_out_is_told_by_its_name(failure: Exception, resource: str) -> None:
    assert exhausted(failure) == resource
    with (
        pytest.raises(ExhaustedError, match=f"the mesh needs more {resource} than there is"),
        resource_guard("the mesh"),
    ):
        raise failure


@pytest.mark.parametrize("failure", ELSE, ids=lambda error: type(error).__name__)
def test_no_other_failure_is_taken_for_it(failure: Exception) -> None:
    assert exhausted(failure) == ""
    with pytest.raises(type(failure)) as passed, resource_guard("the mesh"):
        raise failure
    assert passed.value is failure


class _Large:
    """What a computation holds when it runs out."""


def test_what_ran_out_is_given_back() -> None:
    """The error that goes on keeps nothing of the computation alive, so that there is room to go on."""
    seen: list[weakref.ref[_Large]] = []

    def compute() -> None:
        large = _Large()
        seen.append(weakref.ref(large))
        raise MemoryError

    with pytest.raises(ExhaustedError) as refusal, resource_guard("the mesh"):
        compute()
    assert seen[0]() is None
    assert str(pickle.loads(pickle.dumps(refusal.value))) == str(refusal.value)


def test_a_tolerance_is_a_share_and_a_budget_a_time() -> None:
    for tol, budget in ((None, None), (1e-9, 1e-9), (0.999, 1e9)):
        require_goals(tol, budget, "0.05")
    for tol in (0.0, 1.0, -0.1, math.nan):
        with pytest.raises(InputError, match=r"tol: must be between 0 and 1.*try 0\.05"):
            require_goals(tol, 1.0, "0.05")
    for budget in (0.0, -1.0, math.inf, math.nan):
        with pytest.raises(InputError, match="budget: must be above 0 s"):
            require_goals(0.1, budget, "0.05")
    for value in ("2 N", None, True, [2.0]):
        with pytest.raises(InputError, match="force: must be a number"):
            require_number("force", value, lambda _: True, "must be anything")
