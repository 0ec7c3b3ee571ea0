"""Results handed on: in words, as files, and into an out folder.

A module shows the results of a command. Below them are `simulators` (packages), `drawing` (with dimensions),
`figures` (matplotlib's) and `web` (what pages are made of).
"""
