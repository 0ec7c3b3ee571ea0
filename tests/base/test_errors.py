"""What leaves the package: a resource that ran out, an argument beyond its limits."""

from __future__ import annotations

import errno
import math
import pickle
import weakref

import pytest

from skincad.base import (
    ExhaustedError,
    InputError,
    RefusedError,
    exhausted,
    require_goals,
    require_number,
    resource_guard,
)

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


@pytest.mark.parametrize(("tol", "budget"), [(None, None), (1e-9, 1e-9), (0.999, 1e9)])
def test_goals_within_their_limits_are_taken(tol: float | None, budget: float | None) -> None:
    require_goals(tol, budget, "0.05")


@pytest.mark.parametrize("tol", [0.0, 1.0, -0.1, math.nan])
def test_a_tolerance_is_a_share(tol: float) -> None:
    with pytest.raises(InputError, match=r"tol: must be between 0 and 1.*try 0\.05"):
        require_goals(tol, 1.0, "0.05")


@pytest.mark.parametrize("budget", [0.0, -1.0, math.inf, math.nan])
def test_a_budget_is_a_time(budget: float) -> None:
    with pytest.raises(InputError, match="budget: must be above 0 s"):
        require_goals(0.1, budget, "0.05")


@pytest.mark.parametrize("value", ["2 N", None, True, [2.0]])
def test_what_is_no_number_is_said_to_be_none(value: object) -> None:
    with pytest.raises(InputError, match="force: must be a number"):
        require_number("force", value, lambda _: True, "must be anything")
