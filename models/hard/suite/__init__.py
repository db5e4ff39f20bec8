"""The hard cases: definition of a case, one cell, all cells, and their page.

`closed` holds the references that follow from a formula; the other references are in `tests/data`.
No reference comes from one of our integrators.
"""
