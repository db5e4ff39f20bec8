"""Every refusal of a problem or an option says what does not fit."""

import numpy as np
import pytest

from codegen.errors import InputError
from runtime.integrate.problem import Options, refuse_misfits
from tests.runtime.integrate.systems import pendulum_problem

PROBLEM = pendulum_problem(0.0, 1.0, 2.0)


def test_what_is_right_passes():
    options = Options(
        method="tsit5", rtol=1e-3, atol_q=1e-6, atol_v=np.ones(3), t_eval=[0, 1, 2], max_steps=1
    )
    refuse_misfits(PROBLEM, options)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"t_end": -1.0}, r"must not end \(t_end = -1.0\) before t0 = 0.0"),
        ({"method": "euler"}, "method 'euler' is none of the methods"),
        ({"correction": "never"}, "correction = 'never' must be one of step"),
        ({"rtol": 2.0}, "rtol = 2.0 must lie between"),
        ({"atol_q": [1.0, 2.0]}, r"atol = \[1.0, 2.0\] must be one number or 3"),
        ({"t_eval": [1.0, 2.5]}, "runs from 1.0 to 2.5; it must lie between t0 = 0.0"),
        ({"time_scale": 0.1}, "correction='.*' has none: leave it out, or give"),
    ],
)
def test_misfits(options, message):
    problem = PROBLEM._replace(t_end=options.pop("t_end", PROBLEM.t_end))
    with pytest.raises(InputError, match=message):
        refuse_misfits(problem, Options(**options))


def test_one_tolerance_for_both_is_named_once():
    wrong = np.ones(2)
    with pytest.raises(InputError) as caught:
        refuse_misfits(PROBLEM, Options(atol_q=wrong, atol_v=wrong, rtol=0.0))
    assert [text.split(" =")[0] for text in caught.value.problems] == ["rtol", "atol"]
