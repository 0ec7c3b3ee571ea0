"""What a study's TOML says: what is varied, what is to be small or large, and what must hold."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from skincad.base.errors import InputError
from skincad.base.tables import Document, Table
from skincad.inputs.catalog import read_table, setting_key
from skincad.mechanics.models.table import tier_of
from skincad.studies.subject import Subject, load_subject

KEY = "the result's key in --json, another result's after make. or check., or a varied key"
FORM = 1  # of the file; a later skincad that reads it otherwise counts on


def _flat(data: Any) -> Any:
    """Keys with dots, whether they were written in quotes or as tables in each other."""
    if not isinstance(data, dict):
        return data
    flat: dict[str, Any] = {}
    for key, value in data.items():
        if isinstance(value, dict):
            flat |= {f"{key}.{inner}": inner_value for inner, inner_value in _flat(value).items()}
        else:
            flat[str(key)] = value
    return flat


class Objective(Table):
    """A number of the result that is to be small or large."""

    key: str = Field(description=KEY)
    goal: Literal["min", "max"] = Field(default="min", description="min or max")


class Limit(Table):
    """A number of the result that must lie within limits, with its error."""

    key: str = Field(description=KEY)
    at_least: float | None = Field(default=None, description="the least that it may be")
    at_most: float | None = Field(default=None, description="the most that it may be")

    @model_validator(mode="after")
    def _some(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise InputError("", "needs at_least or at_most", self.key, "give one of them")
        return self


class Study(Document):
    """A search for the best design, scene or circuit: frozen, as its file says.

    Raises InputError for the rules that are broken.
    """

    form: int = Field(default=FORM, description="of this file; leave it as it is")
    about: str = Field(
        description="the design, scene or circuit that it starts from: a template or a TOML file"
    )
    settings: tuple[str, ...] = Field(
        default=(), strict=False, description="overrides of that, as after --set: ridge.count=7"
    )
    vary: Annotated[dict[str, str | list[Any]], BeforeValidator(_flat)] = Field(
        description="keys and what they may be: LOW:HIGH, all, or a list"
    )
    objectives: tuple[Objective, ...] = Field(strict=False, description="what is to be small or large")
    constraints: tuple[Limit, ...] = Field(default=(), strict=False, description="what must hold")
    optimiser: Literal["cma", "nsga2", "sobol"] | None = Field(
        default=None,
        description="cma, nsga2 or sobol; if not given, the one that suits the keys and objectives",
    )
    evaluations: int = Field(default=200, ge=1, le=1_000_000, description="of the model that searches, about")
    tier: str | None = Field(default=None, description="the model that searches; linear if not given")
    judge: str = Field(default="auto", description="the model that has the last word on what is found")
    robust: bool = Field(default=True, description="judge by the worse end of each error, not by the value")
    seed: int = Field(default=1, ge=0, le=2**31, description="of the optimiser; the same seed asks the same")

    @model_validator(mode="after")
    def _rules(self) -> Self:
        if self.form != FORM:
            rule = f"must be {FORM}: this skincad reads no other form of study"
            raise InputError("form", rule, self.form, "write the study anew after a template")
        if not self.vary:
            raise InputError("vary", "names no key", remedy='as in "ridge.height" = "0.4:0.6"')
        if not self.objectives:
            raise InputError("objectives", "names none", remedy="add [[objectives]]")
        for key, tier in (("tier", self.tier), ("judge", self.judge)):
            if tier not in (None, "auto"):
                try:
                    tier_of(str(tier))
                except InputError as failure:
                    raise InputError(key, failure.rule, tier, failure.remedy) from None
        if self.tier == "auto":
            raise InputError("tier", "must be one model, for all to be compared by", "auto", "try linear")
        if self.optimiser == "cma" and len(self.objectives) > 1:
            raise InputError("optimiser", "must be nsga2 or sobol for several objectives", "cma")
        return self

    @property
    def aims(self) -> list[str]:
        """The keys of objectives and constraints."""
        return [aim.key for aim in self.objectives] + [aim.key for aim in self.constraints]

    def subject(self) -> Subject:
        """Return what the study starts from."""
        return load_subject(self.about, list(self.settings))


def load_study(source: str | Path, settings: list[str] | tuple[str, ...] = ()) -> Study:
    """Return the study of a template's name or of a TOML file, with more `settings` of what it is about.

    A path in the file counts from the file. Raises InputError with key, rule, value and remedy.
    """
    data = dict(read_table(source, "studies"))
    about = data.get("about")
    if isinstance(about, str) and about.endswith(".toml") and Path(source).suffix == ".toml":
        data["about"] = str((Path(source).parent / about).absolute())
    written = data.get("settings", [])
    if settings and isinstance(written, list):
        changed = {setting_key(text) for text in settings}
        data["settings"] = [*(text for text in written if setting_key(str(text)) not in changed), *settings]
    return Study(**data)
