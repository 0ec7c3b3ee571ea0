"""What every result offers: words, JSON, figures and files. Computing writes nothing; `write` does."""

from __future__ import annotations

import base64
import html
import io
from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, Protocol, cast

Figure = Any  # matplotlib's, which outputs/ alone names
Writer = Callable[[Path], None]
LONGEST_REPR = 200  # letters: a line of a console, not a page


class Presenter(Protocol):
    """What shows one kind of result: a module of outputs/, or a `Presentation`."""

    COMMAND: str  # whose manifest lists the files

    def lines(self, result: Any, /) -> list[str]:
        """Return what the command prints."""

    def files(self, result: Any, /) -> dict[str, Writer]:
        """Return a writer for each file, by its name."""

    def figures(self, result: Any, /) -> Mapping[str, Callable[[], Figure]]:
        """Return what draws each figure, by its name."""

    def manifest(self, result: Any, /) -> Mapping[str, Any]:
        """Return what the manifest says of the result beside its files."""


class Result(ABC):
    """A frozen answer. `shown_by` names what shows it, imported when it is asked: a module of outputs/, or
    after a colon one of a module's `Presentation`s."""

    shown_by: ClassVar[str]

    @abstractmethod
    def as_json(self) -> dict[str, Any]:
        """Return the object that `--json` prints: numbers with their unit in the key, errors beside them."""

    @property
    def exit_status(self) -> int:
        """What a command that computes it exits with: 0 done and passed, 1 a check failed or is undecided."""
        return 0

    def presenter(self) -> Presenter:
        """Return what shows results of this kind."""
        module, _, name = self.shown_by.partition(":")
        shown = import_module(module)
        return cast(Presenter, getattr(shown, name) if name else shown)

    def files(self) -> dict[str, Writer]:
        """Return name -> writer; a writer takes the path to write to. `skincad.write` writes them all."""
        return self.presenter().files(self)

    def figures(self) -> dict[str, Figure]:
        """Return all matplotlib figures by name, drawn now."""
        return {name: draw() for name, draw in self.presenter().figures(self).items()}

    def figure(self, name: str | None = None) -> Figure:
        """Return the matplotlib figure of this name, the first one if None; KeyError lists the names."""
        draws = self.presenter().figures(self)
        if not draws or (name is not None and name not in draws):
            raise KeyError(f"no figure {name or 'here'}; there are: {', '.join(draws) or 'none'}")
        return draws[name or next(iter(draws))]()

    def __str__(self) -> str:
        return "\n".join(self.presenter().lines(self))

    def __repr__(self) -> str:
        text = f"<{type(self).__name__} {str(self).partition(chr(10))[0]}"
        return text[: LONGEST_REPR - 4] + "...>" if len(text) >= LONGEST_REPR else text + ">"

    def _repr_html_(self) -> str:
        """The words, and the first figure, for a notebook."""
        words = f"<pre>{html.escape(str(self))}</pre>"
        if not self.presenter().figures(self):
            return words
        picture = io.BytesIO()
        self.figure().savefig(picture, format="png")
        return f'{words}<img src="data:image/png;base64,{base64.b64encode(picture.getvalue()).decode()}">'
