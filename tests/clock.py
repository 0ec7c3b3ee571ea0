"""The clock of `auto` in tests: it runs by the models' prices, so that a busy machine changes no verdict."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import perf_counter
from typing import Any

import pytest

SECONDS_A_RIDGE = 0.1  # of the linear model, whose price is 1: about an idle core's
SECONDS_A_READING = 1e-3  # so that nothing takes no time


class PriceClock:
    """A clock that runs only while it is read and while models are."""

    def __init__(self) -> None:
        self.now = 0.0

    def read(self) -> float:
        """Return the time, s."""
        self.now += SECONDS_A_READING
        return self.now

    def loader(self, load: Callable[[str], Callable[..., Any]]) -> Callable[[str], Callable[..., Any]]:
        """Return the table's `load` with models that take their price."""
        from skincad.mechanics import MODELS
        from skincad.shape import skin_of

        def timed(name: str) -> Callable[..., Any]:
            answer = load(name)

            def run(design: Any, *rest: Any) -> Any:
                self.now += SECONDS_A_RIDGE * skin_of(design).count * MODELS[name].price
                return answer(design, *rest)

            return run

        return timed


@pytest.fixture(scope="session", autouse=True)
def price_clock() -> Iterator[PriceClock]:
    """Set the clock of checks, for fixtures of any scope too."""
    from skincad.mechanics import check
    from skincad.mechanics.models import table

    clock = PriceClock()
    with pytest.MonkeyPatch.context() as patch:
        for module in (check, table):
            patch.setattr(module, "perf_counter", clock.read)
        patch.setattr(table, "load", clock.loader(table.load))
        yield clock


@pytest.fixture
def real_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """Set the clock of checks back to the machine's."""
    from skincad.mechanics import check
    from skincad.mechanics.models import table

    for module in (check, table):
        monkeypatch.setattr(module, "perf_counter", perf_counter)
