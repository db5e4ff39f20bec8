"""How the hard cases are asked: what a case is, one cell, all cells, and the page of them.

`closed` holds the references that follow from a formula; the other references are in `tests/data`.
No reference comes from one of our integrators.
"""
