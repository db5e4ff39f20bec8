"""Equations → a `Program`: scalar operations in static single assignment, one kernel a question."""
