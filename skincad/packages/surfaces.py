"""The surfaces of a skin as triangles, in the design's frame, mm: to be seen, and to be touched.

A simulator's contact wants convex pieces: each ridge, the base under them and the carrier are the convex
hulls of their meshes. A hull fills a ridge's root fillets; crests, which touch, are convex themselves.
"""

from __future__ import annotations

import trimesh

from skincad.fabrication.meshes import mesh, upright
from skincad.inputs.design import Design
from skincad.packages.links import base_loop, carrier_part, ridge_parts
from skincad.shape.skin import skin_of
from skincad.solids.plan import Part
from skincad.solids.roles import PartRole
from skincad.solids.skin import along_skin, skin_part

CHORD = 1e-3  # of the pitch: visual
CONTACT_CHORD = 1e-4  # of the pitch, what touches: crests 0.1 um off, where the approach is 100 um


def visual(design: Design) -> dict[str, trimesh.Trimesh]:
    """Return skin and carrier, within CHORD of a pitch of their solids."""
    chord = CHORD * skin_of(design).pitch
    return {"skin": mesh(skin_part(design), chord), "carrier": upright(mesh(carrier_part(design), chord))}


def collision(design: Design) -> dict[str, trimesh.Trimesh]:
    """Return the convex hulls of each ridge, the base and the carrier; ridges within FINE of a pitch."""
    skin = skin_of(design)
    chord, fine = CHORD * skin.pitch, CONTACT_CHORD * skin.pitch
    base = Part("base-hull", PartRole.SKIN, along_skin(design, base_loop(design), ()))
    hulls = {part.name: mesh(part, fine).convex_hull for part in ridge_parts(design)}
    hulls["base-hull"] = mesh(base, chord).convex_hull
    hulls["carrier-hull"] = upright(mesh(carrier_part(design), chord)).convex_hull
    return hulls


def obj(shape: trimesh.Trimesh, name: str) -> str:
    """Return a mesh as OBJ, mm, in the design's frame."""
    return str(trimesh.exchange.obj.export_obj(shape, header=f"{name}, mm, z out of the skin", digits=9))


def glb(shapes: dict[str, trimesh.Trimesh]) -> bytes:
    """Return meshes as GLB: metres and y up, as glTF wants it, so the skin's z is y and its y is -z."""
    scene = trimesh.Scene()
    for name, shape in shapes.items():
        placed = shape.copy()
        placed.vertices = 1e-3 * placed.vertices[:, [0, 2, 1]] * [1.0, 1.0, -1.0]
        scene.add_geometry(placed, node_name=name, geom_name=name)
    return bytes(scene.export(file_type="glb"))
