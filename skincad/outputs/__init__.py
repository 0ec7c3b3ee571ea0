"""Results handed on: in words, as files, and into an out folder.

A module shows the results of a command. Below them are `simulators` (packages), `drawing` (with dimensions),
`figures` (matplotlib's) and `web` (what pages are made of).
"""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    boards: channels_csv kicad_schematic parts_csv
    checks: CHECK advice_lines allowance awaits_advice verdict
    delivery: Delivery of_formats ready save_picture write
    detector_code: CLOCK fitting_every instructions
    drawing.flat: write_shims_dxf
    drawing.overview: PAGE
    figures.canvas: Axes STYLES save sheet
    figures.results: gain_figure
    figures.stress: COLOURS FRAME_WIDTH Moment moments_limit section_animation section_picture
    figures.studies: LADDER_SIZE accuracy_figure pareto
    gallery: forces
    makes: names
    measurements: ACCEPTANCE
    pages: page
    simulations: SIMULATION write_table
    simulators.links: links
    simulators.meshes: tetrahedra
    simulators.package: Package markdown package
    solid_files: write_assembly write_step write_stl
    studies: ACCURACY ACCURACY_FILES front_names sweep_csv sweep_names sweep_page write_solution write_wish
    tomls: HOME LISTS check_new document_name first_of listing schema_of start_names table_entries
        write_copy write_new write_with_modulus
    view: explosion_offset
    """,
)
