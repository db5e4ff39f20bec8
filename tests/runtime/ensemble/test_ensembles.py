"""Rows of an ensemble beside single runs, its refusals, and an interruption."""

import numpy as np
import pytest

from codegen.errors import InputError
from runtime import load
from runtime.ensemble import run_ensemble as runs
from runtime.results import memory


@pytest.fixture(scope="module")
def compressor():
    return load("slider_crank", scene="compressor")


@pytest.mark.parametrize(
    ("model", "scene"),
    [
        ("slider_crank", "compressor"),
        ("quarter_car", None),
        ("hard/bouncing_ball", None),
        ("hard/guide_friction", None),
    ],
)
def test_rows_equal_single_runs_bit_for_bit(model, scene):
    machine = load(model, scene=scene) if scene else load(model)
    row = machine.mechanism.description.parameters[0]
    values, times = row.default * np.array([1.0, 1.01, 1.02]), np.linspace(0.0, 1.0, 11)
    found = machine.ensemble(1.0, times, parameters={row.name: values}, progress=False)
    for run, value in enumerate(values):
        result = machine.simulate(1.0, times, parameters={row.name: value}, progress=False)
        assert found["outcome"].values[run] == str(result.outcome)
        assert found["event_count"].values[run] == len(result.events)
        kept = np.isin(times, result.t)
        single = result.data.isel(time=np.isin(result.t, times))
        for variable in single.data_vars:
            if "time" in single[variable].dims:
                row_values = found[variable].values[run]
                both = row_values[kept], single[variable].values
                np.testing.assert_array_equal(*both, err_msg=str(variable))
                assert np.isnan(row_values[~kept]).all()


def test_a_refused_member_and_a_short_run_are_rows(compressor):
    name = compressor.mechanism.description.parameters.names[0]
    usual = compressor.mechanism.description.parameters[0].default
    given = {name: np.array([usual, -usual])}
    found = compressor.ensemble(0.1, 5, parameters=given, progress=False)
    assert list(found["outcome"].values) == ["OK", "ParameterError"]
    assert np.isnan(found["q"].values[1]).all()
    assert name in str(found["message"].values[1])
    short = compressor.ensemble(
        0.1, 5, parameters={name: np.array([usual])}, max_steps=2, progress=False
    )
    assert short["outcome"].values[0] == "MAX_STEPS"
    assert np.isfinite(short["q"].values[0, 0]).all()
    assert np.isnan(short["q"].values[0, -1]).all()


def test_all_problems_are_named_at_once(compressor):
    first, second = compressor.mechanism.description.parameters.names[:2]
    given = {first: np.ones(3), second: np.ones(4), "nonsense": 1.0}
    starts = {compressor.mechanism.description.coordinates.names[0]: [np.nan, 1.0, 1.0]}
    with pytest.raises(InputError) as error:
        compressor.ensemble(0.1, 5, parameters=given, starts=starts, progress=False)
    for part in (f"['{first}'] has 3", f"['{second}'] has 4", "nonsense", "not finite in 1 of 3"):
        assert part in str(error.value)


def test_too_large_a_dataset_is_refused_in_megabytes(compressor):
    name = compressor.mechanism.description.parameters.names[0]
    with pytest.raises(InputError, match=r"take \d+ MB, and max_bytes permits 1 MB"):
        compressor.ensemble(
            0.1, 1001, parameters={name: np.ones(1000)}, max_bytes=10**6, progress=False
        )


def test_a_dataset_larger_than_the_free_memory_is_refused(compressor, monkeypatch):
    monkeypatch.setattr(memory, "free_bytes", lambda: 10**6)
    name = compressor.mechanism.description.parameters.names[0]
    with pytest.raises(InputError, match=r"and 0.001 GB of memory are free"):
        compressor.ensemble(0.1, 1001, parameters={name: np.ones(1000)}, progress=False)


def test_an_interruption_keeps_what_is_done(compressor, monkeypatch):
    name = compressor.mechanism.description.parameters.names[0]
    usual = compressor.mechanism.description.parameters[0].default
    original, calls = runs.simulate, []

    def interrupted(*arguments, **words):
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt
        return original(*arguments, **words)

    monkeypatch.setattr(runs, "simulate", interrupted)
    found = compressor.ensemble(0.1, 5, parameters={name: np.full(3, usual)}, progress=False)
    assert list(found["outcome"].values) == ["OK", "not run", "not run"]
    assert np.isfinite(found["q"].values[0]).all()
    assert np.isnan(found["q"].values[1:]).all()


def test_joints_that_come_and_go_are_refused():
    machine = load("trebuchet")
    with pytest.raises(InputError, match="joints come and go"):
        machine.ensemble(1.0, 5, parameters={"ball_mass": [1.0, 2.0]}, progress=False)
