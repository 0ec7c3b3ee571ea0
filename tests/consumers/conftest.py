"""One `make` of each template for all consumers: yamada-2002 always, the others among the slow tests."""

from __future__ import annotations

import pytest

import skincad
from tests.conftest import files_into
from tests.consumers import Job
from tests.families import RIDGED

READ = ("step", "stl", "3mf", "dxf", "md")  # all that a consumer opens


def _marks(name: str) -> list[pytest.MarkDecorator]:
    together = pytest.mark.xdist_group(name)  # a template is made once, by the worker that looks at it
    return [together] if name == "yamada-2002" else [together, pytest.mark.slow]


@pytest.fixture(scope="session", params=[pytest.param(name, marks=_marks(name)) for name in RIDGED])
def job(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Job:
    design = skincad.load(request.param)
    if request.param == "yamada-2002":
        return Job(design, request.getfixturevalue("made"))
    return Job(design, files_into(design, tmp_path_factory.mktemp("made") / request.param, READ))
