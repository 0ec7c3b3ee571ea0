"""Every effect that EFFECTS lists, by one test each: a new one is tested by being listed.

A table that a term cannot be without is in NEEDED; friction is always there, for stick and slip.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from skincad.base import InputError
from skincad.effects import (
    EFFECTS,
    INDICATORS,
    MASS,
    Friction,
    Observables,
    SceneOutline,
    SmallStrain,
    Step,
    Term,
    effect,
    share_of,
)
from skincad.effects.moving import MovingPad, matter_of
from skincad.mechanics import (
    OPEN,
    RIGHT,
    STICK,
    Drive,
    PadPiece,
    default_sizes,
    filled_pad,
    piece_of,
    triangles,
)
from skincad.scenes import March, load_scene
from skincad.scenes.march import march
from tests.mechanics.designs import yamada
from tests.outlines import outline
from tests.processes import python
from tests.refusals import refused, refused_by
from tests.small_scene import small_scene

MU, PLATE = 0.6, 0.2  # g
NEEDED: dict[str, dict[str, Any]] = {"friction": {"coefficient": MU}}
VARIANTS: dict[str, tuple[dict[str, Any], ...]] = {
    "viscosity": ({}, {"prony": [[0.5, 1e-4], [0.2, 1e-3]]}),
    "inertia": ({}, {"spectral_radius": 1.0}),
    "texture": ({"wavelength": 0.5, "amplitude": 0.002},),
}
COMPANIONS = {"inertia": ("viscosity",)}  # masses that nothing damps flutter where they slide
DT = 1e-5
DOWN, ALONG = 16, 8  # steps to be pressed, then moved: enough to stick, to slip in part and to slip
TERMS = [
    (name, table)
    for name in EFFECTS
    if issubclass(effect(name), Term)
    for table in VARIANTS.get(name, (NEEDED.get(name, {}),))
]
CASES = pytest.mark.parametrize(("name", "table"), TERMS, ids=[f"{n}-{len(t)}" for n, t in TERMS])


@cache
def piece() -> tuple[PadPiece, object]:
    pad = yamada().with_(ridge={"count": 2}, skin={"width": 4.0})
    pad_piece = piece_of(*filled_pad(pad))
    return pad_piece, triangles(pad_piece.pad, default_sizes(pad_piece.pad, 0.25))


@cache
def model(demands: frozenset[str]) -> Any:
    """One model for all terms that ask the same: it hangs on nothing else."""
    kind = type("Evaluator", (Term,), {"asks": demands})
    return SmallStrain().marched(*piece(), 2, True, [kind()])


def built(name: str, table: dict[str, Any]) -> tuple[Any, list[Term]]:
    term = effect(name)(**table)
    assert isinstance(term, Term)
    others = [effect(other)() for other in COMPANIONS.get(name, ())]
    terms = [term] if name == "friction" else [Friction(coefficient=MU), *others, term]
    return model(frozenset[str]().union(*(entry.asks for entry in terms))), terms


def step(before: Drive, after: Drive, index: int) -> Step:
    return Step((index - 1) * DT, index * DT, before, after, PLATE)


def advanced(skin: Any, terms: list[Term], state: Any, before: Drive, after: Drive, index: int) -> Any:
    now = step(before, after, index)
    return skin.advanced(state, now, share_of(terms, now))


@cache
def pressed(name: str, case: int) -> tuple[Any, Drive]:
    """A state of a case that is pressed by 0.8 N."""
    skin, terms = built(name, TERMS[case][1])
    state, before = skin.start(), Drive(0.0, travel=0.0)
    for i in range(1, DOWN + 1):
        after = Drive(0.8 * i / DOWN, travel=0.0)
        state = advanced(skin, terms, state, before, after, i)
        before = after
    return state, before


def moved(name: str, table: dict[str, Any], travel: float) -> tuple[Any, Drive]:
    """The same, moved by `travel` mm."""
    skin, terms = built(name, table)
    state, before = pressed(name, TERMS.index((name, table)))
    for i in range(1, ALONG + 1):
        after = Drive(0.8, travel=travel * i / ALONG)
        state = advanced(skin, terms, state, before, after, DOWN + i)
        before = after
    return state, before


def stiffness(skin: Any, terms: list[Term], state: Any) -> float:
    """dT/ds where every closed point's set stays: from the compliance alone, apart from the solver."""
    now = step(Drive(0.0), Drive(0.0), 1)
    inertia = 0.0
    if isinstance(skin, MovingPad):
        matter = matter_of(now, share_of(terms, now))
        scheme, _, seen = skin.pad.factorised(DT, matter)
        compliance = seen.compliance
        if MASS in terms[-1].asks:
            inertia = 1e-6 * matter.plate * scheme.force
    else:
        compliance = skin.skin.compliance
    contact_state = state.contact
    m = contact_state.status.size
    closed, stuck = (
        np.flatnonzero(contact_state.status != OPEN),
        np.flatnonzero(contact_state.status == STICK),
    )
    drag = MU * np.where(contact_state.status == RIGHT, 1.0, -1.0) * (contact_state.status >= RIGHT)
    # unknown: p of closed points, t of sticking ones, the approach; forces (t, -p) by them
    k, n = closed.size, stuck.size
    spread = np.zeros((2 * m, k + n))
    spread[closed, np.arange(k)] = drag[closed]
    spread[m + closed, np.arange(k)] = -1.0
    spread[stuck, k + np.arange(n)] = 1.0
    rows = np.concatenate([m + closed, stuck])
    matrix = np.zeros((k + n + 1, k + n + 1))
    matrix[:-1, :-1] = (compliance @ spread)[rows]
    matrix[:k, -1] = 1.0  # u_z = gap - approach
    matrix[-1, :k] = 1.0
    matrix[-1, -1] = inertia
    side = np.concatenate([np.zeros(k), np.ones(n), [0.0]])
    forces = np.linalg.solve(matrix, side)[:-1]
    return float((spread @ forces)[:m].sum())


@CASES
@pytest.mark.parametrize("travel", [0.002, 0.08, 1.2])
def test_tangent_against_finite_differences(name: str, table: dict[str, Any], travel: float) -> None:
    """dT/ds of a step as all sticks, as some slip and as all do; 1e-6: the step is linear while sets stay."""
    skin, terms = built(name, table)
    state, before = moved(name, table, travel)
    ahead, last = replace(before, travel=(before.travel or 0.0) + travel / ALONG), DOWN + ALONG + 1
    here = advanced(skin, terms, state, before, ahead, last).contact
    small = 1e-7 * travel

    def pull(shift: float) -> tuple[float, Any]:
        further = replace(ahead, travel=(ahead.travel or 0.0) + shift)
        contact_state = advanced(skin, terms, state, before, further, last).contact
        return float(contact_state.tangential.sum()), contact_state.status

    (more, one), (less, other) = pull(small), pull(-small)
    assert (one == here.status).all()
    assert (other == here.status).all()
    wanted = stiffness(skin, terms, here)
    sticks = stiffness(skin, terms, replace(here, status=np.where(here.status != OPEN, STICK, OPEN)))
    assert (more - less) / (2 * small) == pytest.approx(wanted, abs=1e-6 * sticks)
    stuck = (here.status == STICK).sum()
    if travel == 1.2:
        assert stuck == 0
        assert abs(wanted) <= 1e-9 * sticks
    else:
        assert stuck > 0


@CASES
def test_zero_force_at_rest(name: str, table: dict[str, Any]) -> None:
    skin, terms = built(name, table)
    state = skin.start()
    for i in range(1, 4):
        state = advanced(skin, terms, state, Drive(0.0, travel=0.0), Drive(0.0, travel=0.0), i)
    reading: Observables = skin.reading(state, state)
    assert (
        reading.normal
        == reading.tangential
        == reading.elastic
        == reading.kinetic
        == reading.dissipated
        == 0.0
    )
    assert not reading.films.any()
    assert not reading.touches.any()


def dragged_through_gross_slip(skin: Any, terms: list[Term], within: float) -> March:
    """A march whose work is stored, moves or is lost, to `within` of it: pressed, then dragged."""
    count = 40
    drives = [
        Drive(0.8 * min(1.0, 2 * i / count), travel=1.0 * max(0.0, 2 * i / count - 1))
        for i in range(count + 1)
    ]
    run = march(skin, DT * np.arange(count + 1), drives, terms, mass=PLATE)
    assert run.stopped is None
    normal, tangential = run.column("normal"), run.column("tangential")
    down, along = np.diff(run.column("approach")), np.diff(run.column("travel"))
    work = (normal[1:] + normal[:-1]) / 2 @ down + (tangential[1:] + tangential[:-1]) / 2 @ along
    works = [reading.work for reading in run.readings[1:]]
    work = work if None in works else sum(works)
    last = run.readings[-1]
    lost = run.column("dissipated").sum() + run.column("viscous").sum()
    assert last.elastic + last.kinetic + lost == pytest.approx(work, rel=within)
    assert run.column("dissipated").sum() > 0.05 * work
    assert run.column("residual").max() <= 1e-10
    return run


@CASES
def test_work_is_stored_moves_or_is_lost(name: str, table: dict[str, Any]) -> None:
    """1e-3 of it, the issue's."""
    run = dragged_through_gross_slip(*built(name, table), within=1e-3)
    assert run.column("viscous").min() >= 0


SLIP = "yamada-2002-slip"


@pytest.mark.parametrize("name", EFFECTS)
def test_an_unknown_key_is_refused(name: str) -> None:
    with refused_by(f"effects.{name}.no_such_key: unknown key"):
        load_scene(SLIP, [f"effects.{name}.no_such_key=1"])


@pytest.mark.parametrize(
    ("name", "setting"),
    [
        ("inertia", "effects.inertia={}"),
        ("viscosity", "effects.viscosity={}"),
        ("texture", "effects.texture={wavelength=0.5, amplitude=0.002}"),
    ],
)
def test_finite_strain_takes_no_term_but_friction(name: str, setting: str) -> None:
    with pytest.raises(InputError, match=rf"effects\.{name}.*does not work together with"):
        load_scene(SLIP, [setting, "effects.finite_strain={}"])


def test_a_scene_has_one_law() -> None:
    with refused("must name one law at most"):
        load_scene(SLIP, ["effects.finite_strain={}", "effects.small_strain={}"])


@pytest.mark.slow
def test_nothing_of_an_effect_left_out_is_imported(tmp_path: Path) -> None:
    """Up to the march's end; then, to say what leaving it out would change, its own file and no more."""
    program = (
        "import sys\n"
        "from skincad.scenes.scene import load_scene\n"
        "from skincad.scenes.simulation import simulate\n"
        "def modules():\n"
        "    return {m for m in sys.modules if m.startswith('skincad.')}\n"
        "def tick(stage, step, left=None):\n"
        "    global marched\n"
        "    marched = modules()\n"
        "scene = load_scene('scene.toml', ['skin=small.toml', 'history.normal_force_N=[0.0, 1.3]',"
        " 'effects.film=none', 'effects.friction=none', 'history.steps=1', 'readout.ridges=[]'])\n"
        "simulate(scene, budget=1e-3, tick=tick)\n"
        "print(*(m for m in marched if m.startswith('skincad.effects.')))\n"
        "print(*(modules() - marched))\n"
        "print(*{m.split('.')[0] for m in sys.modules} & {'OCP', 'cadquery', 'matplotlib'})\n"
    )
    small_scene(tmp_path, "yamada-2002-press", "readout.ridges=[]")  # its files
    process = python(program, cwd=tmp_path)
    assert process.returncode == 0, process.stderr
    marched, after, heavy = process.stdout.split("\n")[:3]
    assert set(marched.split()) == {f"skincad.effects.{name}" for name in ("kinds", "small_strain")}
    names = {EFFECTS[name].partition(":")[0] for name in INDICATORS}
    assert set(after.split()) == names
    assert heavy == ""


def test_an_effect_that_says_what_leaving_it_out_changes_says_so_in_its_row() -> None:
    for name in EFFECTS:
        assert (name in INDICATORS) == ("left_out" in vars(effect(name))), name


RISES, HOLDS = (0.0, 1e-3), (0.0, 4.0)  # s, N


@pytest.mark.parametrize("name", INDICATORS)
def test_what_an_effect_says_of_leaving_it_out_bears_its_name(name: str) -> None:
    """Of yamada-2002, whose loads rise in 1 ms to 4 N and a pull of 1 N."""
    answer = effect(name).left_out(outline(yamada(), RISES, HOLDS, (0.0, 1.0)))
    assert answer is not None
    assert answer.effect == name
    assert answer.change > 0
    assert answer.calibrated
    assert answer.within is not None
    assert answer.within >= 2


@pytest.mark.parametrize(
    ("name", "scene"),
    [
        ("film", outline(yamada().with_(film=None), RISES, HOLDS, (0.0, 0.0))),
        ("film", outline(yamada(), RISES, (0.0, 0.0), (0.0, 0.0))),
        ("inertia", outline(yamada(), RISES, (0.0, 0.0), (0.0, 0.0))),
        ("finite_strain", outline(yamada(), RISES, (0.0, 0.0), (0.0, 0.0))),
        ("free_ends", outline(yamada(), RISES, (0.0, 0.0), (0.0, 0.0))),
    ],
)
def test_what_cannot_matter_is_not_told(name: str, scene: SceneOutline) -> None:
    assert effect(name).left_out(scene) is None
