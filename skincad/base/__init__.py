"""What every room may use and nothing of the field: errors, estimates, tables, files, streams, clocks."""
