"""From plans to what a workshop needs: print meshes, findings, the casting sheet."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    assembly_drawing: AssemblyDrawing CutFace
    coupon: BAR_FORM CouponKit PAD_DESIGN PAD_FORM SILICONE coupon_forms coupon_sheet fit_bar_command
        fit_pad_command read_command read_coupon
    crests: listed_crests printed_crests snapped_to_layers uncertain_ridges
    drawn_features: ABOVE FRONT Groove HoleGroup LEFT SideView Slit notches number views
    electrodes: SHOULDER electrode_findings fan_out
    estimates: by_part
    fasteners: major mount_of
    filling: filling_findings
    films: CUTTERS FilmOffer FilmOffers Ply bending film_offers
    findings: design_findings mount_findings
    job: Job
    machine_rules: extent laid_on_end left_standing on_end overhang
    making: Build MakeResult PartReport STAGES make passes
    measures: interference measure
    meshes: FINER laid manifold mesh print_chord upright
    orders: Order
    papers: environment
    part_drawing: DrawingTable PartDrawing Titled
    parts_list: parts_csv
    patterns: GLUED_LENGTH HOLE StripPattern pattern_notes seal_pattern shim_patterns
        strip_patterns
    pouring: DEAD_VOLUME LayerPour layer_name poured_volume pours
    printing: PrintPlate print_plates
    rules: Finding counted walls_close warning
    sheet: casting_sheet opening_steps sheet_steps
    strips: pull_off strip_findings
    """,
)
