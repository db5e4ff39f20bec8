"""From powers of x to the form of the dense output, F0 + x (F1 + (1 - x) (F2 + x (F3 + ...)))."""

from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

COEFFICIENTS = 6  # a polynomial of degree five has as many


def nested(powers: list[Any]) -> list[Any]:
    """Coefficients F0, F1, ... of the polynomial with coefficients `powers`, constant first."""
    rest, found = list(powers), []
    at_zero = True
    while rest:
        if at_zero:  # what is left at x = 0; then divide by x
            found.append(rest[0])
            rest = rest[1:]
        else:  # what is left at x = 1; then divide by 1 - x: partial sums from the constant on
            found.append(sum(rest))
            rest = [sum(rest[: i + 1]) - found[-1] for i in range(len(rest) - 1)]
        at_zero = not at_zero
    return found


def nesting(polynomials: list[list[Fraction]]) -> npt.NDArray[np.float64]:
    """Matrix that takes coefficients over `polynomials` to F0 ... F5, shape (6, count).

    Each polynomial is given by its coefficients of the powers of x, constant first; it has at most
    degree five.
    """
    columns = []
    for powers in polynomials:
        padded = powers + [Fraction(0)] * (COEFFICIENTS - len(powers))
        columns.append([float(value) for value in nested(padded)])
    return np.ascontiguousarray(np.array(columns).T)
