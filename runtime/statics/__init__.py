"""Equilibrium and its stability."""
