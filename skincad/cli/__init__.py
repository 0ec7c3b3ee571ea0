"""The command line: a module a command, with options and words only. `main` is what `skincad` runs."""

from skincad.cli.process import main as main
from skincad.cli.process import run as run
