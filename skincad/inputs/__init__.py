"""What a person writes: designs with the rules between their keys, processes, what ships, measured data."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    catalog: KINDS Kind LARGEST_FILE Own design_tables display_name kind_of kinds_of load load_design
        overridden own_tables read_table retyped setting_key template_names template_text with_own
    design: Design height_keys scaled_skin with_heights
    feature_tables: FAMILY_TABLES Flat Pin Pocket Ridge Ring places
    film_product: FilmProduct film_products
    gripper: Gripper gripper_named grippers
    guards: THINNEST face_heights shoulder
    material: foreign_modulus layers refuse_layers
    measurements: CREST_COLUMNS CREST_FORM CrestForm FEWEST_ROWS MaterialTest NOTCH_COLUMNS NOTCH_FORM
        NotchForm PRESSED PressCurve STRETCHED form material_test press_curve
        read_crests read_notches
    mold_table: Mount
    process: PROCESSES Process processes
    recordings: FilmRecording film_recording
    shipped: table_text templates_folder
    silicone: SOFTEST STIFFEST Silicone silicones
    skin_tables: Base Film Material Plate Shot Slot
    """,
)
