"""A single file to write: it appears whole or not at all, and never over another."""

from __future__ import annotations

import secrets
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from skincad.base.errors import InputError


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
