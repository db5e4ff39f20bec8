"""The method that a run changes to."""

import pytest

from runtime.integrate.implicit.stiffness_switching import successor
from runtime.integrate.method import METHODS


@pytest.mark.parametrize(
    ("name", "freedoms", "rtol", "expected"),
    [
        ("auto", 2, 1e-3, "radau5"),
        ("auto", 40, 1e-3, "bdf"),
        ("auto", 40, 1e-9, "radau5"),
        ("radau5", 40, 1e-3, "auto"),
        ("bdf", 2, 1e-9, "auto"),
    ],
)
def test_successor(name, freedoms, rtol, expected):
    assert successor(name, freedoms, rtol) == expected
    assert expected in METHODS
