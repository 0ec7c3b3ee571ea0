"""Tests of skincad. Dear results are kept before any module imports the functions that give them."""

from tests.shared import keep_results

keep_results()
