"""Functions given by points: cubic pieces, their fits, and SymPy functions of them."""
