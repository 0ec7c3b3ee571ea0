"""Results handed on: in words, as files, and into an out folder."""
