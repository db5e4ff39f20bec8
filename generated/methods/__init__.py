"""Explicit Runge-Kutta methods, written by ``python -m codegen methods``."""
