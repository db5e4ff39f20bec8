"""Causes of a state that is not finite: equations, forces, tables that the motion has left."""

from collections.abc import Iterator
from itertools import compress

import numpy as np

from codegen.errors import AssemblyError
from runtime.core.kinds import SLIDING
from runtime.core.outcomes import Outcome
from runtime.explicit_time.function_scan import FunctionArrays
from runtime.mechanism.dense_equations import Equations, FloatArray, IntArray
from runtime.mechanism.table_rows import TableRange
from runtime.results.result import Result

_AHEAD = tuple(10.0**k for k in range(-12, 0))  # safety: s ahead of a run's end
_OF_FORCES = "effect", "nonconservative"  # kinds of powers
_PLACES = (
    "a power, a root or a logarithm at or below zero, a division by zero, a table's end, an "
    "exponential that overflows (1/(1 + exp(x)) is (1 - tanh(x/2))/2)"
)


def require_finite(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> None:
    """Refuse a start at which constraints, their rates or their accelerations are not finite."""
    problems = list(_constraints(equations, t, q, v))
    if problems:
        raise AssemblyError([f"{equations.description.title}: {problem}" for problem in problems])


def describe_infinite(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, modes: IntArray
) -> str:
    """Sentences on what is not finite at a state, or else soon after it; empty where all is."""
    places = (
        infinite_terms(equations, t + ahead, q + ahead * v, v, modes) for ahead in (0.0, *_AHEAD)
    )
    return next(filter(None, places), "")


def infinite_terms(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, modes: IntArray
) -> str:
    """Sentences on the constraints and forces that are not finite at a state; empty for none."""
    modes = np.where(modes == SLIDING, 0, modes)
    found = [*_constraints(equations, t, q, v), *_forces(equations, t, q, v, modes)]
    return " ".join(sentence[0].upper() + sentence[1:] for sentence in found)


def _constraints(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> Iterator[str]:
    """A sentence for each joint or driver with a row that is not finite."""
    table, rows = equations.description.constraints, equations.description.jacobian_rows
    moving = equations.description.analysis != "equilibrium"
    parts = (
        ("equation Φ", equations.constraints(t, q)),
        ("derivative Φ_q", np.bincount(rows, equations.slopes(t, q), equations.m)),
        ("velocity ν", equations.velocity_rhs(t, q)),
        ("acceleration γ", equations.acceleration_rhs(t, q, v) if moving else np.zeros(0)),
    )
    named: set[str] = set()
    for word, values in parts:
        for row in np.flatnonzero(~np.isfinite(values)):
            element = table[row].element
            if element not in named:
                named.add(element)
                yield (
                    f"the {word} of {table[row].kind} '{element}' is {values[row]} at "
                    f"t = {t:.9g} s; look for {_PLACES}, and write a law that has finite first "
                    "and second derivatives there, or start elsewhere."
                )


def _forces(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, modes: IntArray
) -> Iterator[str]:
    """A sentence for each effect whose force is not finite, as far as the tables tell."""
    description = equations.description
    if not description.has_masses:
        return
    lost = ~np.isfinite(equations.forces(t, q, v, modes))
    what = f"force of {{}} along {', '.join(compress(description.coordinates.names, lost))}"
    if not lost.any():
        if "potential" not in description.kernels or np.isfinite(equations.potential(t, q, modes)):
            return
        what = "potential of {}"
    powers, idle = np.zeros(len(description.powers)), np.zeros(equations.m)
    equations.kernels.powers(t, q, v, equations.p, modes, idle, powers)
    rows = zip(description.powers, powers, strict=True)
    working = {row.name for row in description.powers if row.kind == "effect"}
    blamed = [row.name for row, power in rows if row.kind in _OF_FORCES and not np.isfinite(power)]
    if not blamed:
        others = (row for row in description.effects if row.kind != "gravity")
        blamed = [row.name for row in others if row.name not in working]
    if blamed:
        names = " or ".join(f"'{name}'" for name in dict.fromkeys(blamed))
        yield (
            f"the {what.format(names)} is not finite at t = {t:.9g} s; look for {_PLACES}, or for "
            "a spring whose ends coincide."
        )


_MARGIN = 1e-9  # accuracy: of a table's length; nearer to its end it still has its last value
_NEAR = 1e-6  # safety: of a table's length; so near to its end a failing run was leaving it
_SOON = 1e-7  # accuracy: of a second, or of the time; over which an argument is differenced


def name_left_tables(result: Result, equations: Equations) -> None:
    """Let a run that failed where the motion leaves a table say so, by name and numbers."""
    if not equations.description.table_ranges or result.outcome is Outcome.OK:
        return
    t, q, v = (array[-1] for array in result.samples[:3])
    if left := left_tables(equations, t, q, v, result.analysis == "kinematics", soon=True):
        result.outcome = Outcome.OUT_OF_RANGE
        result.message = f"Stopped at t = {t:.9g} s. {left} {result.outcome.advice}"


def left_tables(
    equations: Equations, t: float, q: FloatArray, v: FloatArray, of_motion: bool = False,
    *, soon: bool = False,
) -> str:  # fmt: skip
    """Sentences on the tables beyond whose ends a state is; empty where it is inside of all.

    If asked, those `of_motion` alone, which stand in joints and drivers; those left `soon`, too.
    """
    description, state = equations.description, (t, q, v)
    moving = {row.element for row in description.constraints}
    rows = [row for row in description.table_ranges if row.name in moving or not of_motion]
    tables = [_Argument(row, equations.p, len(q)) for row in rows]
    left = [one for one in tables if (one.is_leaving(*state) if soon else one.is_left(*state))]
    return " ".join(dict.fromkeys(one.sentence(*state) for one in left))


class _Argument:
    """What a table is taken at."""

    def __init__(self, row: TableRange, p: FloatArray, n: int) -> None:
        self.row, self.p, self.length = row, p, row.high - row.low
        self._arrays = FunctionArrays(row.rows, begin={"q": len(p), "v": len(p) + n})

    def __call__(self, t: float, q: FloatArray, v: FloatArray) -> float:
        return self._arrays.value(t, np.concatenate([self.p, q, v, [0.0]]))

    def sentence(self, t: float, q: FloatArray, v: FloatArray) -> str:
        """The name, the number and the range."""
        row, value = self.row, self(t, q, v)
        for end in (row.low, row.high):
            if abs(value - end) <= _MARGIN * self.length:
                value = end
        return (
            f"Table '{row.table}' of '{row.name}' is left at {row.at} = {value:.9g}: its points go "
            f"from {row.low:g} to {row.high:g}."
        )

    def is_left(self, t: float, q: FloatArray, v: FloatArray) -> bool:
        """Whether the state is beyond an end."""
        value, margin = self(t, q, v), _MARGIN * self.length
        return bool(value < self.row.low - margin or value > self.row.high + margin)

    def is_leaving(self, t: float, q: FloatArray, v: FloatArray) -> bool:
        """Whether the state is beyond an end, or about to be."""
        if self.is_left(t, q, v):
            return True
        value, ahead = self(t, q, v), _SOON * max(1.0, abs(t))
        change = self(t + ahead, q + ahead * v, v) - value
        to_low, to_high = (abs(value - end) for end in (self.row.low, self.row.high))
        way = to_high if change > 0.0 else to_low if change < 0.0 else min(to_low, to_high)
        return bool(way <= _NEAR * self.length)
