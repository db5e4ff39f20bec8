"""Implicit methods on the independent coordinates: BDF and Radau IIA."""
