"""Files and folders that appear whole or not at all.

Only plain files that the same command's manifest lists, with the bytes that it tells, are ever replaced or
removed. A run writes into .skincad-<command>-<digits>/new in the folder. At its end the earlier result's
files move to old/ beside that and the new ones to their places; the manifest leaves first and comes last, so
that it lies only with a whole result, and files of two results are never mixed. If a run is killed meanwhile,
the next one undoes or finishes it, by the manifest in new/ and by what lies where.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import secrets
import stat
import sys
import time
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any

from skincad.base.errors import InputError, RefusedError
from skincad.base.interrupt import safe_point
from skincad.base.reading import strict_json
from skincad.base.version import __version__

COMMANDS = (  # each owns the files that its manifest lists
    "make", "simulate", "circuit", "accuracy", "check", "film-stress", "fit-material", "solve", "sweep",
    "optimise", "coupon", "coupon-reading", "package",
    "board", "export",
)  # fmt: skip
# a result may have folders of these names, one deep, and no others
FOLDERS = ("solids", "drawings", "film", "orders", "skincad_detector")


def manifest_name(command: str) -> str:
    """Return the name of a command's manifest."""
    return f"{command}.json"


def write_manifest(staging: Path, command: str, data: Mapping[str, Any]) -> None:
    """Write the manifest of all files in a folder, with the further keys of `data`.

    Raises RefusedError for a number that is not finite, which JSON has not.
    """
    name = manifest_name(command)
    hashes = {told: _hash(path) for told, path in files_below(staging).items() if told != name}
    head = {"skincad": __version__, "command": command}
    text = manifest_text({**head, **data, "files": list(hashes), "sha256": hashes})
    (staging / name).write_text(text, encoding="utf-8")


def manifest_text(data: Mapping[str, Any]) -> str:
    """Return a manifest as JSON with its own hash, which leaves out `seconds`: the same of the same input.

    Raises RefusedError for a number that is not finite.
    """
    bare = {key: value for key, value in data.items() if key != "manifest_sha256"}
    timeless = strict_json({key: value for key, value in bare.items() if key != "seconds"})
    bare["manifest_sha256"] = hashlib.sha256(timeless.encode()).hexdigest()
    return strict_json(bare, indent=1) + "\n"


def files_below(folder: Path) -> dict[str, Path]:
    """Return the files in a folder and in its `FOLDERS` by their names from there, as "solids/skin.stl"."""
    below = [folder / name for name in FOLDERS if _is_plain_folder(folder / name)]
    paths = [path for place in (folder, *below) if place.exists() for path in place.iterdir()]
    return dict(sorted((p.relative_to(folder).as_posix(), p) for p in paths if not _is_plain_folder(p)))


def _hash(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def listed(folder: Path, command: str) -> dict[str, str] | None:
    """Return the hash by file name that a command's manifest tells; None where skincad wrote none like this.

    Raises OSError for a manifest that cannot be read.
    """
    path = folder / manifest_name(command)
    try:
        if not stat.S_ISREG(path.lstat().st_mode):
            return None
        text = path.read_text("utf-8")
        data = json.loads(text)
        hashes = {str(name): str(digest) for name, digest in data["sha256"].items()}
        ours = data["command"] == command and text == manifest_text(data)
    except (FileNotFoundError, ValueError, KeyError, TypeError, AttributeError, RecursionError, RefusedError):
        return None
    return hashes if ours and all(_lies_below(name) for name in hashes) else None


def _lies_below(name: str) -> bool:
    """Whether a name is that of a file in a folder or in one of its `FOLDERS`."""
    place, stroke, bare = name.rpartition("/")
    return bare == Path(bare).name not in {"", ".."} and (place in FOLDERS or not stroke)


def unchanged(path: Path, digest: str) -> bool:
    """Return whether a path is a plain file of this hash; raises OSError for one that cannot be read."""
    return stat.S_ISREG(path.lstat().st_mode) and _hash(path) == digest


def checked_fresh(path: Path, suffix: str, key: str) -> None:
    """Raise InputError for a file that is there already, or whose name does not end in `suffix`."""
    try:
        there = path.exists() or path.is_symlink()
    except OSError as failure:
        raise _unwritable(path, key, failure) from None
    if there:
        raise InputError(key, f"{str(path)[:80]} exists already", remedy="name another file, or remove it")
    if path.suffix != suffix:
        raise InputError(key, f"{str(path)[:80]} must end in {suffix}")


@contextmanager
def fresh(path: Path, key: str) -> Iterator[Path]:
    """Yield a path to write to; when the block ends well the file takes the name `path`.

    Raises InputError, with nothing left behind, for a file that is there already or cannot be written;
    `key` is the option that named it.
    """
    checked_fresh(path, path.suffix, key)
    staging = path.with_name(f".{path.name}.{secrets.token_hex(4)}.new")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        yield staging
        checked_fresh(path, path.suffix, key)  # a person may have written it meanwhile
        staging.replace(path)
    except OSError as failure:
        raise _unwritable(path, key, failure) from None
    finally:
        with suppress(OSError):
            staging.unlink(missing_ok=True)


def _unwritable(path: Path, key: str, failure: OSError) -> InputError:
    return InputError(key, f"{str(path)[:80]} cannot be written ({failure.strerror or failure})")


try:
    import fcntl
except ImportError:  # no POSIX: runs into one folder at once are not kept apart
    fcntl = None  # type: ignore[assignment]

OURS = ".skincad-"  # so begins the name of whatever lies in the folder only while runs write there
RUN = re.compile(rf"{re.escape(OURS)}({'|'.join(COMMANDS)})-[0-9a-f]{{8}}")
# what stands in nobody's way: what a new volume holds, a study's log, and a package's and a detector's folder
BESIDE = {"lost+found", "evaluations.jsonl", "package", "detector"}
PATIENCE, POLL = 1.0, 0.05  # s: until a wait is reported; between two attempts


def checked_folder(folder: Path, command: str = "make", names: Iterable[str] = ()) -> Path:
    """Return the real path of an out folder where `command` may write; raises InputError otherwise.

    To be asked before any work: the folder may be new, empty, or hold earlier results, whose files are as
    they were written; no other file may have one of the `names`. What killed runs left there is put right.
    """
    try:
        real = Path(os.path.realpath(folder))
        with suppress(FileNotFoundError):  # a working directory that was deleted lies nowhere
            if Path.cwd().is_relative_to(real):
                raise InputError("folder", f"{folder} is the folder you are in", remedy="name one below it")
        there = next(path for path in (real, *real.parents) if os.path.lexists(path))
        if there == real:
            if not real.is_dir():
                raise InputError("folder", f"{folder} is a file", remedy="name a folder")
            with _locked(real):
                _put_right(real)
                _earlier(real, command, names)
                _try_to_write(real, command)
        else:
            for part in real.relative_to(there).parts:
                with suppress(FileNotFoundError):
                    os.lstat(there / part)  # tells a name that is too long
            _try_to_write(there, command)
    except OSError as failure:
        raise _unwritable(folder, "folder", failure) from None
    return real


@contextmanager
def replaced(folder: Path, command: str = "make", data: Mapping[str, Any] | None = None) -> Iterator[Path]:
    """Yield an empty folder to write into; when the block ends well its files replace the earlier result's.

    `data` are the manifest's keys beside the files. Of two runs at once the later one's result
    stays. Raises InputError, with nothing changed, when `folder` cannot be written, runs out of space, holds
    things and no earlier result, or holds a file of these names that is not as this command wrote it;
    RefusedError when `data` holds a number that is not finite.
    """
    real = checked_folder(folder, command)
    new_folders = [path for path in (real, *real.parents) if not path.exists()]
    run = real / _run_name(command)
    staging = run / "new"
    try:
        real.mkdir(parents=True, exist_ok=True)
        with ExitStack() as alive:
            with _locked(real):
                staging.mkdir(parents=True)
                alive.enter_context(_locked(run))  # for as long as this run lives
            yield staging
            write_manifest(staging, command, data or {})
            with _locked(real):
                _put_in_place(run, command)
    except OSError as failure:
        raise _unwritable(folder, "folder", failure) from failure
    finally:
        if not (run / "old").exists():  # else what it holds could not go back: the next run tries again
            _discard(run)
        with suppress(OSError):  # not empty: there is a result, or another run
            for path in new_folders:
                path.rmdir()


def _try_to_write(folder: Path, command: str) -> None:
    """Raise OSError where no folder can be made: permissions are not all that can stand in the way."""
    probe = folder / _run_name(command)  # if this run is killed here, the next one removes it
    probe.mkdir()
    with suppress(FileNotFoundError):  # a run in this folder may have taken it for a killed one's
        probe.rmdir()


def _run_name(command: str) -> str:
    return f"{OURS}{command}-{secrets.token_hex(4)}"


def _earlier(folder: Path, command: str, names: Iterable[str]) -> list[str]:
    """File names of the command's earlier result, the manifest first.

    Raises InputError where something stands in the way: a file of it that was changed since, a file of one
    of the `names` that is not of it, a manifest that skincad did not write, or a folder of other things.
    """
    manifest, hashes = manifest_name(command), listed(folder, command)
    if hashes is None and os.path.lexists(folder / manifest):
        raise _in_the_way(folder / manifest)
    others = any(not item.name.startswith(OURS) and item.name not in BESIDE for item in folder.iterdir())
    if others and all(listed(folder, other) is None for other in COMMANDS):
        raise InputError(
            "folder", f"{folder} holds files but no earlier result", remedy="name a new or empty folder"
        )
    earlier = [] if hashes is None else [manifest]
    for name in dict.fromkeys((*(hashes or ()), *names)):
        path = folder / name
        if name != manifest and os.path.lexists(path):
            if hashes is None or name not in hashes or not unchanged(path, hashes[name]):
                raise _in_the_way(path)
            earlier.append(name)
    for below in {(folder / name).parent for name in (*names, *earlier)}:
        if os.path.lexists(below) and not _is_plain_folder(below):
            raise _in_the_way(below)
    return earlier


def _is_plain_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _in_the_way(path: Path) -> InputError:
    return InputError(
        "folder",
        f"{path} was not written by skincad, or was changed since",
        remedy="move it away or name another folder",
    )


def _put_in_place(run: Path, command: str) -> None:
    """Let the run's files take the places of the earlier result's; the folder is locked meanwhile."""
    folder, new, old, manifest = run.parent, run / "new", run / "old", manifest_name(command)
    names = sorted(files_below(new), key=lambda name: name == manifest)
    earlier = _earlier(folder, command, names)
    try:
        old.mkdir()
        for name in earlier:
            _move(folder / name, old / name)
        for name in names:
            _move(new / name, folder / name)
    finally:
        _settle(run)


def _settle(run: Path) -> None:
    """Undo what a run had begun to put in place, unless all is there, and remove its folder.

    It may be killed at any point and asked again: the new files are all back before an old one goes back.
    """
    folder, new, old = run.parent, run / "new", run / "old"
    command = RUN.fullmatch(run.name)[1]  # type: ignore[index]
    manifest = manifest_name(command)
    earlier = sorted(files_below(old), key=lambda name: name == manifest)
    come = listed(new, command) or {}
    if (new / manifest).exists() and old.exists():  # it comes last
        for name, digest in come.items():
            if not (new / name).exists() and os.path.lexists(folder / name):
                if not unchanged(folder / name, digest):
                    raise _in_the_way(folder / name)
                _move(folder / name, new / name)
        for name in earlier:
            _move(old / name, folder / name)
    for below in {(folder / name).parent for name in (*earlier, *come)} - {folder}:
        with suppress(OSError):  # it holds files
            below.rmdir()
    _discard(run)


def _move(source: Path, target: Path) -> None:
    if os.path.lexists(target):
        raise _in_the_way(target)
    target.parent.mkdir(parents=True, exist_ok=True)
    source.rename(target)


def _put_right(folder: Path) -> None:
    """Undo or finish what killed runs had begun to put in place, and remove what they left."""
    for run in [path for path in folder.iterdir() if RUN.fullmatch(path.name) and _is_plain_folder(path)]:
        if (run / "old").exists():  # only while the folder is locked, by us now
            _settle(run)
            continue
        with _locked(run, wait=False) as dead:
            if dead:
                _discard(run)


def _discard(run: Path) -> None:
    """Remove a run's folder and the files in it; whatever else somebody has put there stays.

    old/ goes first: a folder without it has nothing to be undone.
    """
    with suppress(OSError):
        for part in (run / "old", run / "new"):
            for path in files_below(part).values():
                path.unlink()
            for place in (*(part / name for name in FOLDERS), part):
                if place.exists():
                    place.rmdir()
        run.rmdir()


@contextmanager
def _locked(folder: Path, wait: bool = True) -> Iterator[bool]:
    """Hold a folder's lock, which ends with the process; yield False where it is not to be had."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:  # a folder that may be written and not read
        yield False
        return
    try:
        yield _lock(handle, folder, wait)
    finally:
        os.close(handle)


def _lock(handle: int, folder: Path, wait: bool) -> bool:
    patient_until = time.monotonic() + PATIENCE
    while fcntl is not None:
        safe_point()
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if not wait:
                return False
        except OSError:  # the file system has no locks
            return False
        else:
            return True
        if time.monotonic() >= patient_until:
            patient_until = math.inf
            if sys.stderr is not None:
                print(f"skincad: waiting for another skincad run in {folder}", file=sys.stderr)
        time.sleep(POLL)
    return False
