"""Functions of a user's own that compute sampled values while a run goes on."""

from collections.abc import Callable, Mapping
from itertools import islice
from typing import Any

from codegen.errors import AnalysisError, InputError
from codegen.readers.calls import note_user_error
from codegen.readers.values import finite_float, shown
from runtime.core.arrays import Vector
from runtime.integrate.problem import Controller
from runtime.mechanism.mechanism import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown

# safety: values of a function, some 150 bytes each, that are kept for a repeated run
_MOST_ANSWERS = 2**18

Functions = Mapping[str, Callable[["Sample"], float]]


class Sample:
    """The state of the machine at the instant of a sample, for a controller to read.

    Attributes
    ----------
    t
        The instant, s.
    """

    def __init__(self, description: Description, t: float, q: Vector, v: Vector) -> None:
        self.t = t
        self._description, self._q, self._v = description, q, v

    def q(self, name: str) -> float:
        """A coordinate, m or rad: ``sample.q("arm.phi")``."""
        return float(self._q[self._description.coordinates.index(name)])

    def v(self, name: str) -> float:
        """The velocity of a coordinate, m/s or rad/s, by either name: ``"arm.phi"``, "arm.omega".

        Raises UnknownNameError if there is none of that name.
        """
        table = self._description.coordinates
        rates = [row.velocity for row in table]
        return float(self._v[rates.index(name) if name in rates else table.index(name)])

    def y(self, name: str) -> float:
        """A state or sampled value, in its unit."""
        return float(self._v[self._description.states[name].column])


def controllers_of(mechanism: Mechanism, functions: Functions | None) -> dict[int, Controller]:
    """Number of a sampled value → what computes it; InputError where one lacks or is too many."""
    description, given = mechanism.description, dict(functions or {})
    needed = description.controllers
    problems = [unknown("sampled value without an expression", n, needed) for n in given
                if n not in needed]  # fmt: skip
    problems += [
        f"sampled value '{name}' has no expression, and the run brings no function for it; give "
        f"simulate(controllers={{'{name}': lambda sample: ...}})."
        for name in needed
        if name not in given
    ]
    if problems:
        raise InputError(f"{description.title}: {problem}" for problem in problems)
    return {
        description.sampled.index(name): _Function(description, name, function)
        for name, function in given.items()
    }


class _Function:
    """A user's function for one sampled value; it remembers what it answered last.

    By instant and state: runs of different tolerances, as for an accuracy, share the instants.
    """

    def __init__(
        self, description: Description, name: str, function: Callable[[Sample], Any]
    ) -> None:
        self.description, self.name, self.function = description, name, function
        self.answers: dict[tuple[float, int], float] = {}

    def __call__(self, t: float, q: Vector, v: Vector) -> float:
        """The answer at the instant t, s, in the state (q, v), (n,) each."""
        with note_user_error(f"the function given as controllers={{'{self.name}': ...}}"):
            answer = self.function(Sample(self.description, t, q, v))
        value = finite_float(answer)
        if value is None:
            raise AnalysisError(
                f"{self.description.title}: the controller of '{self.name}' answers "
                f"{shown(answer)} at t = {t:.9g} s; it must answer a finite number."
            )
        if len(self.answers) >= _MOST_ANSWERS:
            self.answers = dict(islice(self.answers.items(), _MOST_ANSWERS // 2, None))
        self.answers[t, hash((q.tobytes(), v.tobytes()))] = value
        return value

    def again(self, t: float, q: Vector, v: Vector) -> float:
        """The answer of before, as a function may have a memory; else a new one."""
        before = self.answers.get((t, hash((q.tobytes(), v.tobytes()))))
        return self(t, q, v) if before is None else before


def remembered(controllers: Mapping[int, Controller]) -> dict[int, Controller]:
    """The controllers of a run that is taken again: they answer as they did."""
    return {k: getattr(function, "again", function) for k, function in controllers.items()}
