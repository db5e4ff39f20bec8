"""Messages that say what was probably meant."""

import math
from pathlib import Path

import pytest

from codegen import LinkwrightError, Model, build
from codegen.errors import ModelFileError
from codegen.reading.model_file import execute_model_file


def test_a_word_that_is_nearly_one_is_answered_with_it() -> None:
    with pytest.raises(LinkwrightError, match=r"\. gravty: did you mean gravity\?$"):
        Model("m", gravty=(0, -9.81))  # type: ignore[call-arg]


def test_functions_that_need_numbers_name_the_symbol_and_the_remedy() -> None:
    body = Model("m").body("b", mass=1.0, inertia=1.0)
    for call in (math.sin, float):
        with pytest.raises(TypeError, match=r"'b_phi' has no value .* functions of sympy: sin"):
            call(body.phi)


DECLARED = """import math

import numpy as np
from codegen import Model

model = Model("m")
b = model.body("b", mass=1.0, inertia=1.0)
model.torque("t", b, {})
"""


@pytest.mark.parametrize(
    ("value", "remedy"),
    [
        ("-math.sin(2 * b.phi)", "use sympy.sin in place of math.sin."),
        ("np.arctan2(b.x, b.y)", "use sympy.atan2 in place of np.arctan2."),
        ("np.sqrt(b.phi)", "use sympy.sqrt in place of np.sqrt."),
        ("math.fabs(b.x + b.y)", "use sympy.Abs in place of math.fabs."),
        ("np.cos(1.0) + np.sin(b.phi)", "use sympy.sin in place of np.sin."),
        ("np.hypot(b.x, b.y)", "use sympy.sqrt(x**2 + y**2) in place of np.hypot."),
        ("np.log10(2 + b.x)", "use sympy.log(x, 10) in place of np.log10."),
        ("np.nextafter(b.x, b.y)", "use functions of sympy, such as sympy.sin."),
        ("float(2 * b.phi)", "use functions of sympy, such as sympy.sin."),
        ("max(2 * b.phi, 1)", "use sympy.Piecewise, And, Or, Max and Min of coordinates"),
        ("1 if 0 < b.phi < 1 else 2", "use sympy.Piecewise, And, Or, Max and Min of coordinates"),
    ],
)
def test_functions_of_math_and_numpy_name_those_of_sympy(
    tmp_path: Path, value: str, remedy: str
) -> None:
    path = tmp_path / "machine.py"
    path.write_text(DECLARED.format(value), encoding="utf-8")
    with pytest.raises(ModelFileError, match=r"machine\.py, line 8: ") as caught:
        execute_model_file(path)
    assert remedy in str(caught.value)


@pytest.mark.parametrize("value", ["'a' + 1", "np.sin(None)"])
def test_other_type_errors_have_no_remedy(tmp_path: Path, value: str) -> None:
    path = tmp_path / "machine.py"
    path.write_text(DECLARED.format(value), encoding="utf-8")
    with pytest.raises(ModelFileError) as caught:
        execute_model_file(path)
    assert "sympy" not in str(caught.value)


def test_a_function_that_is_given_expressions_is_answered_alike() -> None:
    model = Model("m")
    a, b = (model.particle(name, mass=1.0) for name in "ab")
    model.line_force("f", a, b, lambda length, rate: math.exp(2 * length))
    model.scene("s", ["f"])
    with pytest.raises(LinkwrightError, match=r"use sympy\.exp in place of math\.exp"):
        build(model, compile=False)
