"""The films' stress as functionals of the condensed unknowns; what they say is tested with the scenes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import ngsolve as ngs
import pytest

from skincad.scenes import LEVELS, at_level
from tests.small_scene import THIRD, small_scene


def test_a_mesh_takes_four_linear_forms_whatever_strips_it_has(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each takes a timer of the library's for good, and after 8192 it says so on every line of a study."""
    forms: list[object] = []
    plain = ngs.LinearForm

    def counted(*arguments: Any, **options: Any) -> Any:
        forms.append(arguments)
        return plain(*arguments, **options)

    monkeypatch.setattr(ngs, "LinearForm", counted)
    at_level(
        small_scene(tmp_path, "yamada-2002-press", "history.steps=2", "readout.ridges=[2]", THIRD), LEVELS[0]
    )
    assert len(forms) == 4
