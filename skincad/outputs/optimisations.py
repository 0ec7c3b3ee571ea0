"""Output of `optimise`: the front's designs, and all evaluations as table, pictures and page."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from skincad.base.result import Writer
from skincad.outputs import sweeps
from skincad.outputs.delivery import picture, text
from skincad.studies.query import short, worded
from skincad.studies.searches import combinations
from skincad.studies.study import Member, Optimisation

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


def lines(optimisation: Optimisation) -> list[str]:
    """Return what `optimise` prints."""
    rows = [_first(optimisation)]
    for number, member in enumerate(optimisation.front[:SHOWN], 1):
        rows.append(f"  {f'front {number}':14} {_values(member)}")
        rows += _member_lines(member)
    if len(optimisation.front) > SHOWN:
        rows.append(
            f"  {'more':14} {len(optimisation.front) - SHOWN} designs of the front, in {COMMAND}.json"
        )
    if optimisation.closest is not None:
        rows += [f"  {'nearest':14} {_values(optimisation.closest)}", *_member_lines(optimisation.closest)]
    if optimisation.start is not None:
        rows += [
            f"  {'start':14} {', '.join(worded(k, e) for k, e in optimisation.start.objectives.items())}"
        ]
    tier = optimisation.rows.question.tier
    by = f"{len(optimisation.rows.rows)} designs{f' by {tier}' if tier else ''}, {optimisation.judged} judged"
    spent = (
        f"{optimisation.evaluations} evaluations, {optimisation.reused} reused, {optimisation.seconds:.3g} s"
    )
    rows.append(f"  tried          {by}; {spent}")
    if optimisation.untried:
        count = combinations(optimisation.rows.knobs)
        untried = f"{optimisation.untried} of {count} combinations"
        rows.append(f"  not tried      {untried}; `evaluations = {count}` tries all")
    return rows


def _first(optimisation: Optimisation) -> str:
    goals = ", ".join(
        f"{o.key} {'small' if o.goal == 'min' else 'large'}" for o in optimisation.study.objectives
    )
    if not optimisation.front:
        return f"{optimisation.name}: no design that was judged keeps all constraints ({goals})."
    several = len(optimisation.study.objectives) > 1
    what = f"a front of {len(optimisation.front)} designs" if several else "the best design that was found"
    return f"{optimisation.name}: {what} for {goals}."


def _values(member: Member) -> str:
    return ", ".join(f"{key} {short(value)}" for key, value in member.values.items())


def _member_lines(member: Member) -> list[str]:
    by = f" ({member.tier})" if member.tier else ""
    rows = [f"    {'objective':12} {worded(key, value)}{by}" for key, value in member.objectives.items()]
    return rows + [
        f"    {'constraint' if satisfied else 'BROKEN':12} {worded(key, value)}"
        for key, (value, satisfied) in member.constraints.items()
    ]


def manifest(optimisation: Optimisation) -> dict[str, Any]:
    """Return what the manifest says of the result: all of it."""
    return optimisation.as_json()


def figures(optimisation: Optimisation) -> dict[str, Callable[[], Picture]]:
    """Return the pictures of all that was tried."""
    return dict(sweeps.figures(optimisation.rows))


def files(optimisation: Optimisation) -> dict[str, Writer]:
    """Return the writers of the front's designs, the table, the page and the pictures."""
    count = min(SHOWN, len(optimisation.front))
    designs = {_design(n): text(optimisation.design(n).to_toml) for n in range(1, count + 1)}
    aims = optimisation.aims
    page = text(
        lambda: sweeps.sweep_page(optimisation.rows, lines(optimisation), title=optimisation.name, aims=aims)
    )
    pictures = {name: picture(draw) for name, draw in figures(optimisation).items()}
    return {**designs, TABLE: text(lambda: sweeps.sweep_csv(optimisation.rows)), PAGE: page, **pictures}
