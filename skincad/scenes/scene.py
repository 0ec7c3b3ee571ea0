"""What a scene file says: a skin, what the plate does, and the effects that count.

An effect that is not named is not imported. Its table is parsed by the effect itself.
"""

from __future__ import annotations

from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Table, parse, quantity
from skincad.effects import effect
from skincad.effects.kinds import MASS, Effect, Law, PadChange, Reader, Term
from skincad.inputs.catalog import load, overridden, read_table
from skincad.inputs.design import Design
from skincad.mechanics.contact.grip import Drive

Array = NDArray[np.float64]
LAW = "small_strain"  # of a scene that names none
MOST_FRAMES = 60  # of an animation of less than 2 MB
STEEPEST = 5.0  # deg; of a plate that turns, as of a tilted one (design.py)
# of a history; forces as contact.force, travel as the widest skin (design.py)
LARGEST = {"time_s": 1e6, "normal_force_N": 1e6, "tangential_force_N": 1e6, "displacement_mm": 1e3}
NARROWEST = 1e-4  # Hz; less shows nothing of the longest history
SHORTEST = 1e-9  # s; assumption: sound passes a micrometre of silicone, far less than any mesh shows


class History(Table):
    """What the plate does: points in time, straight lines between them."""

    time_s: list[float] = Field(
        description="of each point, from 0", min_length=2, max_length=10_000, json_schema_extra={"unit": "s"}
    )
    normal_force_N: list[float] = Field(  # noqa: N815
        description="presses, at each point", json_schema_extra={"unit": "N"}
    )
    tangential_force_N: list[float] | None = Field(  # noqa: N815
        default=None, description="of the plate on the skin, to +x", json_schema_extra={"unit": "N"}
    )
    displacement_mm: list[float] | None = Field(
        default=None, description="of a driven plate, to +x, instead", json_schema_extra={"unit": "mm"}
    )
    rotation_deg: list[float] | None = Field(
        default=None,
        description="of the plate about y, positive where it rises towards +x; forces and displacement "
        "are normal to the plate and along it then",
        json_schema_extra={"unit": "deg"},
    )
    steps: int = Field(description="equal steps of the march", ge=1, le=1_000_000)

    @model_validator(mode="after")
    def _rules(self) -> Self:
        self._check_lists()
        if self.time_s[0] != 0.0:
            raise InputError("time_s", "must begin at 0", self.time_s[0])
        for a, b in zip(self.time_s, self.time_s[1:], strict=False):
            if not b > a:
                raise InputError("time_s", f"must not go back or stand still after {a:g} s", b)
            if b - a < SHORTEST:
                raise InputError("time_s", f"needs points at least {SHORTEST:g} s apart", b - a)
        if min(self.normal_force_N) < 0:
            rule = "must not pull: the plate presses or is clear"
            raise InputError("normal_force_N", rule, min(self.normal_force_N), "take 0 or more")
        if self.normal_force_N[0] != 0.0:
            raise InputError("normal_force_N", "must begin unloaded, at 0", self.normal_force_N[0])
        given = [self.tangential_force_N, self.displacement_mm]
        if given.count(None) != 1:
            rule = "needs either tangential_force_N or displacement_mm"
            raise InputError("", rule, remedy="give the one that the plate is driven by")
        across = self.tangential_force_N or self.displacement_mm or [0.0]
        if across[0] != 0.0:
            key = "tangential_force_N" if self.tangential_force_N else "displacement_mm"
            raise InputError(key, "must begin at 0", across[0])
        turn = self.rotation_deg or [0.0]
        if turn[0] != 0.0:
            raise InputError("rotation_deg", "must begin at 0", turn[0])
        if max(map(abs, turn)) > STEEPEST:
            rule = f"must be from -{STEEPEST:g} to {STEEPEST:g} deg: beyond, the plate meets more than ridges"
            raise InputError("rotation_deg", rule, max(turn, key=abs))
        return self

    def _check_lists(self) -> None:
        """Raise InputError for lists that are not of one length, or hold what no scene can mean."""
        for key in (*LARGEST, "rotation_deg"):
            values = getattr(self, key)
            if values is not None and len(values) != len(self.time_s):
                raise InputError(key, f"needs {len(self.time_s)} values, as time_s has", len(values))
        for key, most in LARGEST.items():
            largest = max(getattr(self, key) or [0.0], key=abs)
            if abs(largest) > most:
                raise InputError(key, f"must be at most {most:g} {key.rpartition('_')[2]} in size", largest)

    @cached_property
    def times(self) -> Array:
        """Times `(steps + 1,)`, s."""
        return np.linspace(0.0, self.time_s[-1], self.steps + 1)

    def drives(self) -> list[Drive]:
        """Return what the plate does at each of `times`."""
        at, points = self.times, self.time_s
        normal = np.interp(at, points, self.normal_force_N).tolist()
        angles = np.radians(np.interp(at, points, self.rotation_deg or [0.0] * len(points))).tolist()
        if self.tangential_force_N is not None:
            pulls = np.interp(at, points, self.tangential_force_N).tolist()
            return [Drive(n, tangential=t, angle=a) for n, t, a in zip(normal, pulls, angles, strict=True)]
        moves = np.interp(at, points, self.displacement_mm or []).tolist()
        return [Drive(n, travel=s, angle=a) for n, s, a in zip(normal, moves, angles, strict=True)]


class ScenePlate(Table):
    """The rigid plate."""

    shape: Literal["flat"] = Field(default="flat", description="flat; it keeps its angle")
    mass: float | None = quantity("g", "of the plate; needs effects.inertia", gt=0.0, le=1e6, default=None)


class Readout(Table):
    """What is told."""

    ridges: list[int] = Field(default=[], description="whose films' stresses are told", max_length=999)
    bandwidth_Hz: float = quantity(  # noqa: N815
        "Hz", "of the signals, where they are down by 3 dB", gt=0.0, le=1e9, default=5000.0
    )
    steps: list[Annotated[int, Field(ge=0)]] = Field(
        default=[], description="at which the deformed section is drawn with its stress", max_length=100
    )
    frames: int = Field(
        default=0, description="of an animated picture of the section; 0: none", ge=0, le=MOST_FRAMES
    )

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if self.bandwidth_Hz < NARROWEST:
            raise InputError("bandwidth_Hz", f"must be at least {NARROWEST:g} Hz", self.bandwidth_Hz)
        return self


class Scene(Table):
    """A scene: forces N, lengths mm, times s. `load_scene` checks effects and skin together."""

    name: Annotated[
        str,
        Field(
            pattern=r"^[A-Za-z0-9][A-Za-z0-9_-]{0,63}$",
            description="letters, digits, - and _, up to 64; it names the out folder",
        ),
    ]
    skin: str = Field(description="a design's template, or a TOML file beside the scene", max_length=4096)
    history: History
    plate: ScenePlate = ScenePlate()
    effects: dict[str, dict[str, Any]] = Field(default={}, description="tables of effects by name")
    readout: Readout = Readout()

    @cached_property
    def parts(self) -> dict[str, Effect]:
        """The named effects, each parsed by its own model; raises InputError for what it does not know."""
        return {name: _parsed(name, table) for name, table in self.effects.items()}

    @cached_property
    def terms(self) -> list[Term]:
        """The terms among them."""
        return [part for part in self.parts.values() if isinstance(part, Term)]

    @cached_property
    def asked(self) -> frozenset[str]:
        """What the terms ask of the law."""
        return frozenset[str]().union(*(term.asks for term in self.terms))

    @cached_property
    def law(self) -> Law:
        """The one law."""
        laws = {name: part for name, part in self.parts.items() if isinstance(part, Law)}
        if len(laws) > 1:
            raise InputError("effects", "must name one law at most", " and ".join(laws), "leave one out")
        found = next(iter(laws.values()), None) or _parsed(LAW, {})
        assert isinstance(found, Law)
        return found

    @cached_property
    def design(self) -> Design:
        """The skin's design."""
        try:
            return load(self.skin)
        except InputError as failure:
            if failure.key == self.skin[:80]:
                raise InputError("skin", failure.rule, self.skin, failure.remedy) from None
            raise failure.under("skin") from None


def load_scene(source: str | Path, overrides: list[str] | tuple[str, ...] = ()) -> Scene:
    """Return the scene of a template's name or of a TOML file, `--set` texts applied, checked as a whole.

    Paths of a skin and in an effect's table count from the scene's file. Raises InputError with key, rule,
    value and remedy.
    """
    data = overridden(read_table(source, "scenes"), overrides)
    skin = data.get("skin")
    beside = Path(source).parent / skin if isinstance(skin, str) and skin.endswith(".toml") else None
    if beside is not None and Path(source).suffix == ".toml":
        data["skin"] = str(beside)
    if Path(source).suffix == ".toml":
        data["effects"] = _beside(Path(source).parent, data.get("effects", {}))
    scene = parse(Scene, data)
    _check(scene)
    return scene


def _beside(folder: Path, effects: Any) -> Any:
    """Effects' tables, a TOML file that one names taken from `folder`."""
    if not isinstance(effects, dict):
        return effects

    def placed(value: Any) -> Any:
        return str(folder / value) if isinstance(value, str) and value.endswith(".toml") else value

    return {
        name: {key: placed(value) for key, value in table.items()} if isinstance(table, dict) else table
        for name, table in effects.items()
    }


def _parsed(name: str, table: dict[str, Any]) -> Effect:
    kind = effect(name)
    try:
        return parse(kind, table)
    except InputError as failure:
        key = failure.key.removeprefix("design")
        raise InputError(
            f"effects.{name}" + (f".{key}" if key else ""),
            failure.rule,
            failure.value,
            failure.remedy,
            tuple(other.under(f"effects.{name}") for other in failure.others),
        ) from None


def _check(scene: Scene) -> None:
    """Raise InputError for what scene and skin together do not allow."""
    design = scene.design
    _ = scene.law
    _check_law(scene)
    _check_terms(scene)
    _check_force(scene)
    for name, part in scene.parts.items():
        try:
            part.check(design)
        except InputError as failure:
            raise failure.under(f"effects.{name}") from None
        for needed in part.needs:
            if needed not in scene.effects:
                rule = f"needs the effect {needed}"
                raise InputError(f"effects.{name}", rule, remedy=f"add [effects.{needed}]")
    if scene.readout.ridges and design.slot is None:
        rule = f"asks for films' stresses, and {design.name} has no slots"
        raise InputError("readout.ridges", rule, scene.readout.ridges, "take a skin with slots")
    for ridge in scene.readout.ridges:
        if not 1 <= ridge <= design.ridge.count:
            raise InputError("readout.ridges", f"must be from 1 to {design.ridge.count}", ridge)
    beyond = [step for step in scene.readout.steps if step > scene.history.steps]
    if beyond:
        raise InputError("readout.steps", f"must be from 0 to {scene.history.steps}", beyond[0])
    if len(set(scene.readout.ridges)) < len(scene.readout.ridges):
        raise InputError("readout.ridges", "names a ridge twice", scene.readout.ridges)


def _check_terms(scene: Scene) -> None:
    """Raise InputError for what terms ask and law or plate do not give."""
    law = next((name for name, part in scene.parts.items() if part is scene.law), LAW)
    for name, part in scene.parts.items():
        if isinstance(part, Term) and part.asks - scene.law.gives:
            raise InputError(
                f"effects.{name}", f"is not known together with {law}", remedy=f"leave out {law}"
            )
    if MASS in scene.asked and scene.plate.mass is None:
        raise InputError(
            "plate.mass", "is missing", remedy="masses count here: say how heavy the plate is, g"
        )
    if MASS not in scene.asked and scene.plate.mass is not None:
        rule, remedy = "means nothing where masses do not count", "add [effects.inertia]"
        raise InputError("plate.mass", rule, scene.plate.mass, remedy)


def _check_force(scene: Scene) -> None:
    """Raise InputError for a normal force that the ridges do not bear within the law's range, even if they
    share it evenly. With masses the skin may feel less than the plate."""
    ends, ridges, peak = (
        scene.law.limits(scene.design),
        scene.design.ridge.count,
        max(scene.history.normal_force_N),
    )
    if MASS not in scene.asked and peak > ridges * ends.largest:
        rule = f"must be at most {ridges * ends.largest:.3g} N: {ends.overloaded(peak / ridges)}"
        raise InputError("history.normal_force_N", rule, peak, "take smaller forces or a harder silicone")


def _check_law(scene: Scene) -> None:
    """Raise InputError for what only a quasi-static condensed pad knows, with a law or term that has none."""
    law = next((name for name, part in scene.parts.items() if part is scene.law), LAW)
    others = [] if scene.law.condenses else [law]
    others += [name for name, part in scene.parts.items() if isinstance(part, Term) and part.asks]
    asked = ["history.rotation_deg"] if any(scene.history.rotation_deg or []) else []
    asked += [f"readout.{key}" for key in ("steps", "frames") if getattr(scene.readout, key)]
    bodies = {name: part for name, part in scene.parts.items() if isinstance(part, PadChange)}
    asked += [f"effects.{name}" for name, body in bodies.items() if body.condenses]
    if others and asked:
        rule = f"is not known together with {' and '.join(others)}"
        raise InputError(asked[0], rule, remedy="leave one of them out")
    for name, body in bodies.items():
        if body.feels:
            continue
        if scene.readout.ridges:
            rule = f"asks for films' stresses, and effects.{name} leaves them without"
            raise InputError("readout.ridges", rule, scene.readout.ridges, "take readout.ridges = []")
        for other, part in scene.parts.items():
            if isinstance(part, Reader) and name in part.needs:
                rule = f"reads films' stresses, and effects.{name} leaves them without"
                raise InputError(f"effects.{other}", rule, remedy=f"leave out effects.{other}")
