"""A scene: what is done to a skin, as a person writes it.

An effect that is not named is not imported. Its table is parsed by the effect itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    model_serializer,
    model_validator,
)

from skincad.base.arrays import Array, Index
from skincad.base.errors import InputError
from skincad.base.tables import Document, Table, quantity, told
from skincad.detector.detector import GRIP
from skincad.effects import effect
from skincad.effects.kinds import MASS, MOVING, RELIEF, Effect, Law, PadChange, Reader, Step, Term, share_of
from skincad.inputs.catalog import (
    Own,
    load_design,
    named_document,
    overridden,
    own_tables,
    read_table,
    with_own,
)
from skincad.inputs.design import Design
from skincad.mechanics.contact.state import Drive, FrictionCoefficients
from skincad.scenes.grip import HEARING, Grip, Numbers, listed
from skincad.shape.skin import skin_of

MOST_FRAMES = 60  # of an animation of less than 2 MB
STEEPEST = 5.0  # deg; of a plate that turns, as of a tilted one (design.py)
# of a history; forces as contact.force, travel as the widest skin (design.py)
LARGEST = {"time_s": 1e6, "normal_force_N": 1e6, "tangential_force_N": 1e6, "displacement_mm": 1e3}
NARROWEST = 1e-4  # Hz; less shows nothing of the longest history
SHORTEST = 1e-9  # s; assumption: sound passes a micrometre of silicone, far less than any mesh shows
ROUNDING = 4.0  # units in the last place of the history's end: as far as two sums to one time are apart


class History(Table):
    """What the plate does: points in time, straight lines between them."""

    time_s: Numbers = quantity("s", "of each point, from 0", min_length=2, max_length=10_000)
    normal_force_N: Numbers = quantity("N", "of the plate on the skin, at each point")  # noqa: N815
    tangential_force_N: Numbers | None = quantity(  # noqa: N815
        "N", "of the plate on the skin, to +x", default=None
    )
    displacement_mm: Numbers | None = quantity("mm", "of a driven plate, to +x, instead", default=None)
    rotation_deg: Numbers | None = quantity(
        "deg",
        "of the plate about y, positive where it rises towards +x; forces and displacement "
        "are then normal to the plate and along it",
        default=None,
    )
    steps: int = Field(
        description="number of equal time steps; a corner between two of them adds a step of its own",
        ge=1,
        le=1_000_000,
    )

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
        drives = [self.tangential_force_N, self.displacement_mm]
        if drives.count(None) != 1:
            rule = "needs either tangential_force_N or displacement_mm"
            raise InputError("", rule, remedy="give the one that the plate is driven by")
        pull = self.tangential_force_N or self.displacement_mm or [0.0]
        if pull[0] != 0.0:
            key = "tangential_force_N" if self.tangential_force_N else "displacement_mm"
            raise InputError(key, "must begin at 0", pull[0])
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
        """Times of the march, s: `steps + 1` equally spaced ones, and every corner between two of these.

        A march that stepped over a corner would not know of it: a short pull would be lost.
        """
        even, corners = self._even_times, self._corners
        gap = np.abs(even[self._nearest(even, corners)] - corners)
        return np.union1d(even, corners[gap > ROUNDING * np.spacing(even[-1])])

    @cached_property
    def even(self) -> Index:
        """Places of the equally spaced times in `times`, `(steps + 1,)`."""
        return np.asarray(np.searchsorted(self.times, self._even_times))

    @property
    def step_count(self) -> int:
        """Number of steps of the march: `steps`, and one more for each corner between two of them."""
        return self.times.size - 1

    @property
    def points(self) -> Index:
        """Places in `times` of the history's points, those without a corner at the time next to them."""
        return self._nearest(self.times, np.array(self.time_s))

    @property
    def _even_times(self) -> Array:
        return np.linspace(0.0, self.time_s[-1], self.steps + 1)

    @property
    def _corners(self) -> Array:
        """Times of the points at which a line bends; one that lies on the line tells nothing, but for
        rounding of its values and its time."""
        time = np.array(self.time_s)
        bends = np.zeros(time.size, dtype=bool)
        before, span = np.diff(time)[:-1], time[2:] - time[:-2]
        for key in (*LARGEST, "rotation_deg"):
            if key == "time_s" or (listed := getattr(self, key)) is None:
                continue
            values = np.array(listed)
            slope = (values[2:] - values[:-2]) / span
            off = np.abs(values[1:-1] - values[:-2] - slope * before)
            rounding = np.spacing(np.abs(values).max()) + np.abs(slope) * np.spacing(time[-1])
            bends[1:-1] |= off > ROUNDING * rounding
        return time[bends]

    @staticmethod
    def _nearest(times: Array, wanted: Array) -> Index:
        """Return the places in `times` nearest to those `wanted`."""
        after = np.clip(np.searchsorted(times, wanted), 1, times.size - 1)
        return np.asarray(after - (wanted - times[after - 1] <= times[after] - wanted))

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
    """What is reported."""

    ridges: Annotated[list[int], BeforeValidator(listed), AfterValidator(sorted)] = Field(
        default=[], description="ridges whose films' stresses are reported", max_length=999
    )
    bandwidth_Hz: float = quantity(  # noqa: N815
        "Hz", "of the signals, where they are down by 3 dB", gt=0.0, le=1e9, default=5000.0
    )
    alarms: Literal["sure", "early", "grip"] = Field(
        default="sure",
        description="of the slip detector: few false ones, or few slips without one, or grip: for a gripper "
        "that grips harder, the default beside [grip]",
    )
    steps: Annotated[list[Annotated[int, Field(ge=0)]], BeforeValidator(listed)] = Field(
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


LAW = "small_strain"  # of a scene that names none
ROUND_EFFECTS = "friction", LAW  # what is simulated of round skins
FILMLESS, ALONG_Y = "it has no slots for films", "so far only a section along y is"
# why the others are not, of a round skin
ROUND_REFUSALS = {
    "effects.film": FILMLESS,
    "effects.piezo": FILMLESS,
    "readout.ridges": FILMLESS,
    "effects.inertia": ALONG_Y,
    "effects.viscosity": ALONG_Y,
    "effects.finite_strain": "a large pull leaves no section that turns",
    "effects.free_ends": "it has no ends along y",
    "effects.texture": "a relief along x is not the same all round",
    "history.rotation_deg": "a plate that turns presses a ring harder on one side",
    "readout.steps": "a pull shears each section round the middle otherwise",
    "readout.frames": "a pull shears each section round the middle otherwise",
}
A_ROUND_SKIN = "a round skin", ROUND_EFFECTS, ROUND_REFUSALS
# by family, of skins that no section along y shows: whose, which effects are simulated, why others are not
SIMULATED: dict[str, tuple[str, tuple[str, ...], dict[str, str]]] = {
    "pin": ("pins", (*ROUND_EFFECTS, "finite_strain", "magnet"), {}),
    "ring": A_ROUND_SKIN,
    "flat": A_ROUND_SKIN,
}
LIFT_EFFECTS = *ROUND_EFFECTS, "film", "free_ends", "piezo", "viscosity"  # and of a lift
CHOSEN = "chosen"  # steps at finite strain
DRAWN = "steps", "frames"  # of the readout, what is drawn of single steps


def _placed(value: Any, folder: Path) -> Any:
    """A TOML or CSV file's path from the root, so that it means the same everywhere; any other value as it
    is."""
    if isinstance(value, str) and value.endswith((".toml", ".csv")):
        with suppress(OSError):  # where the working directory is gone
            return str((folder / value).absolute())
    return value


def _skin(value: Any) -> Any:
    """A design, or the text that names one."""
    return _placed(named_document(value, Design, "a design"), Path())


def _effects(tables: Any, folder: Path = Path()) -> Any:
    """Effects' tables, the files that they name taken from `folder`, and nothing that is not given."""
    if not isinstance(tables, dict):
        return tables
    return {
        name: {key: _placed(value, folder) for key, value in table.items() if value is not None}
        if isinstance(table, dict)
        else table
        for name, table in tables.items()
    }


class Scene(Document):
    """What is done to a skin: forces N, lengths mm, times s. `skin` is a Design, or the name of one.

    Raises InputError for broken rules, of the effects and between scene and skin too.
    """

    skin: Annotated[str | Design, BeforeValidator(_skin)] = Field(
        description="a design's template, or a TOML file beside the scene"
    )
    history: History = Field(  # type: ignore[assignment]  # of a lift, its plan
        default=None, description="what the plate does; a scene has this or [grip]"
    )
    grip: Grip | None = Field(
        default=None, description="two fingers grip an object and lift it, in the place of a history"
    )
    plate: ScenePlate = ScenePlate()
    effects: Annotated[dict[str, dict[str, Any]], BeforeValidator(_effects)] = Field(
        default={}, description="tables of effects by name"
    )
    readout: Readout = Readout()

    @model_validator(mode="before")
    @classmethod
    def _planned(cls, data: Any) -> Any:
        """A lift's history is its plan: the first grip, under the load."""
        if not isinstance(data, dict) or data.get("grip") is None:
            return data
        if data.get("history") is not None:
            raise InputError("history", "has no effect beside [grip]", remedy="leave one of them out")
        try:
            grip = data["grip"] if isinstance(data["grip"], Grip) else Grip.model_validate(data["grip"])
        except ValidationError as failure:
            raise told(Grip, failure, "grip") from None
        readout = data.get("readout") or {}
        if isinstance(readout, dict):
            readout = {"alarms": GRIP, **readout}
        return {**data, "history": grip.plan(), "readout": readout}

    @model_serializer(mode="wrap")
    def _without_plan(self, handler: SerializerFunctionWrapHandler) -> dict[str, object]:
        tables: dict[str, object] = handler(self)
        return {key: value for key, value in tables.items() if key != "history" or self.grip is None}

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if self.history is None:
            raise InputError("history", "is missing", remedy="give history a value, or [grip]")
        _check(self)
        return self

    def with_(self, **changes: Any) -> Self:
        """Return a copy with some keys changed, checked again, as a design's `with_`.

        `scene.with_(history={"steps": 100}, effects={"piezo": None})`; a dict for `skin` changes the design.
        """
        if isinstance(skin := changes.get("skin"), dict):
            try:
                changes["skin"] = self.design.with_(**skin)
            except InputError as failure:
                raise failure.under("skin") from None
        return super().with_(**changes)

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

    @property
    def cone(self) -> FrictionCoefficients | None:
        """What friction bears, the same at every step; None without any."""
        still = Drive(0.0)
        return share_of(self.terms, Step(0.0, 1.0, still, still)).cone

    @property
    def moving(self) -> frozenset[str]:
        """What of it no quasi-static pad knows."""
        return self.asked & MOVING

    @cached_property
    def law(self) -> Law:
        """The one law."""
        laws = {name: part for name, part in self.parts.items() if isinstance(part, Law)}
        if len(laws) > 1:
            raise InputError("effects", "must name one law at most", " and ".join(laws), "leave one out")
        chosen_law = next(iter(laws.values()), None) or _parsed(LAW, {})
        assert isinstance(chosen_law, Law)
        return chosen_law

    @cached_property
    def design(self) -> Design:
        """The skin's design."""
        return self.skin if isinstance(self.skin, Design) else _loaded(self.skin)

    @property
    def swept(self) -> bool:
        """Whether the skin is a section swept along y, so that one plane stands for all of it."""
        return skin_of(self.design).body in ("straight", "bent")

    @property
    def bare(self) -> bool:
        """Whether the skin is a bare face, told of by the share of it that slips."""
        return skin_of(self.design).bare

    @property
    def timed(self) -> Sequence[int]:
        """The features whose slip is timed: the monitored ridges, or all of a family that has no films."""
        skin = skin_of(self.design)
        return self.readout.ridges if skin.family == "ridge" else range(1, skin.count + 1)


def _loaded(skin: str, silicones: Own | None = None) -> Design:
    """The design that a scene names."""
    try:
        return load_design(skin, silicones=silicones)
    except InputError as failure:
        if failure.key == skin[:80]:
            raise InputError("skin", failure.rule, skin, failure.remedy) from None
        raise failure.under("skin") from None


def _of_lab(skin: Any, silicones: Own) -> Any:
    """A skin with a lab's own silicones in it; whatever is no skin as it is."""
    if isinstance(skin, str):
        return _loaded(skin, silicones)
    tables = skin.model_dump(exclude_none=True) if isinstance(skin, Design) else skin
    return with_own(tables, "silicones", silicones) if isinstance(tables, dict) else skin


def load_scene(
    source: str | Path,
    settings: list[str] | tuple[str, ...] = (),
    *,
    skin: Design | str | None = None,
    silicones: Own | None = None,
) -> Scene:
    """Return the scene of a template's name or of a TOML file, on its own skin or another.

    `settings` are as those of `load_design`. Paths of a skin and in an effect's table count from the scene's
    file; that of `skin` from the working directory. `silicones` are a lab's own, which go into the skin.
    Raises InputError with key, rule, value and remedy.
    """
    data = overridden(read_table(source, "scenes"), settings)
    if Path(source).suffix == ".toml":
        data["skin"] = _placed(data.get("skin"), Path(source).parent)
        data["effects"] = _effects(data.get("effects", {}), Path(source).parent)
    if skin is not None:
        data["skin"] = skin
    if silicones is not None:
        data["skin"] = _of_lab(data.get("skin"), own_tables("silicones", silicones))
    return Scene(**data)


def _parsed(name: str, table: dict[str, Any]) -> Effect:
    kind = effect(name)
    try:
        return kind.model_validate(table)
    except ValidationError as failure:
        raise told(kind, failure, f"effects.{name}") from None


def _check(scene: Scene) -> None:
    """Raise InputError for what scene and skin together do not allow."""
    design = scene.design
    skin = skin_of(design)
    _ = scene.law
    if not scene.swept:
        _check_family(scene)
    if scene.grip is not None:
        _check_lift(scene, scene.grip)
    _check_parts(scene)
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
    if scene.readout.ridges and skin.slot is None:
        rule = f"needs films' stresses, but {design.name} has no slots"
        raise InputError("readout.ridges", rule, scene.readout.ridges, "take a skin with slots")
    for ridge in scene.readout.ridges:
        if not 1 <= ridge <= skin.count:
            raise InputError("readout.ridges", f"must be from 1 to {skin.count}", ridge)
    too_late = [step for step in scene.readout.steps if step > scene.history.step_count]
    if too_late:
        raise InputError("readout.steps", f"must be from 0 to {scene.history.step_count}", too_late[0])
    if len(set(scene.readout.ridges)) < len(scene.readout.ridges):
        raise InputError("readout.ridges", "names a ridge twice", scene.readout.ridges)


def _check_family(scene: Scene) -> None:
    """Raise InputError for what only a section that is swept along y knows: a round skin is one that turns,
    under a level plate."""
    family = skin_of(scene.design).family
    if family == "pin":
        _check_pins(scene)
    whose, effects, reasons = SIMULATED[family]
    others = {f"effects.{name}": name not in effects for name in scene.effects}
    others["effects.finite_strain.creases"] = getattr(scene.law, "creases", "pass") != "pass"
    others["history.rotation_deg"] = any(scene.history.rotation_deg or [])
    others |= {f"readout.{key}": bool(getattr(scene.readout, key)) for key in ("ridges", *DRAWN)}
    for key, is_set in others.items():
        if is_set:
            why = f": {reasons[key]}" if key in reasons else ""
            raise InputError(key, f"is not simulated of {whose}{why}", remedy="leave it out")


def _check_pins(scene: Scene) -> None:
    """Raise InputError for friction and steps that pins do not know: they slip as points, by Coulomb's."""
    cone, pulls = scene.cone, scene.history.tangential_force_N or scene.history.displacement_mm or []
    steps = getattr(scene.law, "steps", CHOSEN)
    if cone and (cone.breakpoints or cone.kinetic != cone.static):
        rule = "must be Coulomb's with one coefficient for pins"
        raise InputError("effects.friction", rule, remedy="give coefficient alone")
    if any(pulls) and not (cone and cone.static):
        rule = "is missing: a plate without friction pulls no pin"
        raise InputError("effects.friction", rule, remedy="give its coefficient")
    if steps != CHOSEN:
        rule, remedy = "must be chosen for pins", f'take steps = "{CHOSEN}"'
        raise InputError("effects.finite_strain.steps", rule, steps, remedy)


def _check_parts(scene: Scene) -> None:
    """Raise InputError for effects that do not work together, or with the history or the plate: what only a
    quasi-static condensed pad knows, and what terms ask and law or plate do not give."""
    law = next((name for name, part in scene.parts.items() if part is scene.law), LAW)
    asks = {name: part.asks for name, part in scene.parts.items() if isinstance(part, Term)}
    bodies = {name: part for name, part in scene.parts.items() if isinstance(part, PadChange)}
    turns, moving = any(scene.history.rotation_deg or []), [name for name in asks if asks[name] & MOVING]
    needs = ["history.rotation_deg"] * turns
    needs += [f"readout.{key}" for key in DRAWN if getattr(scene.readout, key)]
    still = [f"effects.{name}" for name, body in bodies.items() if body.condenses]
    still += [f"effects.{name}" for name in asks if RELIEF in asks[name]]
    for keys, beside in ((needs, [law] * (not scene.law.condenses) + moving), (still, moving)):
        if keys and beside:
            rule = f"does not work together with {' and '.join(beside)}"
            raise InputError(keys[0], rule, remedy="leave one of them out")
    for name in (name for name, body in bodies.items() if not body.feels):
        rule = f"needs films' stresses, which effects.{name} does not give"
        if scene.readout.ridges:
            raise InputError("readout.ridges", rule, scene.readout.ridges, "take readout.ridges = []")
        for other, part in scene.parts.items():
            if isinstance(part, Reader) and name in part.needs:
                raise InputError(f"effects.{other}", rule, remedy=f"leave out effects.{other}")
    for name, wanted in asks.items():
        if wanted - scene.law.gives:
            rule = f"does not work together with {law}"
            raise InputError(f"effects.{name}", rule, remedy=f"leave out {law}")
    if MASS in scene.asked and scene.plate.mass is None:
        raise InputError("plate.mass", "is missing", remedy="masses count here: give the plate's mass in g")
    if MASS in scene.asked or scene.plate.mass is None:
        return
    beside = [f"[effects.{name}]" for name in moving] + [f"[effects.{law}]"] * (not scene.law.swings)
    beside += ["a plate that turns"] * turns
    beside += [f"[{skin_of(scene.design).family}]"] * (not scene.swept)
    if beside:
        rule = f"does not count beside {' and '.join(beside)}"
        raise InputError("plate.mass", rule, scene.plate.mass, "leave one of them out")


def _check_lift(scene: Scene, grip: Grip) -> None:
    """Raise InputError for a gripper that cannot grip so, and for what a lift does not simulate, or lacks."""
    try:
        grip.acts(scene.design.grippers or {})
    except InputError as failure:
        raise failure.under("grip") from None
    if skin_of(scene.design).family != "ridge":
        raise InputError("grip", "is for a skin with ridges", remedy="take a skin with [ridge]")
    others = {"plate.mass": scene.plate.mass, **{f"readout.{k}": getattr(scene.readout, k) for k in DRAWN}}
    for key, value in others.items():
        if value:
            raise InputError(key, "has no effect beside [grip]", value, "leave it out")
    heard = {"effects.piezo": "piezo" in scene.effects, "readout.ridges": scene.readout.ridges}
    for key, there in heard.items():
        if grip.policy in HEARING and not there:
            rule = f"is missing: policy = {grip.policy} hears the films"
            raise InputError(key, rule, remedy="name what is wired, or take policy = constant")
    _check_lift_effects(scene)


def _check_lift_effects(scene: Scene) -> None:
    """Raise InputError for effects that a lift does not simulate, or without friction."""
    for name in scene.effects:
        if name not in LIFT_EFFECTS:
            raise InputError(f"effects.{name}", "is not simulated of a lift", remedy="leave it out")
    if scene.effects.get("viscosity", {}).get("prony"):
        raise InputError("effects.viscosity.prony", "has no effect on a lift", remedy="give retardation_time")
    if scene.cone is None:
        raise InputError("effects.friction", "is missing", remedy="a lift needs friction: give coefficient")
    if scene.cone.static <= 0:
        raise InputError("effects.friction.coefficient", "must be above 0 in a lift", scene.cone.static)
    if scene.cone.breakpoints:
        raise InputError("effects.friction.law", "must be coulomb in a lift", remedy="give coefficient alone")


def _check_force(scene: Scene) -> None:
    """Raise InputError for a normal force that the ridges do not bear within the law's range, even if they
    share it evenly. With masses the skin may feel less than the plate."""
    ends, peak = scene.law.limits(scene.design), max(scene.history.normal_force_N)
    if MASS not in scene.asked and peak > (most := ends.bears(skin_of(scene.design).count)):
        rule = f"must be at most {most:.3g} N: {ends.overload_reason(ends.largest * peak / most)}"
        key = "history.normal_force_N" if scene.grip is None else "grip.force"
        raise InputError(key, rule, peak, "take smaller forces or a harder silicone")
