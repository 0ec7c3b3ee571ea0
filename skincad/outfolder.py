"""The out folder: a result appears whole or not at all, and an earlier one stays until then."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from skincad.errors import InputError

MANIFEST = "make.json"  # a folder that holds one was made here and may be replaced


@contextmanager
def replaced(folder: Path, ours: frozenset[str]) -> Iterator[Path]:
    """Yield an empty folder to write into; when the block ends well it takes the place of `folder`.

    `ours` are the file names an earlier result may have written; all other files in it are kept. Raises
    InputError, with nothing changed, when `folder` cannot be written, runs out of space or holds files
    and no earlier result.
    """
    folder = Path(os.path.realpath(folder))
    if folder.is_dir() and any(folder.iterdir()) and not (folder / MANIFEST).is_file():
        raise InputError(
            "-o",
            f"{folder} holds files and no earlier result of skincad",
            remedy="name a new or empty folder",
        )
    staging: Path | None = None
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        staging = Path(tempfile.mkdtemp(prefix=f".{folder.name}.", suffix=".new", dir=folder.parent))
        yield staging
        _keep_others(folder, staging, ours)
        staging.chmod(0o777 & ~_umask())
        _swap(staging, folder)
    except OSError as failure:
        raise InputError("-o", f"{folder} cannot be written ({failure.strerror or failure})") from failure
    finally:
        if staging is not None:
            shutil.rmtree(staging, ignore_errors=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def _keep_others(folder: Path, staging: Path, ours: frozenset[str]) -> None:
    if not folder.is_dir():
        return
    for item in folder.iterdir():
        target = staging / item.name
        if item.name in ours or target.exists():
            continue
        if item.is_dir() and not item.is_symlink():
            shutil.copytree(item, target, symlinks=True, copy_function=os.link)
        else:
            os.link(item, target, follow_symlinks=False)


def _swap(staging: Path, folder: Path) -> None:
    """Put `staging` in the place of `folder`; the old one goes back if the second rename fails."""
    if not folder.exists():
        staging.rename(folder)
        return
    old = staging.with_suffix(".old")
    folder.rename(old)
    try:
        staging.rename(folder)
    except OSError:
        old.rename(folder)
        raise
    shutil.rmtree(old, ignore_errors=True)
