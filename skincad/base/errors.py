"""Errors that a person meets, each with key, rule, value and remedy."""

from __future__ import annotations

import copyreg
import errno
import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from difflib import get_close_matches
from numbers import Real
from types import TracebackType
from typing import Any

LONGEST_KEY, LONGEST_LINE = 200, 1500  # letters that are shown, of a key and of all: a line to be read
MOST_TOLD = 10  # broken rules in one line
# what the system and the libraries say of a resource that has run out: error numbers, and words of errors
# that have no number (C++'s own, netgen's, the dynamic linker's, Python's threads')
_RAN_OUT = {
    "memory": (
        {errno.ENOMEM},
        ("bad_alloc", "ould not allocate", "annot allocate", "failed to map segment", "enough memory"),
    ),
    "threads or processes": ({errno.EAGAIN}, ("start new thread", "Resource temporarily unavailable")),
    "open files": ({errno.EMFILE, errno.ENFILE}, ()),
    "space on the disk": ({errno.ENOSPC, errno.EDQUOT}, ()),
}


class _Portable(Exception):  # noqa: N818
    """An error that pickles and copies, whatever arguments its class takes: as its text and attributes.

    An exception's own way calls the class with the text alone, which fails in the process that receives it.
    """

    def __reduce__(self) -> tuple[Any, ...]:
        return copyreg.__newobj__, (type(self), *self.args), self.__dict__  # type: ignore[attr-defined]


class InputError(_Portable, ValueError):
    """What a person wrote cannot be used: key, rule, value and remedy, in one line.

    `others` are further rules that the same input breaks, told in the same line. The command line prints it
    on stderr and exits with status 2; nothing has been written then. Its text is `shown`, so that a file's
    own words cannot move a terminal's cursor or turn the direction of what is read.
    """

    def __init__(
        self,
        key: str,
        rule: str,
        value: object = None,
        remedy: str = "",
        others: tuple[InputError, ...] = (),
    ) -> None:
        self.key, self.rule, self.value, self.remedy, self.others = key, rule, value, remedy, others
        text = f"{_clipped(shown(key), LONGEST_KEY)}: {rule}"
        if value is not None:
            text += f", got {_short(value)}"
        if remedy:
            text += f"; {remedy}"
        text = "; besides, ".join([text, *map(str, others)])
        super().__init__(_clipped(shown(text), LONGEST_LINE))

    def under(self, table: str) -> InputError:
        """Return the error as that of a table inside another: `table` before its key and those of others."""
        key = ".".join(part for part in (table, self.key) if part)
        others = tuple(other.under(table) for other in self.others)
        return InputError(key, self.rule, self.value, self.remedy, others)


class UnclearError(_Portable, ValueError):
    """An estimate was compared with a number that its error does not let it tell from the value."""


class RefusedError(_Portable, RuntimeError):
    """A computation did not meet its own check, so there is no result; the command line exits with 1."""


class FaultError(RefusedError):
    """A result failed a check of skincad's own, whatever the input is. The command line exits with 3."""

    def __init__(self, check: str) -> None:
        report = "this is a fault of skincad, not of the input; please report it with the file of the design"
        super().__init__(f"{check}; {report}")


class ExhaustedError(RefusedError):
    """Memory or another resource ran out: what is asked needs more. The command line exits with 3."""


class resource_guard:  # noqa: N801
    """A block that may ask for more than there is: where it does, ExhaustedError says so of `what`."""

    def __init__(self, what: str) -> None:
        self.what = what

    def __enter__(self) -> None:
        """Begin the block."""

    def __exit__(
        self, kind: type[BaseException] | None, failure: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Raise ExhaustedError in the place of whatever a library made of it; let all else pass."""
        if failure is not None and (lacking := exhausted(failure)):
            failure.__traceback__ = None  # its frames hold what is to be given back
            del trace
            raise ExhaustedError(
                f"{self.what} needs more {lacking} than there is; allow more, or ask for less"
            ) from None


def exhausted(failure: BaseException) -> str:
    """Return which resource ran out by any library's error, or ""; "" too for this package's own errors."""
    if isinstance(failure, InputError | RefusedError):
        return ""
    if isinstance(failure, MemoryError):
        return "memory"
    number, text = getattr(failure, "errno", None), str(failure)
    for resource, (numbers, words) in _RAN_OUT.items():
        if number in numbers or any(word in text for word in words):
            return resource
    return ""


def together(errors: Sequence[InputError]) -> InputError:
    """Return the first of these errors with the others in its line, `MOST_TOLD` at most."""
    broken = (one for error in errors[:MOST_TOLD] for one in (error, *error.others))
    first, *others = [(one.key, one.rule, one.value, one.remedy) for one in broken]
    return InputError(*first, tuple(InputError(*rest) for rest in others[: MOST_TOLD - 1]))


def refusals(step: Callable[[], object]) -> Iterator[InputError]:
    """Yield the InputError that a step raises; nothing where it raises none."""
    try:
        step()
    except InputError as refused:
        yield refused


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """Return the remedy for an unknown word: the nearest known one, or the list of all."""
    names = sorted(known)
    near = get_close_matches(word[:LONGEST_KEY], names, n=1)
    return f"did you mean '{near[0]}'?" if near else f"known: {', '.join(names)}"


def shown(text: str) -> str:
    r"""Return a text as one line: what does not print, or steers how other letters do, as its escape.

    That is line ends, control and format characters (escape sequences, marks of writing direction), lone
    surrogates and spaces other than the common one: `\x1b`, `\u202e`. Letters of all languages stay.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode("ascii") for c in text)


def _short(value: object, limit: int = 80) -> str:
    try:
        text = f"{value:.6g}" if isinstance(value, float) else repr(value)
    except ValueError:  # Python prints no integer of more than 4300 digits
        text = "a number of thousands of digits"
    return _clipped(text, limit)


def _clipped(text: str, limit: int) -> str:
    return text if len(text) <= limit else text[: limit - 3] + "..."


def require_number(
    key: str, value: object, holds: Callable[[float], bool], rule: str, remedy: str = ""
) -> None:
    """Raise InputError unless `value` is a finite number for which `rule` holds."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InputError(key, "must be a number", value, remedy)
    if not (math.isfinite(value) and holds(float(value))):
        raise InputError(key, rule, value, remedy)


def require_goals(tol: float | None, budget: float | None, example: str) -> None:
    """Raise InputError unless `tol` is a relative error, `budget` a time in s, where they are given."""
    if tol is not None:
        rule = "must be between 0 and 1 (relative)"
        require_number("tol", tol, lambda value: 0 < value < 1, rule, f"try {example}")
    if budget is not None:
        require_number("budget", budget, lambda value: value > 0, "must be above 0 s")
