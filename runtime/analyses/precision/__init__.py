"""What accuracy costs in time: a scene by every method, at every tolerance."""

from runtime.analyses.precision.answer import (
    Accuracy,
    Check,
    Choice,
    Line,
    Point,
    Reference,
    Setting,
)
from runtime.analyses.precision.study import accuracy

__all__ = ["Accuracy", "Check", "Choice", "Line", "Point", "Reference", "Setting", "accuracy"]
