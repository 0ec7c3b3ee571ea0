"""Work-precision studies: what accuracy costs in time, one file a ladder."""
