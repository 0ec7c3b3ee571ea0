"""The exam of `accept`, on few parts of one template."""

from __future__ import annotations

import pytest

from bench import table_accept as exam


@pytest.mark.slow
def test_no_good_part_is_out_and_no_faulty_one_in(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exam, "TEMPLATES", ("plain-ridges",))
    one, finer = exam.SETTINGS[0], exam.Setting("finer", errors=exam.FINE)
    results = []
    for seed, fault in enumerate(["", "", "", *exam.FAULTS], 22000):
        trial = exam.trial(seed, fault)
        results += [(fault, exam.called(trial, setting)) for setting in (one, finer)]
    wrong = [(fault, r.verdict) for fault, r in results if r.verdict == ("in" if fault else "out")]
    assert not wrong
    called = {fault: r.cause for fault, r in results if r.verdict == "out"}
    assert called.keys() >= {"softer", "stiffer"}
    assert called["stiffer"] == "modulus"
    assert "right of those called" in "\n".join(exam.table(results))
