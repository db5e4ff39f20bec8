"""Accuracy target: simulations with a prescribed global error in place of tolerances."""

from runtime.results.reached_accuracy import Estimate, ReachedAccuracy, Trial
from runtime.studies.accuracy_target.accuracy_or_tolerances import accuracy_or_tolerances

__all__ = ["Estimate", "ReachedAccuracy", "Trial", "accuracy_or_tolerances"]
