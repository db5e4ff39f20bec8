"""Tables that a state has left, or is leaving, by name and with the numbers."""

import numpy as np

from runtime.core.outcomes import Outcome
from runtime.explicit_time.function_scan import FunctionArrays
from runtime.mechanism.dense_equations import Equations, FloatArray
from runtime.mechanism.table_rows import TableRange
from runtime.results.result import Result

_MARGIN = 1e-9  # accuracy: of a table's length; nearer to its end it has still its value there
_NEAR = 1e-6  # safety: of a table's length; so near to its end a run that fails was leaving it
_AHEAD = 1e-7  # accuracy: of a second, or of the time; over which an argument is differenced


def name_left_tables(result: Result, equations: Equations, every: bool = False) -> None:
    """Let a result that ends where the motion leaves a table say so, by name and numbers.

    Of a run that failed the last state is looked at, or, if asked, `every` state of any.
    """
    rows, samples = equations.description.table_ranges, result.samples
    if not rows:
        return
    tables = [_Argument(row, equations.p, samples.q.shape[1]) for row in rows]
    states = list(zip(samples.t.tolist(), samples.q, samples.v, strict=True))
    for state in states if every else ():
        if found := [one.sentence(*state) for one in tables if one.is_left(*state)]:
            break
    else:
        state = states[-1]
        if result.outcome is Outcome.OK:
            return
        found = [one.sentence(*state) for one in tables if one.is_leaving(*state)]
    if found:
        result.outcome = Outcome.OUT_OF_RANGE
        sentences = " ".join(dict.fromkeys(found))
        result.message = f"Stopped at t = {state[0]:.9g} s. {sentences} {result.outcome.advice}"


def left_tables(equations: Equations, t: float, q: FloatArray, v: FloatArray) -> str:
    """Sentences on the tables beyond whose ends a state is; empty where it is inside of all."""
    tables = [_Argument(row, equations.p, len(q)) for row in equations.description.table_ranges]
    return " ".join(dict.fromkeys(one.sentence(t, q, v) for one in tables if one.is_left(t, q, v)))


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
        value, ahead = self(t, q, v), _AHEAD * max(1.0, abs(t))
        change = self(t + ahead, q + ahead * v, v) - value
        to_low, to_high = (abs(value - end) for end in (self.row.low, self.row.high))
        way = to_high if change > 0.0 else to_low if change < 0.0 else min(to_low, to_high)
        return bool(way <= _NEAR * self.length)
