"""Solids of skin, mold and inserts: plans as data, built by the CAD kernel in `occ.py`."""
