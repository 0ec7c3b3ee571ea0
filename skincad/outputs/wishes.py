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


def lines(wish: WishResult) -> list[str]:
    """Return the answer, how sure it is, each wish that is broken, and each choice with its rule."""
    return [
        answer(wish),
        *_parts_lines(wish),
        *(_row(b.wish, f"asked {b.asked}, got {b.given}: {b.why}") for b in wish.broken),
        *(_row(c.key, f"{c.value}: {c.why}") for c in wish.choices),
        *(_row("trade", words) for words in _trade(wish)),
        *(_row("note", warning) for warning in wish.warnings),
    ]


def _trade(wish: WishResult) -> list[str]:
    """A line each for the thin, the usual and the thick skin."""
    family, rows = wish.design.features.family, []
    for row in wish.trade:
        share = row.passing.value if row.passing else None
        parts = "" if share is None else f", {100 * share:.0f} % of parts pass"
        rows.append(
            f"{row.thickness:g} mm thick: all {family}s need {row.all_touch_force.span(rough=1.0)}{parts}"
        )
    return rows


def answer(wish: WishResult) -> str:
    """Return in one sentence whether the wish is met."""
    verdict = checks.verdict(wish.check)
    sentence = verdict.partition(": ")[2] if wish.check.passed else verdict
    if wish.passed:
        return f"Met: {sentence}"
    names = " and ".join(broken.wish for broken in wish.broken)
    return f"NOT MET: {names}. The nearest design that was found: {sentence}"


def _parts_lines(wish: WishResult) -> list[str]:
    """How many parts pass, where that is known."""
    share = checks.passing_share(wish.check)
    return [_row("parts", f"{share} pass as they come out of the mold")] if share else []


def _row(head: str, words: str) -> str:
    return f"  {head:22} {words}"


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


def next_step(wish: WishResult) -> str:
    """Return what to do next: make what is met, or wish otherwise."""
    if wish.passed:
        return "`skincad make {design}` makes its mold."
    return "`skincad make {design}` makes the nearest design, or wish again with one of the changes above."


WISH = Presentation(
    COMMAND="new",
    lines=lines,
    next_step=next_step,
    details=lambda wish: checks.details(wish.check),
    files=lambda wish: {f"{wish.name}.toml": text(lambda: short_toml(wish, wish.name))},
    figures=lambda wish: checks.figures(wish.check),
)
