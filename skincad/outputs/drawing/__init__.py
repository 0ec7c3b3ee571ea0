"""Drawings with dimensions: shop drawings of parts, patterns that are cut, and the drawing of a design."""
