"""A silicone's law in a design: what it says of the modulus, and what is refused."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import skincad
from skincad.base import InputError
from skincad.inputs import Design, foreign_modulus
from skincad.inputs.material import silicone
from skincad.laws import LAWS, NeoHooke, Ogden
from skincad.mechanics import pad_of
from skincad.outputs import schema_of
from tests.mechanics.designs import reference

OGDEN: dict[str, Any] = {"kind": "ogden", "mu": [0.1, 0.2], "alpha": [3.0, -1.5]}


def with_law(law: object, **material: Any) -> Design:
    return reference().with_(material={"name": None, "young_modulus": None, "law": law, **material})


def test_the_modulus_follows_from_the_law() -> None:
    """E = 2 (1 + nu) G, G the sum of Ogden's mu."""
    material = silicone(with_law(OGDEN, poisson_ratio=0.49))
    assert material.young_modulus.value == pytest.approx(2 * 1.49 * 0.3, rel=1e-14)
    assert material.young_modulus.low == material.young_modulus.high == material.young_modulus.value
    assert pad_of(with_law(OGDEN)).law == Ogden(mu=[0.1, 0.2], alpha=[3.0, -1.5])


def test_a_modulus_beside_it_gives_the_range() -> None:
    material = silicone(with_law(OGDEN, young_modulus={"value": 0.9, "low": 0.8, "high": 1.1}))
    assert (material.young_modulus.low, material.young_modulus.high) == (0.8, 1.1)
    with pytest.raises(InputError, match=r"material\.young_modulus: must be within 1% of the 0\.8994 MPa"):
        with_law(OGDEN, young_modulus=0.95)


def test_neo_hookes_law_is_what_a_pad_has_without_one() -> None:
    assert pad_of(with_law({"kind": "neo-hooke", "mu": 0.3})).laws == {}
    assert isinstance(silicone(with_law({"kind": "neo-hooke", "mu": 0.3})).law, NeoHooke)
    assert pad_of(reference()).laws == {}


def test_a_design_with_a_law_is_the_file_that_it_writes(tmp_path: Path) -> None:
    path = tmp_path / "skin.toml"
    path.write_text(with_law(OGDEN).to_toml())
    assert skincad.load(path) == with_law(OGDEN)
    assert hash(skincad.load(path)) == hash(with_law(OGDEN))


@pytest.mark.parametrize(
    ("law", "told"),
    [
        ({"kind": "gent", "mu": 0.2}, r"material\.law\.j_m: is missing"),
        ({"kind": "gent", "mu": 0.2, "jm": 3.0}, r"material\.law\.jm: unknown key; did you mean 'j_m'"),
        ({"kind": "gint", "mu": 0.2}, r"material\.law\.kind: unknown law, got 'gint'; did you mean 'gent'"),
        ({"kind": "yeoh", "c10": 0.2, "c20": -1.0}, r"material\.law: must pull a bar the more"),
        (
            {"kind": "neo-hooke", "mu": 1e-5},
            r"material\.law: must have a modulus at small strain from 0\.001",
        ),
        (3, r"material\.law: must be a table, \[material\.law\], got 3"),
    ],
)
def test_a_law_that_is_none_is_refused_in_one_line(law: object, told: str) -> None:
    with pytest.raises(InputError, match=told) as refused:
        with_law(law)
    assert "\n" not in str(refused.value)


def test_another_silicone_has_another_law() -> None:
    assert with_law(OGDEN).with_(material={"name": "dragon-skin-10"}).material.law is None


def test_a_law_that_is_not_the_named_silicones_is_told() -> None:
    named = with_law(OGDEN, name="ecoflex-00-30")
    mismatch = foreign_modulus(named)
    assert mismatch is not None
    assert mismatch[1].value == pytest.approx(0.9, rel=1e-2)


def test_a_labs_silicone_may_have_a_law(tmp_path: Path) -> None:
    lab = tmp_path / "lab.toml"
    lab.write_text('[lab-10.law]\nkind = "gent"\nmu = 0.1\nj_m = 12.0\n')
    design = skincad.load("yamada-2002", ["material.name=lab-10"], silicones=lab)
    assert silicone(design).young_modulus.value == pytest.approx(0.2998, rel=1e-12)  # nu 0.499
    assert pad_of(design).law is not None
    lab.write_text('[lab-10]\nyoung_modulus = 0.4\n[lab-10.law]\nkind = "gent"\nmu = 0.1\nj_m = 12.0\n')
    with pytest.raises(InputError, match=r"silicones\.lab-10\.young_modulus: must be within 1%"):
        skincad.load("yamada-2002", ["material.name=lab-10"], silicones=lab)


def test_an_editor_is_told_of_every_law() -> None:
    law = json.loads(schema_of("designs"))["$defs"]["Material"]["properties"]["law"]
    kinds = {one["properties"]["kind"]["const"] for one in law["anyOf"][0]["oneOf"]}
    assert kinds == set(LAWS)
