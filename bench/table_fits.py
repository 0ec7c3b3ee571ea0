"""Prints the tables of docs/evidence/fits.md: every number that was read off runs, and the designs behind it.

`python -m bench.table_fits` prints them. bench/docs_reference.py puts them into the built page.
"""

from __future__ import annotations

from dataclasses import astuple, is_dataclass
from typing import Any

from skincad.mechanics import DESIGNS, FITS, NUMBERS


def as_text(value: Any) -> str:
    """Return a number, or the numbers of a group, for a cell."""
    if is_dataclass(value) and not isinstance(value, type):
        value = astuple(value)
    if isinstance(value, dict):
        return ", ".join(f"{key} {as_text(one)}" for key, one in value.items())
    return ", ".join(as_text(one) for one in value) if isinstance(value, tuple) else f"{value:g}"


def fits() -> list[str]:
    lines = ["| where | numbers | what they are | designs |", "|---|---|---|---|"]
    for fit in FITS:
        numbers = "; ".join(f"{name} {as_text(value)}" for name, value in fit.values.items())
        room = fit.module.replace(".", "/")
        lines.append(f"| {room}.py | {numbers} | {fit.what} | {', '.join(fit.designs)} |")
    return lines


def designs() -> list[str]:
    lines = [f"| set | designs | {' | '.join(NUMBERS.values())} |", "|---" * (2 + len(NUMBERS)) + "|"]
    for name, (what, drawn) in DESIGNS.items():
        ranges = " | ".join(f"{low:g} to {high:g}" for low, high in drawn.values())
        lines.append(f"| {name} | {what} | {ranges} |")
    return lines


if __name__ == "__main__":
    print("\n".join([*fits(), "", *designs()]))
