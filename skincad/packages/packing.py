"""A design as a package for simulators: what each kind needs is computed once; nothing is written here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from skincad.base.errors import InputError, did_you_mean
from skincad.base.progress import Progress, Stopwatch
from skincad.base.result import Result
from skincad.inputs.design import Design
from skincad.packages.links import Links, links
from skincad.packages.springs import Springs, springs
from skincad.packages.taxels import Taxels, taxels

if TYPE_CHECKING:
    import trimesh

    from skincad.mechanics.film.response import FilmResponse
    from skincad.packages.heights import HeightMap
    from skincad.packages.tetrahedra import Tetrahedra

KINDS = ("mujoco", "urdf", "taxels", "mesh")
NO_FILM = "there is no film that is bonded: taxels are the crests, and there is no film response"
DOUBLY_CURVED = "the films' response needs a skin that is straight along y: there is none"


@dataclass(frozen=True, repr=False, eq=False)
class Package(Result):
    """A design for these `kinds` of simulators; what a kind asks for is None where it is not among them.

    `surfaces` are triangle meshes by their file's name, mm, in the design's frame; `notes` say what was left
    out and why.
    """

    shown_by = "skincad.outputs.packages"
    design: Design
    kinds: tuple[str, ...]
    weighs: Links
    surfaces: dict[str, trimesh.Trimesh]
    springs: Springs | None
    taxels: Taxels | None
    response: FilmResponse | None
    mesh: Tetrahedra | None
    heights: HeightMap | None
    notes: tuple[str, ...]
    seconds: dict[str, float]

    @property
    def name(self) -> str:
        """The design's name."""
        return self.design.name

    def as_json(self) -> dict[str, Any]:
        """Return the object of `--json`: the model card, and how many taxels there are."""
        count = None if self.taxels is None else len(self.taxels.names)
        return {**self.presenter().manifest(self), "taxels": count, "seconds": dict(self.seconds)}


def package(
    design: Design,
    kinds: Iterable[str] | str = (),
    *,
    tier: str = "auto",
    progress: Progress | None = None,
) -> Package:
    """Return a design as a package for `kinds` of simulators, all of KINDS if there are none.

    `tier` is the model of the check that MuJoCo's springs follow. Raises InputError for an unknown kind, for
    a plate that is not flat where MuJoCo is asked for, or for a carrier that cannot be made; RefusedError
    where a check or a response is beyond its model's range.
    """
    if not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    names = [kinds] if isinstance(kinds, str) else list(kinds)
    for kind in names:
        if kind not in KINDS:
            raise InputError("kinds", "unknown simulator", kind, did_you_mean(kind, KINDS))
    chosen = tuple(kind for kind in KINDS if not names or kind in names)
    watch, notes = Stopwatch(progress), list[str]()
    with watch.stage("springs"):
        ridge_springs = springs(design, tier, _untimed(progress)) if "mujoco" in chosen else None
    with watch.stage("response"):
        places = taxels(design) if "taxels" in chosen else None
        response = _response(design, notes, progress) if "taxels" in chosen else None
    with watch.stage("solids"):
        weighs = links(design)
    with watch.stage("surfaces"):
        from skincad.packages.surfaces import collision, visual

        shapes = {**visual(design), **collision(design)} if {*chosen} != {"taxels"} else {}
    mesh, heights = None, None
    if "mesh" in chosen:
        from skincad.packages.heights import height_map
        from skincad.packages.tetrahedra import tetrahedra

        with watch.stage("mesh"):
            mesh, heights = tetrahedra(design), height_map(design)
    return Package(
        design,
        chosen,
        weighs,
        shapes,
        ridge_springs,
        places,
        response,
        mesh,
        heights,
        tuple(notes),
        watch.seconds(),
    )


def _untimed(progress: Progress | None) -> Progress | None:
    """Tell the stages of springs, but not the time left of each of their checks."""
    return None if progress is None else lambda stage, _=None, /: progress(f"springs: {stage}")


def _response(design: Design, notes: list[str], progress: Progress | None) -> FilmResponse | None:
    """The films' response, or a note of why there is none."""
    if design.film is None or design.film_state != "bonded":
        notes.append(NO_FILM)
        return None
    if design.skin.curvature_radius_y is not None:
        notes.append(DOUBLY_CURVED)
        return None
    from skincad.mechanics.film.response import film_response

    return film_response(design, progress)
