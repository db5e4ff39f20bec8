"""Explicit Runge-Kutta methods and their dense output."""
