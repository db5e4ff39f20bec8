"""Accuracy target: simulations with a prescribed global error in place of tolerances."""

from runtime.studies.accuracy_target.accuracy_or_tolerances import accuracy_or_tolerances
from runtime.studies.accuracy_target.reached_accuracy import Estimate, ReachedAccuracy, Trial

__all__ = ["Estimate", "ReachedAccuracy", "Trial", "accuracy_or_tolerances"]
