"""Readers of a user's input, the same for declarations, runs and files.

A reader takes a value and returns a plain one, or raises `KindError`. `values` has numbers, flags,
texts, lists and names; `arguments` reads the arguments of public functions; `quantities` reads
numbers with units, and conditions in texts; `expressions` decides what of SymPy is a real number;
`calls` says what is wrong with a call, and with a user's own function.
"""
