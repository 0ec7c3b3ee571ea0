"""Scenes of this folder share their pads."""

from tests.shared_pads import shared_pads  # noqa: F401  # a fixture that all of its tests use
