"""Material tests from CSV files: a pad pressed by a plate, or a bar pulled or squeezed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from skincad.base.arguments import require_number
from skincad.base.columns import read_columns
from skincad.base.errors import InputError

PRESSED, STRETCHED = ("approach_mm", "force_N"), ("extension_mm", "force_N")
TESTS = (PRESSED, ("strain", "stress_MPa"), STRETCHED)
FEWEST_ROWS = 8  # assumption: fewer leave no residual worth the name beside two fitted numbers
MOST_BACK = 0.05  # of the span; assumption: noise of a crosshead is less, an unloading more
MOST_WRONG = 0.05  # of the largest load; assumption: noise of a load cell is less


@dataclass(frozen=True)
class MaterialTest:
    """A test while it loads: `deformation` and `load`, each `(rows,)`, mm and N of a pad, or strain and MPa.

    Strain and stress are engineering ones, negative in compression. `rows` counts those of the file.
    """

    kind: Literal["pad", "tensile", "compression"]
    deformation: NDArray[np.float64]
    load: NDArray[np.float64]
    rows: int
    warnings: tuple[str, ...]


def material_test(
    path: Path | str, gauge_length: float | None = None, area: float | None = None
) -> MaterialTest:
    """Return the loading of a material test; the columns say which kind it is.

    `approach_mm, force_N`: a pad pressed by a plate. `strain, stress_MPa`, or `extension_mm, force_N` with
    gauge length in mm and cross-section in mm2: a bar. A column `time_s` is passed over. Rows after the
    largest deformation are left out. Raises InputError for other columns, rows that go to and fro, loads
    of the wrong sign and too few rows.
    """
    columns = read_columns(path, tuple(sorted({"time_s", *(c for pair in TESTS for c in pair)})))
    pair = next((pair for pair in TESTS if set(pair) == columns.keys() - {"time_s"}), None)
    if pair is None:
        raise InputError(str(path), "must have the columns " + ", or ".join(map(" and ".join, TESTS)))
    deformation, load = (columns[name] for name in pair)
    sides = (("gauge_length", gauge_length, "mm"), ("area", area, "mm2"))
    for option, size, unit in sides:
        if size is not None:
            require_number(option, size, lambda value: value > 0, f"must be above 0 {unit}")
        if (size is None) == (pair == STRETCHED):
            rule = "is missing" if size is None else "is not used by a test"
            raise InputError(option, f"{rule} with the columns {' and '.join(pair)}", size)
    if gauge_length is not None and area is not None:
        deformation, load = deformation / gauge_length, load / area
    squeezed = pair != PRESSED and abs(deformation.min()) > abs(deformation.max())
    kind: Literal["pad", "tensile", "compression"] = "tensile"
    if pair == PRESSED or squeezed:
        kind = "pad" if pair == PRESSED else "compression"
    return _loading(str(path), pair, kind, deformation, load)


def _loading(
    name: str,
    pair: tuple[str, str],
    kind: Literal["pad", "tensile", "compression"],
    deformation: NDArray[np.float64],
    load: NDArray[np.float64],
) -> MaterialTest:
    """The rows up to the largest deformation, if they go there once and the load with them."""
    sign = -1.0 if kind == "compression" else 1.0
    along, against = sign * deformation, sign * load
    last = int(np.argmax(along)) + 1
    up, force = along[:last], against[:last]
    span, largest = float(np.ptp(up)), float(force.max())
    if last < FEWEST_ROWS:
        rule = f"must have at least {FEWEST_ROWS} rows of loading, up to the largest {pair[0]}"
        raise InputError(name, rule, last, "give the rows in the order of the test, the load growing")
    back = np.maximum.accumulate(up) - up
    if (back > MOST_BACK * span).any():
        row = int(np.argmax(back > MOST_BACK * span)) + 1
        raise InputError(
            f"{name}, row {row}",
            f"{pair[0]} goes back before its largest value",
            remedy="give one loading, its rows in the order of the test",
        )
    if largest <= 0 or force.min() < -MOST_WRONG * largest:
        remedy = (
            "tare the load cell; a pad's force counts positive, a compression's stress and strain negative"
        )
        raise InputError(
            name, f"{pair[1]} must have the sign of {pair[0]}", sign * float(force.min()), remedy
        )
    left_out = along.size - last
    warnings = (f"{left_out} rows after the largest {pair[0]} are left out",) if left_out else ()
    return MaterialTest(kind, deformation[:last], load[:last], along.size, warnings)
