"""Every figure that a result offers: nothing cut off, no legend on a curve, a unit on every axis."""

from __future__ import annotations

import csv
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import shapely
from matplotlib.collections import TriMesh
from matplotlib.text import Text
from matplotlib.transforms import Bbox

import skincad
from skincad.base import Result
from skincad.fabrication import Job, mesh, upright
from skincad.inputs import PressCurve
from skincad.mechanics import sensitivities
from skincad.outputs import Axes, accuracy_figure, gain_figure, sheet
from skincad.outputs.figures import canvas, results, scenes
from skincad.outputs.figures import design as pictures
from skincad.scenes import LEVELS, at_level
from skincad.studies import Accuracy, ErrorMeasure, Ladder, Measurement
from tests.designs import RIDGED
from tests.small_scene import THIRD, small_scene

UNITS = (
    *(
        "mm",
        "ms",
        "N",
        "mN",
        "uT",
        "MPa",
        "MPa/s",
        "MPa/s$^2$",
        "mm/mm",
        "Hz",
        "dB",
        "dB re 1 V/N",
        "s",
        "V",
        "mV",
        "uV",
        "um",
    ),
    *("mm3", "pC/N", "rad", "deg", "%", "ohm", "F", "1"),
)
NUMBERED = ("ridge", "ring", "pin", "face", "step", "sample at")  # what is counted has none
EDGE = 1.0  # pixel; where a letter's own smoothing ends


def small(name: str, folder: Path, *more: str) -> Result:
    few = ("history.steps=24", THIRD, *more)
    return skincad.simulate(small_scene(folder, name, *few), tol=0.5)


def pad_test(folder: Path) -> Result:
    strain = np.linspace(0.01, 0.5, 30)
    with (folder / "bar.csv").open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["strain", "stress_MPa"])
        writer.writerows(zip(strain, 0.27 * (1 + strain - (1 + strain) ** -2), strict=True))
    return skincad.fit_material(folder / "bar.csv")


def press_test(_: Path) -> Result:
    force = 0.8 * np.arange(1, 11)  # of a part of a softer silicone
    part = PressCurve("press.csv", 0.12 * force**0.6, force, 0.05, 0.02)
    return skincad.accept(skincad.load("plain-ridges"), part)


SWEPT = {"ridge.levelling": (0, 1), "ridge.pitch": (0.9, 1.2), "mold.process": "all"}
RANKS: dict[str, Any] = {"all_touch_force_N": "min", "approach_mm": "min"}
FEW = "history.time_s=[0.0, 0.02]", "history.tangential_force_N=[0.0, 0.1]"


def yamada(**changes: Any) -> Any:
    return skincad.load("yamada-2002").with_(**changes)


RESULTS: dict[str, Callable[[Path], Result]] = {
    "check": lambda _: skincad.check(yamada(), model="winkler"),
    "check of many ridges": lambda _: skincad.check(skincad.load("gripper-pad"), model="winkler"),
    "check of one ridge": lambda _: skincad.check(yamada(ridge={"count": 1}), model="winkler"),
    "check of magnets": lambda _: skincad.check(skincad.load("magnet-pillars")),
    "film stress": lambda _: skincad.film_stress(skincad.load("steep-fingertip")),
    "fit": pad_test,
    "accept": press_test,
    "press": lambda f: small(
        "yamada-2002-press", f, "history.time_s=[0.0, 0.02]", "readout.ridges=[1, 2, 3]"
    ),
    "pull": lambda f: small("steady-pull", f, *FEW, "readout.ridges=[1, 2, 3]"),
    "section": lambda f: small(
        "hold", f, *FEW, "readout.ridges=[2]", "readout.steps=[20]", "history.rotation_deg=none"
    ),
    "recorder": lambda f: small(
        "steady-pull", f, *FEW, "readout.ridges=[2]", "history.steps=200", "effects.piezo.sampling_Hz=5000.0"
    ),
    "solve": lambda _: skincad.solve(
        yamada(), {"all_touch_force_N": 1.5}, {"ridge.levelling": (0, 1)}, model="winkler"
    ),
    "sweep": lambda _: skincad.sweep(yamada(), SWEPT, sample=24, rank=RANKS, model="winkler"),
    **{
        f"circuit {name}": lambda _, name=name: skincad.gain(skincad.load_circuit(name))
        for name in skincad.template_names("circuits")
    },
}


@cache
def result(name: str, folder: Path) -> Result:
    return RESULTS[name](folder)


@cache
def figures_of(name: str, folder: Path) -> dict[str, canvas.Picture]:
    """The figures of a result, laid out and drawn."""
    figures = dict(result(name, folder).figures()) if name in RESULTS else {name: OTHERS[name](folder)}
    with canvas.own_style():
        for figure in figures.values():
            figure.canvas.draw()
    return figures


def design(name: str) -> canvas.Picture:
    subject = skincad.load(name)
    closed = Job(subject).closed
    return pictures.design_figure(subject, closed, {part.name: mesh(part, 0.05) for part in closed.parts})


def ladder() -> canvas.Picture:
    measure = ErrorMeasure(
        "force", "error of the all-touch force, relative", "1", "the finest: a solid", "", floor=1e-4
    )
    models = {"winkler": 0.6, "linear": 0.02, "corrected": 0.004, "solid": 0.001}
    trials = tuple(
        Measurement(model, f"{k}", 10, (0.01 * 3**k / error, 0.02 * 3**k / error), {"force": error / 2**k})
        for model, error in models.items()
        for k in range(3)
    )
    ladder = Ladder("contact", "contact: error against time", trials, (measure,))
    machine = {"processor": "x", "cores": 2}
    return accuracy_figure(
        Accuracy(name="x", ladders=(ladder, ladder), machine=machine, repeats=2, seconds=1.0)
    )


@cache
def pulled(folder: Path) -> Any:
    """Three ridges monitored, the third of them read, and each slips."""
    few = ("history.steps=24", THIRD, *FEW, "readout.ridges=[1, 2, 3]")
    simulation = at_level(small_scene(folder, "steady-pull", *few), LEVELS[0])
    error = SimpleNamespace(total=2.5e-4)
    return replace(simulation, stress_errors=dict.fromkeys((1, 2, 3), error), slip_steps=[2, 4, 6])


def many_signals(folder: Path) -> canvas.Picture:
    """All of nine ridges monitored, each with an error, and each slips."""
    simulation = pulled(folder)
    signals = dict.fromkeys(range(1, 10), simulation.signals[3])
    errors, slips = dict.fromkeys(signals, simulation.stress_errors[3]), [2 * i for i in signals]
    return scenes.scene_figure(replace(simulation, signals=signals, stress_errors=errors, slip_steps=slips))


def measured_gain() -> canvas.Picture:
    circuit_gain = skincad.gain(skincad.load_circuit("yamada-2002"))
    points = SimpleNamespace(
        frequency=circuit_gain.frequency[::9],
        gain=circuit_gain.gain[::9] - 12.0,
        calibration=SimpleNamespace(offset=-12.5),
    )
    return gain_figure(replace(circuit_gain, measured=points))


DESIGNS = ("yamada-2002", "plain-ridges", "steep-fingertip")
OTHERS: dict[str, Callable[[Path], canvas.Picture]] = {
    "pins of a scene": lambda _: skincad.simulate(
        skincad.load_scene("pillars-9-pull", ["history.steps=8"])
    ).figure(),
    "rings of a scene": lambda _: skincad.simulate(
        skincad.load_scene("rings-5-pull", ["history.steps=8"])
    ).figure(),
    "magnets of a scene": lambda _: scenes.magnet_figure(
        skincad.simulate(skincad.load_scene("magnet-pillars-pull", ["history.steps=20"]))
    ),
    **{f"design {name}": lambda _, name=name: design(name) for name in DESIGNS},
    "signals of many ridges": many_signals,
    "ladder": lambda _: ladder(),
    "gain with data": lambda _: measured_gain(),
    "models": lambda _: results.models_figure(
        [("winkler", 4e-4, 0.8), ("linear", 0.7, 0.45), ("corrected", 2.8, 0.14)]
    ),
    "one model": lambda _: results.models_figure([("corrected-finite-strain", 2.8, 0.14)]),
    "sensitivities": lambda _: results.sensitivity_figure(sensitivities(skincad.load("yamada-2002"), 2.64)),
}


QUICK = {"pull", "check of one ridge", "one model", "models", "gain with data"}


def tier(name: str) -> tuple[pytest.MarkDecorator, ...]:
    """Slow is one figure of a kind; designs and circuits beside yamada-2002 are evidence."""
    if name in QUICK:
        return ()
    if name == "accept":
        return (pytest.mark.evidence(subject="figures: accept"),)
    if name == "check of many ridges":
        return (pytest.mark.evidence(subject="gripper-pad"),)
    if name.startswith("design "):
        subject = name.removeprefix("design ")
        return () if subject == "yamada-2002" else (pytest.mark.evidence(subject=subject),)
    if name.startswith("circuit ") and name != "circuit yamada-2002":
        return (pytest.mark.evidence(subject="figures: circuits"),)
    return (pytest.mark.slow,)


EVERY = [pytest.param(name, marks=tier(name)) for name in [*RESULTS, *OTHERS]]
ONE_DESIGN = pytest.mark.parametrize("name", [pytest.param(n, marks=tier(f"design {n}")) for n in DESIGNS])


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("figures")


def points(axes: Axes) -> Iterator[np.ndarray]:
    """What is drawn of data in the axes, `(n, 2)` pixels: curves between their points too, markers, bars."""
    for line in axes.lines:
        if line.get_transform() != axes.transData:  # lines across all of the axes mark a place
            continue
        at = axes.transData.transform(np.column_stack([np.asarray(d, float) for d in line.get_data()]))
        if len(at) and line.get_linestyle() != "None":
            between = (a + (b - a) * np.linspace(0, 1, 9)[1:, None] for a, b in pairwise(at))
            yield np.vstack([at[:1], *between])
        yield at
    for collection in axes.collections:
        yield axes.transData.transform(np.asarray(collection.get_offsets(), float).reshape(-1, 2))
    for patch in axes.patches:
        box = patch.get_window_extent()
        yield np.array([[x, y] for x in (box.x0, box.x1) for y in (box.y0, box.y1)])


def inside(box: Bbox | None, at: np.ndarray) -> bool:
    if box is None:
        return False
    at = at[np.isfinite(at).all(axis=1)]
    return bool(np.any((box.x0 < at[:, 0]) & (at[:, 0] < box.x1) & (box.y0 < at[:, 1]) & (at[:, 1] < box.y1)))


def cut(figure: canvas.Picture) -> bool:
    """Whether anything that is drawn, letters too, reaches out of the figure."""
    box = figure.get_tightbbox(figure.canvas.get_renderer()).padded(-EDGE / figure.dpi)
    wide, high = figure.get_size_inches()
    return bool(min(box.x0, box.y0) < 0 or box.x1 > wide or box.y1 > high)


def hidden(figure: canvas.Picture) -> bool:
    """Whether a legend lies over what is drawn of data, as far as its axes show it."""
    legends = [*figure.legends, *(axes.get_legend() for axes in figure.axes if axes.get_legend())]
    return any(
        inside(Bbox.intersection(legend.get_window_extent(), axes.get_window_extent()), at)
        for legend in legends
        for axes in figure.axes
        for at in points(axes)
    )


def titles_clear_of_legends(figure: canvas.Picture) -> bool:
    boxes = [legend.get_window_extent() for legend in figure.legends]
    boxes += [axes.get_legend().get_window_extent() for axes in figure.axes if axes.get_legend()]
    titles = [axes.title for axes in figure.axes if axes.title.get_text()]
    titles += [text for text in figure.texts if text.get_text() == figure.get_suptitle() != ""]
    return not any(box.overlaps(title.get_window_extent()) for box in boxes for title in titles)


def labels(figure: canvas.Picture) -> list[str]:
    """The labels of axes of numbers."""
    return [
        label
        for axes in figure.axes
        for axis in ((axes.xaxis, axes.yaxis) if axes.axison else ())
        if (label := axis.label.get_text()) and axis.get_visible()
        if not any(re.match("[a-z]", tick.get_text()) for tick in axis.get_ticklabels())
    ]


def named(label: str) -> bool:
    """Whether a label ends in a unit, of a pure number 1, or is of what is counted."""
    words = re.sub(r"\s*\((?:min|max|tension positive)\)", "", " ".join(label.split()))
    words = words.removesuffix("; films black")
    if words.startswith(NUMBERED) or words.endswith(", relative") or "relative," in words:
        return True
    return any(words.endswith((f", {unit}", f"_{unit}")) for unit in UNITS)


@pytest.mark.slow
@pytest.mark.parametrize("kind", EVERY)
def test_a_figure_is_whole_and_of_one_style(kind: str, folder: Path) -> None:
    """Nothing is cut off, no legend hides a curve or a title, axes have units; one font in five sizes."""
    figures = figures_of(kind, folder)
    assert figures
    for name, figure in figures.items():
        assert not cut(figure), name
        assert not hidden(figure), name
        assert titles_clear_of_legends(figure), name
        assert [label for label in labels(figure) if not named(label)] == [], name
        letters = [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
        assert {text.get_fontname() for text in letters} == {"DejaVu Sans"}, name
        sizes = {canvas.NOTE, canvas.SMALL, canvas.LABEL, canvas.TITLE, canvas.HEAD}
        assert {text.get_fontsize() for text in letters} <= sizes, name


def test_cut_and_hidden_can_fail() -> None:
    """A legend on a curve and a word beyond the edge: the contract can fail."""
    with sheet((4.0, 3.0)) as figure:
        axes = figure.add_subplot()
        axes.plot([0, 1], [0, 1], label="a curve")
        axes.legend(loc="center")
        figure.canvas.draw()
        assert hidden(figure)
        assert not cut(figure)
        figure.text(0.9, 0.5, "a word that is too long")
        assert cut(figure)


def test_figures_are_there_of_each_kind_of_result() -> None:
    """A new presenter with figures is listed here, or this fails."""
    shown = {
        (path.stem, name or picture)
        for path in (Path(skincad.__file__).parent / "outputs").rglob("*.py")
        for name, picture in re.findall(
            r'^def (?!_)(\w*figures)\(|figures=drawn\("([\w-]+)\.png"', path.read_text("utf-8"), re.MULTILINE
        )
    }
    assert shown == {
        *((name, "figures") for name in ("makes", "simulations")),
        *(("measurements", name) for name in ("fit", "accept")),
        *(("studies", f"{name}_figures") for name in ("solution", "sweep")),
        ("studies", "accuracy"),
        ("checks", "check_figures"),
        ("checks", "stress_figures"),
        ("simulations", "gain"),
    }


def test_a_panel_for_each_ridge_has_its_differential_stress_slip_and_error(folder: Path) -> None:
    """A dashed line marks each ridge's slip; only the ridge that is read, 3 of 1, 2, 3, has an error band."""
    figure = scenes.scene_figure(pulled(folder))
    panels, signals, time = figure.axes[1:-1], pulled(folder).signals, pulled(folder).march.time
    assert len(panels) == 3 * len(signals)
    assert "differential stress" in panels[0].get_ylabel()
    for axes, signal in zip(panels, signals.values(), strict=False):
        assert np.array_equal(axes.lines[0].get_ydata(), signal.value)
    lines = [(line, axes) for axes in panels[:3] for line in axes.lines]
    slips = [x.get_xdata()[0] for x, axes in lines if x.get_transform() != axes.transData]
    assert slips == pytest.approx(1e3 * time[[2, 4, 6]])  # ms
    assert_only_ridge_3_has_a_band(figure)


def test_of_many_ridges_the_one_that_is_read_has_an_error_band(folder: Path) -> None:
    assert_only_ridge_3_has_a_band(many_signals(folder))


def assert_only_ridge_3_has_a_band(figure: Any) -> None:
    panels = figure.axes[1:-1]
    assert [i for i, axes in enumerate(panels) if axes.collections] == [2]
    assert panels[2].get_title() == "ridge 3, read"
    assert any("error of ridge 3: ±" in text.get_text() for text in figure.axes[0].get_legend().get_texts())


@pytest.mark.parametrize(("count", "panels"), [(1, 1), (2, 2), (9, 9), (10, 5), (40, 8), (999, 9)])
def test_many_ridges_share_panels(count: int, panels: int) -> None:
    groups = scenes.ridge_groups(list(range(1, count + 1)))
    assert len(groups) == panels
    assert [ridge for group in groups for ridge in group] == list(range(1, count + 1))


def test_no_figure_has_a_colour_of_its_own() -> None:
    folder = Path(skincad.__file__).parent / "outputs" / "figures"
    others = [path for path in folder.glob("*.py") if path.name != "canvas.py"]
    assert len(others) > 4
    for path in others:
        assert not re.findall(r'"#[0-9a-fA-F]{3,6}"', path.read_text("utf-8")), path.name


# full protanopia and deuteranopia, on linear RGB: Machado, Oliveira, Fernandes, IEEE TVCG 15 (2009), 1291
BLIND = (
    ((0.152286, 1.052583, -0.204868), (0.114503, 0.786281, 0.099216), (-0.003882, -0.048116, 1.051998)),
    ((0.367322, 0.860646, -0.227968), (0.280085, 0.672501, 0.047413), (-0.011820, 0.042940, 0.968881)),
)


def lightness_and_hue(colour: str, seen: np.ndarray) -> np.ndarray:
    """A colour in CIE L*a*b* (D65), as an eye sees it that mixes linear RGB by `seen`."""
    rgb = np.array(canvas.to_rgb(colour))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ np.clip(seen @ linear, 0.0, 1.0) / [0.9505, 1.0, 1.089]
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


@pytest.mark.parametrize("seen", [np.eye(3), *map(np.array, BLIND)], ids=["all", "no red", "no green"])
def test_colour_blind_readers_tell_the_curves_apart(seen: np.ndarray) -> None:
    """10 is four times what is just noticed (2.3: Mahy, Van Eycken, Oosterlinck 1994)."""
    colours = canvas.STYLE["axes.prop_cycle"].by_key()["color"]
    places = [lightness_and_hue(colour, seen) for colour in colours]
    pairs = combinations(zip(colours, places, strict=True), 2)
    apart = {(a, b): float(np.linalg.norm(p - q)) for (a, p), (b, q) in pairs}
    assert min(apart.values()) > 10, min(apart, key=apart.__getitem__)


def leaders(figure: canvas.Picture) -> list[shapely.LineString]:
    """The lines from parts to their names, in the picture's pixels."""
    named = [text for axes in figure.axes for text in axes.texts if getattr(text, "arrow_patch", None)]
    return [shapely.LineString([text.xy, text.xyann]) for text in named]


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.evidence(subject=n) if n != "yamada-2002" else ()) for n in RIDGED],
)
def test_no_two_leaders_cross(name: str, folder: Path) -> None:
    known = f"design {name}"
    lines = leaders(figures_of(known, folder)[known] if known in OTHERS else design(name))
    assert len(lines) > 4
    assert not any(a.intersects(b) for a, b in combinations(lines, 2))


def test_leaders_from_any_places_do_not_cross() -> None:
    random = np.random.default_rng(1)
    for _ in range(200):
        anchors = [tuple(at) for at in random.uniform(0, (600, 700), (10, 2))]
        ends = pictures.label_places(anchors, (640, 760))
        lines = [shapely.LineString(pair) for pair in zip(anchors, ends, strict=True)]
        assert not any(a.intersects(b) for a, b in combinations(lines, 2))
        rows = np.sort([row for _, row in ends])
        assert np.diff(rows).min() >= 0.028 * 760 - 1e-9


@ONE_DESIGN
def test_a_scale_bar_is_as_long_as_it_says(name: str, folder: Path) -> None:
    axes = figures_of(f"design {name}", folder)[f"design {name}"].axes[0]
    (bar,) = [line for line in axes.lines if line.get_gid() == "scale bar"]
    words = next(text.get_text() for text in axes.texts if text.get_text().endswith(" mm along x"))
    length = float(words.partition(" ")[0])
    subject = skincad.load(name)
    skin = next(part for part in Job(subject).closed.parts if part.name == "skin")
    camera = pictures.view([upright(mesh(skin, 0.05))], 32.0, 28.0, axes.images[0].get_size()[::-1])
    ends = np.array([camera.pixel(np.array([x, 0.0, 0.0])) for x in (0.0, subject.skin.width)])
    per_mm = np.linalg.norm(ends[1] - ends[0]) / subject.skin.width
    drawn_length = np.linalg.norm(np.diff(bar.get_xydata(), axis=0))
    assert drawn_length == pytest.approx(length * per_mm, rel=1e-9)
    assert 0.1 * subject.skin.width < length <= 0.3 * subject.skin.width + 1e-9


@ONE_DESIGN
def test_the_whole_section_states_its_height_scale(name: str, folder: Path) -> None:
    axes = figures_of(f"design {name}", folder)[f"design {name}"].axes[1]
    scale = axes.get_aspect()
    assert ("true to scale" if scale == 1 else f"heights x {scale:g};") in axes.get_title()
    low, high = axes.get_xlim()
    width = skincad.load(name).skin.width
    assert (low, high) == pytest.approx((-0.51 * width, 0.51 * width))
    a, b = axes.transData.transform([(0, 0), (1, 1)])
    assert (b - a)[1] / (b - a)[0] == pytest.approx(scale, rel=1e-6)


def test_a_sweep_of_two_numbers_is_a_map_between_evaluated_rows() -> None:
    pair = {"ridge.levelling": (0, 1), "ridge.pitch": (0.9, 1.4)}
    sweep = skincad.sweep(yamada(), pair, sample=30, rank={"all_touch_force_N": "min"}, model="winkler")
    axes = sweep.figures()["pairs.png"].axes[0]
    refused = {tuple(row.values.values()) for row in sweep.rows if row.refused}
    (filled,) = [part for part in axes.collections if isinstance(part, TriMesh)]
    mesh_points = filled._triangulation
    corners = np.unique(mesh_points.triangles)
    values = filled.get_array()
    rows = {
        tuple(row.values.values()): row.results["all_touch_force_N"].value
        for row in sweep.rows
        if not row.refused
    }
    assert len(corners) > 10
    assert refused
    for i in corners:
        place = mesh_points.x[i], mesh_points.y[i]
        assert place not in refused
        assert values[i] == rows[place]
    (own,) = [line for line in axes.lines if line.get_label() == "the design itself"]
    assert own.get_xydata().tolist() == [[0.0, yamada().ridge.pitch]]  # levelling: none
    (crosses,) = [part for part in axes.collections if str(part.get_label()).startswith("refused")]
    assert {tuple(place) for place in crosses.get_offsets()} == refused


def test_a_sample_has_no_means_where_few_rows_meet() -> None:
    """A grid has a bar at each of its values; a sample of numbers has none."""
    vary: dict[str, Any] = {"ridge.levelling": (0, 1), "ridge.pitch": (0.9, 1.0)}
    rank = {"all_touch_force_N": "min"}
    grid = {key: [*ends, sum(ends) / 2] for key, ends in vary.items()}
    for sweep, bars in (
        (skincad.sweep(yamada(), vary, sample=8, rank=rank, model="winkler"), 0),
        (skincad.sweep(yamada(), grid, rank=rank, model="winkler"), 3),
    ):
        for axes in sweep.figures()["effects.png"].axes:
            assert len([line for line in axes.lines if line.get_marker() == "_"]) == bars
