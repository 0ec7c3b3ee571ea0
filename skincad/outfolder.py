"""The out folder: a result appears whole or not at all, and an earlier one stays until then."""

from __future__ import annotations

import json
import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from skincad.errors import InputError

MANIFEST, SCENE_MANIFEST = "make.json", "simulate.json"
MANIFESTS = (MANIFEST, SCENE_MANIFEST)  # a folder with one was made here; it lists files that may be replaced
CIRCUIT_MANIFEST = "circuit.json"  # a circuit may have a design's name: neither job takes the other's files


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
            and not any((real / m).is_file() for m in (*MANIFESTS, CIRCUIT_MANIFEST))
        ):
            raise InputError(
                "-o", f"{folder} holds files and no earlier result", remedy="name a new or empty folder"
            )
    except OSError as failure:
        raise _unwritable(folder, failure) from None
    return real


@contextmanager
def replaced(folder: Path, manifests: tuple[str, ...] = MANIFESTS) -> Iterator[Path]:
    """Yield an empty folder to write into; when the block ends well it takes the place of `folder`.

    Files that an earlier result lists in one of the `manifests` go, all others in the folder are kept. Raises
    InputError, with nothing changed, when `folder` cannot be written, runs out of space or holds files
    and no earlier result.
    """
    real = checked_folder(folder)
    staging = real.parent / f".{real.name}.{secrets.token_hex(4)}.new"
    try:
        staging.mkdir(parents=True)
        yield staging
        if real.is_dir():
            _keep_others(real, staging, manifests)
            shutil.copystat(real, staging)
        _swap(staging, real)
    except OSError as failure:
        raise _unwritable(folder, failure) from failure
    finally:
        shutil.rmtree(staging, ignore_errors=True)


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
