"""What every room may use and nothing of the field: errors, estimates, tables, files, streams, clocks."""

from skincad.base.faces import face

# What other rooms, tests and benches use.
__getattr__, __dir__ = face(
    __name__,
    """
    adaptivity: Refinement by_price overrun refine unmet
    arrays: Array Index Mask
    columns: Columns LARGEST_FILE MOST_ROWS SEPARATORS read_columns
    errors: ExhaustedError FaultError InputError LONGEST_LINE MOST_TOLD RefusedError UnclearError
        did_you_mean exhausted refusals require_goals require_number resource_guard shown together
    estimate: Estimate
    faces: imported
    interrupt: INTERRUPTED ignore listen safe_point
    machine: one_blas_thread
    outfolder: COMMANDS checked_folder checked_fresh files_below fresh manifest_name manifest_text
        replaced
    progress: Progress Stopwatch Tick about one_by_one stage_bar step_bar
    reading: Cell DEEPEST MOST_PARTS csv_text markdown_text strict_json tables_of text_of
    result: Figure LONGEST_REPR Record ReportedProperty Result Writer bare_key columns_of data_frame
        declared_items estimate_columns item key_of plain record reported unit_of_key
        with_picture
    saved: saves
    tables: Document NumberWithRange SparseTable Table no_entry quantity table_of told unit_of
    """,
)
