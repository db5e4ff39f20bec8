"""From powers of x to the Newton form of the dense output, F0 + x (F1 + (1 - x) (F2 + ...))."""

from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt

COEFFICIENTS = 6  # of a polynomial of degree five


def newton_form(powers: list[Any]) -> list[Any]:
    """Coefficients F0, F1, ... of the polynomial with coefficients `powers`, constant first."""
    rest, coefficients = list(powers), []
    at_zero = True
    while rest:
        if at_zero:  # the value at x = 0; then divide the rest by x
            coefficients.append(rest[0])
            rest = rest[1:]
        else:  # the value at x = 1; then divide by 1 - x: partial sums from the constant on
            coefficients.append(sum(rest))
            rest = [sum(rest[: i + 1]) - coefficients[-1] for i in range(len(rest) - 1)]
        at_zero = not at_zero
    return coefficients


def newton_form_matrix(polynomials: list[list[Fraction]]) -> npt.NDArray[np.float64]:
    """Matrix that takes coefficients over `polynomials` to F0 ... F5, shape (6, count).

    Each polynomial is given by its coefficients of the powers of x, constant first, up to degree
    five.
    """
    columns = []
    for powers in polynomials:
        padded = powers + [Fraction(0)] * (COEFFICIENTS - len(powers))
        columns.append([float(value) for value in newton_form(padded)])
    return np.ascontiguousarray(np.array(columns).T)
