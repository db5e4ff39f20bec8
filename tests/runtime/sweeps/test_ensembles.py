"""Rows of an ensemble beside single runs, its refusals, and an interruption."""

import signal
import threading
import time

import numpy as np
import pandas as pd
import pytest

from codegen.errors import AnalysisError, InputError
from runtime import load
from runtime.dynamics import prescribed_motion
from runtime.results import samples
from runtime.sweeps import ensemble


@pytest.fixture(scope="module")
def compressor():
    return load("slider_crank", scene="compressor")


def assert_equal_to_single_runs(
    machine, found, times, parameters, starts=None, guesses=None, analysis="simulate"
):
    """Each row has the bits, the events and the words of a single run with its values."""
    for run in range(found.sizes["run"]):
        values, start, guess = (
            {name: float(column[run]) for name, column in (columns or {}).items()} or None
            for columns in (parameters, starts, guesses)
        )
        result = getattr(machine, analysis)(
            1.0, times, parameters=values, start=start, guess=guess, progress=False
        )
        assert found["outcome"].values[run] == str(result.outcome)
        assert found["message"].values[run] == result.message
        assert found["event_count"].values[run] == len(result.events)
        kept = np.isin(times, result.t)
        single = result.data.isel(time=np.isin(result.t, times))
        for variable in single.data_vars:
            if "time" in single[variable].dims:
                row_values = found[variable].values[run]
                both = row_values[kept], single[variable].values
                np.testing.assert_array_equal(*both, err_msg=str(variable))
                assert np.isnan(row_values[~kept]).all()


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    ("model", "scene"),
    [
        ("slider_crank", "compressor"),
        ("quarter_car", None),
        ("robot_arm", None),
        ("hard/bouncing_ball", None),
        ("hard/guide_friction", None),
    ],
)
def test_rows_equal_single_runs_bit_for_bit(model, scene, threads):
    machine = load(model, scene=scene) if scene else load(model)
    row = machine.mechanism.description.parameters[0]
    given = {row.name: row.default * np.linspace(1.0, 1.02, 9)}
    times = np.linspace(0.0, 1.0, 11)
    found = machine.ensemble(1.0, times, parameters=given, threads=threads, progress=False)
    assert_equal_to_single_runs(machine, found, times, given)


@pytest.mark.parametrize("method", ["dopri5", "radau5", "auto"])
def test_options_hold_for_all_members(compressor, method):
    given, times = {"J1": np.linspace(300.0, 900.0, 4)}, np.linspace(0.0, 0.2, 6)
    options = {"method": method, "rtol": 1e-6, "atol": 1e-7, "max_step": 0.01, "progress": False}
    found = compressor.ensemble(0.2, times, parameters=given, threads=1, **options)
    for run, value in enumerate(given["J1"]):
        result = compressor.simulate(0.2, times, parameters={"J1": value}, **options)
        np.testing.assert_array_equal(found["q"].values[run], result.data["q"].values)
        assert found["message"].values[run] == result.message


def interrupt():
    """What Ctrl-C does."""
    signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)


def interrupt_fourth_call(monkeypatch, module, name):
    """Ctrl-C comes with the fourth call of a function of a module; later calls take their time."""
    original, calls = getattr(module, name), []

    def interrupted(*arguments, **words):
        calls.append(1)
        if len(calls) == 4:
            interrupt()
        elif len(calls) > 4:
            time.sleep(0.1)
        return original(*arguments, **words)

    monkeypatch.setattr(module, name, interrupted)


def made_by_simulate(monkeypatch):
    """The members that are made by single runs from now on, one entry each."""
    original, calls = ensemble.simulate_joints, []

    def counted(*arguments, **words):
        calls.append(words["parameters"])
        return original(*arguments, **words)

    monkeypatch.setattr(ensemble, "simulate_joints", counted)
    return calls


@pytest.mark.parametrize(
    ("given", "starts", "threads"),
    [
        ({"J1": np.linspace(200.0, 1000.0, 41)}, {}, 1),
        ({"J1": np.linspace(200.0, 1000.0, 41)}, {}, 2),
        ({"rod_length": np.linspace(3.4, 4.0, 9), "motor_torque": np.linspace(4e4, 5e4, 9)}, {}, 1),
        ({}, {"crank.omega": np.linspace(20.0, 40.0, 5)}, 1),
    ],
    ids=["one thread", "two threads", "joints that close anew", "starts"],
)
def test_the_compiled_loop_makes_all_compressors_but_the_first(
    compressor, monkeypatch, given, starts, threads
):
    """Those that come to rest, in a sliding mode, and those that touch a surface are among them."""
    times, calls = np.linspace(0.0, 1.0, 11), made_by_simulate(monkeypatch)
    found = compressor.ensemble(
        1.0, times, parameters=given, starts=starts, threads=threads, progress=False
    )
    assert len(calls) == 1
    if "J1" in given:
        assert (found["mode"].values == 2.0).any()
        assert any("within the tolerance" in str(said) for said in found["message"].values)
    assert_equal_to_single_runs(compressor, found, times, given, starts)


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


@pytest.mark.parametrize("threads", [1, 2])
def test_a_sign_that_a_parameter_must_not_have_is_refused_as_in_a_single_run(compressor, threads):
    given = {"rod_length": np.array([3.5, 3.55, -3.5, 3.6])}
    found = compressor.ensemble(0.1, 5, parameters=given, threads=threads, progress=False)
    assert list(found["outcome"].values) == ["OK", "OK", "ParameterError", "OK"]
    assert "rod_length is -3.5 m; it must be greater" in str(found["message"].values[2])
    assert np.isnan(found["q"].values[2]).all()


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
    """Twice its samples are there while it is made."""
    needed = 1000 * 1001 * samples.sample_bytes(compressor.mechanism.description)
    monkeypatch.setattr(samples, "free_bytes", lambda: int(1.5 * needed))
    name = compressor.mechanism.description.parameters.names[0]
    with pytest.raises(InputError, match=r"GB of memory are free"):
        compressor.ensemble(0.1, 1001, parameters={name: np.ones(1000)}, progress=False)


@pytest.mark.parametrize("threads", [1, 2])
def test_an_interruption_keeps_what_is_done(compressor, monkeypatch, threads):
    original, calls = ensemble.run_members, []

    def interrupted(*arguments):
        at = original(*arguments)
        calls.append(at)
        if len(calls) == 2:
            interrupt()
        elif len(calls) > 2:
            time.sleep(0.3)  # the main thread has time to hear it, however busy the machine is
        return at

    monkeypatch.setattr(ensemble, "run_members", interrupted)
    count = 400
    given = {"J1": np.linspace(400.0, 500.0, count)}
    found = compressor.ensemble(1.0, 5, parameters=given, threads=threads, progress=False)
    outcomes = found["outcome"].values
    assert {*outcomes} == {"OK", "not run"}
    done = outcomes == "OK"
    assert 1 < done.sum() < count
    assert np.isfinite(found["q"].values[done]).all()
    assert np.isnan(found["q"].values[~done]).all()
    assert not found["event_count"].values[~done].any()


def test_an_interruption_ends_single_runs_in_threads(monkeypatch):
    machine = load("quarter_car")
    interrupt_fourth_call(monkeypatch, ensemble, "simulate_joints")
    name = machine.mechanism.description.parameters.names[0]
    usual = machine.mechanism.description.parameters[0].default
    given = {name: np.full(40, usual)}
    found = machine.ensemble(1.0, 5, parameters=given, threads=2, progress=False)
    outcomes = list(found["outcome"].values)
    assert outcomes[:2] == ["OK", "OK"]
    assert outcomes.count("not run") > 20


def test_what_a_thread_raises_is_raised(compressor, monkeypatch):
    def broken(*arguments):
        raise RuntimeError("a fault in a thread")

    monkeypatch.setattr(ensemble, "run_members", broken)
    with pytest.raises(RuntimeError, match="a fault in a thread"):
        compressor.ensemble(
            0.1, 5, parameters={"J1": np.linspace(400.0, 500.0, 9)}, threads=2, progress=False
        )


def test_no_thread_is_refused(compressor):
    with pytest.raises(InputError, match="threads is 0"):
        compressor.ensemble(0.1, 5, parameters={"J1": [400.0]}, threads=0, progress=False)


def test_joints_that_come_and_go_are_refused():
    machine = load("trebuchet")
    with pytest.raises(InputError, match="joints come and go"):
        machine.ensemble(1.0, 5, parameters={"ball_mass": [1.0, 2.0]}, progress=False)


CROSSED = {"coupler.y": -2.45, "coupler.phi": -1.37, "rocker.y": -1.22, "rocker.phi": -1.77}
"""Where the bars of the four-bar linkage are about, mirrored."""
DRIVEN = ["kinematics", "inverse_dynamics"]


@pytest.fixture(scope="module")
def four_bar():
    return load("four_bar", scene="inverse_dynamics")


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize(
    ("model", "analysis"),
    [
        ("four_bar", "kinematics"),
        ("four_bar", "inverse_dynamics"),
        ("slider_crank", "inverse_dynamics"),
        ("film_follower", "inverse_dynamics"),
        ("watt_six_bar", "kinematics"),
    ],
)
def test_rows_of_driven_motions_equal_single_runs(model, analysis, threads):
    machine = load(model, scene="kinematics" if analysis == "kinematics" else "inverse_dynamics")
    row = machine.parameters[0]
    given, times = {row.name: row.default * np.linspace(1.0, 1.02, 5)}, np.linspace(0.0, 1.0, 11)
    found = machine.ensemble(
        1.0, times, analysis=analysis, parameters=given, threads=threads, progress=False
    )
    assert {*found["outcome"].values} == {"OK"}
    assert_equal_to_single_runs(machine, found, times, given, analysis=analysis)


@pytest.mark.parametrize("analysis", DRIVEN)
def test_members_that_lock_up_or_do_not_assemble_are_named(four_bar, analysis):
    given = {name: np.array([2.5, 1.4, 0.3, 2.6]) for name in ("BC", "CD")}
    found = four_bar.ensemble(1.0, 11, analysis=analysis, parameters=given, progress=False)
    assert list(found["outcome"].values) == ["OK", "LOCKED", "AssemblyError", "OK"]
    assert "crank_drive cannot go on" in str(found["message"].values[1])
    locked = found["q"].values[1]
    assert np.isfinite(locked[:4]).all()  # until 0.376 s
    assert np.isnan(locked[4:]).all()
    assert np.isnan(found["q"].values[2]).all()
    assert np.isfinite(found["q"].values[[0, 3]]).all()


@pytest.mark.parametrize("analysis", ["simulate", *DRIVEN])
def test_guesses_choose_the_branch_of_a_member(analysis):
    scene = "constant_torque" if analysis == "simulate" else "inverse_dynamics"
    machine, times = load("four_bar", scene=scene), np.linspace(0.0, 1.0, 11)
    guesses = {name: np.array([-value, value]) for name, value in CROSSED.items()}
    found = machine.ensemble(1.0, times, analysis=analysis, guesses=guesses, progress=False)
    heights = found["q"].sel(coordinate="coupler.y").values[:, 0]
    np.testing.assert_allclose(heights, [np.sqrt(6.0), -np.sqrt(6.0)])
    assert_equal_to_single_runs(machine, found, times, {}, None, guesses, analysis)


def test_columns_may_be_those_of_a_table(four_bar):
    table = pd.DataFrame({"BC": [2.5, 2.6], "CD": [2.5, 2.4]})
    found = four_bar.ensemble(1.0, 3, analysis="kinematics", parameters=table, progress=False)
    np.testing.assert_array_equal(found["parameter_CD"], table["CD"])
    assert {*found["outcome"].values} == {"OK"}


def test_instants_may_be_all_that_is_given(four_bar):
    found = four_bar.ensemble(
        [0.1, 0.2], analysis="inverse-dynamics", parameters={"BC": [2.5]}, progress=False
    )
    single = four_bar.inverse_dynamics([0.1, 0.2], parameters={"BC": 2.5}, progress=False)
    np.testing.assert_array_equal(found["reaction"].values[0], single.data["reaction"].values)
    about = {name: single.data.attrs[name] for name in ("model", "scene", "analysis")}
    assert found.attrs == about


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"rtol": 1e-6, "max_steps": 9}, "integrates nothing, so rtol, max_steps would be ignored"),
        ({"analysis": "equilibrium"}, "take simulate, kinematics or inverse_dynamics"),
        ({"analysis": "kinematic"}, "analysis is 'kinematic'"),
        ({"t_eval": "steps"}, 't_eval = "steps" has no meaning'),
        ({"starts": {"crank.phi": 0.0}, "guesses": {"crank.phi": 0.0}}, "in starts and in guesses"),
        ({"guesses": {"crank.psi": 0.0}}, r"guesses\['crank.psi'\]"),
    ],
)
def test_words_that_driven_motions_do_not_take_are_refused(four_bar, words, message):
    with pytest.raises(InputError, match=message):
        four_bar.ensemble(
            1.0, **{"analysis": "kinematics", "parameters": {"BC": [2.5]}, **words}, progress=False
        )


@pytest.mark.parametrize(
    ("model", "scene", "analysis", "message"),
    [
        ("four_bar", "constant_torque", "kinematics", "1 degree of freedom is left"),
        ("four_bar", "kinematics", "inverse_dynamics", "needs masses and forces"),
        ("four_bar", "kinematics", "simulate", "needs masses and forces"),
        ("hard/bouncing_ball", None, "kinematics", "rigid contacts"),
    ],
)
def test_a_scene_that_suits_no_member_is_refused_once(model, scene, analysis, message):
    machine = load(model, scene=scene)
    name = machine.parameters[0].name
    with pytest.raises(AnalysisError, match=message):
        machine.ensemble(1.0, 5, analysis=analysis, parameters={name: [1.0, 2.0]}, progress=False)


@pytest.mark.parametrize("threads", [1, 2])
def test_an_interruption_keeps_the_driven_motions_that_are_done(four_bar, monkeypatch, threads):
    interrupt_fourth_call(monkeypatch, prescribed_motion, "kinematics")
    given = {"BC": np.full(40, 2.5)}
    found = four_bar.ensemble(
        1.0, 5, analysis="kinematics", parameters=given, threads=threads, progress=False
    )
    outcomes = list(found["outcome"].values)
    assert outcomes[:2] == ["OK", "OK"]
    assert outcomes.count("not run") > 20
    assert np.isfinite(found["q"].values[[outcome == "OK" for outcome in outcomes]]).all()
