"""What tiers took on this machine: kept in the user's cache folder by `skincad accuracy`, read by their laws.

One JSON file, `cost-law.json`, of numbers that a person can read and may delete at any time. What another
machine or other versions took is not asked; a file that cannot be read is told, and as good as none.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from pydantic import BaseModel, ConfigDict, PositiveFloat, ValidationError

from skincad.base.machine import machine

FOLDER = "SKINCAD_CACHE"  # the environment variable that moves the cache
NAME = "cost-law.json"


class Taken(BaseModel):
    """What a tier's own part took on a design: the size that its law is asked at, and s."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)
    size: PositiveFloat
    seconds: PositiveFloat


class _File(BaseModel):
    """The file: `measured` by tier and design."""

    what: str = "seconds of check's tiers on this machine, by tier and design; may be deleted at any time"
    machine: dict[str, Any]
    measured: dict[str, dict[str, Taken]]


@dataclass(frozen=True)
class Kept:
    """What is kept by tier and design; `trouble` says why it is not read, "" where it is or there is none."""

    taken: Mapping[str, Mapping[str, Taken]] = field(default_factory=dict)
    trouble: str = ""


def place() -> Path:
    """Return where the file lies, or would; raises RuntimeError where there is no home."""
    if given := os.environ.get(FOLDER):
        return Path(given).absolute() / NAME
    told = os.environ.get("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME", "")
    folder = Path(told) if Path(told).is_absolute() else Path.home() / ".cache"
    return folder / "skincad" / NAME


def shown(path: Path) -> str:
    """Return a path without the user's name in it."""
    try:
        home = Path.home()
    except RuntimeError:
        return str(path)
    return str("~" / path.relative_to(home)) if path.is_relative_to(home) else str(path)


def kept() -> Kept:
    """Return what is kept on this machine."""
    try:
        path = place()
        stamp = path.stat()
    except (OSError, RuntimeError):
        return Kept()
    return _read(path, stamp.st_mtime_ns, stamp.st_size)


def keep(design: str, taken: Mapping[str, Taken]) -> Path:
    """Add what tiers took on a design to the file, in the place of what they took before; return where.

    Raises OSError or RuntimeError where the folder cannot take it.
    """
    path = place()
    measured = {tier: dict(by_design) for tier, by_design in kept().taken.items()}
    for tier, one in taken.items():
        measured.setdefault(tier, {})[design] = one
    text = _File(machine=_here(), measured=measured).model_dump_json(indent=1)
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = path.with_name(f".{NAME}-{secrets.token_hex(4)}")  # beside it, and then in its place at once
    try:
        whole.write_text(text + "\n", "utf-8")
        whole.replace(path)
    finally:
        whole.unlink(missing_ok=True)
    return path


@lru_cache(maxsize=1)
def _read(path: Path, _stamp: int, _size: int) -> Kept:
    """The file's contents; read again only once it has changed."""
    try:
        found = _File.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return Kept(trouble=f"{shown(path)} is no cost law that can be read, and is ignored: delete it")
    return Kept(found.measured if found.machine == _here() else {})


@cache
def _here() -> dict[str, Any]:
    """Processor, cores and versions; their load is not theirs."""
    return {key: value for key, value in machine().items() if key != "load"}
