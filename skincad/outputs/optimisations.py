"""What optimising says and leaves: the front's designs, all that was tried as table, pictures and page."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.outputs import sweeps
from skincad.outputs.delivery import picture, text
from skincad.studies.asking import short
from skincad.studies.measures import worded
from skincad.studies.optimisation import Member, Optimisation
from skincad.studies.searches import combinations

if TYPE_CHECKING:
    from skincad.pictures.canvas import Picture

COMMAND = "optimise"
TABLE, PAGE = "optimise.csv", "optimise.html"
SHOWN = 6  # members of the front, in words and as designs


def names() -> list[str]:
    """Return the names of what may be written."""
    designs = [_design(number) for number in range(1, SHOWN + 1)]
    return [*designs, TABLE, PAGE, "effects.png", "pairs.png", "front.png"]


def _design(number: int) -> str:
    return f"front-{number}.toml"


def lines(found: Optimisation) -> list[str]:
    """Return what `optimise` prints."""
    told = [_first(found)]
    for number, member in enumerate(found.front[:SHOWN], 1):
        told.append(f"  {f'front {number}':14} {_values(member)}")
        told += _member_lines(member)
    if len(found.front) > SHOWN:
        told.append(f"  {'more':14} {len(found.front) - SHOWN} designs of the front, in {COMMAND}.json")
    if found.closest is not None:
        told += [f"  {'nearest':14} {_values(found.closest)}", *_member_lines(found.closest)]
    if found.start is not None:
        told += [f"  {'start':14} {', '.join(worded(k, e) for k, e in found.start.objectives.items())}"]
    tier = found.rows.question.tier
    by = f"{len(found.rows.rows)} designs{f' by {tier}' if tier else ''}, {found.judged} judged"
    spent = f"{found.evaluations} evaluations, {found.reused} reused, {found.seconds:.3g} s"
    told.append(f"  tried          {by}; {spent}")
    if found.untried:
        count = combinations(found.rows.knobs)
        told.append(
            f"  not tried      {found.untried} of {count} combinations; `evaluations = {count}` tries all"
        )
    return told


def _first(found: Optimisation) -> str:
    goals = ", ".join(f"{o.key} {'small' if o.goal == 'min' else 'large'}" for o in found.study.objectives)
    if not found.front:
        return f"{found.name}: no design that was judged keeps all constraints ({goals})."
    several = len(found.study.objectives) > 1
    what = f"a front of {len(found.front)} designs" if several else "the best design that was found"
    return f"{found.name}: {what} for {goals}."


def _values(member: Member) -> str:
    return ", ".join(f"{key} {short(value)}" for key, value in member.values.items())


def _member_lines(member: Member) -> list[str]:
    by = f" ({member.tier})" if member.tier else ""
    told = [f"    {'objective':12} {worded(key, value)}{by}" for key, value in member.objectives.items()]
    return told + [
        f"    {'constraint' if kept else 'BROKEN':12} {worded(key, value)}"
        for key, (value, kept) in member.constraints.items()
    ]


def manifest(found: Optimisation) -> dict[str, Any]:
    """Return what the manifest says of the result: all of it."""
    return found.as_json()


def figures(found: Optimisation) -> dict[str, Callable[[], Picture]]:
    """Return the pictures of all that was tried."""
    return dict(sweeps.figures(found.rows))


def files(found: Optimisation) -> dict[str, Writer]:
    """Return the writers of the front's designs, the table, the page and the pictures."""
    count = min(SHOWN, len(found.front))
    designs = {_design(n): text(found.design(n).to_toml) for n in range(1, count + 1)}
    aims = found.aims
    page = text(lambda: sweeps.sweep_page(found.rows, lines(found), title=found.name, aims=aims))
    pictures = {name: picture(draw) for name, draw in figures(found).items()}
    return {**designs, TABLE: text(lambda: sweeps.sweep_csv(found.rows)), PAGE: page, **pictures}
