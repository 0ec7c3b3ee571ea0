"""Film that can be bought for a design: which products go into its slots, and by what its strips are cut.

A product fits if its film is as thick as the design's, goes into the slot with its electrodes and a coat of
silicone on each face, and can be cut to the pattern of film/strips.dxf: bare, with sputtered metal. Without a
film of its own a design takes the thickest that goes in. How stiff electrodes and a laminate make a strip is
that of a beam of layers (Timoshenko and Goodier, Theory of Elasticity); adhesives are left out.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from skincad.base.errors import InputError
from skincad.base.result import Record, Result, item, record
from skincad.fabrication.papers import macro
from skincad.inputs.design import Design
from skincad.inputs.film_product import FilmProduct, film_products
from skincad.inputs.skin_tables import Film
from skincad.shape.skin import skin_of

FILM_ROOM = 0.02  # mm, assumption: beside a film that is drawn in, a coat of silicone of 0.01 on each face
GAUGE_TOLERANCE = 0.05  # relative, assumption: by which a film differs from its nominal thickness
LEAST_LEAD = 0.05  # mm, assumption: the narrowest line that a laser leaves or an etch resist keeps whole
POLYESTER_MODULUS = 4000.0  # MPa, assumption: PET film, drawn; data sheets have 3800 to 5000
ROUNDING = 1e-9  # mm


class Cutter(NamedTuple):
    """What cuts strips: the narrowest that it leaves whole, and how far its edge may be off, mm."""

    name: str
    narrowest: float
    tolerance: float


# From the coarsest; all assumptions. The narrowest: below it a blade or knife curls, tears or drags a strip.
# The tolerance: a line by eye along a ruler; those of plotter and laser as film.cut_tolerance has them.
CUTTERS = (
    Cutter("blade", 1.0, 0.3),
    Cutter("knife plotter", 0.5, 0.1),
    Cutter("laser", 0.0, 0.02),
)


def least_width(lost: float) -> float:
    """Return the narrowest strip whose two leads lie side by side, mm, where each loses so much of its half
    to the bare edge and to the registration."""
    return 2 * (LEAST_LEAD + lost)


def width_cutter(width: float, registration: float) -> Cutter:
    """Return the coarsest cutter for strips of a width, mm, if electrodes keep clear of its edge."""
    for cutter in CUTTERS[:-1]:
        needs = max(cutter.narrowest, least_width(2 * registration + cutter.tolerance))
        if width >= needs - ROUNDING:
            return cutter
    return CUTTERS[-1]


def pattern_cutter(film: Film, width: float) -> Cutter:
    """Return the coarsest cutter for strips of a width, mm, as the bare margin of the design's pattern is."""
    first, bare = CUTTERS.index(width_cutter(width, film.registration)), film.margin - film.registration
    return next((c for c in CUTTERS[first:-1] if c.tolerance <= bare + ROUNDING), CUTTERS[-1])


class Ply(NamedTuple):
    """A layer of a strip: mm and MPa."""

    thickness: float
    modulus: float


def bending(layers: Sequence[Ply]) -> tuple[float, float]:
    """Return the bending stiffness of bonded layers a mm of width, N mm, and how far their neutral layer lies
    above the lowest face, mm."""
    middles, top = [], 0.0
    for layer in layers:
        middles.append(top + layer.thickness / 2)
        top += layer.thickness
    stretch = math.fsum(layer.thickness * layer.modulus for layer in layers)
    pairs = list(zip(layers, middles, strict=True))
    neutral = math.fsum(layer.thickness * layer.modulus * z for layer, z in pairs) / stretch
    own = math.fsum(layer.modulus * layer.thickness**3 / 12 for layer in layers)
    return own + math.fsum(e * t * (z - neutral) ** 2 for (t, e), z in pairs), neutral


@record()
class FilmOffer(Record):
    """A product of templates/films.toml, and whether it fits a design."""

    name: str = item(meaning="its name in the table")
    maker: str = item(meaning="who makes it")
    product: str = item(meaning="what it is called there")
    fits: bool | None = item(meaning="whether it fits; null: not known, so ask its maker")
    why: str = item(meaning="the reason")
    gauge: float | None = item("mm", "of PVDF, the one that is nearest to fit; null: not known")
    sheet: float | None = item("mm", "with electrodes and laminate")
    bending_ratio: float | None = item(meaning="bending stiffness by that of the bare film")
    off_neutral: float | None = item("mm", "of the film's middle, from where bending stretches nothing")
    electrode: str | None = item(meaning="sputtered or printed; null: not known")
    metal: str = item(meaning="of the electrode", null=True)
    cut: str = item(meaning="how it is cut", null=True)
    size: str = item(meaning="of a sheet or sensor", null=True)
    source: str = item(meaning="what the figures are from", null=True)
    date: str = item(meaning="of the source", null=True)
    unchecked: str = item(meaning="what is as commonly listed, and was not checked", null=True)


# what a product and its offer both have, by the same name
AS_SOLD = "maker", "product", "electrode", "metal", "cut", "size", "source", "date", "unchecked"


@record()
class FilmOffers(Result):
    """What can be bought for a design's strips, and how they are cut."""

    shown_by = "skincad.outputs.checks:FILM"
    name: str = item(meaning="of the design")
    film: float | None = item("mm", "the design's film; null: it has none yet")
    slot: float = item("mm", "across the slot")
    slot_takes: float = item("mm", "film with its electrodes, at most")
    strip_width: float = item("mm", "of each strip")
    cutter: str = item(meaning="blade, knife plotter or laser, as the pattern's bare margin is")
    width_cutter: str = item(meaning="the coarsest that the width bears, with a margin to suit")
    cutting: str = item(meaning="how the strips are cut, and why")
    products: tuple[FilmOffer, ...] = item(meaning="what can be bought", key="film_products")

    @property
    def fitting(self) -> tuple[FilmOffer, ...]:
        """The products that fit."""
        return tuple(offer for offer in self.products if offer.fits)


def film_offers(design: Design) -> FilmOffers:
    """Return which products fit a design's strips, and how these are cut.

    Raises InputError for a design without slots.
    """
    slot, film = skin_of(design).slot, design.film
    if slot is None:
        raise InputError("film", "needs slots for film, and the design has none", remedy="give it a [slot]")
    room = 0.0 if design.mold.method == "cast-in" else FILM_ROOM
    takes = max(0.0, round(slot.thickness - room, 9))  # mm, without a float's last digits
    margins = film or Film(thickness=min(slot.thickness, 5.0))
    return FilmOffers(
        name=design.name,
        film=film.thickness if film else None,
        slot=slot.thickness,
        slot_takes=takes,
        strip_width=slot.depth,
        cutter=pattern_cutter(margins, slot.depth).name,
        width_cutter=width_cutter(slot.depth, margins.registration).name,
        cutting=cutting(margins, slot.depth),
        products=tuple(_offer(name, row, margins, film, takes) for name, row in film_products().items()),
    )


def cutting(film: Film, width: float) -> str:
    """Return by what strips of a width, mm, are cut, in words."""
    by, could = pattern_cutter(film, width), width_cutter(width, film.registration)
    return _words("cutting", film, width, by, could, CUTTERS)


def _words(name: str, *values: Any) -> str:
    """The words of a macro of templates/reasons/film.txt."""
    return macro("reasons/film.txt", name, *values).strip()


def _offer(name: str, row: FilmProduct, margins: Film, film: Film | None, takes: float) -> FilmOffer:
    """Judge a product by the design's film, or by what its slot takes."""
    extra, wanted = row.coat + row.laminate, film.thickness if film else None
    going_in = [gauge for gauge in row.gauges if gauge + extra <= takes + ROUNDING]
    if wanted is None:
        gauge = max(going_in, default=min(row.gauges, default=None))
    else:
        gauge = min(row.gauges, key=lambda sold: abs(sold - wanted), default=None)
    ratio = offset = sheet = None
    obstacles = list[str]()
    if gauge is not None:
        sheet = gauge + extra
        half = Ply(row.coat / 2, margins.young_modulus)
        bare = Ply(gauge, margins.young_modulus)
        stiff, neutral = bending([Ply(row.laminate, POLYESTER_MODULUS), half, bare, half])
        ratio = stiff / bending([bare])[0]
        offset = abs(row.laminate + row.coat / 2 + gauge / 2 - neutral)
        named = {
            "laminated": row.laminate > 0,
            "sensor": row.form == "sensor",
            "printed": row.electrode == "printed",
            "gauge": wanted is not None and abs(gauge - wanted) > GAUGE_TOLERANCE * wanted,
            "thick": sheet > takes + ROUNDING,
        }
        obstacles = [obstacle for obstacle, there in named.items() if there]
    facts: dict[str, Any] = {"wanted": wanted, "takes": takes, "gauge": gauge, "sheet": sheet}
    facts |= {"ratio": ratio, "offset": offset, "going_in": going_in, "obstacles": obstacles}
    return FilmOffer(
        name=name,
        fits=None if gauge is None else not obstacles,
        why=_words("why", row, facts),
        gauge=gauge,
        sheet=sheet,
        bending_ratio=ratio,
        off_neutral=offset,
        **{key: getattr(row, key) for key in AS_SOLD},
    )
