"""The silicone as tested: its modulus from a pressed pad or a pulled bar."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    acceptance: Acceptance FORCE_ERROR GOOD_SHARE accept judge
    fit: fit_material
    laws: FITTED_SHARE
    modulus: MaterialFit
    pad: PadCurve finite_strain_curve small_strain_curve
    press_model: PressModel good_curve
    """,
)
