"""The exact section: curves, ridges and slots in the plane (x, z), mm."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    crests: FACE crest_column crest_drops crest_places shift_warnings
    curves: Loop Point Segment area concentric_hit flipped length loop polygon rectangle right_half
    families: FAMILIES
    feature: Feature Placed SensorPlace
    shots: face heights
    skin: GUARD_TOLERANCE Narrowest Section Skin VISIBLE cell_section drawn_section pictured_section
        section skin_of summit upright
    """,
)
