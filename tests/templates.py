"""The templates for tests of seconds: those that are another size of a kind of mold are among the slow."""

from __future__ import annotations

import pytest

from skincad.inputs.catalog import template_names

# as yamada-2002, by edm; lab-bench as plain-ridges, by sla
OTHER_SIZES = {"fingertip-soft", "gripper-pad", "steep-fingertip", "lab-bench"}
KINDS = [
    pytest.param(name, marks=[pytest.mark.slow] if name in OTHER_SIZES else []) for name in template_names()
]
