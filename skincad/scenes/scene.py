"""What a scene says: a skin, what the plate does, and the effects that count.

An effect that is not named is not imported. Its table is parsed by the effect itself.
"""

from __future__ import annotations

from contextlib import suppress
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BeforeValidator, Field, ValidationError, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Document, told
from skincad.effects import effect
from skincad.effects.kinds import MASS, Effect, Law, PadChange, Reader, Term
from skincad.inputs.catalog import Own, load_design, overridden, own_tables, read_table, with_own
from skincad.inputs.design import Design
from skincad.scenes.scene_tables import History, Readout, ScenePlate
from skincad.shape.skin import skin_of

LAW = "small_strain"  # of a scene that names none
LONGEST = 4096  # letters of a path


def _placed(value: Any, folder: Path) -> Any:
    """A TOML file's path from the root, so that it means the same everywhere; any other value as it is."""
    if isinstance(value, str) and value.endswith(".toml"):
        with suppress(OSError):  # where the working directory is gone
            return str((folder / value).absolute())
    return value


def _skin(value: Any) -> Any:
    """A design, or the text that names one."""
    if isinstance(value, dict):
        return Design(**value)
    if not isinstance(value, str | Design):
        raise InputError("", "must be a design, or the name of a template or TOML file", value)
    if isinstance(value, str) and len(value) > LONGEST:
        raise InputError("", f"must have at most {LONGEST} characters", value)
    return _placed(value, Path())


def _effects(tables: Any, folder: Path = Path()) -> Any:
    """Effects' tables, the TOML files that they name taken from `folder`, and nothing that is not given."""
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
    history: History
    plate: ScenePlate = ScenePlate()
    effects: Annotated[dict[str, dict[str, Any]], BeforeValidator(_effects)] = Field(
        default={}, description="tables of effects by name"
    )
    readout: Readout = Readout()

    @model_validator(mode="after")
    def _rules(self) -> Self:
        _check(self)
        return self

    def with_(self, **changes: Any) -> Self:
        """Return a copy with some keys changed, checked anew, as a design's `with_`.

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


def _check_terms(scene: Scene) -> None:
    """Raise InputError for what terms ask and law or plate do not give."""
    law = next((name for name, part in scene.parts.items() if part is scene.law), LAW)
    for name, part in scene.parts.items():
        if isinstance(part, Term) and part.asks - scene.law.gives:
            raise InputError(
                f"effects.{name}", f"does not work together with {law}", remedy=f"leave out {law}"
            )
    if MASS in scene.asked and scene.plate.mass is None:
        raise InputError("plate.mass", "is missing", remedy="masses count here: give the plate's mass in g")
    if MASS not in scene.asked and scene.plate.mass is not None:
        rule, remedy = "has no effect where masses do not count", "add [effects.inertia]"
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
        rule = f"must be at most {ridges * ends.largest:.3g} N: {ends.overload_reason(peak / ridges)}"
        raise InputError("history.normal_force_N", rule, peak, "take smaller forces or a harder silicone")


def _check_law(scene: Scene) -> None:
    """Raise InputError for what only a quasi-static condensed pad knows, with a law or term that has none."""
    law = next((name for name, part in scene.parts.items() if part is scene.law), LAW)
    others = [] if scene.law.condenses else [law]
    others += [name for name, part in scene.parts.items() if isinstance(part, Term) and part.asks]
    needs = ["history.rotation_deg"] if any(scene.history.rotation_deg or []) else []
    needs += [f"readout.{key}" for key in ("steps", "frames") if getattr(scene.readout, key)]
    bodies = {name: part for name, part in scene.parts.items() if isinstance(part, PadChange)}
    needs += [f"effects.{name}" for name, body in bodies.items() if body.condenses]
    if others and needs:
        rule = f"does not work together with {' and '.join(others)}"
        raise InputError(needs[0], rule, remedy="leave one of them out")
    for name, body in bodies.items():
        if body.feels:
            continue
        if scene.readout.ridges:
            rule = f"needs films' stresses, which effects.{name} does not give"
            raise InputError("readout.ridges", rule, scene.readout.ridges, "take readout.ridges = []")
        for other, part in scene.parts.items():
            if isinstance(part, Reader) and name in part.needs:
                rule = f"needs films' stresses, which effects.{name} does not give"
                raise InputError(f"effects.{other}", rule, remedy=f"leave out effects.{other}")
