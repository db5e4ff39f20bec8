"""Machines and results travel to other processes as what they were loaded from."""

import copy
import multiprocessing
import pickle
import shutil
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from codegen import Model
from codegen.errors import ModelFileError
from codegen.reading.model_file import read_model
from runtime import load
from runtime.machine_facade import Machine
from runtime.mechanism.mechanism import _arrived
from runtime.results.result import Result


def _pendulum() -> Model:
    """A pendulum whose hinge is released, so that a run goes on in another scene."""
    model = Model("pendulum", gravity=(0, -9.81))
    length = model.parameter("length", 1.0, unit="m")
    bob = model.body("bob", mass=1.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
    model.release(hinge, when=bob.phi < -1.0)
    model.scene("swing", ["gravity"], start={bob.phi: 0.0, bob.omega: 0.0})
    return model


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> SimpleNamespace:
    """A machine of a `Model`, one of a file, and results of them."""
    folder = tmp_path_factory.mktemp("pickled")
    machine = load(_pendulum(), folder=folder)
    run = machine.simulate(0.2, 3, progress=False)
    longer = machine.simulate(0.8, 5, progress=False)  # goes on in another scene
    driven = load("slider_crank", "inverse_dynamics")
    moved = driven.inverse_dynamics(0.1, 3, progress=False)
    return SimpleNamespace(**locals())


def work(given: tuple[Machine, Result, float]) -> tuple[Result, float]:
    """What a worker does with a machine and a result that it is handed."""
    machine, result, length = given
    run = machine.simulate(0.8, 3, parameters={"length": length}, progress=False)
    return run, float(result.at(0.15).q("bob.phi")[0])


def _there(value: Any) -> Any:
    """The value as another process would have it."""
    _arrived.cache_clear()
    return pickle.loads(pickle.dumps(value))


@pytest.mark.parametrize("kind", ["spawn", "forkserver"])
def test_workers_run_machines_and_return_results(made: SimpleNamespace, kind: str) -> None:
    context = multiprocessing.get_context(kind)
    with ProcessPoolExecutor(1, mp_context=context) as pool:
        given = [(made.machine, made.run, length) for length in (1.1, 1.2)]
        found = [*pool.map(work, given)]
    for (run, between), task in zip(found, given, strict=True):
        expected, same = work(task)
        assert between == same
        np.testing.assert_array_equal(run.q("bob.phi"), expected.q("bob.phi"))
        assert run.at(0.7).q("bob.x")[0] == expected.at(0.7).q("bob.x")[0]


def test_all_that_a_user_holds_is_pickled_and_copied(made: SimpleNamespace) -> None:
    machine, run = made.machine, made.run
    held = (machine, run, made.longer, made.moved, machine.assemble(), run.state(), run.data,
            machine.kernels.accelerations, made.longer.events)  # fmt: skip
    for value in held:
        for taken in (_there(value), copy.copy(value), copy.deepcopy(value)):
            assert type(taken) is type(value)
            assert taken is value or repr(taken) == repr(value)
    longer, moved = _there((made.longer, made.moved))
    assert longer.at(0.7).v("bob.vx")[0] == made.longer.at(0.7).v("bob.vx")[0]
    assert longer.resume(1.0, 2, progress=False).t[-1] == 1.0
    joint = made.driven.constraints[0].element
    expected = made.moved.at(0.03).reaction(joint, "fx")
    np.testing.assert_array_equal(moved.at(0.03).reaction(joint, "fx"), expected)


def test_a_machine_of_a_model_needs_no_file(made: SimpleNamespace, tmp_path: Path) -> None:
    """Its text travels, and its model, of which other modules are built when they are needed."""
    content = pickle.dumps((made.machine, made.run))
    shutil.rmtree(made.machine.path.parent)
    _arrived.cache_clear()
    machine, run = pickle.loads(content)
    again = machine.simulate(0.8, 5, progress=False)
    np.testing.assert_array_equal(again.q("bob.phi"), made.longer.q("bob.phi"))
    assert run.at(0.2).q("bob.phi")[0] == made.run.q("bob.phi")[-1]
    assert machine.mechanism.reduced.kept.size == 1


@pytest.mark.parametrize("name", ["gear_slider", "robot_arm", "film_follower"])
def test_models_are_pickled(name: str) -> None:
    model = read_model(name).model
    there = pickle.loads(pickle.dumps(model))
    assert list(there.elements) == list(model.elements)
    assert [*there.scenes] == [*model.scenes]


def test_what_was_pickled_needs_no_file_as_it_was(tmp_path: Path) -> None:
    """What has to be built there, and cannot, is named."""
    text = "from tests.runtime.test_pickled_machines import _pendulum\nmodel = _pendulum()\n"
    (tmp_path / "pendulum.py").write_text(text)
    machine = load("pendulum.py", folder=tmp_path)
    run = machine.simulate(0.1, 2, progress=False)
    content = pickle.dumps((machine, run))
    machine.path.write_text(machine.path.read_text() + "\n")
    (tmp_path / "pendulum.py").unlink()
    _arrived.cache_clear()
    module = f"linkwright_generated_{machine.path.stem}_{machine.mechanism.origin.digest}"
    kept = sys.modules.pop(module)
    try:
        there, result = pickle.loads(content)
        again = there.simulate(0.1, 2, progress=False)
        assert again.q("bob.phi")[-1] == result.at(0.1).q("bob.phi")[0] == run.q("bob.phi")[-1]
        with pytest.raises(ModelFileError, match=r"pendulum\.py"):
            _ = there.mechanism.reduced
    finally:
        sys.modules[module] = kept
