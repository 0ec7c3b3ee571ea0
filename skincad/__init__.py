"""Castable artificial robot skin, and what it will feel."""

from skincad.catalog import load

__version__ = "0.1.0"
__all__ = ["load"]
