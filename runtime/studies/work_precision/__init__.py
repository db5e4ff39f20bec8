"""Work-precision: the time that accuracy costs a scene, by every method, at every tolerance."""

from runtime.studies.harness import Setting
from runtime.studies.work_precision.diagram import WorkPrecision
from runtime.studies.work_precision.study import accuracy

__all__ = ["Setting", "WorkPrecision", "accuracy"]
