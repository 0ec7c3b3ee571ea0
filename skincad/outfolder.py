"""The out folder: a result appears whole or not at all, and an earlier one stays until then.

It is written beside its place, as .<name>.<digits>.new, and put there by two renames. What a run that was
killed has left is put right by the next run into the same folder.
"""

from __future__ import annotations

import glob
import json
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from skincad.errors import InputError

try:
    import fcntl
except ImportError:  # no POSIX: runs into one folder at once are not kept apart
    fcntl = None  # type: ignore[assignment]

MANIFEST, SCENE_MANIFEST = "make.json", "simulate.json"
MANIFESTS = (MANIFEST, SCENE_MANIFEST)  # a folder with one was made here; it lists files that may be replaced
# a circuit may have a design's name, and ladders have it: no job takes another's files
CIRCUIT_MANIFEST, ACCURACY_MANIFEST = "circuit.json", "accuracy.json"


def checked_folder(folder: Path) -> Path:
    """Return the real path of an out folder that may be written; raises InputError otherwise.

    To be asked before any work: the folder may be new, empty, or an earlier result.
    """
    try:
        real = Path(os.path.realpath(folder))
        if Path.cwd().is_relative_to(real):
            raise InputError("-o", f"{folder} is the folder you are in", remedy="name one below it")
        if real.exists() and not real.is_dir():
            raise InputError("-o", f"{folder} is a file", remedy="name a folder")
        if (
            real.is_dir()
            and any(real.iterdir())
            and not any((real / m).is_file() for m in (*MANIFESTS, CIRCUIT_MANIFEST, ACCURACY_MANIFEST))
        ):
            raise InputError(
                "-o", f"{folder} holds files and no earlier result", remedy="name a new or empty folder"
            )
        probe = next(p for p in real.parents if os.path.lexists(p)) / _staging(real.name)
        probe.mkdir()  # only trying tells: permissions are not all that can stand in the way
        probe.rmdir()
    except OSError as failure:
        raise _unwritable(folder, failure) from None
    return real


@contextmanager
def replaced(folder: Path, manifests: tuple[str, ...] = MANIFESTS) -> Iterator[Path]:
    """Yield an empty folder to write into; when the block ends well it takes the place of `folder`.

    Files that an earlier result lists in one of the `manifests` go, all others in the folder are kept. Of two
    runs at once the later one's result stays. Raises InputError, with nothing changed, when `folder` cannot
    be written, runs out of space or holds files and no earlier result.
    """
    real = checked_folder(folder)
    staging = real.parent / _staging(real.name)
    try:
        real.parent.mkdir(parents=True, exist_ok=True)
        with _locked(real.parent):
            _put_right(real)
            staging.mkdir()
        with _locked(staging):  # for as long as this run lives
            yield staging
            with _locked(real.parent):
                if real.is_dir():
                    _keep_others(real, staging, manifests)
                    shutil.copystat(real, staging)
                _swap(staging, real)
    except OSError as failure:
        raise _unwritable(folder, failure) from failure
    finally:
        shutil.rmtree(staging, ignore_errors=True)


def _staging(name: str) -> str:
    return f".{name}.{secrets.token_hex(4)}.new"


@contextmanager
def _locked(folder: Path, wait: bool = True) -> Iterator[bool]:
    """Hold a folder's lock, which ends with the process; yield False where it is not to be had."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:  # a folder that may be written and not read
        yield False
        return
    try:
        yield _lock(handle, wait)
    finally:
        os.close(handle)


def _lock(handle: int, wait: bool) -> bool:
    if fcntl is None:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:  # another holds it, or the file system has no locks
        return False
    return True


def _put_right(folder: Path) -> None:
    """Bring back an earlier result from between the two renames, and remove what killed runs have left."""
    for old in folder.parent.glob(f".{glob.escape(folder.name)}.????????.old"):
        if not folder.exists():
            old.rename(folder)
        elif _others(old) <= {item.name for item in folder.iterdir()}:
            shutil.rmtree(old, ignore_errors=True)
    for left in folder.parent.glob(f".{glob.escape(folder.name)}.????????.new"):
        with _locked(left, wait=False) as dead:
            if dead:
                shutil.rmtree(left, ignore_errors=True)


def _unwritable(folder: Path, failure: OSError) -> InputError:
    return InputError("-o", f"{str(folder)[:80]} cannot be written ({failure.strerror or failure})")


def _listed(folder: Path, manifests: tuple[str, ...]) -> set[str]:
    """File names of the earlier result in this folder."""
    names = set(manifests)
    for manifest in manifests:
        try:
            names.update(map(str, json.loads((folder / manifest).read_text("utf-8"))["files"]))
        except (ValueError, KeyError, TypeError, OSError):
            continue  # not ours, or older: what it made stays
    return names


def _others(folder: Path) -> set[str]:
    """Names in this folder that no earlier result lists."""
    return {item.name for item in folder.iterdir()} - _listed(
        folder, (*MANIFESTS, CIRCUIT_MANIFEST, ACCURACY_MANIFEST)
    )


def _keep_others(folder: Path, staging: Path, manifests: tuple[str, ...]) -> None:
    ours = _listed(folder, manifests)
    for item in folder.iterdir():
        target = staging / item.name
        if item.name in ours or target.exists():
            continue
        if item.is_dir() and not item.is_symlink():
            shutil.copytree(item, target, symlinks=True, copy_function=_link)
        else:
            _link(item, target)


def _link(source: Path | str, target: Path | str) -> None:
    """Link where the file system can, copy where it can't."""
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:
        shutil.copy2(source, target, follow_symlinks=False)


def _swap(staging: Path, folder: Path) -> None:
    """Put `staging` in the place of `folder`; the old one goes back if anything comes between."""
    if not folder.exists():
        staging.rename(folder)
        return
    old = staging.with_suffix(".old")
    folder.rename(old)
    try:
        staging.rename(folder)
    except BaseException:
        old.rename(folder)
        raise
    shutil.rmtree(old, ignore_errors=True)
