"""Results as JSON that every reader takes: numbers are finite, or the result is none."""

from __future__ import annotations

import json
from typing import Any

from skincad.base.errors import RefusedError


def strict_json(data: dict[str, Any], indent: int | None = None) -> str:
    """Return the JSON of a result; raises RefusedError for a NaN or an infinite number in it.

    To be asked before anything is written: JSON has no such numbers, and nobody can use them.
    """
    try:
        return json.dumps(data, allow_nan=False, indent=indent)
    except ValueError:
        raise RefusedError("the result holds numbers that are not finite: nothing is written") from None
