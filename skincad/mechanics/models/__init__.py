"""The models of a check, one file each, and the table of them."""
