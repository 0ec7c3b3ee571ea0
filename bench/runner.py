"""Cases of a bench: judged one by one or on several processes, recorded, and told in a table.

A program says what one case is, how it is judged and what columns its table has; `rows` does the rest. Of
each case one line of JSON goes to out/, with a mark of the code that judged it: a run that stopped goes on
where it was, and changed code judges all cases again.
"""

from __future__ import annotations

import argparse
import json
import math
import pickle
import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import suppress
from dataclasses import asdict, is_dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, TypeVar

from threadpoolctl import threadpool_limits

from skincad.base import InputError, RefusedError
from skincad.mechanics import ContactError

ROOT = Path(__file__).parents[1]
LEVEL = 1.96  # two-sided 95 %
REFUSED = "refused by"
REFUSALS = InputError, RefusedError, ContactError
T = TypeVar("T")
Case = int | str
Row = dict[str, Any]


def parser(
    about: str | None, *numbers: str, seed: int | None = None, recorded: bool = True
) -> argparse.ArgumentParser:
    """Return the parser of a bench: numbers that say which cases, `--seed`, and the options of `rows`."""
    options = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    for name in numbers:
        options.add_argument(name, type=int)
    if seed is not None:
        options.add_argument("--seed", type=int, default=seed, help="the first seed")
    if recorded:
        options.add_argument("--workers", type=int, default=1, help="processes")
        options.add_argument("--records", type=Path, help="file of JSON lines; out/NAME.jsonl by default")
    return options


@cache
def code() -> str:
    """Return a mark of the program, its templates and its benches: other code judges anew."""
    files = sorted(
        path
        for folder in ("skincad", "templates", "bench")
        for path in (ROOT / folder).rglob("*")
        if path.suffix in (".py", ".toml")
    )
    return sha256(b"".join(path.read_bytes() for path in files)).hexdigest()[:12]


def records(path: Path) -> dict[Case, Row]:
    """Return what a file has of this code, by case. A line that was cut off counts for nothing."""
    known = dict[Case, Row]()
    for line in path.read_text("utf-8").splitlines() if path.exists() else ():
        with suppress(json.JSONDecodeError):
            record = json.loads(line)
            if record["code"] == code():
                known[record["case"]] = record["row"]
    return known


def rows(
    name: str,
    judge: Callable[[Any], Any],
    cases: Iterable[Case],
    options: Any,
    line: Callable[[Any], str] | None = None,
    kind: Callable[..., Any] = dict,
) -> list[Any]:
    """Return the row of each case in their order, and print its `line` as soon as it is known.

    A judge returns a mapping of plain data or a dataclass, whose `kind` makes one of the record again. What
    it refuses is recorded, printed, and left out. `name` says what the case doesn't: which way of judging.
    """
    cases = list(cases)
    path = options.records or ROOT / "out" / f"{name}.jsonl"
    path.parent.mkdir(parents=True, exist_ok=True)
    known = records(path)

    def tell(case: Case) -> None:
        if REFUSED in known[case]:
            print(f"{case}: refused: {known[case][REFUSED]}", file=sys.stderr, flush=True)
        elif line:
            print(line(kind(**known[case])), flush=True)

    for case in cases:
        if case in known:
            tell(case)
    with path.open("a", encoding="utf-8") as file:
        file.write("\n" * (path.stat().st_size > 0 and not path.read_bytes().endswith(b"\n")))  # after a kill
        missing = [case for case in cases if case not in known]
        for case, row in _judged(judge, missing, options.workers):
            text = json.dumps({"code": code(), "case": case, "row": row}, default=_plain)
            file.write(text + "\n")
            file.flush()
            known[case] = json.loads(text)["row"]
            tell(case)
    return [kind(**known[case]) for case in cases if REFUSED not in known[case]]


def _plain(value: Any) -> Any:
    return value.item()


def _judged(judge: Callable[[Any], Any], cases: Sequence[Case], workers: int) -> Iterator[tuple[Case, Row]]:
    """Yield cases with their rows as they come; each process has one thread of linear algebra."""
    with threadpool_limits(limits=1, user_api="blas"):
        if workers == 1:
            for case in cases:
                yield case, _row(judge, case)
            return
        with ProcessPoolExecutor(workers) as pool:
            jobs = {pool.submit(_row, judge, case): case for case in cases}
            for job in as_completed(jobs):
                yield jobs[job], job.result(timeout=0)  # it is completed


def _row(judge: Callable[[Any], Any], case: Case) -> Row:
    try:
        answer = judge(case)
    except REFUSALS as refusal:
        return {REFUSED: str(refusal)}
    return asdict(answer) if is_dataclass(answer) and not isinstance(answer, type) else dict(answer)


def kept(path: Path, make: Callable[[], T]) -> T:
    """Return what a file has, made and written where there is none."""
    if not path.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(pickle.dumps(make()))
    return pickle.loads(path.read_bytes())  # type: ignore[no-any-return]


def until(count: int, make: Callable[[int], T | None]) -> Iterator[T]:
    """Yield `count` cases of `make(number)`, which draws each from one generator: what is refused is printed
    and drawn again, and None, a case without a row, is too."""
    number = 0
    while number < count:
        try:
            case = make(number)
        except InputError as refusal:
            print(f"refused: {refusal}")
            continue
        if case is not None:
            number += 1
            yield case


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share (Wilson, J. Am. Stat. Assoc. 22 (1927) 209)."""
    if not count:
        return 0.0, 1.0
    part, z2 = hits / count, LEVEL**2
    middle = (part + z2 / (2 * count)) / (1 + z2 / count)
    half = LEVEL / (1 + z2 / count) * math.sqrt(part * (1 - part) / count + z2 / (4 * count**2))
    return max(0.0, middle - half), min(1.0, middle + half)


def share(hits: int, count: int) -> str:
    low, high = wilson(hits, count)
    return f"{hits} of {count} = {hits / max(1, count):.0%} ({low:.0%} to {high:.0%})"


def table(head: Sequence[str], lines: Iterable[Sequence[object]]) -> list[str]:
    """Return a table: the first column to the left, the others to the right, each as wide as it has to be."""
    cells = [[*map(str, head)], *([*map(str, line)] for line in lines)]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    return [
        "  ".join(
            text.ljust(width) if i == 0 else text.rjust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in cells
    ]
