"""Measurements of the compiler and the runtime; ``python -m benchmarks``."""
