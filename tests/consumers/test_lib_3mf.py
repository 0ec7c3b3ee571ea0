"""lib3mf in strict mode takes the 3MF files, and lets none pass that is not sound."""

from __future__ import annotations

import zipfile
from pathlib import Path

import lib3mf
import pytest

from tests.conftest import Made
from tests.consumers import Job, lib_3mf


def test_the_files_hold_the_parts_named_coloured_closed_and_of_their_volume(job: Job) -> None:
    assert lib_3mf.complaints(job) == []


def test_strict_mode_refuses_an_object_id_of_zero(made: Made, tmp_path: Path) -> None:
    """What the CAD library's own writer gives, and a slicer then calls not manifold."""
    with (
        zipfile.ZipFile(made.folder / "solids/skin.3mf") as good,
        zipfile.ZipFile(tmp_path / "bad.3mf", "w") as bad,
    ):
        for name in good.namelist():
            bad.writestr(name, good.read(name).replace(b'<object id="2"', b'<object id="0"'))
    with pytest.raises(lib3mf.ELib3MFException):
        lib_3mf.read(tmp_path / "bad.3mf")
