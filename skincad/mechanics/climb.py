"""From tier to tier, until a verdict is clear, its error as asked or the time used up."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

from skincad.base.climbing import overrun
from skincad.base.errors import ExhaustedError, InputError, RefusedError, needing
from skincad.base.estimate import Estimate
from skincad.base.stopwatch import Progress, about
from skincad.inputs.design import Design
from skincad.inputs.material import silicone
from skincad.inputs.process import processes
from skincad.mechanics.left_out import LeftOut, left_out
from skincad.mechanics.plate_friction import PlateFriction
from skincad.mechanics.problem import (
    Answer,
    ContactError,
    LateError,
    Manufacture,
    Request,
    SizeError,
    Spread,
    no_yield,
)
from skincad.mechanics.tiers.table import (
    AUTO,
    TIERS,
    able,
    at_size,
    below,
    beside,
    expected,
    is_small_strain,
    load,
    run,
)
from skincad.mechanics.validity import (
    beyond_small_strain,
    refuse_crushed,
    strain_warnings,
    strained,
    tipping,
)
from skincad.mechanics.verdict import (
    AskedTier,
    ContactCheck,
    before_refusal,
    decided,
    lost,
    relative_error,
    unasked_left_out,
    with_model,
    with_open_friction,
    with_shortfall,
)

HOPELESS = 1.5  # budgets that the linear tier's law may ask for and the tier still be tried
LEAST = 1e-3  # s; what is left of a budget that is used up: the coarsest rung
# of an asked tolerance, what `auto` leaves to the mesh, and where the model leaves nothing out
MESH_SHARE, LAST_SHARE = 0.3, 0.5
FINEST = 5e-3  # relative; the mesh that `auto` takes where the model's error is the larger anyway
# s; where neither tolerance nor budget are given, no model is begun that would end later
PATIENCE = 120.0
LARGE = 12.0  # s of the linear model by its law: such a pad starts on the coarsest mesh, as with a budget
Told = Callable[[ContactCheck], object]  # is given each tier's verdict as it is known


class Climb:
    """One check: the tiers solved so far, and the verdict of each."""

    def __init__(
        self,
        design: Design,
        force: float,
        drops: tuple[float, ...],
        notes: tuple[str, ...],
        progress: Progress | None,
        told: Told | None = None,
    ) -> None:
        self.design, self.force, self.drops, self.notes = design, force, drops, notes
        self.progress, self.told = progress, told
        self.began, self.sampling = perf_counter(), 0.0
        self.done: dict[str, Answer] = {}
        self.known: dict[str, Answer] = {}  # with friction and what the model leaves out
        self.climbed: list[AskedTier] = []
        self.tiers = [name for name in AUTO if not able(name, design, bool(drops))]
        self.friction = PlateFriction(design, force, drops)

    def auto(self, tol: float | None, budget: float | None) -> ContactCheck:
        """Climb until the error is met, the verdict clear or the budget used."""
        request = Request(self.force, None, None, self.drops, parts=not self.drops)
        name = self.tiers[self._start(tol)]
        large = tol is None and name == "linear" and _law_seconds("linear", self.design) > LARGE
        if name != "winkler" and (budget is not None or large):
            return self._within(request, tol, budget)
        return self._climbed(name, request, tol, budget)

    def _within(self, request: Request, tol: float | None, budget: float | None) -> ContactCheck:
        """Climb from the linear tier where it fits into the budget, or PATIENCE; the closed form is the least
        there is."""
        limit = PATIENCE if budget is None else budget
        least = self.tiers[0] == "winkler"
        name = "linear" if "linear" in self.tiers else self.tiers[0]
        load(name)  # the library's import is no part of the budget
        self.began = perf_counter()
        try:
            if least and name == "linear" and expected(name, self.design, set()) > HOPELESS * limit:
                raise LateError(expected(name, self.design, set()))
            return self._climbed(name, replace(request, must_fit=least, budget=limit), tol, budget)
        except LateError as late:
            found = self._tier("winkler", replace(request, tol=FINEST))
            words = f"the linear tier would take about {about(late.seconds)} of the budget of {limit:g} s"
            if budget is None:
                words = (
                    f"the linear tier would take about {about(late.seconds)}, and without --budget a check "
                    f"takes about {PATIENCE:g} s at most"
                )
            found = replace(found, warnings=(*found.warnings, words), next_tier=(name, late.seconds))
            return with_shortfall(found, tol, 0.0)

    def _climbed(self, name: str, request: Request, tol: float | None, budget: float | None) -> ContactCheck:
        found: ContactCheck | None = None
        limit = budget if budget is not None or tol is not None else PATIENCE
        while True:
            timed = limit is not None and request.budget is not None  # by a budget, or as the pad is large
            left = max(limit - self._spent() - self._yield(), LEAST) if limit and timed else None
            try:
                found = self._tier(name, replace(request, tol=mesh_tolerance(name, tol), budget=left))
            except (InputError, RefusedError) as refusal:
                found = found or self._solved_before(request, refusal)
                if found is None:
                    raise
                later = self.tiers[self.tiers.index(name) + 1 :]
                by_force = isinstance(refusal, InputError) and refusal.key == "force"
                if later and budget is None and by_force and self._ends(later[0]) <= (limit or math.inf):
                    name = later[0]  # a plane model's limit need not be the solid's
                    continue
                found = before_refusal(found, name, refusal)
                break
            enough = budget is None and self._settled(found) if tol is None else self._met(found, tol)
            if found.next_tier is None or (not outgrown(self.design, found) and (found.beyond or enough)):
                break
            if limit is not None and self._spent() + found.next_tier[1] > limit:
                break
            name, request = found.next_tier[0], replace(request, must_fit=False)
        found = unasked_left_out(self._with_yield(found))
        found = replace(found, warnings=(*found.warnings, *overrun("", self._spent(), budget)))
        return with_shortfall(found, tol, 0.0) if tol is not None else with_open_friction(found)

    def _solved_before(self, request: Request, refusal: Exception) -> ContactCheck | None:
        """The verdict of the best tier that a refused one was built on; of a pad that is too large for any
        mesh the closed form's."""
        solved = [name for name in self.tiers if name in self.done]
        if not solved and isinstance(refusal, SizeError) and self.tiers[0] == "winkler":
            solved = ["winkler"]
        return self._tier(solved[-1], replace(request, must_fit=False)) if solved else None

    def _start(self, tol: float | None) -> int:
        """The first tier that may meet the tolerance, by Winkler's strains; the linear one without any."""
        first = self.tiers.index("linear") if "linear" in self.tiers else 0
        if tol is None or self.drops:
            return first
        rough = run("winkler", self.design, Request(self.force), {}, None)
        for i, name in enumerate(self.tiers):
            bounds = self._bounds(name, rough)
            value = rough.all_touch_force if name == "winkler" else Estimate(1.0, 0.0, "1")
            relative = (value.error or 0.0) / (value.value or 1.0) + math.fsum(b.threshold for b in bounds)
            if relative - self._spared(bounds, tol) <= tol:
                return i
        return len(self.tiers) - 1

    def _bounds(self, name: str, found: Answer) -> tuple[LeftOut, ...]:
        """Bounds of what a tier leaves out of an answer."""
        effects = (*TIERS[name].leaves_out, *self.friction.left_out(name))
        return left_out(effects, self.design, found, self.force)

    def _spared(self, bounds: tuple[LeftOut, ...], tol: float) -> float:
        """What of the relative error no tier takes away, where that alone is the tolerance: then the rest is
        asked to meet it."""
        part = self.friction.stays(bounds)
        return part if part > tol - FINEST else 0.0

    def _met(self, found: ContactCheck, tol: float) -> bool:
        """Whether the tolerance is met, as far as any tier can."""
        spared = self._spared(found.left_out, tol) * (found.all_touch_force.value or 0.0)
        return relative_error(found, spared) <= tol

    def _settled(self, found: ContactCheck) -> bool:
        """Whether the verdict is clear, or what no tier takes away keeps it open in any case."""
        return decided(found) or lost(found, self.friction.stays(found.left_out))

    def _ends(self, name: str) -> float:
        """Seconds from the check's beginning to the end of a model that is begun now."""
        return self._spent() + self._seconds(name)

    def _spent(self) -> float:
        return perf_counter() - self.began

    def judged(self, name: str, request: Request) -> ContactCheck:
        """Return the verdict by one tier, with its yield."""
        return self._with_yield(self._tier(name, request))

    def _tier(self, name: str, request: Request) -> ContactCheck:
        """The verdict by one tier, solved on what is solved already."""
        started = self._spent()
        for each in (*below(name), name):
            if self.progress and each not in (*self.done, "winkler"):
                self.progress(f"{each} tier", self._seconds(name))
            found = run(each, self.design, request, self.done, self.progress)
        refuse_crushed(self.design, self.force, name, found.approach.value or 0.0)
        left = None if request.budget is None else request.budget - (self._spent() - started)
        found = self.friction.on(name, found, left, beside("friction", self.design) * self._speed())
        found = found.consistent(self.force)
        bounds = self._bounds(name, found)
        self.known[name] = known = with_model(found, bounds, self.force)
        verdict = self._verdict(name, known, bounds)
        self.climbed.append(AskedTier(name, verdict.all_touch_force, self._spent() - started, found.unknowns))
        if self.told:
            self.told(verdict)
        return verdict

    def _with_yield(self, found: ContactCheck) -> ContactCheck:
        """The last verdict with its yield; those before it are asked for none."""
        known, made, reserved = self.known[found.tier], None, self._yield()
        failed: tuple[str, ...] = ()
        if not (self.drops or found.beyond or found.tier == "winkler"):
            try:
                with needing("the yield"):
                    made = self._manufacture(known)
            except (ContactError, ExhaustedError) as failure:  # the yield has no say in the verdict
                failed = (no_yield(failure),)
        beyond = found.beyond or self._fault(found.tier, known)  # of the plane, which a solid's yield solves
        following = found.next_tier
        return replace(
            found,
            beyond=beyond,
            deformed=self.done["linear"].deformed if "linear" in self.done else (),
            manufacture=None if beyond else made,
            seconds={**found.seconds, "total": self._spent(), **self._sampled(known)},
            warnings=(*found.warnings, *failed),
            next_tier=following and (following[0], following[1] + self._yield() - reserved),
        )

    def _manufacture(self, found: Answer) -> Manufacture | None:
        """Yield and sensitivities of the design, the ridge model's force scaled to what the tier found."""
        threshold, parts = found.all_touch_force.value, found.parts
        if threshold is None or self.design.ridge.count == 1:
            return None
        if parts is None:  # the coarsest linear mesh is enough for what is scaled anyway
            rough = Request(self.force, FINEST, parts=True)
            parts = run("linear", self.design, rough, self.done, self.progress).parts
        if parts is None:
            return None
        from skincad.mechanics.manufacture import manufacture

        started = perf_counter()
        unsure = found.all_touch_force.error or 0.0
        made = manufacture(parts, self.force, threshold, spread_of(self.design), unsure)
        self.sampling = perf_counter() - started
        return made

    def _verdict(self, name: str, found: Answer, bounds: tuple[LeftOut, ...]) -> ContactCheck:
        design, force, small = self.design, self.force, is_small_strain(name)
        beyond = (small and beyond_small_strain(design, force, found)) or self._fault(name, found)
        warnings = (*found.warnings, *self.notes, *(strain_warnings(design, found) if small else ()))
        return ContactCheck(
            design.name,
            force,
            design.ridge.count,
            found.touching,
            found.all_touch_force,
            found.approach,
            found.ridge_force,
            name,
            found.unknowns,
            found.residual,
            {"total": self._spent(), **found.seconds},
            warnings,
            bounds,
            tuple(self.climbed),
            self._next(name),
            plate=design.contact.plate.shape,
            beyond=beyond,
            tipping=tipping(design, found),
            friction=design.contact.friction,
        )

    def _fault(self, name: str, found: Answer) -> str:
        """What goes through each other unseen: the solid looks at crowns alone, the plane at all."""
        plane = self.done.get("linear", found)
        fault = found.fault or (plane.fault if is_small_strain(name) else "")
        return fault and f"at {self.force:g} N {fault}, which the model does not cover"

    def _yield(self) -> float:
        """Seconds of the yield: those that it took, or by its law at the speed seen so far."""
        return 0.0 if self.drops else self.sampling or beside("yield", self.design) * self._speed()

    def _sampled(self, found: Answer) -> dict[str, float]:
        """Time of the yield: its model's, which the linear tier built, and its parts'."""
        return {"yield": found.seconds.get("yield", 0.0) + self.sampling} if self.sampling else {}

    def _next(self, name: str) -> tuple[str, float] | None:
        """The next tier with less left out and its seconds: its law's, at the speed seen so far."""
        mine, later = TIERS[name], list(TIERS)
        better = [
            other
            for other in self.tiers
            if later.index(other) > later.index(name)
            and (name == "winkler" or len(TIERS[other].leaves_out) <= len(mine.leaves_out))
        ]
        if not better:
            return None
        return better[0], self._seconds(better[0])

    def _seconds(self, name: str) -> float:
        """What a tier will take from here: its law's at the speed seen so far, and the yield."""
        return expected(name, self.design, set(self.done)) * self._speed() + self._yield()

    def _speed(self) -> float:
        """Seconds on this design for a second of the laws, by the linear tier; 1 where that is not solved."""
        plane = self.done.get("linear")
        if plane is None:
            return 1.0
        spent = math.fsum(s for stage, s in plane.seconds.items() if stage != "yield")
        return spent / at_size("linear", plane.unknowns)


def outgrown(design: Design, found: ContactCheck) -> bool:
    """Whether a tier for small strains has found that they are not: a better one has to say what then."""
    return is_small_strain(found.tier) and (bool(found.beyond) or strained(design, found))


def _law_seconds(name: str, design: Design) -> float:
    """Return the seconds of a model by its law alone: the same on every machine."""
    return TIERS[name].law.at(TIERS[name].size(design))


def mesh_tolerance(name: str, tol: float | None) -> float:
    """Return the relative error that `auto` asks of a tier's mesh for one of the whole."""
    share = MESH_SHARE if TIERS[name].leaves_out else LAST_SHARE
    return FINEST if tol is None else min(FINEST, share * tol)


def spread_of(design: Design) -> Spread:
    """Return how parts of a design differ: by its mold's process and its material's range."""
    process, modulus = design.mold.process, silicone(design).young_modulus
    sigma = processes(design.printer)[process].crest_sigma
    return Spread(process, sigma, (modulus.low, modulus.value, modulus.high))
