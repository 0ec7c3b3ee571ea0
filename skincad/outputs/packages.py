"""A package for simulators: its words and its files."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import trimesh

from skincad.base.reading import strict_json
from skincad.base.result import Writer
from skincad.inputs.design import Design
from skincad.outputs.delivery import text
from skincad.packages.card import card, markdown
from skincad.packages.heights import HeightMap
from skincad.packages.mesh_files import materials, msh, vtu
from skincad.packages.mjcf import scene_xml, skin_xml
from skincad.packages.packing import Package
from skincad.packages.surfaces import glb, obj
from skincad.packages.taxel_files import response_csv, taxels_csv, write_response, write_taxels
from skincad.packages.urdf import skin_urdf

COMMAND = "package"
SOLID_FILES = ("skin.step", "carrier.step")


def lines(package: Package) -> list[str]:
    """Return what `package` prints."""
    rows = [f"{package.name} for {', '.join(package.kinds)}: {package.weighs.mass:.4g} g on its carrier"]
    if springs := package.springs:
        verdict = springs.verdict
        rows.append(f"  springs        approach {verdict.approach} at {verdict.force:g} N, as in the check")
        for other in springs.elsewhere:
            off = f"{other.approach_off:.1%} off the check, ridge forces {other.shares_off:.1%} of the mean"
            rows.append(f"  at {f'{other.force:g} N':11} approach {off}")
    if package.mesh:
        count = sum(len(elements) for elements in package.mesh.elements.values())
        rows.append(f"  mesh           {count} tetrahedra, volume off by {package.mesh.deviation:.1e} of it")
    if package.taxels:
        films = package.taxels.kinds.count("film")
        rows.append(f"  taxels         {films} film strips, {len(package.taxels.names) - films} crests")
    return [*rows, *(f"  note           {note}" for note in package.notes)]


def manifest(package: Package) -> dict[str, Any]:
    """Return the model card, which the manifest is."""
    return card(package)


def figures(_: Package) -> dict[str, Callable[[], Any]]:
    """Return none."""
    return {}


def files(package: Package) -> dict[str, Writer]:
    """Return the writer of each file."""
    return {**dict(_files(package)), **dict(_solids(package.design))}


def _files(package: Package) -> Iterator[tuple[str, Writer]]:
    design, kinds = package.design, {*package.kinds}
    yield "package.md", text(partial(markdown, package))
    yield "design.toml", text(design.to_toml)
    if kinds & {"mujoco", "urdf", "mesh"}:
        yield from ((f"{name}.stl", partial(_stl, shape)) for name, shape in package.surfaces.items())
    if package.springs:
        yield "skin.xml", text(partial(skin_xml, design, package.weighs, package.springs))
        yield "scene.xml", text(partial(scene_xml, design, package.springs))
    if "urdf" in kinds:
        yield "skin.urdf", text(partial(skin_urdf, design, package.weighs))
    if package.mesh and package.heights:
        mesh, heights = package.mesh, package.heights
        shapes = {name: package.surfaces[name] for name in ("skin", "carrier")}
        yield from ((f"{name}.obj", text(partial(obj, shape, name))) for name, shape in shapes.items())
        yield "skin.glb", lambda path: _write(path, glb(shapes))
        yield "skin.msh", text(partial(msh, mesh))
        yield "skin.vtu", text(partial(vtu, mesh))
        yield "materials.json", text(lambda: strict_json(materials(design, mesh), indent=1))
        yield "heights.png", partial(_png, heights)
        yield "heights.json", text(lambda: strict_json(heights.about(), indent=1))
    if package.taxels:
        yield "taxels.csv", text(partial(taxels_csv, package.taxels))
        yield "taxels.npz", partial(write_taxels, package.taxels)
    if package.response:
        yield "response.csv", text(partial(response_csv, design, package.response))
        yield "response.npz", partial(write_response, design, package.response)


def _solids(design: Design) -> Iterator[tuple[str, Writer]]:
    yield "skin.step", partial(_skin_step, design)
    yield "carrier.step", partial(_carrier_step, design)


def _write(path: Path, content: bytes) -> None:
    path.write_bytes(content)


def _png(heights: HeightMap, path: Path) -> None:
    """As an image of one channel of 16 bits."""
    from PIL import Image

    Image.fromarray(heights.levels()).save(path, format="PNG")


def _stl(shape: trimesh.Trimesh, path: Path) -> None:
    from skincad.outputs.export import write_stl

    write_stl(shape, path)


def _skin_step(design: Design, path: Path) -> None:
    from skincad.outputs.export import write_step
    from skincad.solids.skin import skin_solid

    write_step(skin_solid(design), path)


def _carrier_step(design: Design, path: Path) -> None:
    """The carrier in the design's frame: the mold's, turned about x."""
    from skincad.outputs.export import write_step
    from skincad.packages.links import carrier_part
    from skincad.solids.occ import workplane

    write_step(workplane(carrier_part(design)).rotate((0, 0, 0), (1, 0, 0), 180), path)
