"""Taxels and responses as CSV and NPZ: the header says frame, unit and meaning."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from skincad.base.arrays import Array
from skincad.base.plain import Cell, csv_text
from skincad.circuit.film import charge, electrode
from skincad.inputs.design import Design
from skincad.mechanics.film.response import SPANS, FilmResponse
from skincad.packages.taxels import Taxels

FRAME = "frame of the design: x across the ridges, y along them, z out of the skin, flat back at z = 0"
AXES = ("across", "along_y", "outward")
PARTS = ("through_film", "along_film", "lengthwise")
WAYS = ("normal", "tangential")


def taxels_csv(places: Taxels) -> str:
    """Return a taxel a row: its place and its three axes, the third outward."""
    columns = ["name", "kind", "ridge", "side", "x_mm", "y_mm", "z_mm"]
    columns += [f"{axis}_{x}" for axis in AXES for x in "xyz"] + ["size_mm", "length_mm"]
    rows: list[list[Cell]] = [[*columns]]
    for i, name in enumerate(places.names):
        pose = places.poses[i]
        values = [*pose[:, 3], *pose[:, :3].T.ravel(), *places.sizes[i]]
        words = [name, places.kinds[i], str(places.ridges[i]), places.sides[i]]
        rows.append([*words, *(repr(float(v) + 0.0) for v in values)])
    return csv_text(rows, [FRAME, "mm; axes are unit vectors, the third points out of the skin"])


def write_taxels(places: Taxels, path: Path) -> None:
    """Write the same as NPZ: `poses` (n, 3, 4), `names`, `kinds`, `ridges`, `sides`, `sizes` and `about`."""
    np.savez(
        path,
        poses=places.poses,
        names=np.array(places.names),
        kinds=np.array(places.kinds),
        ridges=np.array(places.ridges),
        sides=np.array(places.sides),
        sizes=places.sizes,
        about=np.array(f"poses (n, 3, 4): axes as columns, then the place in mm; {FRAME}"),
    )


def charges(design: Design, felt: FilmResponse) -> tuple[Array, Array]:
    """Return charge per N `(2, ridges, strips)` pC/N and its error `(2, ridges)`, of normal and tangential
    force; the film's draw axis lies along y."""
    film = design.film
    assert film is not None
    both = np.stack([felt.normal, felt.tangential])
    coefficients, area = (film.d31, film.d32, film.d33), electrode(design)
    found = charge(both[..., 0], both[..., 2], both[..., 1], area=area, coefficients=coefficients) * 1e12
    size = np.abs([film.d33, film.d32, film.d31])
    return found, area * felt.error @ size


def response_csv(design: Design, felt: FilmResponse) -> str:
    """Return a row for each force on a ridge and strip: stress and charge per N, error and range."""
    stress = [f"{part}_MPa_per_N" for part in PARTS]
    columns = ["force_on_ridge", "direction", "strip", *stress, *(f"{name}_error" for name in stress)]
    columns += [f"{name}_change_at_{span:g}_of_force" for span in SPANS for name in stress]
    columns += ["charge_pC_per_N", "charge_error_pC_per_N"]
    comments = [
        "mean stress in a strip, tension positive, and its charge, per N of force on one ridge alone;",
        "normal: in compression; tangential: what the plate does to the skin, to +x; add up ridges",
        f"contact as at {felt.force:g} N on the skin; change: how much differs where it is that of another",
    ]
    return csv_text([columns, *_rows(design, felt)], comments)


def _rows(design: Design, felt: FilmResponse) -> Iterator[list[Cell]]:
    charged, charge_error = charges(design, felt)
    for w, (way, found) in enumerate(zip(WAYS, (felt.normal, felt.tangential), strict=True)):
        for r in range(len(found)):
            beside = [*felt.error[w, r], *felt.at_other_forces[:, w, r].ravel()]
            for s, (ridge, side) in enumerate(felt.strips):
                values = [*found[r, s], *beside, charged[w, r, s], charge_error[w, r]]
                yield [str(r + 1), way, f"ridge-{ridge}-{side}", *(f"{v:.9g}" for v in values)]


def write_response(design: Design, felt: FilmResponse, path: Path) -> None:
    """Write the same as NPZ: `stress` (2, ridges, strips, 3) MPa/N, `charge` (2, ridges, strips) pC/N, their
    errors, and the ridges' forces `pressed` (ridges,) N and `pulled` (2, ridges) of 1 N."""
    charged, charge_error = charges(design, felt)
    about = "axis 0: normal, tangential; last of stress: through the film, along it in the section, along y"
    np.savez(
        path,
        stress=np.stack([felt.normal, felt.tangential]),
        stress_error=felt.error,
        change=felt.at_other_forces,
        spans=np.array(SPANS),
        charge=charged,
        charge_error=charge_error,
        strips=np.array([f"ridge-{ridge}-{side}" for ridge, side in felt.strips]),
        force=np.array(felt.force),
        contact=felt.contact,
        pressed=felt.ridge_force,
        pulled=felt.ridge_force_per_pull,
        about=np.array(about),
    )
