"""The language of a declaration: bodies, elements, symbols, parameters, scenes."""
