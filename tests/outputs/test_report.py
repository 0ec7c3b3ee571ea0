"""The report: whole in itself, each figure with its command, and a command that works when it is copied."""

from __future__ import annotations

import base64
import io
import re
import shlex
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from html import unescape
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
import typer
from PIL import Image

import skincad
from skincad.base import Estimate, InputError
from skincad.cli import app
from skincad.effects import Piezo
from skincad.fabrication import Build, Job, design_findings, warning
from skincad.inputs import Design
from skincad.mechanics import ContactCheck
from skincad.outputs import makes, report
from skincad.scenes import LEVELS, Simulation, at_level
from tests.conftest import run_skincad
from tests.outputs.test_calculations import VARIANTS, design_of
from tests.refusals import refused_command
from tests.small_scene import THIRD, small_scene

PNG = b"\x89PNG not looked at"
LARGEST = 3_000_000  # bytes: what a person still forwards
PAIR: dict[str, Any] = {
    "skin": {"width": 4.0},
    "contact": {"force": 0.9},
    "ridge": {"count": 2, "heights": [0.5, 0.47]},
}


def job_of(design: Design, check: ContactCheck | None, scenes: tuple[Simulation, ...] = ()) -> Build:
    job = Job(design)
    return Build(job, {}, None, tuple(design_findings(job)), check, scenes)


def page_of(job: Build, picture: bytes = PNG) -> str:
    return report.report(job, lambda: picture, makes.sheet_text(job), makes.drawing_svg(job))


class Page(HTMLParser):
    """Addresses, figures' captions and commands, ids, open tags."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.addresses: list[str] = []
        self.ids: list[str] = []
        self.captions = 0
        self.images = 0
        self.commands: list[str] = []
        self.open: list[str] = []
        self.wrong: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        attributes = dict(attrs)
        self.addresses += [
            attributes[key] or "" for key in ("src", "href", "data", "action") if key in attributes
        ]
        self.ids += [attributes["id"] or ""] if "id" in attributes else []
        self.images += tag == "img"
        self.captions += tag == "figcaption"
        if tag not in ("meta", "img", "br", "link", "input"):
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if not self.open or self.open.pop() != tag:
            self.wrong.append(tag)

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "code":
            self.commands.append(data)


@cache
def checked() -> Build:
    """Two unlike ridges of yamada-2002, by a model that knows what the yield is, with a finding."""
    design = skincad.load("yamada-2002").with_(**PAIR)
    finding = warning("edge radius", "the cavity's floor", 0.04, 0.05, "mm", "take a finer tool")
    return replace(job_of(design, skincad.check(design, model="linear")), findings=(finding,))


@cache
def checked_page() -> str:
    return page_of(checked())


@cache
def unchecked_page() -> str:
    return page_of(replace(checked(), check=None))


@pytest.fixture(scope="module")
def felt(tmp_path_factory: pytest.TempPathFactory) -> Simulation:
    few = ("history.steps=20", "history.time_s=[0.0, 0.02]", THIRD, "history.tangential_force_N=[0.0, 0.1]")
    scene = small_scene(tmp_path_factory.mktemp("scene"), "steady-pull", *few, "readout.ridges=[1, 2]")
    return at_level(scene, LEVELS[0])  # its error is the command's to find


@pytest.fixture(scope="module")
def whole(felt: Simulation) -> str:
    design = felt.scene.design
    return page_of(job_of(design, skincad.check(design, model="winkler"), (felt,)))


@pytest.fixture(params=["checked", "unchecked", "whole"])
def text(request: pytest.FixtureRequest) -> str:
    if request.param == "whole":
        return str(request.getfixturevalue("whole"))
    return checked_page() if request.param == "checked" else unchecked_page()


def pictures(text: str) -> Iterator[str]:
    """The SVG pictures that a page holds."""
    for data in re.findall(r'src="data:image/svg\+xml;base64,([^"]*)"', text):
        yield base64.b64decode(data).decode()


@pytest.mark.slow
def test_it_needs_nothing_else(text: str) -> None:
    page = Page(text)
    assert not page.wrong
    assert not page.open
    assert all(address.startswith(("data:", "#")) for address in page.addresses)
    assert {a[1:] for a in page.addresses if a.startswith("#")} <= {*page.ids}
    assert len(set(page.ids)) == len(page.ids)
    for word in ("http:", "https:", "url(", "@import", "<script", "file:"):
        drawn = re.sub(r'src="data:[^"]*"|xmlns="[^"]*"', "", text)
        assert word not in drawn, word
    assert len(text.encode()) <= LARGEST
    for drawn in pictures(text):
        assert not re.findall(r'(?:href|src)="(?!#)[^"]*"', drawn)
        assert "font-family" not in drawn


def test_every_figure_says_where_it_is_from(text: str) -> None:
    page = Page(text)
    assert page.images == page.captions > 0
    captions = re.findall(r"<figcaption>(.*?)</figcaption>", text)
    assert all("By <code>skincad " in caption for caption in captions)


def test_commands_are_ones_that_there_are(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each is parsed by the command line, and what it names is loaded."""
    monkeypatch.chdir(tmp_path)
    for name, data in re.findall(r'download="([^"]*)" href="data:text/plain;base64,([^"]*)"', text):
        Path(name).write_bytes(base64.b64decode(data))
    known: Any = typer.main.get_command(app.app)
    commands = {c for c in Page(text).commands if c.startswith("skincad ")}
    assert any(c.startswith("skincad make ") for c in commands)
    for command in commands - {"skincad check design.toml --measured crests.csv"}:
        _, name, *words = shlex.split(command)
        options = known.commands[name].make_context(name, list(words)).params
        load = {"simulate": skincad.load_scene, "circuit": skincad.load_circuit}.get(
            name, skincad.load_design
        )
        load(options["source"], options["settings"])


@pytest.mark.slow
@pytest.mark.dear("a check and a report of pins, and of a face")
def test_magnets_have_their_part_and_a_face_has_no_margin() -> None:
    """What is said of magnets is what `check` says; a face touches from the first contact on."""
    pins, face = skincad.load("magnet-pillars"), skincad.load("flat-magnet")
    check = skincad.check(pins, model="reduced")
    page = page_of(job_of(pins, check))
    assert 'href="#magnets"' in page
    assert "9 sensors tell all 27 components of the pins&#x27; forces apart" in page or (
        "9 sensors tell all 27 components of the pins' forces apart" in page
    )
    z = check.magnet.sensors[4].change[2]
    assert f"{z.value:.3f} ± {z.error:.3f}" in page
    assert "-0.000 ±" not in page
    assert "pin.tip_diameter" in page
    assert "Differences of the reduced model" in page
    page = page_of(job_of(face, skincad.check(face, model="linear")))
    assert "margin" not in page.partition('id="findings"')[0].partition("<main>")[2]
    assert 'id="magnets"' not in page


def test_a_copied_check_gives_the_printed_verdict(yamada: Design, tmp_path: Path) -> None:
    design = yamada.with_(ridge={"height": 0.6, "count": 3}, skin={"width": 5.0})
    page = Page(page_of(job_of(design, skincad.check(design, model="winkler"))))
    line = next(c for c in page.commands if c.startswith("skincad check "))
    settings = "--set skin.width=5.0 --set ridge.count=3 --set ridge.height=0.6"
    assert line == f"skincad check yamada-2002 {settings} --model winkler"
    process = run_skincad(*shlex.split(line)[1:], "--no-advice", cwd=tmp_path)
    verdict = skincad.check(design, model="winkler")
    assert str(verdict.all_touch_force) in process.stdout


def test_the_verdict_its_error_and_what_it_rests_on() -> None:
    text, check = unescape(checked_page()), checked().check
    assert check is not None
    assert check.manufacture is not None
    share = check.manufacture.passing.value
    assert 0.0 < share <= 1.0
    assert re.search(rf">{100 * share:.0f}(\.\d)? % \(", text)
    for entry in (
        "skincad report: yamada-2002",
        str(check.all_touch_force),
        f"{check.unknowns} unknowns",
        *(f"leaving out {part.effect}" for part in check.left_out),
        "skin.curvature_radius",
        skincad.__version__,
    ):
        assert entry in text, entry
    cells = "warning", "edge radius", "the cavity's floor", "0.04", "0.05", "mm", "take a finer tool"
    assert re.search(r"</td>\s*<td[^>]*>".join(cells), text)


def test_what_the_models_leave_out_is_what_the_error_has() -> None:
    """The table of models and the error's parts name the same effects, friction of an unknown plate too."""
    check = checked().check
    assert check is not None
    parts = {part.effect for part in check.left_out}
    row = re.search(r"<td>linear</td>\s*<td>([^<]*)</td>", checked_page())
    assert row is not None
    assert "friction" in parts
    assert {*row[1].split(", ")} == parts


FAST = {"one ridge", "own heights", "doubly curved"}
KINDS = [
    *(n if n in FAST else pytest.param(n, marks=pytest.mark.evidence(subject="reports")) for n in VARIANTS),
    *(pytest.param(n, marks=pytest.mark.evidence(subject=n)) for n in ("plain-ridges", "fingertip-soft")),
]


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_design_has_a_report(name: str) -> None:
    design = design_of(name)
    page = Page(page_of(job_of(design, skincad.check(design, model="winkler"))))
    assert not page.wrong
    assert {"verdict", "models", "yield", "sensitivities", "findings", "calculation", "sheet"} <= {*page.ids}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"out_of_range": "it is crushed", "manufacture": None}, "UNDECIDED: it is crushed."),
        ({"all_touch_force": Estimate(None, None, "N"), "touching": 3}, "beyond the model"),
        ({"all_touch_force": Estimate(0.0, 0.0, "N"), "left_out": ()}, "As drawn they do at once"),
        (
            {"all_touch_force": Estimate(0.0, 0.0, "N"), "left_out": (), "manufacture": None},
            "already do at 0 N",
        ),
    ],
)
def test_verdicts_without_numbers_are_told(changes: dict[str, Any], says: str) -> None:
    check: Any = checked().check
    text = page_of(replace(checked(), check=replace(check, **changes)))
    assert says in unescape(text)


def test_without_a_verdict_its_parts_say_so() -> None:
    text = unchecked_page()
    assert text.count("Not checked whether all ridges touch. This part needs a verdict.") == 3
    assert re.search("<code>skincad make yamada-2002 [^<]* --no-check</code>", text)
    assert "Calculation" in text


@pytest.mark.slow
def test_the_same_design_gives_the_same_bytes() -> None:
    again = replace(checked(), check=replace(checked().check, seconds={"total": 99.0}))  # type: ignore[type-var]
    assert page_of(again) == checked_page()


def test_a_scene_is_shown_with_its_amplifier_and_its_files(whole: str, felt: Simulation) -> None:
    page = Page(whole)
    assert "skincad simulate scene-steady-pull.toml" in page.commands
    assert any(c.startswith("skincad circuit transimpedance --set film.area=") for c in page.commands)
    for entry in felt.left_out:
        assert entry.indicator in unescape(whole)
    assert 'download="scene-steady-pull.toml"' in whole
    assert "--scene scene-steady-pull.toml" in whole


def test_a_scenes_amplifier_is_shown_without_the_rig_that_it_was_measured_with(felt: Simulation) -> None:
    drawn, _ = report.amplifier_part(felt, Piezo(circuit="yamada-2002"))
    assert "--set indenter=none --set force_sensor=none" in drawn
    assert "without a cut-off" in drawn
    assert "as measured with its rig" not in drawn


def test_without_a_scene_it_says_what_adds_one(yamada: Design) -> None:
    design = yamada.with_(ridge={"count": 3}, skin={"width": 5.0})
    scene = report.suggested_scene(design)
    assert scene is not None
    wanted = f"skincad make yamada-2002 --set skin.width=5.0 --set ridge.count=3 --scene {scene}"
    assert wanted in Page(page_of(job_of(design, None))).commands
    assert "skincad make --scene FILE adds one of yours" in checked_page()  # no template has two ridges


@pytest.mark.parametrize("name", skincad.template_names())
def test_a_suggested_scene_takes_the_skin(name: str) -> None:
    design = skincad.load(name)
    scene = report.suggested_scene(design)
    simulated = design.ridge is None or (design.film is not None and name != "fingertip-soft")
    assert (scene is not None) == simulated
    if scene is not None:
        assert skincad.load_scene(scene, skin=design).design == design


def test_scenes_are_results_of_the_skin_that_is_made(yamada: Design, felt: Simulation) -> None:
    with pytest.raises(InputError, match=r"scenes: must be of the skin that is made.*load_scene"):
        skincad.make(yamada, scenes=[felt])
    with pytest.raises(InputError, match="scenes: must be what simulate returns"):
        skincad.make(yamada, scenes=[felt.scene])  # type: ignore[list-item]
    with pytest.raises(InputError, match="scenes: must have names of their own"):
        skincad.make(felt.scene.design, scenes=[felt, felt])


@pytest.mark.slow
def test_an_amplifier_without_a_gain_is_no_end(felt: Simulation, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(_: object) -> None:
        raise InputError("sweep", "gives no finite gain")

    monkeypatch.setattr("skincad.circuit.bode.gain", refused)
    text = report.scene_part(felt, "design.toml").html
    assert "Its gain cannot be computed: sweep: gives no finite gain." in text


def test_a_preview_has_no_report(yamada: Design, tmp_path: Path) -> None:
    assert "report.html" in makes.names(yamada)
    assert "report.html" not in makes.names(yamada, solids=False, preview=True)
    message = refused_command("make", "yamada-2002", "--preview", "--scene", "hold", cwd=tmp_path)
    assert message.startswith("--scene: are for the report, which --preview leaves out")


@pytest.mark.slow
def test_the_command_runs_a_scene_for_the_report(tmp_path: Path) -> None:
    few = ("history.steps=4", "history.time_s=[0.0, 0.02]", THIRD, "history.tangential_force_N=[0.0, 0.1]")
    scene = small_scene(tmp_path, "steady-pull", *few, "readout.ridges=[2]")
    (tmp_path / "skin.toml").write_text(scene.design.to_toml())
    (tmp_path / "scene.toml").write_text(scene.to_toml())
    words = ("make", "skin.toml", "--no-check", "--scene", "scene.toml", "--format", "html", "--json")
    process = run_skincad(*words, cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    assert '"scenes": [{"name": "steady-pull"' in process.stdout
    assert "Scene steady-pull" in (tmp_path / "out" / "yamada-2002" / "report.html").read_text("utf-8")


@pytest.mark.parametrize(
    "name",
    [
        pytest.param("yamada-2002", marks=pytest.mark.slow),
        *(pytest.param(n, marks=pytest.mark.evidence(subject=n)) for n in ("steep-fingertip", "gripper-pad")),
    ],
)
def test_in_a_browser_without_a_network(name: str, tmp_path: Path, request: pytest.FixtureRequest) -> None:
    from tests.outputs.browser import shown

    if name == "yamada-2002":
        file = request.getfixturevalue("made").folder / "report.html"
    else:
        skincad.write(skincad.make(skincad.load(name), model="winkler"), tmp_path / "made", formats="html")
        file = tmp_path / "made" / "report.html"
    assert file.stat().st_size <= LARGEST
    with shown(file) as seen:
        assert name in seen.page.inner_text("h1")
        images = seen.page.locator("img")
        assert images.count() > 0
        for image in images.all():
            assert image.evaluate("image => image.complete && image.naturalWidth > 0")
        assert [request for request in seen.requests if not request.startswith("data:")] == [file.as_uri()]
        assert seen.complaints == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [1400, 420])
def test_contents_stay_beside_a_wide_page_and_fold_above_a_narrow_one(
    width: int, yamada: Design, tmp_path: Path
) -> None:
    from tests.outputs.browser import shown

    dot = io.BytesIO()
    Image.new("RGB", (1452, 814)).save(dot, "PNG")
    file = tmp_path / "report.html"
    job = job_of(yamada, skincad.check(yamada, model="linear"))
    file.write_text(page_of(job, dot.getvalue()), "utf-8")
    with shown(file, (width, 900)) as seen:
        page = seen.page
        assert seen.overflow() == 0
        wide, folded = page.locator("nav.column"), page.locator("nav.folded")
        assert (wide.is_visible(), folded.is_visible()) == (width == 1400, width == 420)
        figures = [image.bounding_box() for image in page.locator("figure img").all()]
        assert len(figures) > 3
        assert {box["width"] for box in figures if box} == {page.locator("h1").bounding_box()["width"]}  # type: ignore[index]
        links = wide if width == 1400 else folded
        if width == 420:
            assert not links.locator("a").first.is_visible()
            page.click("summary")
        links.locator("a", has_text="To make it again").click()
        head = page.locator("#files").bounding_box()
        assert head is not None
        assert 0 <= head["y"] < 900
        assert page.evaluate("scrollY") > 1000
        if width == 1400:
            box = wide.bounding_box()
            assert box is not None
            assert 0 <= box["y"] < 100  # still in view
            assert box["x"] + box["width"] <= head["x"]
        page.emulate_media(media="print")
        assert not wide.is_visible()
        assert not folded.is_visible()
        assert seen.complaints == []
