"""What a mold takes: plates, sums, errors and prices."""

from __future__ import annotations

import csv
import math

import pytest

import skincad
from skincad.base import Estimate, InputError
from skincad.fabrication import Job, by_part, casting_sheet, laid, laid_on_end, mesh, parts_csv, print_chord
from skincad.fabrication.estimates import ProcessEstimate, estimates, exposure_time, lines
from skincad.fabrication.parts_list import ESTIMATED, HEADS, ORDERED
from skincad.inputs import Design, processes
from skincad.solids.mold import mold
from tests.templates import SHIPPED, of_one_printer


def estimated(design: Design) -> tuple[ProcessEstimate, ...]:
    closed = mold(design)
    parts = [part for part in closed.parts if part.made == "made"]
    prints = {p.name: laid(mesh(p, print_chord(design)), laid_on_end(Job(design), p), p) for p in parts}
    return estimates(Job(design, closed), prints)


@pytest.mark.parametrize("name", SHIPPED)
def test_every_made_part_has_estimates_with_errors(name: str) -> None:
    design = skincad.load(name)
    processes = estimated(design)
    assert sorted(by_part(processes)) == sorted(p.name for p in mold(design).parts if p.made == "made")
    for estimate in (*processes, *by_part(processes).values()):
        for number in (estimate.mass, estimate.time, estimate.cost):
            assert number.error is not None
            assert 0 < number.error < float(number)
    for estimate in processes:
        assert float(estimate.mass) == pytest.approx(sum(float(part.mass) for part in estimate.parts))
        assert float(estimate.cost) == pytest.approx(sum(float(part.cost) for part in estimate.parts))


def test_resin_takes_the_tallest_part_of_each_plate() -> None:
    """lab-bench: the cavity, 23.1 mm high, and what lies beside it; the cover does not fit there."""
    design = of_one_printer("lab-bench")
    (resin,) = estimated(design)
    sla = processes()["sla"]
    assert resin.plates == 2
    assert float(resin.time) == pytest.approx((exposure_time(23.1, sla) + exposure_time(4.0, sla)) / 3600)
    assert float(resin.time) < sum(float(part.time) for part in resin.parts)
    (one,) = estimated(of_one_printer("lab-bench", ["printer.sla.build_y=120.0"]))
    assert one.plates == 1
    assert float(one.time) == pytest.approx(exposure_time(23.1, sla) / 3600)


def test_filament_takes_all_parts_one_after_the_other() -> None:
    (filament,) = estimated(of_one_printer("nozzle-04"))
    assert filament.plates == 1
    assert float(filament.time) == pytest.approx(sum(float(part.time) for part in filament.parts))


def test_parts_of_two_processes_are_told_apart() -> None:
    design = skincad.load("milled-pad")
    processes = estimated(design)
    assert [(estimate.process, len(estimate.parts), estimate.plates) for estimate in processes] == [
        ("cnc", 3, 0),
        ("edm", 4, 0),
    ]
    assert [line[:16] for line in lines(Job(design), processes)] == ["By cnc, 3 parts:", "By edm, 4 parts:"]


def test_cost_is_material_machine_and_setup() -> None:
    """Of lab-bench by hand; and where prices are known, its error is that of mass and time."""
    (resin,) = estimated(of_one_printer("lab-bench"))
    sla = processes()["sla"]
    material = float(resin.mass) / 1000 * (1 + sla.waste) * sla.price
    machine, setup = float(resin.time) * sla.rate, resin.plates * sla.setup / 60 * sla.rate
    assert float(resin.cost) == pytest.approx(material + machine + setup)
    (sure,) = estimated(of_one_printer("lab-bench", ["printer.sla.price_error=0.0"]))
    assert sure.cost.error == pytest.approx(material * sla.mass_error + machine * sla.time_error)


def test_a_workshops_own_prices_count() -> None:
    (shipped,) = estimated(of_one_printer("lab-bench"))
    (priced,) = estimated(of_one_printer("lab-bench", ["printer.sla.price=0.0", "printer.sla.rate=20.0"]))
    setup, hours = 2 * 45 / 60, float(shipped.time)
    assert float(priced.cost) == pytest.approx(20.0 * (hours + setup))
    assert priced.mass == shipped.mass


@pytest.mark.parametrize(
    ("key", "value"),
    [("density", 0.0), ("infill", 1.5), ("loops", 0), ("loops", 2.5), ("outer_speed", 0.0), ("price", -1.0)],
)
def test_bad_keys_are_refused(key: str, value: float) -> None:
    with pytest.raises(InputError, match=rf"^printer.fdm.{key}: "):
        of_one_printer("nozzle-04", [f"printer.fdm.{key}={value}"])


def test_the_parts_list_has_them_beside_the_volumes() -> None:
    design = skincad.load("plain-ridges")
    closed, processes = mold(design), estimated(design)
    head, *rows = parts_csv(Job(design, closed), processes).splitlines()
    assert head.split(",") == [*HEADS, *ESTIMATED, *ORDERED]
    cover = by_part(processes)["cover"]
    (row,) = (row for row in rows if row.split(",")[2] == "cover")
    cells = [
        f"{n:.4g}" for e in (cover.mass, cover.time, cover.cost) for n in (float(e), e.error or math.nan)
    ]
    assert ",".join([*cells, cover.basis]) in row
    bought = [row for row in csv.DictReader([head, *rows]) if row["made_by"] == "bought"]
    assert not any(row[key] for row in bought for key in ESTIMATED)


def test_the_sheet_says_them_in_a_line() -> None:
    design = skincad.load("plain-ridges")
    closed, processes = mold(design), estimated(design)
    text = casting_sheet(Job(design, closed), [], "Passes.", True, None, processes)
    assert f"Estimates. {lines(Job(design), processes)[0]}" in text
    assert "Estimates" not in casting_sheet(Job(design, closed), [], "Passes.", True)
    assert "5 parts on 1 plate:" in text


def test_an_estimate_keeps_its_unit() -> None:
    (resin,) = estimated(skincad.load("plain-ridges"))
    assert isinstance(resin.mass, Estimate)
    assert (resin.mass.unit, resin.time.unit, resin.cost.unit) == ("g", "h", "EUR")
