"""Output of `accept`: the verdict in one sentence, the causes that fit, and what to do next."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from skincad.base.result import Writer
from skincad.material.acceptance import Acceptance, CauseFit
from skincad.outputs.delivery import Presentation, picture, text

if TYPE_CHECKING:
    from skincad.outputs.figures.canvas import Picture

COMMAND = "accept"
SHOWN_FROM = 0.1  # of the likeliest cause's probability; less likely ones are in the JSON alone
MOST_GOOD = 0.98  # a share of good parts that a shop may have
STEPS = {
    "modulus": "mix again and cast another part; or keep this silicone by `--update FILE`",
    "crests": "measure the crests, and judge them by `skincad check {design} --measured CSV`",
    "ridge": "look at the ridges; vent the mold or degas the silicone",
    "back": "look for voids and loose glue behind the skin; press on a stiff table",
    "friction": "wet or powder the plate, and press again",
}


def lines(result: Acceptance) -> list[str]:
    """Return the verdict, the causes and the numbers behind them."""
    low, high = result.modulus_range
    return [
        sentence(result),
        *([] if result.passed else cause_lines(result)),
        f"  modulus        {result.young_modulus} if nothing else departs ({low:g} to {high:g} MPa is good)",
        f"  rows           {result.rows_used} of {result.rows} used, up to {result.largest_force:.3g} N; "
        f"errors {result.force_error:g} N, {result.approach_error:g} mm",
        f"  zero           {result.zero} of approach",
        *(f"  note           {warning}" for warning in result.warnings),
    ]


def sentence(result: Acceptance) -> str:
    """Return the verdict in one sentence."""
    good = f"{100 * result.good_probability:.3g} %"
    if result.verdict == "in":
        return f"IN: the curve is a good part's, by {good}."
    if result.verdict == "can't tell":
        return f"CAN'T TELL: the curve may be a good part's ({good}) or a faulty one's."
    if result.cause is None:
        return "OUT: the curve is no good part's, and no cause fits."
    best, *others = result.causes
    also = "" if result.alone or not others else f"; so does {brief(others[0])}"
    return f"OUT: the curve is no good part's. {brief(best)[0].upper()}{brief(best)[1:]} fits best{also}."


def brief(cause: CauseFit) -> str:
    """Return a cause with its size."""
    place = f" ({cause.place})" if cause.place else ""
    size = f"{cause.size}".strip()
    return {
        "modulus": f"a modulus of {size}",
        "crests": f"a crest error{place} of {size}",
        "ridge": f"a ridge that did not fill (perhaps {cause.place}), by {size},",
        "back": f"a soft back of {size}",
        "friction": f"a plate that sticks, by {100 * (cause.size.value or 0):.0f} %,",
    }[cause.cause]


def cause_lines(result: Acceptance) -> list[str]:
    """Return a line for each cause that is nearly as likely as the likeliest."""
    least = SHOWN_FROM * result.causes[0].probability
    return [
        f"  {'cause' if number == 0 else '':14} {brief(cause).rstrip(',')}: {100 * cause.probability:.0f} %, "
        f"chi-square {cause.misfit:.3g} of {result.rows_used}"
        for number, cause in enumerate(result.causes)
        if cause.probability >= least
    ]


def next_step(result: Acceptance) -> str:
    """Return what to do next."""
    if result.passed:
        return "mount this part."
    if result.verdict == "can't tell" and result.in_from_share <= MOST_GOOD:
        share = f"{100 * result.in_from_share:.2g} %"
        return f"if {share} of your parts are good, this one is in: say so by `--good-share`."
    if result.verdict == "can't tell":
        causes = " ".join(
            f"--ruled-out {row.cause}" for row in result.causes if row.cause in ("ridge", "friction")
        )
        looked = f"look at the ridges and wet the plate, then add `{causes}`; or " if causes else ""
        return f"{looked}read finer, and say so by --force-error and --approach-error."
    return f"{STEPS.get(result.cause or '', 'measure the crests, and press again')}."


def figures(result: Acceptance) -> dict[str, Callable[[], Picture]]:
    """Return the rows and the curves of a good part."""
    from skincad.outputs.figures.results import acceptance_figure

    return {"accept.png": partial(acceptance_figure, result)}


def files(result: Acceptance) -> dict[str, Writer]:
    """Return the writers of the picture and of the words."""
    pictures = {name: picture(draw) for name, draw in figures(result).items()}
    return {"accept.txt": text(lambda: f"{result}\n"), **pictures}


ACCEPTANCE = Presentation(COMMAND=COMMAND, lines=lines, files=files, next_step=next_step, figures=figures)
