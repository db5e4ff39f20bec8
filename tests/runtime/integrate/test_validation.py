"""Every refusal of a problem or an option says what is wrong with it."""

from dataclasses import replace

import numpy as np
import pytest

from codegen.errors import InputError
from runtime.integrate.problem import Options
from runtime.integrate.validation import check
from tests.runtime.integrate.systems import PENDULUM, pendulum_problem

PROBLEM = pendulum_problem(0.0, 1.0, 2.0)


def test_what_is_right_passes():
    options = Options(
        method="tsit5", rtol=1e-3, atol_q=1e-6, atol_v=np.ones(3), t_eval=[0, 1, 2], max_steps=1
    )
    check(PENDULUM, PROBLEM, options)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"q": np.zeros(2)}, r"q has shape \(2,\); it must be \(3,\)"),
        ({"v": np.array([0.0, np.inf, 0.0])}, "v has entries that are not finite"),
        ({"sizes": -1.0}, "sizes = -1.0 must be positive and finite, one number or 3"),
        ({"t_end": -1.0}, r"must not end \(t_end = -1.0\) before t0 = 0.0"),
        ({"t_end": np.inf}, "must not end"),
    ],
)
def test_problems(changes, message):
    with pytest.raises(InputError, match=message):
        check(PENDULUM, replace(PROBLEM, **changes), Options())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"method": "euler"}, "method 'euler' is none of the methods"),
        ({"method": "bdf"}, "needs the derivatives of the kernels"),
        ({"correction": "never"}, "correction = 'never' must be one of step"),
        ({"rtol": 2.0}, "rtol = 2.0 must lie between"),
        ({"rtol": True}, "rtol = True"),
        ({"atol_q": [1.0, 2.0]}, r"atol_q = \[1. 2.\] must be positive"),
        ({"atol_v": "small"}, "atol_v = 'small' must be positive, one number or 3"),
        ({"t_eval": [1.0, 0.5]}, "row of ascending times"),
        ({"t_eval": [1.0, 2.5]}, "runs from 1.0 to 2.5; it must lie between t0 = 0.0"),
        ({"h_max": 0.0}, "h_max = 0.0 must be a positive, finite number of seconds"),
        ({"time_scale": np.nan}, "time_scale = nan"),
        ({"time_scale": 0.1}, "correction='.*' has none: leave it out, or give"),
        ({"max_steps": 0}, "max_steps = 0 must be a whole number from 1"),
        ({"chunk": 1.5}, "chunk = 1.5"),
        ({"max_events": None}, "max_events = None"),
    ],
)
def test_options(options, message):
    with pytest.raises(InputError, match=message):
        check(PENDULUM, PROBLEM, Options(**options))


def test_one_tolerance_for_both_is_named_once():
    wrong = -1.0
    with pytest.raises(InputError) as caught:
        check(PENDULUM, PROBLEM, Options(atol_q=wrong, atol_v=wrong, rtol=0.0))
    assert [text.split(" =")[0] for text in caught.value.problems] == ["rtol", "atol"]
