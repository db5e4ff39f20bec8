"""Accuracy target: simulations with a prescribed global error in place of tolerances."""
