"""What ships with skincad: templates and silicones; and TOML in, with `--set` overrides.

A file is read as data only: no code, at most `LARGEST_FILE` bytes, no path inside it is followed.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, Literal

from skincad.base.errors import InputError, did_you_mean
from skincad.base.reading import MOST_PARTS, tables_of, text_of
from skincad.base.tables import Ranged
from skincad.inputs.design import Design, drop_dependents, renamed_material
from skincad.inputs.process import Process, merged
from skincad.inputs.shipped import table_text, templates_folder
from skincad.inputs.skin_tables import Material

LARGEST_FILE = 1_000_000  # bytes; a design is a few thousand
Kind = Literal["designs", "scenes", "circuits"]
KINDS: tuple[Kind, ...] = ("designs", "scenes", "circuits")


SHRINKAGE = 0.001  # source: data sheets, about 0.1 % of a silicone cured at room temperature


@dataclass(frozen=True)
class Silicone:
    """A casting silicone: MPa, kg/m3, minutes and hours at room temperature; elongation as a strain; Pa s
    freshly mixed."""

    name: str
    young_modulus: Ranged
    poisson_ratio: float
    density: float
    mix: tuple[float, float] | None
    pot_life_min: float | None
    cure_h: float | None
    platinum_cure: bool
    elongation_at_break: float
    viscosity: float
    source: str
    shrinkage: float = SHRINKAGE  # linear


# assumption: nearly incompressible, the density that casting silicones share, the least of their elongations,
# the largest of their viscosities
OWN_SILICONE = Silicone(
    name="own silicone",
    young_modulus=Ranged(value=1.0, low=1.0, high=1.0),
    poisson_ratio=0.499,
    density=1070.0,
    mix=None,
    pot_life_min=None,
    cure_h=None,
    platinum_cure=True,
    elongation_at_break=1.0,
    viscosity=35.0,
    source="assumption",
)


def template_names(kind: Kind = "designs") -> list[str]:
    """Return the names of the templates of one kind, sorted."""
    folder = templates_folder() / kind
    if not folder.is_dir():
        return []
    return sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))


def template_text(name: str, kind: Kind = "designs") -> str:
    """Return a template's TOML text; raises InputError for an unknown name."""
    known = template_names(kind)
    if name not in known:
        raise InputError(name, "no such template", remedy=did_you_mean(name, known))
    return (templates_folder() / kind / f"{name}.toml").read_text("utf-8")


def load_design(
    source: str | Path,
    settings: list[str] | tuple[str, ...] = (),
    *,
    printer: str | Path | None = None,
) -> Design:
    """Return the design of a template's name or of a TOML file.

    `printer` is a TOML file of a workshop's own processes; they go into the design's `[printer]`, so that a
    copy of the design means the same without the file. `settings` are `table.key=value` with a TOML value,
    or `table=none` to drop an optional table, and come last. Raises InputError with key, rule, value, remedy.
    """
    data = read_table(source, "designs")
    if printer is not None:
        data = with_printer(data, printer)
    return Design(**overridden(data, settings))


load = load_design  # as it was called first


def with_printer(data: dict[str, Any], file: str | Path) -> dict[str, Any]:
    """Return a design's tables with those of a printer file on top of its `[printer]`."""
    own, rows = data.get("printer", {}), _read_file(Path(file), str(file))
    if not isinstance(own, dict):
        raise InputError("printer", "must be a table, [printer]", own)
    for name, row in rows.items():
        if isinstance(row, dict) and isinstance(own.get(name, {}), dict):
            own = {**own, name: {**own.get(name, {}), **row}}
        else:
            own = {**own, name: row}
    return {**data, "printer": own}


def read_table(source: str | Path, kind: Kind) -> dict[str, Any]:
    """Return the parsed TOML of a template's name or of a file's path."""
    name = str(source)
    if name in template_names(kind):
        return tables_of(template_text(name, kind), name)
    path = Path(source)
    try:
        missing = not path.is_file() and path.suffix != ".toml"
    except (OSError, ValueError):
        missing = False  # reading it says why
    if missing:
        rule = f"no such template among {kind}, and no TOML file"
        raise InputError(name[:80], rule, remedy=did_you_mean(name[:80], template_names(kind)))
    return _read_file(path, name)


def _read_file(path: Path, name: str) -> dict[str, Any]:
    """Return the parsed TOML of a regular file; InputError calls it `name`."""
    return tables_of(text_of(path, name, LARGEST_FILE, "TOML"), name)


def overridden(data: dict[str, Any], settings: list[str] | tuple[str, ...]) -> dict[str, Any]:
    """Return the tables with `key=value` texts applied in order; the input stays as it is."""
    result = _copied(data)
    for text in settings:
        path, equals, value = text.partition("=")
        keys = [k.strip() for k in path.split(".")]
        if not equals or not all(keys) or len(keys) > MOST_PARTS:
            raise InputError("settings", "must be table.key=value", text, "as in ridge.height=0.6")
        table = result
        for key in keys[:-1]:
            table = table.setdefault(key, {})
            if not isinstance(table, dict):
                raise InputError("settings", f"{key} is a value, not a table", text)
        if value.strip() == "none":
            table.pop(keys[-1], None)
            drop_dependents(result, path.strip())
        else:
            table[keys[-1]] = _toml_value(value.strip())
    named = {text.partition("=")[0].strip() for text in settings}
    renamed_material(result, {key.removeprefix("material.") for key in named if key.startswith("material.")})
    return result


def _copied(table: dict[str, Any]) -> dict[str, Any]:
    return {key: _copied(value) if isinstance(value, dict) else value for key, value in table.items()}


def _toml_value(text: str) -> Any:
    """The value that a TOML would have here; a text that is none stands for itself."""
    if "\n" in text or "\r" in text:
        raise InputError("settings", "must be one line", text)
    try:
        return tables_of(f"value = {text}", "settings")["value"]
    except InputError:
        return text


def processes(own: Mapping[str, Process] | None = None) -> dict[str, Process]:
    """Return what each process can make: the shipped ones, with a design's `[printer]` on top."""
    return merged(_shipped(), own or {})


@cache
def _shipped() -> dict[str, Process]:
    rows = tomllib.loads(processes_text())
    return {name: Process(**{**row, "based_on": name}) for name, row in rows.items()}


def processes_text() -> str:
    """Return the TOML of the shipped processes, with where each value is from."""
    return table_text("processes")


@cache
def silicones() -> dict[str, Silicone]:
    """Return the catalog of silicones by name."""
    rows = tomllib.loads(table_text("silicones"))
    return {
        name: Silicone(
            name=name,
            **{**row, "young_modulus": Ranged(**row["young_modulus"]), "mix": tuple(row["mix"])},
        )
        for name, row in rows.items()
    }


def silicone(material: Material) -> Silicone:
    """Return the silicone that a design's `[material]` means: the catalog's, with own values on top.

    Without a name the mix, pot life and cure are unknown (None), nu and density typical ones. Raises
    InputError for a name that the catalog doesn't know.
    """
    found = silicones().get(material.name or "")
    if found is None and material.name is not None:
        raise InputError(
            "material.name", "unknown silicone", material.name, did_you_mean(material.name, silicones())
        )
    if found is None:
        found = OWN_SILICONE
    return replace(
        found,
        young_modulus=material.young_modulus or found.young_modulus,
        poisson_ratio=found.poisson_ratio if material.poisson_ratio is None else material.poisson_ratio,
        density=material.density or found.density,
    )
