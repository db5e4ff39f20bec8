"""An explicit Runge-Kutta method: its Butcher tableau, error estimate and dense output.

Stages are numbered from 1. With s stages, k_{s+1} is the derivative at the end of the step, which
is the first stage of the next; further stages serve the dense output alone. Of a pair published as
FSAL (first same as last) the last row is b, and its stage is k_{s+1}: leave that row out
(Bogacki-Shampine has s = 3, Dormand-Prince s = 6).
"""

from dataclasses import dataclass
from fractions import Fraction
from itertools import zip_longest
from typing import NamedTuple

Weights = tuple[Fraction, ...]  # factors of k_1, k_2, ...; zeros behind the last may be missing


class Stage(NamedTuple):
    """One row of a Butcher tableau: k_i = f(t + c h, y + h Σ a_j k_j)."""

    c: Fraction
    a: Weights


@dataclass(frozen=True)
class Tableau:
    """A method, as the generator of its code takes it."""

    about: str  # docstring of the generated module: authors, sources, properties
    order: int  # p
    # Order of the lower solution that the error estimate compares with: the length of a step is
    # chosen by the power 1 / (error_order + 1) of the error.
    error_order: int
    stages: tuple[Stage, ...]  # stages 2 to s
    b: Weights  # weights of the solution at the end of the step
    error: Weights  # of the error estimate; that of k_{s+1} is 0 or missing where it has none
    dense_order: int
    # Weights of the rows F4, F5, ... of the dense output F0 + x (F1 + (1 - x) (F2 + x (F3 + ...)));
    # the first four rows are those of the cubic Hermite polynomial, which `()` is alone.
    dense: tuple[Weights, ...]
    beta: float = 0.04  # step control: its proportional part
    safety: float = 0.9  # step control: the share of what the error permits
    shrink: float = 0.2  # least ratio of two steps' lengths
    grow: float = 10.0  # largest ratio of two steps' lengths
    lower: Weights = ()  # solution of still lower order, for an estimate that joins two
    further: tuple[Stage, ...] = ()  # stages s + 2 and on, of the dense output
    # Relative tolerance above which the error alone does not keep a vibration from growing: steps
    # are then kept within the region of stability. None where they always are.
    stability_edge: float | None = None

    @property
    def all_stages(self) -> tuple[Stage, ...]:
        """Stages 1, 2, ... with the derivative at the end and those of the dense output."""
        first, end = Stage(Fraction(0), ()), Stage(Fraction(1), self.b)
        return first, *self.stages, end, *self.further

    @property
    def last(self) -> int:
        """Number s of stages, behind which k_{s+1} lies."""
        return 1 + len(self.stages)

    @property
    def stability_function(self) -> Weights:
        """Coefficients of R(z), constant first: a step takes y' = λ y from y to R(h λ) y."""
        powers: list[Weights] = [(Fraction(1),)]  # of the stages' states, stage by stage
        for stage in (*self.stages, Stage(Fraction(1), self.b)):
            terms = [[a * x for x in k] for a, k in zip(stage.a, powers, strict=False)]
            sums = (sum(x, Fraction(0)) for x in zip_longest(*terms, fillvalue=Fraction(0)))
            powers.append((Fraction(1), *sums))
        return powers[-1]


def weights(text: str) -> Weights:
    """Numbers as they are published: fractions, or decimals with all their digits."""
    return tuple(Fraction(number) for number in text.split())


def stages(text: str) -> tuple[Stage, ...]:
    """Rows ``c | a a ...`` of a Butcher tableau; a line without ``|`` goes on with the last row."""
    rows: list[str] = []
    for line in text.strip().splitlines():
        if "|" in line:
            rows.append(line)
        else:
            rows[-1] += line
    parts = (row.partition("|") for row in rows)
    return tuple(Stage(Fraction(c.strip()), weights(a)) for c, _, a in parts)


def difference(b: Weights, other: Weights) -> Weights:
    """Weights of the difference of two solutions."""
    return tuple(x - y for x, y in zip_longest(b, other, fillvalue=Fraction(0)))
