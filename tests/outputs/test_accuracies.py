"""The ladders' tables in words."""

from __future__ import annotations

from skincad.outputs.accuracies import ladder_lines
from skincad.studies import Ladder, Measurement, measures_of


def test_a_measure_has_a_readers_name_above_its_column() -> None:
    point = Measurement("linear", "fineness 1", 10, (1.0,), {"mesh F9": 0.12, "whole approach": 0.34})
    text = list(ladder_lines(Ladder("contact", "contact of a skin", (point,), measures_of({}, ""))))
    assert not [line for line in text if "F9" in line]
    for name, value in (("mesh all-touch force", "0.12"), ("whole approach", "0.34")):
        head, row = text[1].index(name) + len(name), text[2].index(value) + len(value)
        assert head - row in (0, 1), text  # a star may stand after the value
