"""Films that can be bought: which fit a design's slots and why, and by what its strips are cut."""

from __future__ import annotations

import datetime
import json
from pathlib import Path

import numpy as np
import pytest

import skincad
from skincad.fabrication import (
    CUTTERS,
    FilmOffer,
    FilmOffers,
    Job,
    Ply,
    bending,
    electrode_findings,
    film_offers,
    sheet_steps,
)
from skincad.inputs import film_products
from tests.conftest import run_skincad
from tests.designs import SHIPPED
from tests.refusals import refused_by, refused_command

FILMED = [name for name in SHIPPED if skincad.load(str(name.values[0])).film]
WIDE = ("nozzle-04", ["film.cut_tolerance=0.3"])  # strips of 1.5 mm


def offers(name: str, *settings: str) -> FilmOffers:
    return film_offers(skincad.load(name, settings))


def offer(films: FilmOffers, name: str) -> FilmOffer:
    (one,) = (row for row in films.products if row.name == name)
    return one


def test_a_beam_of_layers_bends_as_by_hand() -> None:
    """One layer: E t^3 / 12. Two: the bimetal strip's closed form (Timoshenko, J. Opt. Soc. Am. 11, 1925,
    233). Three: the integral of E (z - n)^2, summed finely."""
    film, polyester = Ply(0.028, 3000.0), Ply(0.125, 4000.0)
    assert bending([film]) == pytest.approx((3000 * 0.028**3 / 12, 0.014), rel=1e-12)
    (a, p), (b, q) = polyester, film
    closed = (p * a**3 + q * b**3) / 12 + p * a * q * b / (p * a + q * b) * ((a + b) / 2) ** 2
    assert bending([polyester, film])[0] == pytest.approx(closed, rel=1e-12)
    layers = [polyester, Ply(0.006, 9000.0), film]
    height, edges = 0.0, [0.0]
    for layer in layers:
        height += layer.thickness
        edges.append(height)
    z = (np.arange(200_000) + 0.5) * height / 200_000
    modulus = np.array([layer.modulus for layer in layers])[np.searchsorted(edges[1:], z)]
    neutral = (modulus * z).sum() / modulus.sum()
    stiffness = (modulus * (z - neutral) ** 2).sum() * height / 200_000
    assert bending(layers) == pytest.approx((stiffness, neutral), rel=1e-4)  # steps of a layer's edge


@pytest.mark.parametrize(
    ("slot", "gauge"),
    [(0.04, None), (0.05, 0.028), (0.07, 0.028), (0.072, 0.052), (0.1, 0.052), (0.13, 0.11)],
)
def test_a_slot_without_a_film_takes_the_thickest_that_goes_in(slot: float, gauge: float | None) -> None:
    """With 0.02 mm beside it: 28, 52 and 110 µm go into slots from 48, 72 and 130 µm on."""
    films = offers("yamada-2002", "film=none", "contact.film=none", f"slot.thickness={slot}")
    bare = offer(films, "te-sputtered")
    assert films.film is None
    assert films.slot_takes == pytest.approx(slot - 0.02)
    assert bare.fits is (gauge is not None)
    assert [row.name for row in films.fitting] == ["te-sputtered"] * (gauge is not None)
    if gauge is None:
        assert bare.why == "28 µm in all, and the slot takes 20 µm"
    else:
        assert bare.gauge == gauge


@pytest.mark.parametrize("name", FILMED)
def test_a_template_can_be_filled(name: str) -> None:
    """The sheet of its film's own gauge fits, and no product that is laminated, printed or a sensor."""
    films = offers(name)
    assert [row.name for row in films.fitting] == ["te-sputtered"]
    assert films.fitting[0].gauge == films.film
    assert {row.fits for row in films.products} == {True, False, None}


def test_each_product_says_why() -> None:
    films = offers("yamada-2002")
    assert offer(films, "te-sputtered").why == "28 µm with sputtered metal; the slot takes 30 µm"
    for name, words in {
        "te-ink": ("printed silver can't be etched", "bends 2.9 times as stiffly", "40 µm in all"),
        "te-dt": ("outline and its leads", "printed silver", "40 µm in all"),
        "te-ldt0": ("laminated to 125 µm of polyester", "bends 240 times", "165 µm in all"),
        "te-ldt1": ("laminated to 165 µm of polyester", "its neutral layer", "205 µm in all"),
        "polyk": ("ask for 28 µm, poled, sputtered metal on both faces",),
    }.items():
        row = offer(films, name)
        assert row.fits is (None if name == "polyk" else False)
        assert all(part in row.why for part in words), row.why
    # ink of the film's own stiffness thickens a bare strip: the cube of its thickness
    assert offer(films, "te-ink").bending_ratio == pytest.approx((40 / 28) ** 3)
    assert offer(films, "te-ink").off_neutral == pytest.approx(0.0, abs=1e-12)
    assert offer(films, "te-sputtered").bending_ratio == pytest.approx(1.0)


def test_another_gauge_says_what_to_set() -> None:
    films = offers("yamada-2002", "film.thickness=0.04", "slot.thickness=0.1")
    bare = offer(films, "te-sputtered")
    assert bare.fits is False
    assert bare.why.startswith("sold at 28, 52 and 110 µm, the design's film has 40 µm: ")
    setting = next(word for word in bare.why.split() if word.startswith("film.thickness="))
    assert offer(offers("yamada-2002", "slot.thickness=0.1", setting), "te-sputtered").fits
    # a film is within 5 % of its gauge
    assert offer(offers("yamada-2002", "film.thickness=0.029"), "te-sputtered").fits


def test_a_film_that_is_cast_in_fills_its_slot() -> None:
    assert offers("cast-in").slot_takes == skincad.load("cast-in").slot.thickness


@pytest.mark.parametrize(
    ("name", "settings", "cutter", "could"),
    [
        ("yamada-2002", [], "laser", "laser"),
        ("yamada-2002", ["film.cut_tolerance=0.0"], "laser", "laser"),
        ("home-printer", [], "laser", "knife plotter"),
        ("home-printer", ["film.cut_tolerance=0.1"], "knife plotter", "knife plotter"),
        ("home-printer", ["film.cut_tolerance=0.2"], "knife plotter", "knife plotter"),
        ("nozzle-04", [], "laser", "blade"),
        (*WIDE, "blade", "blade"),
        ("nozzle-04", ["film.electrode_margin=0.32"], "blade", "blade"),
        # electrodes that lie off by 0.3 mm leave no room for a blade's 0.3
        ("nozzle-04", ["film.registration=0.3", "film.cut_tolerance=0.1"], "knife plotter", "knife plotter"),
    ],
)
def test_what_cuts_a_strip(name: str, settings: list[str], cutter: str, could: str) -> None:
    films = offers(name, *settings)
    assert (films.cutter, films.width_cutter) == (cutter, could)
    assert films.cutting.startswith(f"by {cutter}")
    assert ("will do with film.cut_tolerance=" in films.cutting) == (cutter != could)


@pytest.mark.parametrize("cutter", CUTTERS[:-1], ids=lambda cutter: cutter.name)
def test_the_narrowest_strip_of_a_cutter_has_room_for_its_leads(cutter: tuple[str, float, float]) -> None:
    """By the rule of the electrodes, which doesn't know cutters."""
    _, narrowest, tolerance = cutter
    wide = skincad.load("nozzle-04", [f"slot.depth={narrowest}", f"film.cut_tolerance={tolerance}"])
    assert electrode_findings(Job(wide)) == []
    assert film_offers(wide).cutter == cutter[0]


def test_the_casting_sheet_says_what_cuts() -> None:
    for name, settings, words in (
        ("yamada-2002", [], "Cut them by laser: strips of 0.25 mm are too narrow for a blade (1 mm)"),
        (*WIDE, "Cut them by blade and ruler, or anything finer: strips of 1.5 mm bear it"),
        ("nozzle-04", [], "blade and ruler will do with film.cut_tolerance=0.3"),
    ):
        assert words in sheet_steps(Job(skincad.load(name, settings)))["strips ready"]


def test_each_product_has_a_dated_source_or_says_that_it_has_none() -> None:
    for name, row in film_products().items():
        assert row.source or row.unchecked, name
        assert not row.date or datetime.date.fromisoformat(row.date) < datetime.date(2026, 12, 1)
        assert row.date or not row.gauges, name  # what is judged has a date
        assert "as commonly listed, not checked" in row.provenance or row.date
    assert film_products()["te-ldt0"].date == "1998-11-13"


def test_without_slots_there_is_nothing_to_buy(tmp_path: Path) -> None:
    for name in ("plain-ridges", "pillars-9", "flat-magnet"):
        with refused_by("film: needs slots for film, and the design has none"):
            film_offers(skincad.load(name))
    line = refused_command("check", "plain-ridges", "--film", "--json", cwd=tmp_path)
    assert line == "--film: needs slots for film, and the design has none; give it a [slot]"


def test_check_prints_the_films(tmp_path: Path) -> None:
    words = ("check", "steep-fingertip", "--model", "winkler", "--film")
    lines = run_skincad(*words, cwd=tmp_path).stdout.splitlines()
    heads = [line[2:17].strip() for line in lines]
    assert heads.count("fits") == 1
    assert heads.count("fits not") == 4
    assert heads.count("may fit") == 1  # those to be asked, together
    assert any("(1998-11-13)" in line for line in lines)
    assert lines[heads.index("cut strips")].startswith("  cut strips     by laser")
    data = json.loads(run_skincad(*words, "--json", cwd=tmp_path).stdout)
    plain = json.loads(run_skincad(*words[:-1], "--json", cwd=tmp_path).stdout)
    assert {*data} - {*plain} == {
        "film_mm", "slot_mm", "slot_takes_mm", "strip_width_mm", "cutter", "width_cutter", "cutting",
        "film_products",
    }  # fmt: skip
    assert [row["name"] for row in data["film_products"] if row["fits"]] == ["te-sputtered"]
