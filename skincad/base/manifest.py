"""A manifest: what a command says in its out folder of the files that it wrote, each with its hash."""

from __future__ import annotations

import hashlib
import json
import stat
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skincad.base.errors import RefusedError
from skincad.base.strictjson import strict_json
from skincad.base.version import __version__

# each owns the files that its manifest lists
COMMANDS = (
    "make",
    "simulate",
    "circuit",
    "accuracy",
    "check",
    "film-stress",
    "fit-material",
    "solve",
    "sweep",
    "optimise",
    "coupon",
    "coupon-reading",
    "package",
)


def manifest_name(command: str) -> str:
    """Return the name of a command's manifest."""
    return f"{command}.json"


def write_manifest(staging: Path, command: str, data: Mapping[str, Any]) -> None:
    """Write the manifest of all files in a folder, with what else is `told`.

    Raises RefusedError for a number that is not finite, which JSON has not.
    """
    name = manifest_name(command)
    hashes = {path.name: _hash(path) for path in sorted(staging.iterdir()) if path.name != name}
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
    return hashes if ours and all(name == Path(name).name for name in hashes) else None


def unchanged(path: Path, digest: str) -> bool:
    """Return whether a path is a plain file of this hash; raises OSError for one that cannot be read."""
    return stat.S_ISREG(path.lstat().st_mode) and _hash(path) == digest
