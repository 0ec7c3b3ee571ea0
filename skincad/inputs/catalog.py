"""What ships by name, and what a person's own file overrides.

A file is read as data only: no code, at most `LARGEST_FILE` bytes, no path inside it is followed.
"""

from __future__ import annotations

import json
import re
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Literal

from pydantic import BaseModel

from skincad.base.errors import InputError, did_you_mean
from skincad.base.reading import MOST_PARTS, tables_of, text_of
from skincad.base.tables import Document, no_entry
from skincad.inputs.design import Design, drop_dependents, drop_replaced, renamed_material
from skincad.inputs.feature_tables import FAMILY_TABLES
from skincad.inputs.gripper import Gripper
from skincad.inputs.process import Process
from skincad.inputs.shipped import templates_folder
from skincad.inputs.silicone import Silicone

OwnTable = Literal["printer", "silicones", "grippers"]
OWN_TABLES: tuple[OwnTable, ...] = ("printer", "silicones", "grippers")
Own = str | Path | Mapping[str, Any]  # a TOML file of one's own tables, or the tables
LARGEST_FILE = 1_000_000  # bytes; a design is a few thousand
LONGEST_PATH = 4096  # letters
Kind = Literal["designs", "scenes", "circuits", "studies"]
KINDS: tuple[Kind, ...] = ("designs", "scenes", "circuits")  # what `new` writes, and studies vary
# what a file is, and what takes it
_WORDS = {
    "designs": ("a design", "make, check or accuracy"),
    "scenes": ("a scene", "simulate"),
    "circuits": ("a circuit", "circuit"),
    "studies": ("a study", "optimise"),
    "silicones": ("a table of silicones", "--silicones (in Python silicones=...)"),
    "printer": ("a table of processes", "--printer (in Python printer=...)"),
    "grippers": ("a table of grippers", "--grippers (in Python grippers=...)"),
}
# a quoted text, or a decimal point with the digits beside it
_DECIMAL = re.compile(
    r""""(?:[^"\\]|\\.)*"|'[^']*'|"""
    r"(?<![\w.])(?=\.?\d)(?P<whole>\d*)\.(?P<decimals>\d*)(?=([eE][+-]?\d+)?(?![\w.]))",
    re.ASCII,
)
# the tables that only files of a kind have, by which one that was given to another's command is known
_MARKS: dict[Kind, set[str]] = {
    "designs": {*FAMILY_TABLES, "slot", "material", "mold", "contact"},
    "scenes": {"history", "grip", "effects", "readout"},
    "circuits": {"amplifier", "motional", "cable", "sweep"},
    "studies": {"vary", "objectives", "constraints"},
}


def template_names(kind: Kind = "designs") -> list[str]:
    """Return the names of the templates of one kind, sorted."""
    folder = templates_folder() / kind
    if not folder.is_dir():
        return []
    return sorted(f.name.removesuffix(".toml") for f in folder.iterdir() if f.name.endswith(".toml"))


def display_name(design: Design) -> str:
    """Return a design's name, and that it was changed where it is a template's and the values are not."""
    ours = design.name in template_names() and design != load_design(design.name)
    return f"{design.name} (changed)" if ours else design.name


def template_text(name: str, kind: Kind = "designs") -> str:
    """Return a template's TOML text; raises InputError for an unknown name."""
    known = template_names(kind)
    if name not in known:
        raise InputError(name, "no such template", remedy=did_you_mean(name, known))
    return (templates_folder() / kind / f"{name}.toml").read_text("utf-8")


def named_document(value: Any, model: type[Document], what: str) -> Any:
    """Return a document, of its tables where these are given, or the text that names one.

    Raises InputError for anything else; `what` it must be."""
    if isinstance(value, dict):
        return model(**value)
    if not isinstance(value, str | model):
        raise InputError("", f"must be {what}, or the name of a template or TOML file", value)
    if isinstance(value, str) and len(value) > LONGEST_PATH:
        raise InputError("", f"must have at most {LONGEST_PATH} characters", value)
    return value


def kinds_of(name: str) -> list[Kind]:
    """Return the kinds that have a template of this name."""
    return [kind for kind in _MARKS if name in template_names(kind)]


def load_design(
    source: str | Path,
    settings: list[str] | tuple[str, ...] = (),
    *,
    printer: Own | None = None,
    silicones: Own | None = None,
    grippers: Own | None = None,
) -> Design:
    """Return the design of a template's name or of a TOML file.

    `printer`, `silicones` and `grippers` are a workshop's own processes, a lab's own silicones and grippers,
    as TOML files or as tables; they go into the design's `[printer]`, `[silicones]` and `[grippers]`, so that
    a copy of the design means the same without them. `settings` are `table.key=value` with a TOML value, or
    `table=none` to drop an optional table, and come last. Raises InputError with key, rule, value, remedy.
    """
    return Design(**design_tables(source, settings, printer=printer, silicones=silicones, grippers=grippers))


def design_tables(
    source: str | Path, settings: list[str] | tuple[str, ...] = (), **own: Own | None
) -> dict[str, Any]:
    """Return the tables of a design that `load_design` makes one of, its files' and settings' in them."""
    folder = Path(source).parent if Path(source).suffix == ".toml" else Path()
    data = _with_bone(read_table(source, "designs"), folder)
    for table in OWN_TABLES:
        data = with_own(data, table, own.get(table))
    return _with_bone(overridden(data, settings), Path())


def _with_bone(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Tables with the path of their bone from the root, so that it means the same in each file written of
    them: a file's own is beside it, one that is set in the working directory."""
    mold = data.get("mold")
    if not isinstance(mold, dict) or not isinstance(mold.get("bone"), str):
        return data
    with suppress(OSError):  # where the working directory is gone
        return {**data, "mold": {**mold, "bone": str((folder / mold["bone"]).absolute())}}
    return data


load = load_design  # as it was called first


def with_own(data: dict[str, Any], table: OwnTable, source: Own | None) -> dict[str, Any]:
    """Return a file's tables with one's own on top of its `[printer]`, `[silicones]` or `[grippers]`."""
    if source is None:
        return data
    rows, tables = own_tables(table, source), data.get(table, {})
    if not isinstance(tables, dict):
        raise InputError(table, f"must be a table, [{table}]", tables)
    for name, row in rows.items():
        if isinstance(row, dict) and isinstance(tables.get(name, {}), dict):
            tables = {**tables, name: {**tables.get(name, {}), **row}}
        else:
            tables = {**tables, name: row}
    return {**data, table: tables}


def own_tables(table: OwnTable, source: Own) -> dict[str, Any]:
    """Return one's own tables; those of a file are read."""
    if isinstance(source, Mapping):
        return dict(source)
    if not isinstance(source, str | Path):
        raise InputError(table, "must be a TOML file, or tables", source)
    rows = _read_file(Path(source), str(source))
    _refuse_others(str(source), _marked(rows), table)
    return rows


def read_table(source: str | Path, kind: Kind) -> dict[str, Any]:
    """Return the parsed TOML of a template's name or of a file's path.

    Raises InputError for one of another kind, which says what takes it.
    """
    name = str(source)
    if name in template_names(kind):
        return tables_of(template_text(name, kind), name)
    path = Path(source)
    try:
        missing = not path.is_file() and path.suffix != ".toml"
    except (OSError, ValueError):
        missing = False  # reading it says why
    if missing:
        _refuse_others(name, kinds_of(name), kind)
        rule = f"no such template among {kind}, and no TOML file"
        raise InputError(name[:80], rule, remedy=did_you_mean(name[:80], template_names(kind)))
    data = _read_file(path, name)
    if not _MARKS[kind] & data.keys():
        _refuse_others(name, _marked(data), kind)
    return data


def kind_of(source: str | Path) -> Kind:
    """Return which kind a template's name or a TOML file is, by its tables; a design where nothing tells."""
    if known := kinds_of(str(source)):
        return known[0]
    path = Path(source)
    try:
        kinds = _marked(_read_file(path, str(source))) if path.is_file() else []
    except (OSError, ValueError):
        kinds = []  # loading it says why
    return next((kind for kind in KINDS if kind in kinds), "designs")


_OWN_ROWS: tuple[tuple[str, type[BaseModel]], ...] = (
    ("silicones", Silicone),
    ("printer", Process),
    ("grippers", Gripper),
)


def _marked(data: dict[str, Any]) -> list[str]:
    """What the tables may be by their keys; nothing where those are no kind's."""
    if isinstance(data.get("name"), str):
        return [str(kind) for kind, marks in _MARKS.items() if marks & data.keys()][:1]

    def all_are(model: type[BaseModel]) -> bool:
        rows = data.values()
        return bool(rows) and all(isinstance(r, dict) and r.keys() <= model.model_fields.keys() for r in rows)

    return [table for table, model in _OWN_ROWS if all_are(model)]


def _refuse_others(name: str, kinds: Sequence[str], wanted: str) -> None:
    """Raise InputError, which says what takes it, for what is of other kinds than the wanted one."""
    if kinds and wanted not in kinds:
        kind_words = " and ".join(_WORDS[kind][0] for kind in kinds)
        takers = ", or to ".join(_WORDS[kind][1] for kind in kinds)
        rule = f"is {kind_words}, not {_WORDS[wanted][0]}"
        raise InputError(name[:80], rule, remedy=f"give it to {takers}")


def _read_file(path: Path, name: str) -> dict[str, Any]:
    """Return the parsed TOML of a regular file; InputError calls it `name`."""
    return tables_of(text_of(path, name, LARGEST_FILE, "TOML"), name)


def overridden(data: dict[str, Any], settings: list[str] | tuple[str, ...]) -> dict[str, Any]:
    """Return the tables with `key=value` texts applied in order; the input stays as it is.

    A number at a key's end counts a list's entries from 1. Raises InputError for a key that is given twice.
    """
    result = _copied(data)
    named = set[str]()
    for text in settings:
        name, (_, equals, value) = setting_key(text), text.partition("=")
        keys = name.split(".")
        if not equals or not all(keys) or len(keys) > MOST_PARTS:
            raise InputError("settings", "must be table.key=value", text, "as in ridge.height=0.6")
        if name in named:
            raise InputError("settings", f"must give {name} once", text, "leave one of them out")
        named.add(name)
        table = result
        for depth, key in enumerate(keys[:-1], 2):
            inner = table.setdefault(key, {})
            if isinstance(inner, list | tuple) and depth == len(keys) and keys[-1].isdecimal():
                table[key] = _with_entry(inner, name, _toml_value(value.strip()))
                break
            if not isinstance(inner, dict):
                raise InputError("settings", f"{key} is a value, not a table", text)
            table = inner
        else:
            if value.strip() == "none":
                table.pop(keys[-1], None)
                drop_dependents(result, name)
                continue
            table[keys[-1]] = _toml_value(value.strip())
            if len(keys) == 2 and keys[0] in FAMILY_TABLES:  # table and key
                drop_replaced(result, keys[0], {keys[-1]})
    renamed_material(result, {key.removeprefix("material.") for key in named if key.startswith("material.")})
    return result


def _with_entry(entries: Sequence[Any], key: str, value: Any) -> list[Any]:
    """A list with the entry that the key's last part counts from 1 changed."""
    places = [str(place) for place in range(1, len(entries) + 1)]
    if (place := key.rpartition(".")[2]) not in places:
        raise no_entry(key, len(entries))
    return [value if here == place else entry for here, entry in zip(places, entries, strict=True)]


def setting_key(text: str) -> str:
    """Return the key that a `key=value` text sets, without spaces."""
    return ".".join(part.strip() for part in text.partition("=")[0].split("."))


def _copied(table: dict[str, Any]) -> dict[str, Any]:
    return {key: _copied(value) if isinstance(value, dict) else value for key, value in table.items()}


def _toml_value(text: str) -> Any:
    """The value that a TOML would have here, or has with its decimals completed, as .02; a text that is none
    stands for itself."""
    if "\n" in text or "\r" in text:
        raise InputError("settings", "must be one line", text)
    for written in (text, _DECIMAL.sub(_completed, text)):
        with suppress(InputError):
            return tables_of(f"value = {written}", "settings")["value"]
    return text


def _completed(part: re.Match[str]) -> str:
    """A decimal with the zero that TOML wants beside its point; a quoted text as it is."""
    whole, decimals = part["whole"], part["decimals"]
    return part[0] if whole is None else f"{whole or '0'}.{decimals or '0'}"


MOST_SETTINGS = 6  # a line to be read; more of them are a file


def retyped(
    document: Document,
    kind: Kind,
    load: Callable[[str, list[str]], Document],
    file: str | None = None,
) -> str:
    """Return the words after a command that give this document again: its template's name and `--set`
    options, or else `file`, the name that its TOML has.

    `load` makes a document of a name and settings.
    """
    other = file or f"{document.name}.toml"
    if document.name not in template_names(kind):
        return other
    values, shipped = document.model_dump(mode="json", exclude_none=True), load(document.name, [])
    template = shipped.model_dump(mode="json", exclude_none=True)
    settings = list(_differences(values, template))
    if len(settings) > MOST_SETTINGS:
        return other
    try:
        again = load(document.name, settings).model_dump(mode="json", exclude_none=True)
    except InputError:
        return other
    if again != values:
        return other
    return " ".join([document.name, *(f"--set {shlex.quote(setting)}" for setting in settings)])


def _differences(values: Mapping[str, Any], template: Mapping[str, Any], table: str = "") -> Iterator[str]:
    """Yield `key=value` of what differs, `key=none` of what is gone."""
    for key in [*values, *(key for key in template if key not in values)]:
        name = f"{table}{key}"
        one, other = values.get(key), template.get(key)
        if one == other:
            continue
        if isinstance(one, dict) and isinstance(other, dict):
            yield from _differences(one, other, f"{name}.")
        else:
            yield f"{name}={_toml(one)}"


def _toml(value: Any) -> str:
    """A value as TOML in one line."""
    if value is None:
        return "none"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_toml(entry)}" for key, entry in value.items()) + "}"
    if isinstance(value, str) and value.replace("-", "").isalnum() and not value[:1].isdigit():
        return value
    return json.dumps(value)
