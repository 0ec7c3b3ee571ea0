"""The film's capacitance and charge."""

from __future__ import annotations

import numpy as np
import pytest

from skincad.circuit import capacitance, charge, constants, load_circuit

D = (23.0, 3.0, -33.0)


def test_a_square_centimetre_of_28_um_film_has_the_data_sheets_380_pf() -> None:
    assert capacitance(100.0, 0.028, 12.0) == pytest.approx(380e-12, rel=0.01)  # data sheet's digits


def test_a_strip_has_about_11_pf() -> None:
    assert capacitance(0.25 * 12, 0.028, 12.0) == pytest.approx(11e-12, rel=0.05)


def test_each_stress_gives_its_own_charge_by_the_draw_axis() -> None:
    def of(*stress: float, axis: str = "length") -> float:
        return float(charge(*stress, area=3.0, coefficients=D, draw_axis=axis))  # type: ignore[arg-type]

    assert of(1.0, 0.0, 0.0) == pytest.approx(-33e-12 * 3)  # 1 MPa over 3 mm2 is 3 N
    assert of(0.0, 1.0, 0.0) == pytest.approx(23e-12 * 3)
    assert of(0.0, 0.0, 1.0) == pytest.approx(3e-12 * 3)
    assert of(0.0, 1.0, 0.0, axis="width") == pytest.approx(3e-12 * 3)
    assert of(0.0, 0.0, 1.0, axis="width") == pytest.approx(23e-12 * 3)


def test_plane_strains_stress_along_y_counts() -> None:
    through = np.array([0.0, -0.1, -0.2])
    plain = charge(through, 0.0, 0.0, area=3.0, coefficients=D)
    with_y = charge(through, 0.5 * through, 0.0, area=3.0, coefficients=D)
    # d31 has the other sign: half the stress along y takes 23/66 of the charge away
    np.testing.assert_allclose(with_y, plain * (1 - 0.5 * 23 / 33), rtol=1e-12)


def test_a_wider_strip_and_a_longer_lead_change_the_constants() -> None:
    plain = constants(load_circuit("transimpedance"))
    wide = constants(load_circuit("transimpedance", ["film.area=6.0"]))
    lead = constants(load_circuit("transimpedance", ["cable.capacitance=20e-12"]))
    assert wide.capacitance - plain.capacitance == pytest.approx(capacitance(3.0, 0.028, 12.0))
    assert lead.capacitance - plain.capacitance == pytest.approx(10e-12)
