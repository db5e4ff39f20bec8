"""Readers of what a user gives: declarations, runs and files use the same ones.

A reader takes a value and returns a plain one, or raises `KindError`. `values` has numbers, flags,
texts, lists and names; `arguments` reads the arguments of public functions; `quantities` reads
numbers with units, and conditions in texts; `expressions` decides what of SymPy is a real number;
`calls` says what is wrong with a call, and with a user's own function.
"""
