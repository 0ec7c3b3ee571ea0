"""One `make` of each template with ridges for all consumers: yamada-2002 is slow, the others are evidence."""

from __future__ import annotations

import pytest

import skincad
from tests.conftest import files_into
from tests.consumers import Job, consumed
from tests.families import RIDGED

READ = ("step", "stl", "3mf", "dxf", "md")  # all that a consumer opens


@pytest.fixture(scope="session", params=[consumed(name) for name in RIDGED])
def job(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Job:
    design = skincad.load(request.param)
    if request.param == "yamada-2002":
        return Job(design, request.getfixturevalue("made"))
    return Job(design, files_into(design, tmp_path_factory.mktemp("made") / request.param, READ))
