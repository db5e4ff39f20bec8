"""Work-precision: the time that accuracy costs a scene, by every method, at every tolerance."""

from runtime.studies.work_precision.diagram import Setting, WorkPrecision
from runtime.studies.work_precision.study import accuracy

__all__ = ["Setting", "WorkPrecision", "accuracy"]
