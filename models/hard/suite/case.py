"""A case: a machine, a question with a known answer, and the error that a run may have."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from codegen import Model
    from runtime import Machine, Result

Array = npt.NDArray[np.float64]

ROOT = Path(__file__).resolve().parent.parent.parent.parent
TOLERANCES = (1e-6, 1e-9, 1e-12)

SHARE = 0.3
"""Average error of an accepted step, in parts of the tolerance.

The controller aims below the tolerance and its estimates are pessimistic.
"""

KEPT = 100.0
"""Largest error, in tolerances, with which a tolerance counts as kept."""

WORTH = 1.0
"""A number whose bound is larger than this, in m, rad or s, lies beyond the horizon."""


@dataclass(frozen=True)
class Reference:
    """The right answer.

    Attributes
    ----------
    values : (k,) or (k, j)
        The numbers, a row an instant.
    times : (k,)
        The instants that the rows belong to, s; ascending.
    growth
        Error at a row that an error of one unit of tolerance in an earlier step has grown to;
        one number, or an array that broadcasts against `values`.
    steps
        Steps of a method of order 8 at rtol 1e-9, whose errors add up.
    trusted
        Error of the reference itself, and of numbers that double precision cannot hold better;
        one number, or an array like `growth`.
    """

    values: Array
    times: Array
    growth: float | Array
    steps: float
    trusted: float | Array

    def bound(self, rtol: float, order: int = 8) -> Array:
        """Largest error of a right run by a method of this order, in the shape of `values`.

        An error made in one step grows as every perturbation of the motion does; at worst all of
        them add up. Rounding counts as a tolerance of 2.2e-16. A method of order p takes a number
        of steps that goes with rtol^(-1/p). From order 5 on the bound is that of order 8; below,
        it is larger by the ratio of the steps to those of order 5.
        """
        worst = max(SHARE * self.steps, KEPT) * np.asarray(self.growth, dtype=np.float64)
        tolerance = rtol + np.finfo(np.float64).eps
        more_steps = tolerance ** (1 / 5 - 1 / min(order, 5))
        allowed = worst * tolerance * more_steps + np.asarray(self.trusted)
        return np.broadcast_to(allowed, self.values.shape).copy()


@dataclass(frozen=True)
class Case:
    """A question about a machine, with its answer.

    Attributes
    ----------
    name
        On the command line.
    hard, see
        The difficulty, and what to look for in its rows: a sentence or two.
    model, scene
        The declaration's name, `hard/andrews`, and its scene; with `declare` the family's.
    t_end
        End of the run, s.
    quantity
        What is compared, with its unit.
    measure
        A run → the numbers, in the shape of the reference's values.
    reference
        The right answer; computed once.
    origin
        Source of the reference, its correct digits, and the reason for its growth.
    sampled
        Whether the reference's times are the instants of output; otherwise there are 201.
    tolerances
        The values of rtol.
    ends
        Names of outcomes in which a run may end; the first is the one that is wished for. REFUSED
        is no `Outcome`: an error before the first step, as the question does not fit the machine.
    work
        A run → the work of all that has no potential, from the start to each instant, J; None
        where it is not known in closed form.
    declare
        Declares the machine, where it is one of a family that has no file of its own.
    long
        Whether its code is so long that it is not compiled for the tests, nor for methods that
        need its derivatives too.
    parameters, start, options
        Handed on to `Machine.simulate`.
    """

    name: str
    hard: str
    see: str
    model: str
    scene: str
    t_end: float
    quantity: str
    measure: "Callable[[Result], Array]"
    reference: Callable[[], Reference]
    origin: str
    sampled: bool = True
    tolerances: tuple[float, ...] = TOLERANCES
    ends: tuple[str, ...] = ("OK",)
    work: "Callable[[Result], Array | float] | None" = None
    declare: "Callable[[], Model] | None" = None
    long: bool = False
    parameters: Mapping[str, float] = field(default_factory=dict)
    start: Mapping[str, float] = field(default_factory=dict)
    options: Mapping[str, Any] = field(default_factory=dict)

    def machine(self) -> "Machine":
        """The machine, built if need be."""
        return machine(self.model, self.scene, self.declare)

    def instants(self) -> Array:
        """Instants of output, s."""
        return self.reference().times if self.sampled else np.linspace(0.0, self.t_end, 201)


@cache
def machine(model: str, scene: str, declare: "Callable[[], Model] | None" = None) -> "Machine":
    """A machine of the library or of this package; what is declared here is built in `results`."""
    from runtime import load

    if declare is None:
        return load(model, scene, folder=ROOT)
    return load(declare(), scene, folder=ROOT / "results" / "machines")


def coordinates(*names: str) -> "Callable[[Result], Array]":
    """Measure the coordinates named, a column each."""

    def measured(run: "Result") -> Array:
        return np.column_stack([run.q(name) for name in names])

    return measured


def conservative(run: "Result") -> float:
    """Nothing but potentials acts."""
    return 0.0


def table(name: str) -> Array:
    """A file of `tests/data` with a head line, as floats, shape (rows, columns)."""
    path = ROOT / "tests" / "data" / name
    return np.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
