"""Singular configurations: detection along a motion, location and characterisation."""
