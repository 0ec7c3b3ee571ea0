"""The catalogue tests/hard_cases.toml as cases to run, and what each expects."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bench.campaign.cases import Case, Figures, figures
from skincad.base import table_of, unit_of
from skincad.inputs import Design, overridden, read_table

FILE = Path(__file__).parent / "hard_cases.toml"
FOLDERS = {"simulate": "scenes", "circuit": "circuits"}
NOT_SCALED = {"mold", "printer"}  # a mold's walls and screws do not grow with the part


@dataclass(frozen=True)
class Entry:
    """A row of the catalogue: `kind` and what to run; `watch` names the figure, as in "ridge_force.0".

    It must be `value`, or the sum of `like` (other runs, each times its `factor`), within `rel` or `abs`, for
    the reason `why`; or the case is `refused` in these words.
    """

    name: str
    hard: str
    kind: str
    on: str
    set: tuple[str, ...] = ()
    skin: tuple[str, ...] = ()
    lengths: float = 1.0
    moduli: float = 1.0
    arguments: dict[str, Any] | None = None
    watch: str = ""
    value: Any = None
    like: tuple[dict[str, Any], ...] = ()
    rel: float = 0.0
    abs: float = 0.0
    why: str = ""
    refused: str = ""
    tier: str = "fast"
    row: str = ""  # its name; a row with a list of models is several entries

    def case(self, change: dict[str, Any] | None = None) -> Case:
        """The case of this entry, or of one of `like`, which says only what is different there."""
        given = {**vars(self), **(change or {})}
        tables = overridden(read_table(given["on"], FOLDERS.get(self.kind, "designs")), given["set"])
        skin = None
        if given["skin"]:
            skin = overridden(read_table(tables["skin"], "designs"), given["skin"])
            skin = scaled(skin, given["lengths"], given["moduli"])
        elif self.kind not in FOLDERS:
            tables = scaled(tables, given["lengths"], given["moduli"])
        return Case(self.kind, tables, skin, given["arguments"] or {})

    def expected(self) -> Any:
        """The value, or the sum of those of other runs."""
        if not self.like:
            return self.value
        return sum(self._other(change) for change in self.like)

    def _other(self, change: dict[str, Any]) -> Any:
        found = np.asarray(watched(figures(self.case(change)), change.get("watch", self.watch)), dtype=float)
        return change.get("factor", 1.0) * (found[::-1] if change.get("reversed") else found)


def entries() -> Iterator[Entry]:
    """All rows, in the file's order; a row with a list of `models` is one entry a model."""
    for row in tomllib.loads(FILE.read_text("utf-8"))["case"]:
        models, late = row.pop("models", None), row.pop("evidence_models", [])
        row["like"] = tuple(row.get("like", ()))
        if models is None:
            yield Entry(**row, row=row["name"])
            continue
        for model in (*models, *late):
            arguments = {**row.get("arguments", {}), "model": model}
            changes = {"name": f"{row['name']}, {model}", "row": row["name"], "arguments": arguments}
            yield Entry(**{**row, **changes, "tier": "evidence" if model in late else "fast"})


def watched(found: Figures, path: str) -> Any:
    """A figure by its path, as in "stress.3.-1"."""
    for key in path.split("."):
        found = found[int(key)] if isinstance(found, list) else found[key]
    return found


def scaled(tables: dict[str, Any], lengths: float, moduli: float) -> dict[str, Any]:
    """A design's tables, its skin's lengths and moduli times these factors."""
    factors = {"mm": lengths, "MPa": moduli}
    found = dict(tables)
    for name, table in tables.items():
        model = table_of(Design, name)
        if model is None or name in NOT_SCALED:
            continue
        found[name] = {
            key: _times(value, factors.get(unit_of(Design, (name, key)), 1.0)) for key, value in table.items()
        }
    return found


def _times(value: Any, factor: float) -> Any:
    if isinstance(value, dict):
        return {key: _times(inner, factor) for key, inner in value.items()}
    if isinstance(value, list):
        return [_times(inner, factor) for inner in value]
    return value * factor if isinstance(value, float) and factor != 1.0 else value
