"""Every part of every design is one valid solid of the volume that its own formula gives."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from dataclasses import replace

import pytest

import skincad
from skincad.inputs import Design
from skincad.shape import rectangle, section
from skincad.solids import (
    Bore,
    KernelError,
    Prism,
    RevolvedBody,
    skin_part,
    skin_solid,
    solid,
    unchecked_solid,
)
from skincad.solids.mold import mold
from skincad.solids.occ import KERNEL_TOLERANCE, flattened, rounding_error
from tests.templates import KINDS


@pytest.mark.parametrize("name", KINDS)
def test_templates_parts_are_valid_and_of_their_volume(name: str) -> None:
    for part in mold(skincad.load(name)).parts:
        shape = unchecked_solid(part)
        assert shape.isValid()
        assert shape.Volume() == pytest.approx(part.volume, rel=1e-9)


@pytest.mark.slow
def test_hard_shapes_are_valid_and_of_their_volume(variants: dict[str, Design]) -> None:
    for name, design in variants.items():
        shape = solid(skin_part(design))
        # arcs that rise less than the kernel's 1e-7 mm become lines: that moves area by 1e-7 x width
        slack = 1e-7 * design.skin.width * design.skin.length
        exact = section(design).area * design.skin.length
        assert shape.Volume() == pytest.approx(exact, rel=1e-9, abs=slack), name


def test_skin_is_a_workplane_with_exact_cylinders(yamada: Design) -> None:
    faces = skin_solid(yamada).faces().vals()
    kinds = {face.geomType() for face in faces}
    assert kinds == {"PLANE", "CYLINDER"}
    assert len(faces) == len(section(yamada).outline) + 4 * 18 + 2


def test_a_solid_that_is_not_its_plans_volume_is_refused(yamada: Design) -> None:
    cover = mold(yamada).part("cover")
    outside = replace(cover, cuts=(*cover.cuts, Bore((100.0, 0.0, 0.0), "z", 1.0, 1.0)))
    with pytest.raises(KernelError, match="cover: volume differs from its formula"):
        solid(outside)


@pytest.mark.parametrize("share", [0.9, 1.2])
def test_cuts_may_be_off_by_the_kernels_tolerance_on_each_face(
    share: float, yamada: Design, monkeypatch: pytest.MonkeyPatch
) -> None:
    cover = mold(yamada).part("cover")
    off = share * KERNEL_TOLERANCE * solid(cover).Area()
    monkeypatch.setattr("skincad.solids.occ.volume", lambda part, _: part.volume + off)
    with nullcontext() if share < 1 else pytest.raises(KernelError, match="cover: volume differs"):
        solid(cover)
    uncut = replace(cover, cuts=())
    with pytest.raises(KernelError, match="cover: volume differs"):  # no edge of it is computed
        solid(uncut)


def test_a_missing_system_library_is_named_with_its_package(monkeypatch: pytest.MonkeyPatch) -> None:
    import importlib

    class Lacking:
        """As the dynamic linker has it on a bare Linux."""

        def find_spec(self, name: str, *_: object) -> None:
            if name == "cadquery":
                words = "libGL.so.1: cannot open shared object file: No such file or directory"
                raise ImportError(words)

    monkeypatch.setattr(sys, "meta_path", [Lacking(), *sys.meta_path])
    monkeypatch.delitem(sys.modules, "cadquery")
    monkeypatch.delitem(sys.modules, "skincad.solids.occ")
    with pytest.raises(skincad.InputError, match="libgl1 libx11-6"):
        importlib.import_module("skincad.solids.occ")


@pytest.mark.parametrize("far", [1e4, 1e8])
def test_what_far_centres_may_round_is_the_last_digits_of_their_distance_on_every_face(far: float) -> None:
    """By hand: faces of 2 (10 + 4) mm round the section, each 20 mm long, moved by the distance's digits."""
    flat = rectangle(-5.0, 5.0, 0.0, 4.0)
    assert rounding_error(Prism(flat, "y", -10.0, 10.0)) == 0.0
    assert rounding_error(Bore((0.0, 0.0, 0.0), "z", 1.0, 1.0)) == 0.0
    digits = far * sys.float_info.epsilon
    for centre in (far, -far):
        swept = rounding_error(RevolvedBody(flat, centre, -10.0 / far, 10.0 / far))
        assert swept == pytest.approx(4 * digits * 28.0 * 20.0, rel=1e-9)  # up to 4 times as much
    # an arc of a far centre is as a face that far
    arc = replace(flat[0], bulge=10.0 / far / 4)
    assert rounding_error(Prism((arc, *flat[1:]), "y", -10.0, 10.0)) == pytest.approx(
        4 * digits * 10.0 * 20.0, rel=1e-6
    )


def test_only_an_arc_that_the_kernel_cannot_tell_from_a_line_is_one() -> None:
    flat = rectangle(-5.0, 5.0, 0.0, 4.0)
    for rise, line in ((0.99 * KERNEL_TOLERANCE, True), (1.01 * KERNEL_TOLERANCE, False)):
        for sign in (1, -1):
            arc = replace(
                flat[0], bulge=sign * 2 * rise / 10.0
            )  # rise of an arc: half the chord by the bulge
            assert arc.point(0.5).z == pytest.approx(-sign * rise, rel=1e-6)
            shown = flattened(Prism((arc, *flat[1:]), "y", -10.0, 10.0))
            assert isinstance(shown, Prism)
            assert (shown.outline[0].bulge == 0.0) == line
