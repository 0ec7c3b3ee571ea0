"""Hypothesis strategies of cases: designs that hang together, with values at and next to the limits.

`random_designs` says how the keys of a design hang together; here its dice are Hypothesis's, which
shrinks, and some keys are put on a limit of their own field, one float beside it, or a power of ten.
"""

from __future__ import annotations

import math
from typing import Any

import annotated_types
from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy
from pydantic import BaseModel

from bench.campaign import random_designs
from bench.campaign.cases import Case
from skincad.base import Table, table_of
from skincad.circuit import Circuit
from skincad.inputs import Design

NEVER = {"name", "process", "end_plate_process", "lid_process"}
MOST_RIDGES = 25  # of what is solved: a pad of hundreds is the catalogue's
CHECKED = ("winkler", "linear", "linear", "corrected", "finite-strain")


class Drawn:
    """Dice whose throws Hypothesis draws, and so shrinks; the ends of a range are drawn often."""

    def __init__(self, draw: DrawFn) -> None:
        self.draw = draw

    def over(self, low: float, high: float) -> float:
        near = st.sampled_from([low, high, math.nextafter(low, high), math.nextafter(high, low)])
        return float(self.draw(st.floats(low, high) | st.floats(low, high) | near))

    def scale(self, low: float, high: float) -> float:
        return float(min(high, max(low, math.exp(self.over(math.log(low), math.log(high))))))

    def happens(self, share: float) -> bool:
        return bool(self.draw(st.integers(0, 99)) >= 100 - 100 * share)

    def whole(self, low: int, high: int) -> int:
        return int(self.draw(st.integers(low, high)))

    def one(self, values: Any) -> Any:
        return self.draw(st.sampled_from(list(values)))

    def maybe(self, share: float, **tables: Any) -> dict[str, Any]:
        return {key: value for key, value in tables.items() if self.happens(share)}


def limits(model: type[BaseModel], key: str) -> list[float]:
    """The values at and next to the limits of a number's field; powers of ten where it has none."""
    rows: list[float] = []
    for rule in model.model_fields[key].metadata:
        if isinstance(rule, annotated_types.Ge | annotated_types.Le):
            rows.append(float(getattr(rule, "ge", getattr(rule, "le", 0.0))))  # type: ignore[arg-type]
        if isinstance(rule, annotated_types.Gt):
            rows += [math.nextafter(float(rule.gt), math.inf), float(rule.gt) + 1e-6]  # type: ignore[arg-type]
    beside = [math.nextafter(v, w) for v in rows for w in (-math.inf, math.inf)]
    return [*rows, *beside, *(10.0**k for k in (-12, -6, -3, 0, 3))]


def numbers(model: type[Table]) -> list[tuple[str, ...]]:
    """The paths of all plain numbers of a model."""
    rows: list[tuple[str, ...]] = []
    for key, field in model.model_fields.items():
        inner = table_of(model, key)
        if inner is not None and key not in ("printer", "silicones", "grippers"):
            rows += [(key, *rest) for rest in numbers(inner)]
        elif "float" in str(field.annotation) and "list" not in str(field.annotation) and key not in NEVER:
            rows.append((key,))
    return rows


def attacked(draw: DrawFn, model: type[Table], tables: dict[str, Any], most: int) -> dict[str, Any]:
    """The tables with up to `most` numbers on a limit of their field."""
    for path in draw(st.lists(st.sampled_from(numbers(model)), max_size=most, unique=True)):
        inner, table, home = model, tables, path[:-1]
        for key in home:
            inner = table_of(inner, key) or inner
            if not isinstance(table.get(key), dict):
                break
            table[key] = dict(table[key])
            table = table[key]
        else:
            table[path[-1]] = draw(st.sampled_from(limits(inner, path[-1])))
    return tables


@st.composite
def designs(draw: DrawFn, most: int = 1, ridges: int = MOST_RIDGES) -> dict[str, Any]:
    dice = Drawn(draw)
    tables = {"name": "campaign", **random_designs.tables(dice)}  # type: ignore[arg-type]
    tables["ridge"]["count"] = min(tables["ridge"]["count"], ridges)
    skin = tables["skin"]
    if not dice.happens(0.1):  # else two of three are refused: the base circle falls by too much
        skin["thickness"] = max(skin["thickness"], skin["width"] ** 2 / (5 * skin["curvature_radius"]))
    if dice.happens(0.2):
        skin["curvature_radius_y"] = skin["length"] * dice.scale(0.65, 1e5)
    contact: dict[str, Any] = {"force": dice.scale(1e-6, 1e3)}
    states = ["loose", "ignored"] + (["bonded"] if "film" in tables else [])
    if "slot" in tables:
        contact["film"] = dice.one(states)
    tables["contact"] = contact
    return attacked(draw, Design, tables, most)


@st.composite
def shapes(draw: DrawFn, kind: str) -> Case:
    return Case(kind, draw(designs(most=2)))


@st.composite
def molds(draw: DrawFn) -> Case:
    tables = draw(designs(most=1, ridges=15))
    tables["skin"].pop("curvature_radius_y", None)
    return Case("mold", tables)


def _material(dice: Drawn) -> dict[str, Any]:
    near = dice.one([0.0, 0.3, 0.49, 0.499, 0.49999, 0.4999999])
    return {"young_modulus": dice.scale(0.04, 3.0), "poisson_ratio": near}


@st.composite
def checks(draw: DrawFn) -> Case:
    dice = Drawn(draw)
    tables = draw(designs(ridges=15))
    tables["material"] = _material(dice)
    tables["contact"]["plate"] = _plate(dice, tables["skin"]["width"])
    arguments: dict[str, Any] = {"model": dice.one(CHECKED), "tol": dice.one([0.05, 0.02, 0.2])}
    if dice.happens(0.5):
        # near where all touch, by the elastic foundation's own scale: modulus x length x sag of the circle
        skin = tables["skin"]
        sag = skin["width"] ** 2 / (8 * skin["curvature_radius"])
        scale = tables["material"]["young_modulus"] * skin["length"] * sag
        arguments["force"] = min(1e6, max(1e-9, scale * dice.scale(0.05, 20.0)))
    return Case("check", tables, arguments=arguments)


def _plate(dice: Drawn, width: float) -> dict[str, Any]:
    shape = dice.one(["flat", "flat", "flat", "tilted", "cylinder", "step"])
    more = {
        "flat": {},
        "tilted": {"tilt": dice.over(-5.0, 5.0)},
        "cylinder": {"radius": dice.scale(1.0, 1e8), "position": dice.over(-width, width)},
        "step": {"height": dice.scale(1e-6, 1.0), "position": dice.over(-width, width)},
    }
    return {"shape": shape, **more[shape]}


@st.composite
def scenes(draw: DrawFn, overload: float = 1.0) -> Case:
    """Scenes; with `overload` their forces, and what drives the plate, are up to that many times as large."""
    dice = Drawn(draw)
    skin = draw(designs(most=0, ridges=7))
    skin["skin"].pop("curvature_radius_y", None)
    skin["material"] = _material(dice)
    sag = skin["skin"]["width"] ** 2 / (8 * skin["skin"]["curvature_radius"])
    scale = skin["material"]["young_modulus"] * skin["skin"]["length"] * sag
    peak = min(1e3, max(1e-9, scale * dice.scale(0.05, 5.0)))
    if overload > 1.0:
        # of what the ridges bear evenly: 0.3 of modulus, mean width and length each, small strain's range
        area = (skin["ridge"]["root_width"] + skin["ridge"]["tip_width"]) / 2 * skin["skin"]["length"]
        borne = 0.3 * skin["material"]["young_modulus"] * area * skin["ridge"]["count"]
        peak = min(1e6, borne * dice.scale(0.1, overload))
    points, duration = dice.whole(2, 6), dice.scale(1e-7, 10.0)
    time = [duration * i / (points - 1) for i in range(points)]
    normal = [0.0, *(peak * dice.one([0.0, 0.3, 1.0, 1.0, 2.0]) for _ in range(points - 1))]
    mu = dice.one([0.0, 1e-9, 0.1, 0.5, 1.0, 1.0, 2.0, 10.0])
    history: dict[str, Any] = {"time_s": time, "normal_force_N": normal, "steps": dice.whole(1, 40)}
    if dice.happens(0.6):
        ratios = [0.0, 0.5, 0.9, -0.9, 1.0, 1.0 - 1e-12, 1.0 + 1e-12]
        history["tangential_force_N"] = [0.0, *(mu * n * dice.one(ratios) for n in normal[1:])]
    else:
        reach = skin["ridge"]["height"] * (dice.scale(1.0, overload) if overload > 1.0 else 1.0)
        history["displacement_mm"] = [0.0, *(reach * dice.over(-1.0, 1.0) for _ in normal[1:])]
    friction = {"coefficient": mu, **({"kinetic": mu * dice.over(0.0, 1.0)} if dice.happens(0.3) else {})}
    tables = {
        "name": "campaign",
        "skin": "skin.toml",
        "history": history,
        "effects": {"friction": friction, **({"film": {}} if "film" in skin else {})},
        "readout": {"ridges": [1] if "slot" in skin else [], "bandwidth_Hz": dice.scale(1.0, 1e6)},
    }
    if overload > 1.0 and mu < 2.0 and dice.happens(0.15):  # masses may bear what the skin does not
        tables |= {"plate": {"mass": dice.scale(1e-3, 1e3)}}
        tables["effects"] |= {"inertia": {}, "viscosity": {}}
        tables["history"] |= {"steps": min(history["steps"], 10)}
    return Case("simulate", tables, skin)


@st.composite
def circuits(draw: DrawFn) -> Case:
    dice = Drawn(draw)
    low = dice.scale(1e-3, 1e4)
    high = low * dice.scale(10.0, 1e4)
    tables: dict[str, Any] = {
        "name": "campaign",
        "film": {"area": dice.scale(1e-2, 1e4), "thickness": dice.scale(0.004, 1.0)},
        "cable": {"capacitance": dice.scale(1e-15, 1e-8)},
        "motional": {
            "resistance": dice.scale(1.0, 1e9),
            "inductance": dice.scale(1e-6, 1e6),
            "capacitance": dice.scale(1e-18, 1e-6),
        },
        "amplifier": {
            "series_resistance": dice.scale(1.0, 1e9),
            "input_resistance": dice.scale(1e3, 1e14),
            "input_capacitance": dice.scale(1e-14, 1e-9),
            "feedback_resistance": dice.scale(1.0, 1e11),
            "output_resistance": dice.scale(1e-2, 1e5),
            "gain": dice.scale(1.0, 1e9),
        },
        "sweep": {"low": low, "high": high, "fit_high": high, "points": dice.whole(20, 200)},
    }
    if dice.happens(0.3):
        tables["indenter"] = {"resonance": dice.scale(low, high), "damping": dice.scale(1e-3, 5.0)}
    if dice.happens(0.3):
        tables["force_sensor"] = {"resonance": dice.scale(low, high), "damping": dice.scale(1e-3, 5.0)}
    return Case("circuit", attacked(draw, Circuit, tables, 2))


MODES: dict[str, tuple[SearchStrategy[Case], ...]] = {
    "geometry": (shapes("section"), shapes("solid"), shapes("solid"), molds()),
    "check": (checks(),),
    "scene": (scenes(),),
    "overload": (scenes(overload=1000.0),),
    "circuit": (circuits(),),
}
