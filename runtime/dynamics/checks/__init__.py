"""Checks of a run that has ended: what contradicts its outcome, and what explains it."""
