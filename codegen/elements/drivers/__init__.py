"""Drivers: constraints that prescribe a motion in time."""
