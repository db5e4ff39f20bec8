"""Kinds of peaked functions of the position, by their argument u."""

from enum import IntEnum, unique


@unique
class PeakKind(IntEnum):
    """A function by its argument; the names are those of a module's PEAKS."""

    EXPONENTIAL = 0  # e^u
    STEP = 1  # tanh u and the like, with all its change about u = 0
    POWER = 2  # |u|^exponent


# Compiled code reads integers of a module.
EXPONENTIAL, STEP, POWER = map(int, PeakKind)
