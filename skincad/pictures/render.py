"""Shaded pictures of meshes without a display: orthographic rays, one a pixel, cast by Embree."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import trimesh
from trimesh.ray.ray_pyembree import RayMeshIntersector

from skincad.base.arrays import Array, Index, Mask

Colour = tuple[float, float, float]
Image = Array
_LIGHT = np.array([0.35, -0.55, 0.76])  # from the viewer's upper right, in the scene's frame
_OVERSAMPLE = 2


@dataclass(frozen=True)
class Camera:
    """An orthographic view: unit vectors of the picture's right, up and towards the viewer; scale."""

    right: Array
    up: Array
    towards: Array
    centre: Array  # mm, in the picture's plane
    per_mm: float  # pixels
    size: tuple[int, int]  # width, height in pixels

    def pixel(self, point: Array) -> tuple[float, float]:
        """Return where a point of the scene lies in the picture, pixels from its upper left."""
        across = (float(point @ self.right) - self.centre[0]) * self.per_mm + self.size[0] / 2
        down = self.size[1] / 2 - (float(point @ self.up) - self.centre[1]) * self.per_mm
        return across, down


def view(meshes: list[trimesh.Trimesh], azimuth: float, height: float, size: tuple[int, int]) -> Camera:
    """Return the view from these angles (degrees: from -y towards +x, and above the horizon) that just
    holds the meshes in `size` pixels."""
    a, h = np.radians(azimuth), np.radians(height)
    towards = np.array([np.sin(a) * np.cos(h), -np.cos(a) * np.cos(h), np.sin(h)])
    right = np.array([np.cos(a), np.sin(a), 0.0])
    up = np.cross(towards, right)
    corners = np.vstack([mesh.vertices for mesh in meshes])
    flat = np.column_stack([corners @ right, corners @ up])
    low, high = flat.min(axis=0), flat.max(axis=0)
    per_mm = 0.96 * float(np.min(np.array(size) / (high - low)))
    return Camera(right, up, towards, (low + high) / 2, per_mm, size)


def shaded(meshes: list[trimesh.Trimesh], colours: list[Colour], seen: Camera) -> Image:
    """Return the picture, `(height, width, 3)` from 0 to 1: matt surfaces on white, edges drawn dark."""
    whole = trimesh.util.concatenate(meshes)
    owner = np.repeat(np.arange(len(meshes)), [len(mesh.faces) for mesh in meshes])
    wide, high = (_OVERSAMPLE * n for n in seen.size)
    step = 1 / (seen.per_mm * _OVERSAMPLE)
    across = seen.centre[0] + (np.arange(wide) - (wide - 1) / 2) * step
    upward = seen.centre[1] - (np.arange(high) - (high - 1) / 2) * step
    far = float(np.abs(whole.bounds).max()) * 4
    grid = across[None, :, None] * seen.right + upward[:, None, None] * seen.up + far * seen.towards
    origins = grid.reshape(-1, 3)
    rays = np.broadcast_to(-seen.towards, origins.shape)
    hit = RayMeshIntersector(whole).intersects_first(origins, rays).reshape(high, wide)
    normals = np.asarray(whole.face_normals)
    brightness = 0.45 + 0.55 * np.clip(normals @ _LIGHT, 0, 1)
    paint = np.array(colours)[owner] * brightness[:, None]
    image = np.vstack([paint, np.ones(3)])[hit]  # -1, the last: white
    image[_edges(hit, owner, normals)] *= 0.35
    blocks = image.reshape(seen.size[1], _OVERSAMPLE, seen.size[0], _OVERSAMPLE, 3)
    return np.asarray(blocks.mean(axis=(1, 3)))


def _edges(hit: Index, owner: Index, normals: Array) -> Mask:
    """Pixels whose right or lower neighbour shows another part, or a face at more than 25 degrees."""
    part, facing = np.append(owner, -1), np.vstack([normals, np.zeros(3)])  # -1, the last: nothing is hit
    edge = np.zeros(hit.shape, dtype=bool)
    for axis in (0, 1):
        other = np.roll(hit, -1, axis)
        differ = hit != other  # a face has no edge within itself
        one, next_one = hit[differ], other[differ]
        turned = (np.einsum("ij,ij->i", facing[one], facing[next_one]) < 0.9) & (one >= 0)
        edge[differ] |= (part[one] != part[next_one]) | turned
    return edge
