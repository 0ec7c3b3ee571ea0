"""`python -m skincad`."""

from skincad.cli import main

main()
