"""Simulations that are asked for a global error in place of tolerances."""

from runtime.analyses.accurate.answer import Estimate, ReachedAccuracy, Trial
from runtime.analyses.accurate.asking import accuracy_or_tolerances

__all__ = ["Estimate", "ReachedAccuracy", "Trial", "accuracy_or_tolerances"]
