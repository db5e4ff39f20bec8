"""Continuation of driven motions: predictor-corrector, folds and bifurcations."""
