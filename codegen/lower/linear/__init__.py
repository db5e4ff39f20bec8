"""The static factorization of a scene's linear system, and its back substitution."""
