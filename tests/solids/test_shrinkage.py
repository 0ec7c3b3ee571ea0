import pytest

import skincad
from skincad.inputs import Design
from skincad.shape import area, section
from skincad.solids import scaled_for_shrinkage, skin_part
from skincad.solids.mold import mold
from skincad.solids.shrinkage import shrinkage
from tests.families import RIDGED


@pytest.mark.parametrize("name", RIDGED)
def test_the_cavity_shrinks_to_the_part(name: str) -> None:
    """Volume by the cube; the slots' holes are the shims', which don't shrink, and grow with the length."""
    design = skincad.load(name)
    by = 1 / (1 - shrinkage(design))
    cast, part = mold(design).part("skin"), skin_part(design)
    assert by > 1.0009
    holes = sum(area(slot.loop()) for slot in section(design).slots) * design.skin.length
    # a shim is not larger, so the poured skin has holes of their old section over the larger length
    assert cast.volume + by * holes == pytest.approx(by**3 * (part.volume + holes), rel=1e-12)


def test_every_point_of_the_outline_moves_away_from_the_backs_middle(yamada: Design) -> None:
    by = 1 / (1 - 0.01)
    old, new = (section(d) for d in (yamada, scaled_for_shrinkage(yamada.with_(mold={"shrinkage": 0.01}))))
    for a, b in zip(old.outline, new.outline, strict=True):
        assert b.start == pytest.approx((by * a.start.x, by * a.start.z), abs=1e-12)  # rounding
        assert b.bulge == pytest.approx(a.bulge, rel=1e-9, abs=1e-12)
    for a, b in zip(old.slots, new.slots, strict=True):
        assert b.centre == pytest.approx((by * a.centre.x, by * a.centre.z), abs=1e-12)
        assert (b.thickness, b.depth) == (a.thickness, a.depth)


def test_ones_own_shrinkage_goes_before_the_silicones(yamada: Design) -> None:
    assert shrinkage(yamada) == 0.001
    assert shrinkage(yamada.with_(mold={"shrinkage": 0.0})) == 0.0
    assert section(scaled_for_shrinkage(yamada.with_(mold={"shrinkage": 0.0}))) == section(yamada)


def test_what_is_poured_may_pass_a_keys_limit() -> None:
    flat = skincad.load("yamada-2002", ["skin.curvature_radius=1e8"])
    assert scaled_for_shrinkage(flat).skin.curvature_radius == pytest.approx(1e8 / 0.999)
