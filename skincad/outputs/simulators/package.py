"""A design as a package for simulators: what each kind needs, its words, its files, and the model card.

The card says what was simplified, what each number rests on, and where it holds. Licence: the owner's.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import trimesh

from skincad.base.errors import InputError, did_you_mean
from skincad.base.progress import Progress, Stopwatch
from skincad.base.reading import strict_json
from skincad.base.result import Result, Writer, item, record, reported
from skincad.fabrication.papers import macro
from skincad.inputs.design import Design
from skincad.inputs.material import layers, silicone
from skincad.mechanics.film.response import SPANS as RESPONSE_SPANS
from skincad.outputs.delivery import Presentation, text
from skincad.outputs.simulators.links import (
    MOST_BODIES,
    Links,
    carrier_part,
    collision,
    contact_chord,
    feature_bodies,
    glb,
    links,
    obj,
    visual,
)
from skincad.outputs.simulators.meshes import (
    HeightMap,
    Tetrahedra,
    height_map,
    materials,
    msh,
    tetrahedra,
    vtu,
)
from skincad.outputs.simulators.models import (
    FRICTION,
    STEP,
    friction,
    scene_xml,
    skin_urdf,
    skin_xml,
    slide_damping,
)
from skincad.outputs.simulators.springs import Springs, springs
from skincad.outputs.simulators.taxels import (
    Taxels,
    response_csv,
    taxels,
    taxels_csv,
    write_response,
    write_taxels,
)
from skincad.outputs.simulators.usd import installed, require_usd, write_usd
from skincad.outputs.solid_files import write_step, write_stl
from skincad.shape.skin import skin_of
from skincad.solids.layout import lid_process
from skincad.solids.plan import Prism
from skincad.solids.skin import skin_part

if TYPE_CHECKING:
    from skincad.mechanics.film.response import FilmResponse


KINDS = ("mujoco", "urdf", "taxels", "mesh", "usd")
MANY = "of so many pins a volume mesh takes minutes: ask for it by --for mesh"
NO_USD = "no usd, which needs usd-core: pip install 'skincad[usd]'"
NO_FILM = "there is no film that is bonded: taxels are the crests, and there is no film response"
DOUBLY_CURVED = "the films' response needs a skin that is straight along y: there is none"
FLAT_BACK = "the volume mesh, as the check, takes the bone as a flat back at z = 0"
FRAME = "x along the skin's width, y along its length, z out of the skin; the skin's flat back is at z = 0"
LICENCE = "to be stated by the skin's owner"


@record(eq=False)
class Package(Result):
    """A design for these `kinds` of simulators; what a kind asks for is None where it is not among them.

    `surfaces` are triangle meshes by their file's name, mm, in the design's frame; `notes` say what was left
    out and why.
    """

    shown_by = "skincad.outputs.simulators.package:PACKAGE"
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
    seconds: dict[str, float] = item(meaning="wall time by stage, s")
    mesh_prefix: str = item(meaning="what URDF's mesh names begin with", default="")

    @reported(meaning="the model card: what was simplified, and what each number rests on", inline=True)
    def _card(self) -> dict[str, Any]:
        return card(self)

    @reported(meaning="how many, null without any", key="taxels")
    def _taxels(self) -> int | None:
        return None if self.taxels is None else len(self.taxels.names)

    @property
    def name(self) -> str:
        """The design's name."""
        return self.design.name


def package(
    design: Design,
    kinds: Iterable[str] | str = (),
    *,
    model: str = "auto",
    mesh_prefix: str = "",
    progress: Progress | None = None,
) -> Package:
    """Return a design as a package for `kinds` of simulators, all of KINDS if there are none: a
    volume mesh of up to MOST_BODIES features, USD where usd-core is installed.

    `model` is the model of the check that MuJoCo's springs follow. `mesh_prefix` is what the names of URDF's
    meshes begin with, as `package://my_robot/meshes/`; without one they lie beside the file. Raises
    InputError for an unknown kind, for USD without usd-core, for a plate that is not flat where MuJoCo or USD
    is asked for, or for a carrier that cannot be made; RefusedError where a check or a response is beyond
    its model's range.
    """
    if not isinstance(design, Design):
        raise InputError("design", "must be a Design", design, "skincad.load(...) gives one")
    names = [kinds] if isinstance(kinds, str) else list(kinds)
    for kind in names:
        if kind not in KINDS:
            raise InputError("kinds", "unknown simulator", kind, did_you_mean(kind, KINDS))
    if "usd" in names:
        require_usd()
    watch, notes = Stopwatch(progress), list[str]()
    many = skin_of(design).count > MOST_BODIES
    unasked = {"mesh": MANY if many else "", "usd": "" if installed() else NO_USD}
    notes += [why for why in unasked.values() if why and not names]
    chosen = tuple(kind for kind in KINDS if (kind in names if names else not unasked.get(kind)))
    # the stages of springs, but not the time left of each of their checks
    untimed = None if progress is None else lambda stage, _=None, /: progress(f"springs: {stage}")
    with watch.stage("springs"):
        wanted, coupled = {*chosen} & {"mujoco", "usd"}, "mujoco" in chosen
        ridge_springs = springs(design, model, untimed, coupled=coupled) if wanted else None
    with watch.stage("response"):
        places = taxels(design) if {*chosen} & {"taxels", "usd"} else None
        response = _response(design, notes, progress) if "taxels" in chosen else None
    with watch.stage("solids"):
        weighs = links(design, bodies=bool({*chosen} & {"mujoco", "urdf", "usd"}))
    with watch.stage("surfaces"):
        shapes = {**visual(design), **collision(design)} if {*chosen} != {"taxels"} else {}
    mesh, heights = None, None
    if "mesh" in chosen:
        notes += [FLAT_BACK] if design.mold.bone else []
        with watch.stage("mesh"):
            if progress and (pins := len(skin_part(design).adds)):
                progress(f"mesh of {pins} pins", 1.0 * pins)  # s, about: 9 take 7 s, 127 take 127 s
            mesh, heights = tetrahedra(design), height_map(design)
    return Package(
        design=design,
        kinds=chosen,
        weighs=weighs,
        surfaces=shapes,
        springs=ridge_springs,
        taxels=places,
        response=response,
        mesh=mesh,
        heights=heights,
        notes=tuple(notes),
        mesh_prefix=mesh_prefix,
        seconds=watch.seconds(),
    )


def _response(design: Design, notes: list[str], progress: Progress | None) -> FilmResponse | None:
    """The films' response, or a note of why there is none."""
    if design.film is None or design.film_state != "bonded":
        notes.append(NO_FILM)
        return None
    if not isinstance(skin_part(design).body, Prism):
        notes.append(DOUBLY_CURVED)
        return None
    from skincad.mechanics.film.response import film_response

    return film_response(design, progress)


def _files(package: Package) -> Iterator[tuple[str, Writer]]:
    """The writer of each file."""
    design, kinds = package.design, {*package.kinds}
    yield "package.md", text(partial(markdown, package))
    yield "design.toml", text(design.to_toml)
    if kinds & {"mujoco", "urdf", "mesh"}:
        yield from ((f"{name}.stl", partial(write_stl, shape)) for name, shape in package.surfaces.items())
    if package.springs and "mujoco" in kinds:
        yield "skin.xml", text(partial(skin_xml, design, package.weighs, package.springs))
        yield "scene.xml", text(partial(scene_xml, design, package.springs))
    if "urdf" in kinds:
        yield "skin.urdf", text(partial(skin_urdf, design, package.weighs, package.mesh_prefix))
    if package.mesh and package.heights:
        mesh, heights = package.mesh, package.heights
        shapes = {name: package.surfaces[name] for name in ("skin", "carrier")}
        yield from ((f"{name}.obj", text(partial(obj, shape, name))) for name, shape in shapes.items())
        yield "skin.glb", partial(_glb, shapes)
        yield "skin.msh", text(partial(msh, mesh))
        yield "skin.vtu", text(partial(vtu, mesh))
        yield "materials.json", text(lambda: strict_json(materials(design, mesh), indent=1))
        yield "heights.png", partial(_png, heights)
        yield "heights.json", text(lambda: strict_json(heights.about(), indent=1))
    if package.springs and package.taxels and "usd" in kinds:
        links, places, surfaces = package.weighs, package.taxels, package.surfaces
        yield "skin.usda", partial(write_usd, design, links, package.springs, places, surfaces, FRAME)
    if package.taxels and "taxels" in kinds:
        yield "taxels.csv", text(partial(taxels_csv, package.taxels))
        yield "taxels.npz", partial(write_taxels, package.taxels)
    if package.response:
        yield "response.csv", text(partial(response_csv, design, package.response))
        yield "response.npz", partial(write_response, design, package.response)
    yield from ((f"{name}.step", partial(_step, design, name)) for name in ("skin", "carrier"))


def _glb(shapes: dict[str, trimesh.Trimesh], path: Path) -> None:
    path.write_bytes(glb(shapes))


def _png(heights: HeightMap, path: Path) -> None:
    """As an image of one channel of 16 bits."""
    from PIL import Image

    Image.fromarray(heights.levels()).save(path, format="PNG")


def _step(design: Design, name: str, path: Path) -> None:
    """Skin or carrier in the design's frame: the carrier is the mold's, turned about x."""
    from skincad.solids.occ import workplane
    from skincad.solids.skin import skin_solid

    about_x = (0, 0, 0), (1, 0, 0), 180
    carrier = name == "carrier"
    write_step(workplane(carrier_part(design)).rotate(*about_x) if carrier else skin_solid(design), path)


def card(package: Package) -> dict[str, Any]:
    """Return the card as JSON: `simplified` in words, `numbers` with what each rests on and its range."""
    return {
        "name": package.name,
        "for": list(package.kinds),
        "frame": FRAME,
        "licence": None,
        "mass_g": package.weighs.mass,
        "simplified": [*_simplified(package), *package.notes],
        "numbers": [dict(zip(("what", "rests_on", "holds"), row, strict=True)) for row in _numbers(package)],
        "springs": package.springs and package.springs.as_json(),
    }


def markdown(package: Package) -> str:
    """Return the card as Markdown."""
    facts = {"simplifications": [*_simplified(package), *package.notes], "numbers": _numbers(package)}
    return macro("papers/model-card.md", "card", package, FRAME=FRAME, LICENCE=LICENCE, **facts)


def _simplified(package: Package) -> list[str]:
    design = package.design
    chord, family = contact_chord(design), skin_of(design).family
    most = max(map(len, feature_bodies(design).values()))
    body = family if most == 1 else f"group of up to {most} neighbouring {family}s"  # what moves as one
    facts = {"chord": chord, "body": body, "family": family}
    return macro("papers/model-card.md", "simplified", package, **facts).splitlines()


def _numbers(package: Package) -> list[tuple[str, ...]]:
    design = package.design
    stuffs = [f"{s.density / 1e3:g} g/cm3 of {s.name}" for s in (silicone(design), *layers(design))]
    whose = "the bone, taken to be of the lids' material" if design.mold.bone else "the carrier"
    stuffs.append(f"{lid_process(design).density:g} g/cm3 of {whose}")
    without = " and without magnets" if getattr(design.features.pocket, "magnet", None) else ""
    mass = (
        f"mass {package.weighs.mass:.6g} g, centres and inertias",
        f"the exact solids of skin.step and carrier.step; {', '.join(stuffs)}",
        f"as designed{without}; parts weigh what their silicone's batch weighs",
    )
    facts: dict[str, Any] = {"STEP": STEP, "FRICTION": FRICTION, "friction": friction(design)}
    if package.springs:
        facts["armature"], facts["damping"] = slide_damping(package.springs)
    if response := package.response:
        both = (response.normal, response.tangential)
        change = response.at_other_forces[..., 0].max(axis=(1, 2))
        changes = zip(change, (span * response.force for span in RESPONSE_SPANS), strict=True)
        facts["largest"] = max(float(np.abs(stress[..., 0]).max()) for stress in both)
        facts["error"] = float(response.error[..., 0].max())
        facts["changes"] = [f"{stress:.2g} MPa/N at {force:g} N" for stress, force in changes]
    rows = macro("papers/model-card.md", "number_rows", package, **facts).splitlines()
    return [mass, *(tuple(row.split(" | ")) for row in rows)]


PACKAGE = Presentation(
    COMMAND="package",
    words="package.txt",
    writers=lambda package: dict(_files(package)),
    manifest=card,
)
