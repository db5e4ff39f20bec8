"""Everything that can be wrong with a declaration, found before it is compiled."""
