"""Results into folders: the one place where a result becomes files, whole or not at all."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from html import escape
from pathlib import Path
from typing import Any

from skincad.base.errors import InputError, did_you_mean
from skincad.base.faces import imported
from skincad.base.outfolder import checked_folder, files_below, fresh, manifest_name, replaced
from skincad.base.progress import Progress, Stopwatch
from skincad.base.reading import strict_json
from skincad.base.result import Result, Writer, with_picture
from skincad.fabrication.papers import macro

PICTURES = ("png", "gif")
MOST_NAMED = 6  # files of a folder that are named
PAGES = ("report.html", "view.html", "study.html", "optimise.html")  # the first that is there says all


@dataclass(frozen=True)
class Delivery:
    """The files in `folder`: the manifest, other files with their size in bytes, and seconds by stage."""

    folder: Path
    manifest: str
    files: tuple[tuple[str, int], ...]
    seconds: dict[str, float]

    def sizes(self) -> list[dict[str, str | int]]:
        """Return the contract's `files`."""
        return [{"path": str(self.folder / name), "bytes": size} for name, size in self.files]

    def __str__(self) -> str:
        named = [*(name for name, _ in self.files), self.manifest]
        names = ": " + ", ".join(named) if len(named) <= MOST_NAMED else ""
        page = next((f"; open {self.folder / name}" for name in PAGES if name in named and not names), "")
        return f"{len(named)} files in {self.folder}{names}{page}"


def words_and_figure(result: Result) -> str:
    """Return the HTML of a result's words, with its first figure below."""
    if not result.presenter().figures(result):
        return f"<pre>{escape(str(result))}</pre>"
    return with_picture(str(result), result.figure())


@dataclass(frozen=True, kw_only=True)
class Presentation:
    """How one kind of result is shown: see `Presenter` in `skincad.base.result`.

    Its words are the macros `lines`, `next_step` and `details` of a text of templates/answers, which may ask
    for `facts`, the functions and numbers that the result itself does not have.
    """

    COMMAND: str
    words: str
    facts: Mapping[str, Any] = field(default_factory=dict)
    # of files that are no pictures, or drawn otherwise
    writers: Callable[[Any], dict[str, Writer]] = lambda _: {}
    html: Callable[[Any], str] = words_and_figure
    figures: Callable[[Any], dict[str, Callable[[], Any]]] = lambda _: {}
    manifest: Callable[[Any], dict[str, Any]] = lambda result: result.as_json()
    replaces: Callable[[Any, Path], None] = lambda *_: None  # raises InputError for what must be kept

    def files(self, result: Any) -> dict[str, Writer]:
        """Return a writer for each file, by its name; each figure is one."""
        writers = self.writers(result)
        drawings = {name: draw for name, draw in self.figures(result).items() if name not in writers}
        return writers | {name: picture(draw) for name, draw in drawings.items()}

    def said(self, name: str, *values: Any) -> str:
        """Return what a macro of the text makes of these values."""
        return macro(f"answers/{self.words}", name, *values, **self.facts)

    def rows(self, name: str, *values: Any) -> list[str]:
        """Return the lines of a macro."""
        return self.said(name, *values).split("\n")[:-1]

    def lines(self, result: Any) -> list[str]:
        """Return the answer, and how sure it is."""
        return self.rows("lines", result)

    def next_step(self, result: Any) -> str:
        """Return what to do next."""
        return "".join(self.rows("next_step", result))

    def details(self, result: Any) -> list[str]:
        """Return the numbers behind it."""
        return self.rows("details", result)


def write(
    result: Result, folder: Path | str, *, formats: Iterable[str] | str = (), progress: Progress | None = None
) -> Delivery:
    """Write a result's files and its manifest into `folder`, whole or not at all.

    `formats` are file name endings ("step", "png", ...); all if there are none. An earlier result of the same
    kind is replaced. Raises InputError, with nothing changed, for a folder that cannot take the files, holds
    other things, or a file that was changed since it was written; RefusedError for numbers not finite.
    """
    presenter, target, files = result.presenter(), Path(folder), result.files()
    chosen = {name: files[name] for name in of_formats(files, formats)}
    ready(target, presenter.COMMAND, chosen)
    presenter.replaces(result, target)
    strict_json(result.as_json())  # before anything is written
    watch = Stopwatch(progress)
    with replaced(target, presenter.COMMAND, presenter.manifest(result)) as staging:
        for name, writer in chosen.items():
            with watch.stage("picture" if _ending(name) in PICTURES else "files"):
                (staging / name).parent.mkdir(parents=True, exist_ok=True)
                writer(staging / name)
        sizes = tuple((name, path.stat().st_size) for name, path in files_below(staging).items())
    return Delivery(target, manifest_name(presenter.COMMAND), sizes, watch.seconds())


def save_picture(result: Result, path: Path | str, *, key: str = "path") -> bool:
    """Draw a result's first figure into a PNG file of its own; return whether it has one.

    Raises InputError, with nothing left behind, for a file that is there already or cannot be written; it
    calls the file `key`.
    """
    draws = result.presenter().figures(result)
    if not draws:
        return False
    with fresh(Path(path), key) as staging:
        picture(next(iter(draws.values())))(staging)
    return True


def ready(folder: Path, command: str, names: Iterable[str]) -> None:
    """Raise InputError, before any work, for an out folder that cannot take a command's files."""
    place = str(checked_folder(folder, command, names))
    if place.encode("utf-8", "replace").decode("utf-8") != place:  # the CAD kernel takes no other
        raise InputError("folder", "must be UTF-8", place, "name another folder, or set LC_ALL=C.UTF-8")


def of_formats(names: Iterable[str], formats: Iterable[str] | str) -> list[str]:
    """Return the names that end so, all where no format is named; InputError for one that no name has."""
    names, wanted = list(names), [formats] if isinstance(formats, str) else list(formats)
    endings = {_ending(name) for name in names}
    for ending in wanted:
        if ending not in endings:
            raise InputError("formats", "unknown format", ending, did_you_mean(ending, endings))
    return [name for name in names if not wanted or _ending(name) in wanted]


def _ending(name: str) -> str:
    return name.rpartition(".")[2]


def drawn(name: str, home: str) -> Callable[[Any], dict[str, Callable[[], Any]]]:
    """Return the figures of results that have one: by its file's name what draws it, a function of
    outputs/figures as "results:fit_figure", imported when it draws."""
    return lambda result: {name: lambda: imported(f"skincad.outputs.figures.{home}")(result)}


def text(of: Callable[[], str]) -> Writer:
    """Return the writer of a text, made when it is written."""

    def writer(path: Path) -> None:
        path.write_text(of(), encoding="utf-8")

    return writer


def picture(draw: Callable[[], Any]) -> Writer:
    """Return the writer of a figure as PNG, drawn when it is written."""

    def writer(path: Path) -> None:
        from skincad.outputs.figures.canvas import Picture, save

        figure = draw()
        assert isinstance(figure, Picture)
        save(figure, path)

    return writer
