"""A designed skin for other people's simulators: rigid links, springs, taxels, meshes and a card."""

from __future__ import annotations
