"""Figures of results, drawn by matplotlib, which `canvas` alone names."""

from __future__ import annotations
