"""Whether the ridges touch, and how hard: finite elements on the section and unilateral contact."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    bodies.condense: FrontFactors condense factored
    bodies.film_field: StripStress strip_stress
    bodies.mesh: PadPiece Sizes SolidMesh at_faces default_sizes half_of height_of meshed_piece
        piece_of plain_mesh plane_piece solid_mesh triangles unit_of
    bodies.plane_body: excess
    bodies.prisms: fronts_of graded section_forms
    bodies.solid_body: SolidBody
    bodies.solid_law: Excess
    check: exceeds_model mesh_tolerance require_force spread_of
    contact.frictional: halved in_halves joined solve_contact
    contact.frictional_pad: FrictionalPad FrictionalState Tangential frictional_pad_of
    contact.frictionless: NodalContact Ridges press
    contact.ridge_model: ridge_forces ridge_model
    contact.state: Compliance ContactState Drive FrictionCoefficients GrossSlip OPEN RIGHT STICK Swing at_rest
    contact.tips: SWAY TipState Tips advance
    dynamics.modes: Modes at_points mode_step resolved slow_modes
    dynamics.pad: linear
    dynamics.ringing: FREE_TOP RETARDATION layer_period shear_frequency skin_mass
    dynamics.steps: DynamicState Matter PadEquations
    film.fields: DeformedSection RidgeField WholeState collision on_sides
    film.response: FilmResponse SPANS film_response
    film.sliding: ContactPad of_ends sliding
    film.stress: FilmStress FilmStresses check_request filled_pad film_stress film_stresses
    fits: DESIGNS FITS NUMBERS unlike
    left_out: FRICTION LeftOut finite_strain free_ends friction
    magnetics: cylinder_field force_noise magnet_signal magnetic_pins
    manufacture: KEYS Sensitivity all_touch intervals sensitivities
    models.correction: Correction Errors LevelAnswer
    models.corrected: added_compliance plain_pad
    models.friction: FULL SOLID_ORDER SOLID_STEPS solve_solid
    models.linear: LevelSolver level
    models.pin_cell: hertz lone
    models.reduced: pin_model pin_tops pressed
    models.solid: Layers coarse_sizes condensed_pad forms_of solve_level
    models.solid_finite_strain: COARSE_ERRORS COARSE_LAYERS COARSE_PARTS body_of
    models.table: AUTO MODELS expected_seconds load model_named prerequisites run unsupported_reason
        whole_price
    models.winkler: compliances crest_gaps ridge_stiffness stiffnesses
    plate_friction: PlateFriction
    problem: Answer ContactError LateError NEGLIGIBLE PVDF_DENSITY Pad PadLayer Request RidgeModel
        SizeError check_pad pad_of solid_pad_of
    validity: LARGEST_STRAIN Limits crown_radius limits material_warnings plane_modulus
        refuse_crushed ridge_strain small_strain_violation tipping
    verdict: Change ContactCheck Holding LiftSignal NO_MODEL NextModel is_decided wiring_order
    """,
)
