"""The model of a file, and its scenes: chosen, varied, as data."""
