"""Integration of the equations of motion: compiled once, for every model."""
