"""Numbers that were read off runs, in one table: neither physics with a source nor an assumption.

A fit says nothing about designs that are unlike those behind it. What makes designs alike here are seven
numbers without a unit (`shape_of`); a set of designs holds the range of each. A verdict by a model whose
fits saw nothing like the design says so, and a scene's estimate is then called uncalibrated.

The numbers stay where they are used; a row says where. docs/evidence/fits.md shows the table with their
values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib import import_module
from typing import Any

from skincad.inputs.design import Design
from skincad.inputs.material import layers, silicone
from skincad.mechanics.validity import mean_width
from skincad.shape.skin import skin_of

NUMBERS = {
    "ridges": "ridges",
    "slenderness": "height by mean width",
    "base": "base thickness by pitch",
    "length": "length by base thickness",
    "curvature": "width by radius",
    "poisson": "Poisson's ratio",
    "layers": "modulus of a layer by the skin's own",
}
ROUNDING = 1e-9  # relative; a design at a range's end is within


def shape_of(design: Design) -> dict[str, float]:
    """Return the design's numbers, keys as in NUMBERS."""
    skin, table, own = skin_of(design), design.skin, silicone(design)
    moduli = (stuff.young_modulus.value / own.young_modulus.value for stuff in layers(design))
    return {
        "ridges": float(skin.count),
        "slenderness": max(skin.heights) / mean_width(design),
        "base": table.thickness / skin.pitch,
        "length": table.length / table.thickness,
        "curvature": table.width / table.curvature_radius,
        "poisson": own.poisson_ratio,
        "layers": max(moduli, key=lambda ratio: abs(math.log(ratio)), default=1.0),
    }


@dataclass(frozen=True)
class Designs:
    """A set of designs: what they are, and between what their numbers lie."""

    what: str
    ranges: dict[str, tuple[float, float]]


@dataclass(frozen=True)
class Fit:
    """Numbers `where` (module and names), what they are, and the sets of designs behind them. `models` are
    those whose verdict's error they are part of; `effect` is the one whose estimate they scale. All designs
    are of one `family`."""

    where: str
    what: str
    designs: tuple[str, ...]
    models: tuple[str, ...] = ()
    effect: str = ""
    family: str = "ridge"

    @property
    def values(self) -> dict[str, Any]:
        """The numbers by name."""
        module, names = self.where.split(":")
        home = import_module(f"skincad.{module}")
        return {name: getattr(home, name) for name in names.split()}

    @property
    def ranges(self) -> dict[str, tuple[float, float]]:
        """Between what each number lies in all sets together."""
        sets = [DESIGNS[name].ranges for name in self.designs]
        return {key: (min(of[key][0] for of in sets), max(of[key][1] for of in sets)) for key in sets[0]}


def _ranges(
    *of: tuple[float, float], layers: tuple[float, float] = (1.0, 1.0)
) -> dict[str, tuple[float, float]]:
    return dict(zip(NUMBERS, (*of, layers), strict=True))


DESIGNS = {
    "templates": Designs(
        "the ten templates",
        _ranges((3, 21), (0.645, 1.38), (1.666, 4.0), (3.0, 6.0), (0.034, 1.25), (0.499, 0.499)),
    ),
    "variants": Designs(
        "plain-ridges and yamada-2002 with one key or two changed",
        _ranges((3, 15), (0.4, 1.44), (2.0, 8.0), (1.5, 12.0), (0.07, 0.28), (0.3, 0.49999)),
    ),
    "many": Designs(
        "plain-ridges with 45 and 101 ridges on a wider base",
        _ranges((45, 101), (0.8, 0.8), (4.0, 4.0), (3.0, 3.0), (0.0, 0.2), (0.499, 0.499)),
    ),
    "verdicts": Designs(
        "bench.verdicts, seeds 1000 to 1160 and 5000 to 5044",
        _ranges((3, 9), (0.447, 2.84), (0.781, 6.674), (0.776, 12.394), (0.034, 0.658), (0.47, 0.499)),
    ),
    "campaign": Designs(
        "bench.campaign.random_designs, seeds 0 to 149",
        _ranges((1, 15), (0.134, 3.791), (0.241, 33.934), (0.481, 56.631), (0.0, 1.316), (0.499, 0.499)),
    ),
    "scenes": Designs(
        "bench.random_scenes, seeds 0 to 59",
        _ranges((3, 9), (0.509, 1.38), (1.509, 4.994), (0.883, 11.974), (0.017, 1.25), (0.499, 0.499)),
    ),
    "pins": Designs(
        "bench.pins, seeds 0 to 11 and 100 to 111, six with 0.499",
        _ranges((9, 25), (0.5159, 1.587), (0.425, 1.29), (2.413, 7.238), (0.0, 0.3723), (0.49, 0.499)),
    ),
    "layered pins": Designs(
        "bench.pins layers, seeds 300 to 312 and 320 to 334",
        _ranges(
            (9, 25),
            (0.5194, 1.717),
            (0.389, 1.228),
            (2.344, 9.563),
            (0.0, 0.3851),
            (0.49, 0.49),
            layers=(0.05543, 14.6),
        ),
    ),
}
SEEN = "templates", "variants", "campaign"
PLANE = "linear", "corrected", "corrected-finite-strain"
SOLIDS = "solid", "solid-finite-strain"

FITS = (
    Fit(
        "mechanics.models.winkler:THRESHOLD_ERROR APPROACH_ERROR PER_RIDGE SHARE_ERROR BASE_COUPLING "
        "COUPLING_PER_THICKNESS STIFFENING_MARGIN APPROACH_MARGIN FILLET_ROUNDING SHARE_MARGIN",
        "errors of the closed form, and the springs that it takes for base and fillets",
        SEEN,
        ("winkler",),
    ),
    Fit(
        "mechanics.models.winkler:DOUBLY_THRESHOLD_ERROR DOUBLY_APPROACH_ERROR DOUBLY_SHARE_ERROR",
        "errors of the closed form on a second curvature, in 47 cases of radius 15 mm to infinity",
        ("templates", "variants"),
    ),
    Fit(
        "mechanics.models.linear:TAIL THRESHOLD_BY_APPROACH APPROACH_BY_THRESHOLD SHARE_BY_APPROACH",
        "what is left of the mesh's error, by differences of orders and meshes",
        SEEN,
        (*PLANE, "finite-strain"),
    ),
    Fit(
        "mechanics.models.finite_strain:EDGE_THRESHOLD EDGE_STATE",
        "change by the law that the clamped ends follow",
        ("templates",),
    ),
    Fit(
        "mechanics.models.corrected:ERRORS",
        "errors of the change by free ends, from a coarse solid",
        ("templates", "variants", "verdicts", "campaign"),
        PLANE[1:],
    ),
    Fit(
        "mechanics.models.solid:SECTION_TAIL LAYERS_TAIL",
        "what is left of a solid's error, by differences of orders and layers",
        SEEN,
        SOLIDS,
    ),
    Fit("mechanics.bodies.prisms:MISSED", "what a bent solid feels of a missed rigid lift", ("variants",)),
    Fit(
        "mechanics.models.solid_finite_strain:ERRORS",
        "errors of the change by finite strain, from a coarse solid",
        ("templates", "variants"),
        SOLIDS[1:],
    ),
    Fit(
        "mechanics.models.solid_finite_strain:COARSE_ERRORS COARSE_PARTS",
        "the same with fewer functions along y: a constant, and a part of the change",
        ("templates", "variants", "verdicts", "campaign"),
        PLANE[2:],
    ),
    Fit(
        "mechanics.models.reduced:ERRORS",
        "errors of one force a feature against the full model",
        ("many",),
    ),
    Fit(
        "mechanics.models.reduced:PIN_ERRORS",
        "errors of one force a pin against CalculiX",
        ("pins", "layered pins"),
        ("reduced",),
        family="pin",
    ),
    Fit(
        "mechanics.models.friction:BASE_ERRORS ERRORS_BY_CHANGE PLANE_PART",
        "errors of the change by friction in plane strain, and what finite strain leaves of it",
        ("templates", "variants"),
    ),
    Fit(
        "mechanics.models.friction:SOLID_ERRORS SOLID_ERRORS_BY_CHANGE LOST",
        "the same of a solid",
        SEEN,
    ),
    Fit(
        "mechanics.left_out:ENDS_BOUND STRAIN_BOUND ALONG_PART",
        "bounds of what free ends, finite strain and friction along y change",
        SEEN,
        ("linear", "corrected", "solid", "finite-strain"),
    ),
    Fit(
        "mechanics.left_out:FORCE_BY_FRICTION APPROACH_BY_FRICTION SHARE_BY_FRICTION",
        "bounds of what friction changes, where it is not computed",
        SEEN,
    ),
    Fit(
        "effects.free_ends:BONDED_STRIPS NO_BONDED_STRIPS",
        "how far free ends let a ridge sink: reach and fall",
        ("scenes",),
    ),
    Fit(
        "mechanics.manufacture:MODEL_MISCLASSIFIES SCALED_MISCLASSIFIES SCALED_FROM PROPORTIONAL_MARGIN "
        "EDGE_MARGIN EXPONENT_MARGINS CONFINEMENT_MARGIN PITCH_MARGIN_BELOW PITCH_MARGIN_ABOVE",
        "errors of the share of good parts and of sensitivities",
        ("templates", "variants"),
    ),
    Fit("mechanics.film.stress:TAIL", "what is left of a film stress's error", ("templates", "scenes")),
    Fit(
        "effects.film:OF_SHEAR OF_PRESSURE WITHIN PRESSED",
        "what films change of the differential stress",
        ("scenes",),
        effect="film",
    ),
    Fit(
        "effects.inertia:CALIBRATED WITHIN ROUGHLY",
        "what a plate's mass changes of it",
        ("scenes",),
        effect="inertia",
    ),
    Fit(
        "effects.free_ends:SLIPPING CALIBRATED WITHIN ROUGHLY",
        "what free ends change of it",
        ("scenes",),
        effect="free_ends",
    ),
    Fit(
        "effects.finite_strain:WITHIN",
        "what finite strain changes of it",
        ("scenes",),
        effect="finite_strain",
    ),
    Fit("effects.slip_order:LOADED PULLED CLEAR", "which ridge slips first by another law", ("scenes",)),
)


def unlike(design: Design, *, model: str = "", effect: str = "") -> str:
    """Return in which numbers the design is unlike all that a model's or an effect's fits saw, or ""."""
    family, numbers, unseen = skin_of(design).family, shape_of(design), dict[str, str]()
    fits = [fit for fit in FITS if fit.family == family]
    if family != "ridge" and not any(model in fit.models for fit in fits):
        return f"it has [{family}]"
    for fit in fits:
        if model in fit.models or (effect and effect == fit.effect):
            for key, (low, high) in fit.ranges.items():
                margin = ROUNDING * abs(high)
                if not low - margin <= numbers[key] <= high + margin:
                    name = f"{family}s" if key == "ridges" else NUMBERS[key]
                    unseen[key] = f"{name} {numbers[key]:.5g} (seen: {low:.5g} to {high:.5g})"
                    if key == "layers" and low == high:
                        unseen[key] = "layers of other silicones (seen: none)"
    return ", ".join(unseen.values())
