# ruff: noqa: PLC0414
"""Old names of what feature.py and skin.py hold, until all rooms have moved."""

from skincad.inputs.design import Design
from skincad.shape.feature import Frame as Frame
from skincad.shape.feature import SensorPlace
from skincad.shape.skin import GUARD_TOLERANCE as GUARD_TOLERANCE
from skincad.shape.skin import MOLDABLE_WALL as MOLDABLE_WALL
from skincad.shape.skin import Section as Section
from skincad.shape.skin import section as section
from skincad.shape.skin import skin_of

SlotPlace = SensorPlace
CONTACT_KINDS = ("tip_fillet", "crown")


def frame(design: Design, ridge: int) -> Frame:
    """Return the frame of a ridge."""
    return skin_of(design).placed[ridge - 1].frame
