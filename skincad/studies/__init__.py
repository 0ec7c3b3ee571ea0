"""From a wish to a design: the value that gives it, and many designs side by side.

A study asks one question (a check, a make, a simulation or a gain) of one subject (a design, a scene or a
circuit) at many values of its keys.
"""
