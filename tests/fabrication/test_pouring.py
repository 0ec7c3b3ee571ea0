"""How silicone is mixed and filled in, by hand's arithmetic."""

import math

import pytest

import skincad
from skincad.fabrication import Job, casting_sheet, pouring
from skincad.fabrication.pouring import filling, front_time, groove_time, pouring_findings, small_batch
from skincad.fabrication.strips import pour
from skincad.inputs import Design, silicones
from skincad.solids import WIDTHS
from tests.templates import SHIPPED


def test_a_front_is_a_film_under_its_own_weight(yamada: Design) -> None:
    """12 mm at rho g h^2 sin(a) / (3 mu): 1080 kg/m3, 4 mm, 10 degrees, 20 Pa s."""
    speed = 1080 * 9.81 * 0.004**2 * math.sin(math.radians(10)) / (3 * 20)
    assert front_time(Job(yamada)) == pytest.approx(0.012 / speed, rel=1e-12)
    thin = Job(yamada.with_(skin={"thickness": 2.0}))
    assert front_time(thin) == pytest.approx(4 * front_time(Job(yamada)), rel=1e-12)
    level = Job(yamada.with_(mold={"pour_tilt": 0.0}))
    assert front_time(level) == front_time(Job(yamada.with_(mold={"pour_tilt": 1.0})))


def test_a_groove_fills_as_a_gap_does_by_washburn() -> None:
    """Integrated step by step: b^2 / (12 mu) times the pressure's gradient, which falls as it gets deeper."""
    job = Job(skincad.load("plain-ridges"))
    head, gap, depth = 1080 * 9.81 * 0.004, 0.625e-3, 0.5e-3
    step, time = depth / 2000, 0.0
    for i in range(2000):
        time += step * 12 * 20 * (i + 0.5) * step / (gap**2 * head)
    assert groove_time(job) == pytest.approx(time, rel=1e-6)


def test_grooves_that_the_mix_does_not_flow_into_are_brushed(yamada: Design) -> None:
    job = Job(yamada)
    assert groove_time(job) / pouring.LAG > 300
    text = casting_sheet(job, [], "", True)
    brushed, mixed, closed = (
        text.index(words) for words in ("Brush the mix", "Mix. Start", "Lay the carrier")
    )
    assert mixed < brushed < closed
    thin = Job(yamada.with_(silicones={"dragon-skin-30": {"viscosity": 3.0}}))
    assert not filling(thin).brushed
    text = casting_sheet(thin, [], "", True)
    assert "Brush the mix" not in text
    assert text.index("Lay the carrier") < text.index("Mix. Start")


def test_the_thumb_presses_by_hagen_and_poiseuille() -> None:
    """A blunt tip of 16 gauge, 1.19 x 12.7 mm, and a syringe of 5 ml, 12.06 mm."""
    job = Job(skincad.load("milled-pad", ["mold.gate=2.0"]))
    how = filling(job)
    flow = pouring.poured_volume(job) * 1e-9 / how.seconds
    pressure = 128 * 20 * 12.7e-3 * flow / (math.pi * 1.19e-3**4)
    assert how.force == pytest.approx(pressure * math.pi / 4 * 12.06e-3**2, rel=1e-12)
    stiff = Job(job.design.with_(silicones={job.silicone.name: {"viscosity": 200.0}}))
    assert filling(stiff).force <= pouring.THUMB
    assert filling(stiff).seconds > how.seconds


def test_a_gate_is_wider_where_a_thumb_would_press_too_hard_and_the_skin_has_room() -> None:
    """The next usual width at which the force asks for no longer time; a thin skin keeps it narrow."""
    design = skincad.load("milled-pad", ["mold.fill_time=30"])
    stiff = design.with_(silicones={design.material.name: {"viscosity": 200.0}}, skin={"thickness": 12.0})
    wide, job = WIDTHS.index(Job(stiff).gate or 0.0), Job(stiff)
    assert wide > 0
    assert filling(job).force < pouring.THUMB
    narrower = Job(stiff.with_(mold={"gate": WIDTHS[wide - 1]}))
    assert filling(narrower).force > 0.9 * pouring.THUMB
    thin = Job(stiff.with_(skin={"thickness": 3.0}))
    assert thin.gate is not None
    assert thin.gate < WIDTHS[wide]


@pytest.mark.parametrize("name", SHIPPED)
def test_every_templates_mold_is_full_within_its_pot_life(name: str) -> None:
    job = Job(skincad.load(name))
    how = filling(job)
    assert how.force <= pouring.THUMB
    assert how.seconds >= max(front_time(job), job.design.mold.fill_time)
    assert pouring_findings(job) == []
    text = casting_sheet(job, [], "", True)
    assert f"Take {pouring.time_words(how.seconds)} to fill it" in text
    assert (f"- syringe, {how.syringe} ml" in text) == (job.gate is not None)


def test_strips_that_are_cast_in_are_told_how_far_they_give_way() -> None:
    """In the time that filling takes: the drift is the front's speed times a constant."""
    job = Job(skincad.load("cast-in"))
    flow = pour(job)
    assert flow is not None
    slow = flow.drift * job.design.mold.fill_time / filling(job).seconds
    assert f"moved aside by up to {slow:.2g} mm" in casting_sheet(job, [], "", True)
    assert slow < flow.drift
    assert "moved aside" not in casting_sheet(Job(skincad.load("yamada-2002")), [], "", True)


def test_a_mix_that_thickens_before_the_mold_is_full_is_warned_of(yamada: Design) -> None:
    """3 min of stirring, 3 of degassing and 1 of filling, of 5."""
    (finding,) = pouring_findings(Job(yamada.with_(silicones={"dragon-skin-30": {"pot_life_min": 5.0}})))
    assert (finding.rule, finding.measured, finding.limit) == ("pot life", 7.0, 5.0)


def test_the_least_mix_is_weighed_to_two_per_cent() -> None:
    known = silicones()
    assert small_batch(known["dragon-skin-10"]) == 2.0
    assert small_batch(known["sylgard-184"]) == 6.0  # 10 : 1, of which B is 0.55 g
    assert "weigh 5.45 g of A and 0.55 g of B, 6.00 g" in pouring.weights(known["sylgard-184"], 6.0)
