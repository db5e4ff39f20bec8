"""Simulations that are asked for a global error in place of tolerances."""

from runtime.analyses.accurate.answer import Accuracy, Estimate, Trial
from runtime.analyses.accurate.asking import accuracy_or_tolerances

__all__ = ["Accuracy", "Estimate", "Trial", "accuracy_or_tolerances"]
