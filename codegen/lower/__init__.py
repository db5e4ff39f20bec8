"""Equations → a `Program`: scalar operations in static single assignment, and its kernels."""
