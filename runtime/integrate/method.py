"""An integration method as the loop sees it, and the register of all methods.

A new method is a module that sets `METHOD`, and one line here; the module of an explicit
Runge-Kutta method is generated from its tableau. See docs/development/rooms/integration.md.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, NamedTuple

from codegen.files.generated_modules import import_generated
from codegen.files.library_folders import methods_folder

if TYPE_CHECKING:
    from runtime.core.arrays import Integers

    Step = Callable[[Integers, float, float], int]  # context t h
    Error = Callable[[Integers, float, float], float]
    Propose = Callable[[Integers, float], float]


class Registration(NamedTuple):
    """What is known of a method without its code."""

    module: str  # that sets `METHOD`
    # methods of one family and one order err alike: they do not confirm each other's results
    family: str
    order: int  # power of the step's length with which the errors of a run fall
    implicit: bool = False  # whether it needs derivatives of the kernels, at times or throughout
    begins_with: str = ""  # method that it loads with itself, and with which runs begin


GENERATED = "generated.methods"
"""Package of the methods that are written from their tableaus, as a checkout has it."""

RUNGE_KUTTA, COLLOCATION = "explicit Runge-Kutta", "collocation"
MULTISTEP, SWITCHING = "multistep", "switching"

LEADING = "dop853"
"""The explicit method with which runs cross singular configurations, and "auto" begins."""

REGISTER = {
    "dop853": Registration(f"{GENERATED}.dop853", RUNGE_KUTTA, 8),
    "dopri5": Registration(f"{GENERATED}.dopri5", RUNGE_KUTTA, 5),
    "tsit5": Registration(f"{GENERATED}.tsit5", RUNGE_KUTTA, 5),
    "radau5": Registration("runtime.integrate.implicit.radau5", COLLOCATION, 5, implicit=True),
    "bdf": Registration("runtime.integrate.implicit.bdf", MULTISTEP, 5, implicit=True),
    "auto": Registration(
        "runtime.integrate.implicit.stiffness_switching", SWITCHING, 5, True, LEADING
    ),
}
METHODS = tuple(REGISTER)
"""Names of the methods."""

EXPLICIT = tuple(name for name, method in REGISTER.items() if not method.implicit)
IMPLICIT = tuple(name for name, method in REGISTER.items() if method.implicit)
"""Those that need derivatives of the kernels, at times or throughout."""


def alternatives(names: tuple[str, ...]) -> str:
    """Names to choose from, as a sentence lists them: ``a, b or c``."""
    return f"{', '.join(names[:-1])} or {names[-1]}"


def _no_memory(n: int) -> tuple[int, int]:
    return 0, 0


@dataclass(frozen=True)
class Method:
    """An integration method.

    Its functions are compiled for the types in `runtime.core.function_table_slots`; the loop calls
    them by their addresses. All but `memory` work on the rows of the workspace (see
    `runtime.core.workspace_rows`): the state y = (q, v) at Y0 and Y1, derivatives from K on, dense
    output from F on.
    """

    # Power of the step's length in its estimated error: lengths are chosen by the power
    # 1 / estimate_order of it. `Registration.order` is that in the errors of a run.
    estimate_order: int
    last: int  # row, after K, of the derivative at the end of the step
    dense_rows: int  # of the dense output's coefficients
    safety: float  # share of the length that the error permits
    shrink: float  # least ratio of two steps' lengths
    grow: float  # largest
    # Take the step from Y0 with derivative K to Y1, not yet returned onto the constraints. Answers
    # the Newton iterations that took, negative where one failed.
    stages: "Step"
    error: "Error"  # estimated, of the step over its tolerance, root mean square over q and v
    dense: "Step"  # fills the coefficient rows of the dense output; answers as `stages`
    propose: "Propose"  # ratio of the next step's length to that of the step just accepted
    # Called after each accepted step, after `propose`: Y0 and Y1 still hold both ends, t is the
    # start. Answers 1 where another method is due.
    accepted: "Step"
    restart: "Step"  # called where the motion goes on by other equations, or after another method
    # Evaluations of the right-hand side in `stages` and in `dense`, for the statistics. The first
    # is 0 in implicit methods, which count their own, and only in them.
    stage_calls: int = 0
    dense_calls: int = 0
    beta: float = 0.0  # proportional part of the step control
    # floats and integers that the method keeps for n coordinates, from step to step
    memory: Callable[[int], tuple[int, int]] = _no_memory
    # Where in a step the right-hand side is evaluated, as fractions of it: a step across a singular
    # configuration is laid so that the configuration is between two of them.
    nodes: tuple[float, ...] = (0.0, 1.0)
    # Change of the coordinates, in their sizes, over which a singular configuration is looked for
    # ahead of the motion.
    foresight: float = 0.1  # accuracy: a nearer one matters to the finest tolerances


@cache
def find_method(name: str) -> Method:
    """A method, compiled when it is first asked for."""
    module = REGISTER[name].module
    folder, _, stem = module.rpartition(".")
    if folder == GENERATED:  # by its path: a user's own folder may be a package of that name
        found: Method = import_generated(methods_folder() / f"{stem}.py").METHOD
    else:
        found = import_module(module).METHOD
    return found
