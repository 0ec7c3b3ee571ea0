"""The skin as URDF: the same links as the MuJoCo model's, all fixed, for URDF knows no springs. m, kg.

Source: the URDF XML specification (wiki.ros.org/urdf/XML); meshes are named beside the file.
"""

from __future__ import annotations

from collections.abc import Iterator

from skincad.inputs.design import Design
from skincad.packages.files import numbers
from skincad.packages.links import Links, Weight
from skincad.packages.mjcf import KG, KG_M2, M


def skin_urdf(design: Design, links: Links) -> str:
    """Return the skin on its carrier: root link `carrier`, in the design's frame."""
    lines = ['<?xml version="1.0"?>', f'<robot name="{design.name}">']
    lines += _link("carrier", links.carrier, "carrier", "carrier-hull")
    lines += [*_link("skin", links.base, "skin", "base-hull"), *_joint("carrier", "skin")]
    if links.filling:
        lines += [*_link("filling", links.filling), *_joint("skin", "filling")]
    for i, weight in enumerate(links.ridges, 1):
        lines += [*_link(f"ridge-{i}", weight, None, f"ridge-{i}"), *_joint("skin", f"ridge-{i}")]
    return "\n".join([*lines, "</robot>", ""])


def _link(
    name: str, weight: Weight, visual: str | None = None, collision: str | None = None
) -> Iterator[str]:
    i = weight.inertia * KG_M2
    axes = {"ixx": i[0, 0], "ixy": i[0, 1], "ixz": i[0, 2], "iyy": i[1, 1], "iyz": i[1, 2], "izz": i[2, 2]}
    yield f'  <link name="{name}">'
    yield "    <inertial>"
    yield f'      <origin xyz="{numbers(weight.centre * M)}" rpy="0 0 0"/>'
    yield f'      <mass value="{numbers([weight.mass * KG])}"/>'
    words = zip(axes, numbers(axes.values()).split(), strict=True)
    yield "      <inertia " + " ".join(f'{axis}="{value}"' for axis, value in words) + "/>"
    yield "    </inertial>"
    for kind, mesh in (("visual", visual), ("collision", collision)):
        if mesh:
            yield f"    <{kind}>"
            yield '      <origin xyz="0 0 0" rpy="0 0 0"/>'
            yield f'      <geometry><mesh filename="{mesh}.stl" scale="{M:g} {M:g} {M:g}"/></geometry>'
            yield f"    </{kind}>"
    yield "  </link>"


def _joint(parent: str, child: str) -> Iterator[str]:
    yield f'  <joint name="{parent}-{child}" type="fixed">'
    yield '    <origin xyz="0 0 0" rpy="0 0 0"/>'
    yield f'    <parent link="{parent}"/>'
    yield f'    <child link="{child}"/>'
    yield "  </joint>"
