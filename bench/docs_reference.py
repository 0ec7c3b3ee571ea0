"""Generated parts of docs/: commands, Python names, TOML and JSON keys, the gallery, and the tables of fits.

A hook of mkdocs. They exist in the built site; a checkout has a line in the place of each.
`python -m bench.docs_reference FOLDER` writes them.
"""

from __future__ import annotations

import argparse
import inspect
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import is_dataclass
from importlib import import_module
from operator import attrgetter
from pathlib import Path
from typing import Any, get_args

import typer
from mkdocs.structure.files import File

import skincad
from bench import table_fits
from skincad.base import Record, Table, declared_items, key_of
from skincad.cli.app import app
from skincad.effects import EFFECTS, effect
from skincad.inputs import Design, Gripper, Process, Silicone
from skincad.outputs import gallery, table_entries

RESULTS = {  # a command, and the record that its --json prints
    "new": "studies.wish:WishResult",
    "check": "mechanics.verdict:ContactCheck",
    "check --stress": "mechanics.film.stress:FilmStresses",
    "check --film": "fabrication.films:FilmOffers",
    "make": "fabrication.making:MakeResult",
    "simulate": "scenes.simulation:Simulation",
    "circuit": "circuit.bode:CircuitGain",
    "circuit --board": "circuit.boards:Board",
    "solve": "studies.solving:Solution",
    "sweep": "studies.sweeping:SweepResult",
    "optimise": "studies.study:Optimisation",
    "accuracy": "studies.accuracy.accuracy:Accuracy",
    "fit-material": "material.modulus:MaterialFit",
    "accept": "material.acceptance:Acceptance",
    "listen --taps": "detector.taps:TapTest",
    "coupon": "fabrication.coupon:CouponKit",
    "coupon --measured": "fabrication.coupon:CouponReading",
    "package": "outputs.simulators.package:Package",
    "export": "outputs.detector_code:DetectorCode",
}
DOCUMENTS = ("Circuit", "Design", "Scene", "Study")  # fields are keys of TOML, which have their own page
METHODS = "with_, to_toml"
TYPES = (  # the first that a type's last part names
    ("Estimate", "number with error"), ("bool", "true or false"), ("str|Literal|Verdict", "text"),
    ("float", "number"), (r"\w*Array|ndarray|Floats", "number"), ("int", "whole number"),
    ("BySource", "number by source"),
)  # fmt: skip
NAMED_LATE = ("fabrication.estimates", "fabrication.fasteners", "fabrication.rules")  # hold records of make's


def commands_page() -> str:
    """Return the page of commands: each with its arguments, options and defaults."""
    lines = ["# Commands", "", "The output of `skincad COMMAND --help`, on one page.", ""]
    group = typer.main.get_command(app)
    for name, command in group.commands.items():  # type: ignore[attr-defined]
        context = command.make_context(name, [], resilient_parsing=True)
        lines += [f"## skincad {name}", "", *inspect.cleandoc(command.help or "").splitlines(), ""]
        shown = [parameter.get_help_record(context) for parameter in command.params]
        rows = [f"| `{record[0]}` | {_cell(record[1])} |" for record in shown if record]
        lines += ["| argument or option | meaning |", "|---|---|", *rows, ""]
    return "\n".join(lines)


def python_page() -> str:
    """Return the page of public names, each by its docstring; mkdocstrings fills it in."""
    words = "Every public name of `skincad`. [Use Python](../howto/python.md) shows them at work."
    lines = ["# Python", "", words, ""]
    for name in skincad.__all__:
        home = f"{inspect.unwrap(getattr(skincad, name)).__module__}.{name}"
        lines += [f"::: {home}", "    options:", f"      heading: skincad.{name}"]
        lines += [
            f"      {kind}: [{METHODS}]" for kind in ("members", "inherited_members") if name in DOCUMENTS
        ]
        lines += ["", "[Its keys](toml.md).", ""] if name in DOCUMENTS else [""]
    return "\n".join(lines)


def toml_page() -> str:
    """Return the page of TOML keys: unit, range, default and meaning of each."""
    from skincad.circuit import Circuit
    from skincad.scenes import Scene
    from skincad.studies import Study

    lines = [
        "# TOML keys", "", "Every key of every file that skincad reads. `skincad new FILE --template NAME`",
        "writes a file with the same text as comments.", "",
    ]  # fmt: skip
    kinds: list[type[Table]] = [Design, Scene, Circuit, Study]
    for model in kinds:
        lines += [f"## {model.__name__}", "", *_tables(model, "")]
        if model is Scene:
            for name in EFFECTS:
                lines += _tables(effect(name), f"effects.{name}")
    own = (
        ("Silicones", Silicone, "my-silicone"),
        ("Processes", Process, "my-printer"),
        ("Grippers", Gripper, "my-gripper"),
    )
    for title, model, name in own:
        lines += [f"## {title}", "", f"A table a row, as `[{name}]`.", "", *_tables(model, name)]
    return "\n".join(lines)


def _tables(model: type[Table], path: str) -> Iterator[str]:
    """A table of keys for a model and, below it, each table within."""
    rows, inner = table_entries(model)
    if path:
        yield from (f"### `[{path}]`", "", _cell(inspect.cleandoc(model.__doc__ or "").split("\n\n")[0]), "")
    if rows:
        yield from ("| key | meaning | unit, range, default |", "|---|---|---|")
        for key, limits, default, meaning in rows:
            usual = default if default in ("", "required") else f"default `{default}`"
            yield f"| `{key}` | {_cell(meaning)} | {'; '.join(part for part in (limits, usual) if part)} |"
        yield ""
    for key, table in inner.items():
        if table in (Silicone, Process, Gripper):  # each has its own section
            continue
        yield from _tables(table, f"{path}.{key}" if path else key)


def json_page() -> str:
    """Return the page of JSON keys: of each command, and of each record within them."""
    lines = [
        "# JSON keys", "", "The output of `--json`. A key ends in its unit. A number with error is",
        '`{"value": v, "error": e}`; `v` is null if there is none. Lists over ridges start with ridge 1.', "",
    ]  # fmt: skip
    for module in NAMED_LATE:
        import_module(f"skincad.{module}")
    known: dict[str, type[Record]] = {}
    for command, home in RESULTS.items():
        kind = _imported(home)
        lines += [f"## skincad {command}", "", *_record_rows(kind, known)]
    lines += ["## Records within", ""]
    listed: set[str] = set()
    while names := [name for name in known if name not in listed]:
        for name in names:
            listed.add(name)
            lines += [f"### {name}", "", *_record_rows(known[name], known)]
    return "\n".join(lines)


def _imported(home: str) -> type[Record]:
    module, _, name = home.partition(":")
    return getattr(import_module(f"skincad.{module}"), name)  # type: ignore[no-any-return]


def _record_rows(kind: type[Record], known: dict[str, type[Record]]) -> Iterator[str]:
    yield from ("| key | type | meaning |", "|---|---|---|")
    yield from _rows_of(kind, known)
    yield ""


def _rows_of(kind: type[Record], known: dict[str, type[Record]]) -> Iterator[str]:
    records = {record.__name__: record for record in _below(Record)}
    for name, item in declared_items(kind):
        written = _annotation(kind, name)
        inner = next((records[word] for word in re.findall(r"\w+", written) if word in records), None)
        if item.inline and inner:
            yield from _rows_of(inner, known)
            continue
        if inner:
            known.setdefault(inner.__name__, inner)
        key = "(more keys)" if item.inline else f"`{item.key or key_of(name, item.unit)}`"
        yield f"| {key} | {_type(written, inner)} | {_cell(item.meaning)} |"


def _annotation(kind: type, name: str) -> str:
    """An attribute's type as the class writes it."""
    for parent in kind.__mro__:
        value = vars(parent).get(name)
        kept = getattr(value, "__dict__", {})
        getter = value.fget if isinstance(value, property) else kept.get("method") or kept.get("func")
        if isinstance(getter, attrgetter):  # of another record
            written, holder = "", kind
            for part in getter.__reduce__()[1][0].split("."):
                written = _annotation(holder, part)
                holder = _class_named(written)
            return written
        if getter:
            return str(getter.__annotations__["return"])
        if name in vars(parent).get("__annotations__", {}):
            return str(vars(parent)["__annotations__"][name])
    return ""


def _class_named(written: str) -> type:
    """The class of the package that a type names, as "Scene | None"."""
    modules = [module for name, module in sys.modules.items() if name.startswith("skincad")]
    named = (vars(module).get(word) for word in re.findall(r"\w+", written) for module in modules)
    ones = (one for value in named for one in (get_args(value) or (value,)))  # the first of a union
    return next((one for one in ones if getattr(one, "__module__", "").startswith("skincad")), type(None))


def _type(written: str, inner: type[Record] | None) -> str:
    """A Python type in words: "list of number"."""
    if inner:
        plain = f"[{inner.__name__}](#{inner.__name__.lower()})"
    else:
        last = re.split(r"\b(?:dict|Mapping)\[[^,]+,", written)[-1]
        plain = next((shown for name, shown in TYPES if re.search(rf"\b{name}\b", last)), "value")
    if written.startswith(("tuple", "list", "np.", "Array", "Floats", "Sequence")):
        return f"list of {plain}"
    return f"table of {plain}" if re.match(r"dict|Mapping", written) else plain


def _below(kind: type[Record]) -> Iterable[type[Record]]:
    for child in kind.__subclasses__():
        if is_dataclass(child):
            yield child
        yield from _below(child)


def _cell(text: str) -> str:
    escaped = {"|": "\\|", "<": "&lt;", "*": "\\*", "_": "\\_"}
    return " ".join(text.split()).translate(str.maketrans(escaped))


PAGES: dict[str, Callable[[], str]] = {
    "gallery.md": gallery.page,
    "reference/cli.md": commands_page,
    "reference/python.md": python_page,
    "reference/toml.md": toml_page,
    "reference/json.md": json_page,
}


def on_files(files: Any, *, config: Any) -> Any:
    """Add the pages to the site; mkdocs calls this."""
    for path, page in PAGES.items():
        if stub := files.get_file_from_path(path):  # what a checkout shows in its place
            files.remove(stub)
        files.append(File.generated(config, path, content=page()))
    return files


def with_tables(markdown: str) -> str:
    """Put the tables of fits where a page's comments ask for them."""
    tables = {"fits": table_fits.fits, "designs": table_fits.designs}
    return re.sub(r"<!-- bench\.table_fits: (\w+) -->", lambda asked: "\n".join(tables[asked[1]]()), markdown)


def on_page_markdown(markdown: str, *, page: Any, **_: Any) -> str:
    """Fill in tables, and rank those of Evidence below other pages in the search; mkdocs calls this."""
    if page.file.src_uri.startswith("evidence/"):
        page.meta["search"] = {"boost": 1e-4}  # a match in a title counts 1000 times one in the text
    return with_tables(markdown)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    for path, page in PAGES.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(page())
