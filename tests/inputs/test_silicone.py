"""A lab's own silicones and a silicone's law: how they reach a design, which are refused; moduli that can't
be meant."""

from __future__ import annotations

import json
import tomllib
from pathlib import Path
from typing import Any

import pytest
import tomlkit

import skincad
from skincad.base import InputError
from skincad.fabrication import Job, design_findings
from skincad.inputs import Design, Silicone, foreign_modulus, silicones, table_text, template_names
from skincad.laws import LAWS, NeoHooke, Ogden
from skincad.mechanics import pad_of, spread_of
from skincad.outputs import schema_of
from skincad.scenes import load_scene
from tests.conftest import run_skincad
from tests.mechanics.designs import reference
from tests.small_scene import THIRD, small_scene

OWN = """
[dragon-skin-30]
young_modulus = { value = 0.9, low = 0.8, high = 1.0 }

[lab-10]
young_modulus = 0.25
mix = [10.0, 1.0]
platinum_cure = false

[soft-batch]
based_on = "ecoflex-00-30"
viscosity = 4.0
"""


def silicone(design: Design) -> Silicone:
    return Job(design).silicone


@pytest.fixture
def lab(tmp_path: Path) -> Path:
    path = tmp_path / "lab.toml"
    path.write_text(OWN)
    return path


def test_every_shipped_silicone_has_a_range_that_spans_its_sources() -> None:
    """Each source's modulus at small strain lies within; those with two differ by a factor of 1.7 to 2.8."""
    assert list(silicones()) == list(tomllib.loads(table_text("silicones")))
    for name, entry in silicones().items():
        assert entry.name == name
        assert {"mix", "pot_life_min", "cure_h", "viscosity", "source"} <= entry.model_fields_set
        rows = [source.modulus(entry.poisson_ratio) for source in entry.sources]
        assert entry.young_modulus.low < entry.young_modulus.high
        assert entry.young_modulus.low <= min(rows) <= max(rows) <= entry.young_modulus.high, name
        assert len(rows) == 1 or 1.7 < max(rows) / min(rows) < 2.8, name
    assert [name for name in template_names() if foreign_modulus(skincad.load(name))] == []


def test_the_databases_moduli_are_three_times_mu() -> None:
    """E0 = 3 mu = 0.044, 0.121, 0.336, 0.505 MPa; data sheets 0.118, 0.260, 0.579, 1.016 by 100 % modulus."""
    names = ("ecoflex-00-30", "dragon-skin-10", "dragon-skin-20", "dragon-skin-30")
    entries = [silicones()[name] for name in names]
    rows = [[source.modulus(0.5) for source in entry.sources] for entry in entries]
    assert [first for first, _ in rows] == pytest.approx([0.0435, 0.1206, 0.3363, 0.5046], rel=1e-3)
    psi = 0.00689476  # MPa; neo-Hooke at a stretch of 2 is E / 3 (2 - 1 / 4)
    by_sheet = [3 * pull * psi / 1.75 for pull in (10, 22, 49, 86)]
    assert [last for _, last in rows] == pytest.approx(by_sheet, rel=3e-3)


@pytest.mark.parametrize(
    ("row", "told"),
    [
        ("what = 'a'\nwhere = 'b'", "needs a young_modulus or a law, and not both"),
        ("what = 'a'\nwhere = 'b'\nyoung_modulus = 1.0\nlaw = {kind = 'neo-hooke', mu = 0.3}",
         "and not both"),
        ("what = 'a'\nyoung_modulus = 1.0", "where: is missing"),
    ],
)  # fmt: skip
def test_a_source_that_says_nothing_is_refused(row: str, told: str, tmp_path: Path) -> None:
    path = tmp_path / "lab.toml"
    path.write_text(f"[lab-10]\nyoung_modulus = 0.3\n[[lab-10.sources]]\n{row}\n")
    with pytest.raises(InputError, match=told):
        skincad.load("yamada-2002", silicones=path)


def test_an_own_file_changes_what_it_names_and_adds_what_is_new(lab: Path) -> None:
    design = skincad.load("yamada-2002", silicones=lab)
    known, shipped = silicones(design.silicones), silicones()
    changed = {"young_modulus": known["dragon-skin-30"].young_modulus}
    assert known["dragon-skin-30"].young_modulus.value == 0.9
    assert known["dragon-skin-30"] == shipped["dragon-skin-30"].model_copy(update=changed)
    new = known["lab-10"]
    assert (new.name, new.mix, new.platinum_cure) == ("lab-10", [10.0, 1.0], False)
    assert (new.density, new.source) == (1070.0, "assumption")
    changed = {"name": "soft-batch", "viscosity": 4.0}
    assert known["soft-batch"] == shipped["ecoflex-00-30"].model_copy(update=changed)
    assert known["sylgard-184"] == shipped["sylgard-184"]


def test_the_design_means_it_by_name_and_its_own_values_come_first(lab: Path) -> None:
    design = skincad.load("lab-bench", ["material.name=lab-10"], silicones=lab)
    assert silicone(design).young_modulus.value == 0.25
    assert spread_of(design).modulus == (0.25, 0.25, 0.25)
    assert silicone(design.with_(material={"density": 990.0})).density == 990.0
    assert silicone(design.with_(material={"name": "soft-batch"})).viscosity == 4.0
    assert skincad.load("lab-bench", silicones=tomllib.loads(OWN)) == skincad.load("lab-bench", silicones=lab)
    with pytest.raises(InputError, match=r"^silicones: must be a TOML file, or tables, got 3$"):
        skincad.load("lab-bench", silicones=3)
    typed = ["silicones.lab-10.viscosity=2", "material.name=lab-10"]
    assert silicone(skincad.load("lab-bench", typed, silicones=lab)).viscosity == 2
    before = {"lab-10": {"young_modulus": 0.3, "density": 990.0}, "third": {"young_modulus": 1.0}}
    design = skincad.load("lab-bench").with_(silicones=before)
    file = lab.with_name("own.toml")
    file.write_text(design.to_toml())
    known = silicones(skincad.load(file, silicones=lab).silicones)
    assert (known["lab-10"].young_modulus.value, known["lab-10"].density) == (0.25, 990.0)
    assert known["third"].young_modulus.value == 1.0


def test_the_design_carries_them_without_the_file(lab: Path, tmp_path: Path) -> None:
    design = skincad.load("lab-bench", ["material.name=lab-10"], silicones=lab)
    exact = {"value": 0.25, "low": 0.25, "high": 0.25}
    assert design.model_dump()["silicones"] == {
        **tomllib.loads(OWN),
        "lab-10": {"young_modulus": exact, "mix": [10.0, 1.0], "platinum_cure": False},
    }
    copy = tmp_path / "elsewhere" / "design.toml"
    copy.parent.mkdir()
    copy.write_text(tomlkit.dumps(design.model_dump(exclude_none=True)))
    lab.unlink()
    assert skincad.load(copy) == design
    assert hash(skincad.load(copy)) == hash(design)
    assert design != design.with_(silicones={"lab-10": {"young_modulus": 0.3}})


def test_a_scenes_skin_may_be_of_them(lab: Path, tmp_path: Path) -> None:
    skin = skincad.load("yamada-2002").model_dump(exclude_none=True)
    skin["material"] = {"name": "lab-10"}
    (tmp_path / "skin.toml").write_text(tomlkit.dumps(skin))
    scene = load_scene("hold", [f"skin={tmp_path / 'skin.toml'}"], silicones=lab)
    assert silicone(scene.design).young_modulus.value == 0.25
    written = tmp_path / "scene.toml"
    written.write_text(scene.to_toml())
    lab.unlink()
    assert load_scene(written).design == scene.design
    with pytest.raises(InputError, match=r"^skin\.material\.name: unknown silicone, got 'lab-10'"):
        load_scene("hold", [f"skin={tmp_path / 'skin.toml'}"])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[lab-10]\nviscosty = 1.0", "silicones.lab-10.viscosty: unknown key; did you mean 'viscosity'?"),
        ("[lab-10]\nviscosity = 1.0", "lab-10.young_modulus: is missing for a new silicone; give it, or"),
        ("[lab-10]\nyoung_modulus = 250", "MPa, got 250; is it in MPa? 250 kPa is 0.25 MPa"),
        ("[lab-10]\nbased_on = 'dragonskin-30'",
         "lab-10.based_on: unknown silicone, got 'dragonskin-30'; did"),
        ("[dragon-skin-30]\nbased_on = 'x'", "based_on: unknown silicone, got 'x'; known: dragon-skin-10, "),
        ("[dragon-skin-30]\nbased_on = 'sylgard-184'", "must not be given for dragon-skin-30, which ships"),
        ("[LAB]\nyoung_modulus = 1", "silicones: the name must be 3 to 32 lower-case letters, digits and -"),
        ("[lab-10]\nyoung_modulus = 1\nmix = [1.0]", "silicones.lab-10.mix: "),
        ("lab-10 = 1.0", "silicones.lab-10: must be a table, [silicones.lab-10], got 1"),
        ("name = 'x'\n[ridge]", "lab.toml: is a design, not a table of silicones; give it to make, check"),
        ("[sla]\nlayer = 0.1", "lab.toml: is a table of processes, not a table of silicones; give it to"),
        ("[lab", "lab.toml: is not TOML"),
    ],
)  # fmt: skip
def test_a_bad_file_is_refused_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str, message: str
) -> None:
    monkeypatch.chdir(tmp_path)  # a message shows the first 80 letters of a path
    path = Path("lab.toml")
    path.write_text(text)
    with pytest.raises(InputError) as refused:
        skincad.load("lab-bench", silicones=path)
    assert message in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(("wrong", "right"), [("lab-1", "lab-10"), ("dragon-skn-30", "dragon-skin-30")])
def test_a_wrong_name_is_told_with_the_nearest_of_both(wrong: str, right: str, lab: Path) -> None:
    with pytest.raises(InputError, match=rf"material\.name: unknown silicone, .*did you mean '{right}'"):
        skincad.load("lab-bench", [f"material.name={wrong}"], silicones=lab)


@pytest.mark.parametrize(
    ("modulus", "asked"),
    [
        (800000.0, "got 800000; is it in MPa? 800000 Pa is 0.8 MPa"),
        (69000.0, "got 69000; is it in MPa? 69000 Pa is 0.069 MPa"),
        (800.0, "got 800; is it in MPa? 800 kPa is 0.8 MPa"),
        (0.0008, "got 0.0008; is it in MPa? 0.0008 GPa is 0.8 MPa"),
        (1e300, "got 1e+300; is it in MPa?"),
        ({"value": 50.0, "low": 40.0, "high": 400.0}, "got 400; is it in MPa? 400 kPa is 0.4 MPa"),
    ],
)
def test_a_modulus_of_no_silicone_asks_for_its_unit(yamada: Design, modulus: object, asked: str) -> None:
    with pytest.raises(InputError) as refused:
        yamada.with_(material={"young_modulus": modulus})
    assert str(refused.value) == f"material.young_modulus: must be from 0.001 to 100 MPa, {asked}"


def modulus_words(design: Design) -> tuple[list[str], list[str]]:
    """What make and check say of a name with another's modulus."""
    findings = [str(f) for f in design_findings(Job(design)) if f.rule == "silicone"]
    return findings, [w for w in skincad.check(design, model="winkler").warnings if "modulus" in w]


def test_a_name_with_anothers_modulus_is_told(yamada: Design) -> None:
    data = {"name": "ecoflex-00-30", "young_modulus": {"value": 0.8, "low": 0.65, "high": 0.95}}
    soft = yamada.with_(material=data)
    drop = "drop material.young_modulus or, if you measured it, drop the name"
    whose = f"use the name dragon-skin-30, which it fits; or {drop}"
    (finding,), (warning,) = modulus_words(soft)
    words = "warning: silicone: material.young_modulus, which is not that of ecoflex-00-30: 0.8 MPa"
    assert finding == f"{words}, limit 0.125; {whose}"
    assert warning == f"the modulus of 0.8 MPa is not that of ecoflex-00-30 (0.04 to 0.125 MPa); {whose}"
    hard = yamada.with_(material={"name": "sylgard-184", "young_modulus": 90.0})
    assert modulus_words(hard)[1] == [
        f"the modulus of 90 MPa is not that of sylgard-184 (1.3 to 3 MPa); {drop}"
    ]
    softer = yamada.with_(material={"name": "sylgard-184", "young_modulus": 0.2})
    assert "0.2 MPa, limit 1.3; use the name dragon-skin-10" in modulus_words(softer)[0][0]


@pytest.mark.slow
def test_a_scene_is_told_so_too(tmp_path: Path) -> None:
    change = {"name": "dragon-skin-10", "young_modulus": 0.8}
    scene = small_scene(tmp_path, "yamada-2002-press", THIRD, "history.steps=2", "readout.ridges=[1]")
    warnings = skincad.simulate(scene.with_(skin={"material": change}), budget=0.01).warnings
    words = "the modulus of 0.8 MPa is not that of dragon-skin-10 (0.11 to 0.3 MPa)"
    assert any(words in warning for warning in warnings)


def test_a_batch_within_the_published_range_is_not_told(yamada: Design) -> None:
    few = skincad.load("plain-ridges", ["ridge.count=3", "skin.width=5.0", "contact.force=0.5"])
    assert modulus_words(few) == ([], [])
    for low, value, high in ((0.125, 0.14, 0.15), (0.03, 0.035, 0.04)):
        touching = {"value": value, "low": low, "high": high}
        design = few.with_(material={"name": "ecoflex-00-30", "young_modulus": touching})
        assert modulus_words(design) == ([], [])
    assert modulus_words(few.with_(material={"name": None, "young_modulus": 5.0})) == ([], [])
    for modulus in (1e-3, 100.0):
        assert silicone(yamada.with_(material={"young_modulus": modulus})).young_modulus.value == modulus


@pytest.mark.slow
def test_the_command_line_takes_a_lab(tmp_path: Path, lab: Path) -> None:
    chosen = ("--silicones", str(lab), "--set", "material.name=lab-10", "--set", "ridge.count=1")
    out = ("--format", "toml", "-o", str(tmp_path / "made"))
    result = run_skincad("make", "lab-bench", *chosen, *out, "--tier", "winkler", "--json", cwd=tmp_path)
    assert result.returncode in (0, 1), result.stderr
    lab.unlink()
    assert silicone(skincad.load(tmp_path / "made" / "design.toml")).young_modulus.value == 0.25
    checked = run_skincad("check", "made/design.toml", "--tier", "winkler", "--json", cwd=tmp_path)
    verdict, again = json.loads(result.stdout)["check"], json.loads(checked.stdout)
    assert (verdict["approach_mm"], verdict["tier"]) == (again["approach_mm"], again["tier"])


@pytest.mark.parametrize(
    "words",
    [
        "make lab-bench",
        "check lab-bench",
        "simulate hold",
        "accuracy lab-bench",
        "fit-material x.csv --design lab-bench",
    ],
)
def test_every_command_with_a_skin_refuses_a_bad_lab(words: str, tmp_path: Path) -> None:
    (tmp_path / "lab.toml").write_text("[lab-10]\nviscosty = 1.0")
    result = run_skincad(*words.split(), "--silicones", "lab.toml", cwd=tmp_path)
    assert result.returncode == 2
    rule = "silicones.lab-10.viscosty: unknown key; did you mean 'viscosity'?\n"
    assert result.stderr in (f"skincad: {rule}", f"skincad: skin.{rule}")


def test_fit_material_takes_them_only_with_a_design(tmp_path: Path, lab: Path) -> None:
    result = run_skincad("fit-material", "x.csv", "--silicones", str(lab), cwd=tmp_path)
    assert result.stderr == "skincad: --silicones: needs --design; name the design with --design\n"


OGDEN: dict[str, Any] = {"kind": "ogden", "mu": [0.1, 0.2], "alpha": [3.0, -1.5]}


def with_law(law: object, **material: Any) -> Design:
    return reference().with_(material={"name": None, "young_modulus": None, "law": law, **material})


def test_a_law_gives_the_modulus_and_its_range(tmp_path: Path) -> None:
    """E = 2 (1 + nu) G, G the sum of Ogden's mu."""
    material = silicone(with_law(OGDEN, poisson_ratio=0.49))
    assert material.young_modulus.value == pytest.approx(2 * 1.49 * 0.3, rel=1e-14)
    assert material.young_modulus.low == material.young_modulus.high == material.young_modulus.value
    assert pad_of(with_law(OGDEN)).law == Ogden(mu=[0.1, 0.2], alpha=[3.0, -1.5])
    material = silicone(with_law(OGDEN, young_modulus={"value": 0.9, "low": 0.8, "high": 1.1}))
    assert (material.young_modulus.low, material.young_modulus.high) == (0.8, 1.1)
    with pytest.raises(InputError, match=r"material\.young_modulus: must be within 1% of the 0\.8994 MPa"):
        with_law(OGDEN, young_modulus=0.95)
    path = tmp_path / "skin.toml"
    path.write_text(with_law(OGDEN).to_toml())
    assert skincad.load(path) == with_law(OGDEN)
    assert hash(skincad.load(path)) == hash(with_law(OGDEN))
    law = json.loads(schema_of("designs"))["$defs"]["Material"]["properties"]["law"]
    kinds = {one["properties"]["kind"]["const"] for one in law["anyOf"][0]["oneOf"]}
    assert kinds == set(LAWS)


def test_neo_hookes_law_is_what_a_pad_has_without_one() -> None:
    assert pad_of(with_law({"kind": "neo-hooke", "mu": 0.3})).laws == {}
    assert isinstance(silicone(with_law({"kind": "neo-hooke", "mu": 0.3})).law, NeoHooke)
    assert pad_of(reference()).laws == {}
    assert with_law(OGDEN).with_(material={"name": "dragon-skin-10"}).material.law is None
    named = with_law(OGDEN, name="ecoflex-00-30")
    mismatch = foreign_modulus(named)
    assert mismatch[1].value == pytest.approx(0.9, rel=1e-2)


@pytest.mark.parametrize(
    ("law", "told"),
    [
        ({"kind": "gent", "mu": 0.2}, r"material\.law\.j_m: is missing"),
        ({"kind": "gent", "mu": 0.2, "jm": 3.0}, r"material\.law\.jm: unknown key; did you mean 'j_m'"),
        ({"kind": "gint", "mu": 0.2}, r"material\.law\.kind: unknown law, got 'gint'; did you mean 'gent'"),
        ({"kind": "yeoh", "c10": 0.2, "c20": -1.0}, r"material\.law: must pull a bar the more"),
        ({"kind": "neo-hooke", "mu": 1e-5},
         r"material\.law: must have a modulus at small strain from 0\.001"),
        (3, r"material\.law: must be a table, \[material\.law\], got 3"),
    ],
)  # fmt: skip
def test_a_law_that_is_none_is_refused_in_one_line(law: object, told: str) -> None:
    with pytest.raises(InputError, match=told) as refused:
        with_law(law)
    assert "\n" not in str(refused.value)


def test_a_labs_silicone_may_have_a_law(tmp_path: Path) -> None:
    lab = tmp_path / "lab.toml"
    lab.write_text('[lab-10.law]\nkind = "gent"\nmu = 0.1\nj_m = 12.0\n')
    design = skincad.load("yamada-2002", ["material.name=lab-10"], silicones=lab)
    assert silicone(design).young_modulus.value == pytest.approx(0.2998, rel=1e-12)  # nu 0.499
    assert pad_of(design).law is not None
    lab.write_text('[lab-10]\nyoung_modulus = 0.4\n[lab-10.law]\nkind = "gent"\nmu = 0.1\nj_m = 12.0\n')
    with pytest.raises(InputError, match=r"silicones\.lab-10\.young_modulus: must be within 1%"):
        skincad.load("yamada-2002", ["material.name=lab-10"], silicones=lab)
