"""Names and numbers of kinds: analyses, modes of switching functions, events, peaked functions."""

from enum import IntEnum, unique

ANALYSES = ("simulate", "kinematics", "inverse_dynamics", "equilibrium")


def analysis_name(text: str) -> str:
    """The name in its usual spelling: ``inverse-dynamics`` and ``inverse`` are one analysis."""
    name = text.strip().replace("-", "_").replace(" ", "_")
    return "inverse_dynamics" if name == "inverse" else name


def analysis_title(name: str) -> str:
    """The name in a sentence: inverse dynamics."""
    return name.replace("_", " ")


@unique
class Mode(IntEnum):
    """The mode of a switching function g, frozen within a step; an input of the kernels."""

    OFF = 0  # g ≤ 0
    ON = 1  # g > 0, an open rigid contact, a freewheel that overruns
    # Motion stays on g = 0: sliding mode, sticking friction, a closed contact or a freewheel that
    # grips. To kernels it says of mixed conditions that each holds as it is written.
    SLIDING = 2
    FREE = 3  # of friction with an unknown stiction force: it exerts none, and does not stick


@unique
class Boundary(IntEnum):
    """What holds of a condition where the motion stays on g = 0 and no mode moves it from there."""

    OPEN = 0  # it does not hold, as g > 0
    CLOSED = 1  # it holds, as g ≥ 0
    BALANCED = 2  # the mean of both sides, as in sign and Heaviside
    MIXED = 3  # several on one velocity do not agree, and each holds as it is written


@unique
class Hold(IntEnum):
    """What may hold a switching function of velocities at g = 0, in mode 2."""

    NONE = 0  # both modes, by their share
    FRICTION = 1  # friction that sticks
    ONE_WAY = 2  # a freewheel: never g < 0, and a force as large as needed, never negative


@unique
class TablePart(IntEnum):
    """What a switching function says of a table; the names are those of a module's SWITCHES."""

    NONE = 0
    KNOTS = 1  # its sign changes where a derivative of the table jumps
    RANGE = 2  # it is positive between the ends of the table


@unique
class Direction(IntEnum):
    """The kind of an event of a switching function; the last two are singular configurations."""

    CEASED = -1
    HOLDS = 0
    BEGAN = 1
    IMPACT = 2
    CROSSED = 3
    LOCKED = 4


# Compiled code reads integers of a module.
SLIDING, FREE = int(Mode.SLIDING), int(Mode.FREE)
OPEN, CLOSED = int(Boundary.OPEN), int(Boundary.CLOSED)
BALANCED, MIXED = int(Boundary.BALANCED), int(Boundary.MIXED)
FRICTION, ONE_WAY = int(Hold.FRICTION), int(Hold.ONE_WAY)
KNOTS, RANGE = int(TablePart.KNOTS), int(TablePart.RANGE)


@unique
class PeakKind(IntEnum):
    """A function by its argument; the names are those of a module's PEAKS."""

    EXPONENTIAL = 0  # e^u
    STEP = 1  # tanh u and the like, with all its change about u = 0
    POWER = 2  # |u|^exponent
    KINK = 3  # the same, of a place that a motion does not go through


# Compiled code reads integers of a module.
EXPONENTIAL, STEP, POWER, KINK = map(int, PeakKind)
