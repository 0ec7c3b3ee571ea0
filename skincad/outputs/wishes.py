"""Output of a wish: whether it is met, what was chosen and why, and its design as a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import tomlkit

from skincad.outputs import checks
from skincad.outputs.delivery import Presentation, text
from skincad.outputs.tomls import commented_toml, document_name, write_with_schema

if TYPE_CHECKING:
    from skincad.studies.wish import WishResult


def short_toml(wish: WishResult, name: str, schema: str = "") -> str:
    """Return the design's TOML without what is at its default, each choice with its rule above it."""
    design = wish.design.with_(name=name)
    document = tomlkit.parse(tomlkit.dumps(design.model_dump(exclude_defaults=True, exclude_none=True)))
    rules = {choice.key: choice.why for choice in wish.choices}
    rows = [f"#:schema ./{schema}", ""] if schema else []
    table = ""
    for row in [*_head(wish), *tomlkit.dumps(document).splitlines()]:
        if row.startswith("["):
            table = row.strip("[]")
        rule = rules.get(f"{table}.{row.partition(' = ')[0]}") or (row.startswith("[") and rules.get(table))
        rows += [f"# {rule}"] if rule else []
        rows.append(row)
    return "\n".join(rows) + "\n"


def _head(wish: WishResult) -> list[str]:
    skin, design = wish.design.skin, wish.design
    touch = f"all {design.features.family}s touch at {design.contact.force:g} N"
    size = f"{skin.width:g} x {skin.length:g} mm, {touch}"
    broken = [f"# NOT MET: {b.wish}: asked {b.asked}, got {b.given}: {b.why}" for b in wish.broken]
    return [f"# A pad of {size}: {design.material.name}, mold by {design.mold.process}", *broken]


def write_wish(path: Path, wish: WishResult, full: bool = False) -> list[Path]:
    """Write the design of a wish, short or with every key explained, and its schema beside it; return both
    paths. Raises InputError for a file that is there already or cannot be written."""
    name = document_name(path.stem)

    def written(schema: str) -> str:
        short = short_toml(wish, name, schema)
        return commented_toml("designs", short, path.stem, schema) if full else short

    return write_with_schema(path, "designs", written, wish.design.features.family)


WISH = Presentation(
    COMMAND="new",
    words="new.txt",
    facts=checks.CHECK.facts,
    files=lambda wish: {f"{wish.name}.toml": text(lambda: short_toml(wish, wish.name))},
    figures=lambda wish: checks.figures(wish.check),
)
