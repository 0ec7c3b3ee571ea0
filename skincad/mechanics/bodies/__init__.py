"""Meshed bodies: finite elements on the section or the solid, condensed to the points that may touch."""
