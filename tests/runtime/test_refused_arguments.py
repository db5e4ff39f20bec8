"""Arguments of the wrong kind are refused at the door, in a sentence, before anything runs."""

import inspect
from typing import Any

import numpy as np
import pytest

from codegen.errors import InputError
from runtime.machine_facade import Machine
from runtime.validation.arguments import KINDS

NAN = float("nan")


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"t_end": "abc"}, "t_end is 'abc'; it must be a finite number of seconds"),
        ({"t_end": "1"}, "t_end is '1'"),
        ({"t_end": NAN}, "t_end is nan"),
        ({"t_end": True}, "t_end is True"),
        ({"t_end": 10**400}, "t_end is 1000"),
        ({"t_end": None}, "t_end is None"),
        ({"t_start": "0"}, "t_start is '0'"),
        ({"rtol": "x"}, "rtol is 'x'; it must be a positive finite number"),
        ({"rtol": True}, "rtol is True"),
        ({"atol": NAN}, "atol is nan"),
        ({"atol": "x"}, "atol is 'x'"),
        ({"first_step": "x"}, "first_step is 'x'"),
        ({"max_step": -1.0}, r"max_step is -1.0; it must be a positive number of seconds"),
        ({"max_steps": 10**30}, "max_steps is 10000.*whole number"),
        ({"max_steps": 2.5}, "max_steps is 2.5; it must be a whole number from 1 to"),
        ({"max_steps": True}, "max_steps is True; it must be a whole number from 1 to"),
        ({"max_steps": 0}, "max_steps is 0; it must be a whole number from 1 to"),
        ({"max_steps": "5"}, "max_steps is '5'"),
        ({"max_bytes": "5"}, "max_bytes is '5'"),
        ({"max_bytes": 0}, "max_bytes is 0; it must be a whole number from 1 to"),
        ({"guess": [1.0]}, r"guess is \[1.0\]; it must be a mapping from names to numbers"),
        ({"guess": {1: 2.0}}, "guess is .*; its name 1 is no text"),
        ({"guess": {"bar.phi": True}}, "bar.phi is True; it must be a finite number"),
        ({"guess": {"bar.phi": 10**400}}, "bar.phi is 1000"),
        ({"parameters": [1.0]}, "parameters is .*mapping from names"),
        ({"parameters": {1: 2.0}}, "parameters is .*; its name 1 is no text"),
        ({"start": [1.0]}, "start is .*what assemble.. returns"),
        ({"t_eval": "abc"}, "must be instants in s"),
        ({"t_eval": "1.0"}, "must be instants in s"),
        ({"t_eval": [True]}, "must be instants in s"),
        ({"t_eval": [1j]}, "must be instants in s"),
        ({"t_eval": [10**400]}, "must be instants in s"),
        ({"t_eval": {"a": 1}}, "must be instants in s"),
    ],
)
def test_simulate(pendulum: Machine, given: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        pendulum.simulate(**{"t_end": 1.0, **given})


def test_all_problems_are_told_at_once(pendulum: Machine) -> None:
    with pytest.raises(InputError) as caught:
        pendulum.simulate("soon", rtol="x", guess=3)  # type: ignore[arg-type]
    assert len(caught.value.problems) == 3


def test_start_says_all(pendulum: Machine, driven: Machine) -> None:
    start = pendulum.assemble(t=1.0)
    with pytest.raises(InputError, match="start and guess are both given"):
        pendulum.simulate(2.0, start=start, guess={"bar.phi": 1.0})
    with pytest.raises(InputError, match=r"start and t_start = 0\.5 s are both given"):
        pendulum.simulate(2.0, start=start, t_start=0.5)
    with pytest.raises(InputError, match="assembled for another machine"):
        pendulum.simulate(2.0, start=driven.assemble())


@pytest.mark.parametrize("given", [{"t": "x"}, {"t": NAN}, {"guess": 3}, {"parameters": 3}])
def test_other_analyses(pendulum: Machine, driven: Machine, given: dict[str, Any]) -> None:
    motion = {"t_start" if name == "t" else name: value for name, value in given.items()}
    for analyse, words in (
        (pendulum.equilibrium, given), (pendulum.assemble, given),
        (driven.kinematics, {"t_end": [0.0, 1.0], **motion}),
        (driven.inverse_dynamics, {"t_end": [0.0, 1.0], **motion}),
    ):  # fmt: skip
        with pytest.raises(InputError, match="it must be a"):
            analyse(**words)


@pytest.mark.parametrize(
    ("q", "v"),
    [
        (np.zeros(3), np.zeros(9)),
        (np.zeros(9), None),
        (None, np.zeros(9)),
        (np.zeros(9), [0.0] * 9),
        (np.full(9, NAN), np.zeros(9)),
    ],
)
def test_modes_of_a_state_of_the_wrong_shape(gas: Machine, q: Any, v: Any) -> None:
    with pytest.raises(InputError, match="must be an array of 9 finite numbers"):
        gas.initial_modes(0.0, q, v)


def test_unknown_quantities_are_refused_before_anything_runs(
    pendulum: Machine, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object, **__: object) -> None:
        raise AssertionError("a run was prepared")

    monkeypatch.setattr("runtime.accuracy_target.search.PreparedSimulation", never)
    with pytest.raises(InputError, match=r"no series 'a'.*\n.*no series 'b'"):
        pendulum.simulate(0.01, accuracy=1e-4, quantities=np.array(["a", "b"]), progress=False)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "method", ["simulate", "ensemble", "kinematics", "inverse_dynamics", "equilibrium", "assemble"]
)
def test_every_argument_of_an_analysis_has_a_reader(method: str) -> None:
    arguments = {*inspect.signature(getattr(Machine, method)).parameters}
    assert arguments - {*KINDS} <= {"self", "start", "starts", "guesses", "until"}
