"""What accuracy costs in time: a scene by every method, at every tolerance."""

from runtime.analyses.precision.answer import (
    Check,
    Choice,
    Line,
    Point,
    Reference,
    Setting,
    WorkPrecision,
)
from runtime.analyses.precision.study import accuracy

__all__ = ["Check", "Choice", "Line", "Point", "Reference", "Setting", "WorkPrecision", "accuracy"]
