"""Functions of a user's own that compute sampled values while a run goes on."""

from collections.abc import Callable, Mapping
from typing import Any

from codegen.errors import AnalysisError, InputError
from codegen.plain_values import finite_float, shown
from codegen.public_callables import note_user_error
from runtime.core.array_types import Vector
from runtime.integrate.problem import Controller
from runtime.mechanism.mechanism_tables_and_kernels import Mechanism
from runtime.mechanism.module_tables import Description
from runtime.mechanism.table_rows import unknown

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
        description.sampled.index(name): _controller(description, name, function)
        for name, function in given.items()
    }


def _controller(
    description: Description, name: str, function: Callable[[Sample], Any]
) -> Controller:
    def compute(t: float, q: Vector, v: Vector) -> float:
        with note_user_error(f"the function given as controllers={{'{name}': ...}}"):
            answer = function(Sample(description, t, q, v))
        value = finite_float(answer)
        if value is None:
            raise AnalysisError(
                f"{description.title}: the controller of '{name}' answers {shown(answer)} at "
                f"t = {t:.9g} s; it must answer a finite number."
            )
        return value

    return compute
