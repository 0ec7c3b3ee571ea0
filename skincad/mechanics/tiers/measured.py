"""Measured times of tiers on this machine: `skincad accuracy` writes them, the cost model reads them.

They stand in one JSON file, `cost-law.json`, in the user's cache folder. A person can read it and may delete
it at any time. Times of another machine or of other versions are not used. A file that cannot be read is
ignored with a warning.
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

FOLDER_VARIABLE = "SKINCAD_CACHE"  # the environment variable that moves the cache
FILE_NAME = "cost-law.json"


class TierTiming(BaseModel):
    """Time of a tier's own part on a design: the size for its cost model, and seconds."""

    model_config = ConfigDict(frozen=True, allow_inf_nan=False)
    size: PositiveFloat
    seconds: PositiveFloat


class _File(BaseModel):
    """The file: `measured` by tier and design."""

    what: str = "seconds of check's tiers on this machine, by tier and design; may be deleted at any time"
    machine: dict[str, Any]
    measured: dict[str, dict[str, TierTiming]]


@dataclass(frozen=True)
class TimingCache:
    """Timings by tier and design; `trouble` says why the file is ignored, "" if it is read or missing."""

    timings: Mapping[str, Mapping[str, TierTiming]] = field(default_factory=dict)
    trouble: str = ""


def cache_file() -> Path:
    """Return the path of the cache file, which may not exist; raises RuntimeError without a home folder."""
    if chosen_folder := os.environ.get(FOLDER_VARIABLE):
        return Path(chosen_folder).absolute() / FILE_NAME
    cache_home = os.environ.get("LOCALAPPDATA" if os.name == "nt" else "XDG_CACHE_HOME", "")
    folder = Path(cache_home) if Path(cache_home).is_absolute() else Path.home() / ".cache"
    return folder / "skincad" / FILE_NAME


def without_home(path: Path) -> str:
    """Return a path without the user's name in it."""
    try:
        home = Path.home()
    except RuntimeError:
        return str(path)
    return str("~" / path.relative_to(home)) if path.is_relative_to(home) else str(path)


def timing_cache() -> TimingCache:
    """Return the timings measured on this machine."""
    try:
        path = cache_file()
        stamp = path.stat()
    except (OSError, RuntimeError):
        return TimingCache()
    return _read(path, stamp.st_mtime_ns, stamp.st_size)


def save_timings(design: str, timings: Mapping[str, TierTiming]) -> Path:
    """Write the timings of tiers on a design to the cache file, replacing earlier ones; return its path.

    Raises OSError or RuntimeError if the file cannot be written.
    """
    path = cache_file()
    measured = {tier: dict(by_design) for tier, by_design in timing_cache().timings.items()}
    for tier, one in timings.items():
        measured.setdefault(tier, {})[design] = one
    text = _File(machine=_here(), measured=measured).model_dump_json(indent=1)
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = path.with_name(
        f".{FILE_NAME}-{secrets.token_hex(4)}"
    )  # written beside it, then moved into its place
    try:
        whole.write_text(text + "\n", "utf-8")
        whole.replace(path)
    finally:
        whole.unlink(missing_ok=True)
    return path


@lru_cache(maxsize=1)
def _read(path: Path, _stamp: int, _size: int) -> TimingCache:
    """The file's contents; read again only once it has changed."""
    try:
        contents = _File.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return TimingCache(
            trouble=f"{without_home(path)} is no cost law that can be read, and is ignored: delete it"
        )
    return TimingCache(contents.measured if contents.machine == _here() else {})


@cache
def _here() -> dict[str, Any]:
    """Processor, cores and versions, without the load."""
    return {key: value for key, value in machine().items() if key != "load"}
