"""Whether the ridges touch, and how hard: finite elements on the section and unilateral contact."""
