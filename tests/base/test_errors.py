"""What leaves the package: which errors say that a resource ran out."""

from __future__ import annotations

import errno
import pickle
import weakref

import pytest

from skincad.base import ExhaustedError, InputError, RefusedError, exhausted, resource_guard

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
