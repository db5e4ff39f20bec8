"""Readers of what a user gives: declarations, runs and files use the same ones.

A reader takes a value and returns a plain one, or raises `KindError`. `values` has numbers, flags,
texts and lists; `arguments` reads the arguments of public functions; `quantities` reads numbers
with units, and conditions in texts; `expressions` decides what of SymPy can be a real number;
`calls` and `failures` say what is wrong with a call, and with a user's own function.
"""
