"""Simulations that go on where another stopped, and that start from what another reached."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from codegen import Model
from codegen.errors import AnalysisError, AssemblyError, InputError
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.assembled_state import State
from runtime.results.result import Result
from tests.runtime.same_bits import same


@pytest.fixture(scope="module")
def swing(tmp_path_factory: pytest.TempPathFactory) -> Model:
    """A damped rod on a hinge, with its works."""
    model = Model("resumed_swing", gravity=(0, -9.81))
    bob = model.body("bob", mass=2.0, inertia=0.5)
    model.revolute("hinge", model.ground.at(0, 0), bob.at(-1, 0))
    model.torque("damper", on=bob, value=-0.3 * bob.omega)
    outputs = ["work(damper)", "work(gravity)", "energy"]
    start = {bob.phi: 0.4, bob.omega: 0.0}
    model.scene("damped", effects=["gravity", "damper"], start=start, outputs=outputs)
    model.scene("guessed", effects=["gravity", "damper"])
    return model


# -- going on ---------------------------------------------------------------------------------


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "bdf", "auto"])
@pytest.mark.parametrize(
    ("name", "ends"),
    [
        ("hard/contact_follower thrown", (0.8, 1.0, 1.3)),
        ("hard/n_four_bar fall", (0.7, 0.71, 3.0)),
        ("slider_crank compressor", (1.03, 1.1, 2.0)),
    ],
)
def test_a_resumed_run_has_the_bits_of_one_that_went_through(
    name: str, ends: tuple[float, ...], method: str
) -> None:
    machine, (first, second, last) = load(*name.split()), ends
    t = np.unique([*np.linspace(0.0, last, 37), first, second])
    whole = machine.simulate(last, t, method=method)
    begun = machine.simulate(first, t[t <= first], method=method)
    then = begun.resume(second, t[(t >= first) & (t <= second)])
    end = then.resume(last, t[t >= second])
    same(machine.simulate(second, t[t <= second], method=method), then)
    same(whole, end)
    assert end.outcome is whole.outcome is Outcome.OK
    assert end.stats["steps"] == whole.stats["steps"]
    assert end.message.startswith(f"Resumed at t = {second:.9g} s. Reached t = {last:g} s")
    events = [*begun.events, *then.events, *end.events]
    times = [event.time for event in whole.events]  # in a step that an end has cut, by rounding
    assert [event.time for event in events] == pytest.approx(times, abs=1e-12)
    assert [event.time for event in end.events] == times[len(times) - len(end.events) :]
    inside = np.linspace(0.0, last, 23)
    same(whole.at(inside), end.at(inside))


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("name", ["hard/five_bar fall", "quick_return shaper"])
def test_so_has_one_in_reduced_coordinates(name: str) -> None:
    machine = load(*name.split())
    t = np.linspace(0.0, 2.6, 27)
    whole = machine.simulate(2.6, t, formulation="reduced")
    begun = machine.simulate(1.3, 2, formulation="reduced")
    assert len(begun._motion.checkpoints.rows) > 1
    same(whole, begun.resume(2.6, t[t >= 1.3]))


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize("t_eval", [7, "steps", [40.0, 60.0]])
def test_works_go_on(swing: Model, tmp_path: Path, t_eval: object) -> None:
    machine = load(swing, "damped", folder=tmp_path)
    whole = machine.simulate(60.0, rtol=1e-10)
    begun = machine.simulate(40.0, [7.0], rtol=1e-10)
    rest = begun.resume(60.0, t_eval)  # type: ignore[arg-type]
    assert rest.t[-1] == 60.0
    for name in ("damper", "gravity"):
        assert rest.work(name) == pytest.approx(whole.at(rest.t).work(name), abs=1e-9)
        assert rest.at([0.1, 50.0]).work(name) == pytest.approx(
            whole.at([0.1, 50.0]).work(name), abs=1e-9
        )


def test_a_run_that_a_limit_ended_goes_on(gas: Machine) -> None:
    whole = gas.simulate(3.0, "steps")
    begun = gas.simulate(3.0, "steps", max_steps=3)
    assert begun.outcome is Outcome.MAX_STEPS
    rest = begun.resume(3.0, "steps")
    assert [*begun.t, *rest.t[rest.t > begun.t[-1]]] == whole.t.tolist()
    same(whole, rest)


@pytest.mark.parametrize(
    ("t_end", "t_eval", "message"),
    [
        (0.1, None, r"t_end = 0\.1 s must lie after t = 0\.2 s"),
        (0.4, [0.1, 0.3], r"lies between t = 0\.2 s and 0\.4 s"),
        (0.4, "often", '"steps"'),
        ("later", None, "a finite number of seconds"),
    ],
)
def test_what_cannot_go_on(gas: Machine, t_end: object, t_eval: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        gas.simulate(0.2, 2).resume(t_end, t_eval)  # type: ignore[arg-type]


def test_what_does_not_go_on(gas: Machine, driven: Machine, free: Machine) -> None:
    with pytest.raises(InputError, match="kinematics has every instant at once"):
        driven.kinematics(0.1).resume(0.2)
    with pytest.raises(InputError, match="this is a result of equilibrium"):
        free.equilibrium().resume(0.2)
    with pytest.raises(InputError, match="an accuracy is that of a whole run"):
        gas.simulate(0.1, accuracy=1e-4).resume(0.2)
    failed = gas.simulate(0.1, 2)
    failed.outcome = Outcome.SINGULAR
    with pytest.raises(AnalysisError, match="goes on there no more"):
        failed.resume(0.2)


# -- starting from ----------------------------------------------------------------------------


def test_a_run_starts_from_what_another_reached(gas: Machine) -> None:
    r = gas.simulate(0.6)
    state = r.state(0.4)
    assert isinstance(state, State)
    assert state["crank.phi"] == r.at(0.4).q("crank.phi")[0]
    whole = gas.simulate(1.0, [0.4, 0.6, 1.0], rtol=1e-11)
    for start, t in ((r, 0.6), (r.state(), 0.6), (state, 0.4)):
        then = gas.simulate(1.0, [t, 1.0], start=start)
        assert then.t[0] == t
        assert then.samples.q[0] == pytest.approx(r.at(t).samples.q[0], abs=1e-12)
        assert then.samples.q[1] == pytest.approx(whole.samples.q[2], abs=1e-5)
        assert f"It starts from a state at t = {t:.9g} s" in then.message
    assert r.state()["crank.omega"] == r.v("crank.omega")[-1]


def test_a_run_starts_at_rest_from_an_equilibrium(free: Machine) -> None:
    rest = free.equilibrium()
    r = free.simulate(0.5, 3, start=rest)
    assert r.samples.q == pytest.approx(np.tile(rest.samples.q, (3, 1)), abs=1e-7)


def test_a_state_of_another_machine_is_refused(gas: Machine, swing: Model, tmp_path: Path) -> None:
    other = load(swing, "damped", folder=tmp_path).simulate(0.1, 2)
    with pytest.raises(InputError, match="assembled for another machine"):
        gas.simulate(1.0, start=other)
    with pytest.raises(InputError, match="start and guess are both given"):
        gas.simulate(1.0, start=gas.simulate(0.1, 2), guess={"crank.phi": 1.0})
    with pytest.raises(InputError, match=r"a result or its state\(t\), a saved one as"):
        gas.simulate(1.0, start=3)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="of one instant; t has 2"):
        gas.simulate(0.1).state([0.0, 0.1])  # type: ignore[arg-type]


def test_start_sets_values_and_guess_begins_a_search(swing: Model, tmp_path: Path) -> None:
    guessed = load(swing, "guessed", folder=tmp_path)
    r = guessed.simulate(0.1, 2, start={"bob.phi": 0.7, "bob.omega": 0.2})
    assert r.q("bob.phi")[0] == 0.7
    assert r.v("bob.omega")[0] == pytest.approx(0.2, abs=1e-15)
    assert "start sets bob.phi = 0.7 rad, bob.omega = 0.2 rad/s." in r.message
    r = guessed.simulate(0.1, 2, guess={"bob.x": 0.3, "bob.y": 0.1})
    assert "guess bob.x = 0.3 became " in r.message
    assert "start= sets a value" in r.message
    damped = load(swing, "damped", folder=tmp_path)
    with pytest.raises(
        AssemblyError, match=r"guess names what the scene fixes: bob\.phi = 0\.4 rad"
    ):
        damped.simulate(0.1, 2, guess={"bob.phi": 0.5})


def test_a_start_that_the_joints_do_not_allow_is_refused(swing: Model, tmp_path: Path) -> None:
    damped = load(swing, "damped", folder=tmp_path)
    with pytest.raises(AssemblyError, match=r"Start says bob\.x = 0\.9 m.*bob\.phi = 0\.4 rad"):
        damped.simulate(0.1, start={"bob.x": 0.9})
    with pytest.raises(AssemblyError, match=r"nearest: bob\.phi"):
        damped.simulate(0.1, start={"bob.fi": 0.9})
    with pytest.raises(InputError, match=r"bob\.x is given in start and in guess"):
        damped.simulate(0.1, start={"bob.x": 0.9}, guess={"bob.x": 0.8})


# -- files ------------------------------------------------------------------------------------


def _equal(a: Result, b: Result) -> None:
    for name, x, y in zip(a.samples._fields, a.samples, b.samples, strict=True):
        assert np.array_equal(x, y, equal_nan=True), name
    assert a.facts() == b.facts()
    assert [e[:3] for e in a.events] == [e[:3] for e in b.events]
    assert a.partitions == b.partitions
    assert a.works.keys() == b.works.keys()
    assert all(np.array_equal(a.works[name], b.works[name]) for name in a.works)
    assert a.outcome is b.outcome


@pytest.mark.usefixtures("often")
@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("hard/contact_follower thrown", {}),
        ("hard/belt_block riding", {"method": "bdf"}),
        ("hard/five_bar fall", {"formulation": "reduced"}),
        ("slider_crank compressor", {"accuracy": 1e-5}),
        ("slider_crank compressor", {"max_steps": 40, "rtol": 1e-10}),
    ],
)
def test_a_saved_run_comes_back(tmp_path: Path, name: str, options: dict) -> None:
    r = load(*name.split()).simulate(1.3, 14, **options)
    again = load_result(r.save(tmp_path / "run.nc"))
    _equal(r, again)
    t = np.linspace(0.0, r.t[-1], 9)
    same(r.at(t), again.at(t))
    if r.accuracy is None:
        same(r.resume(1.7, 5), again.resume(1.7, 5))
    machine = load(*name.split())
    states = [machine.simulate(r.t[-1] + 0.1, 3, start=start).samples.q for start in (r, again)]
    assert np.array_equal(*states)


def test_a_driven_motion_comes_back(tmp_path: Path) -> None:
    machine = load("slider_crank", "inverse_dynamics")
    for r in (machine.inverse_dynamics(0.3, 7), machine.kinematics(0.3, 7)):
        again = load_result(r.save(tmp_path / "motion.nc"))
        _equal(r, again)
        assert again.at(0.123).samples.q.tolist() == r.at(0.123).samples.q.tolist()


def test_works_come_back_with_a_machine_of_the_program(swing: Model, tmp_path: Path) -> None:
    machine = load(swing, "damped", folder=tmp_path)
    r = machine.simulate(2.0, 5)
    file = r.save(tmp_path / "swing.nc")
    again = load_result(file, machine)
    _equal(r, again)
    assert again.at(1.1).work("damper") == r.at(1.1).work("damper")
    assert again.resume(3.0, 3).work("damper").tolist() == r.resume(3.0, 3).work("damper").tolist()
    with pytest.raises(InputError, match="has a result of resumed_swing/damped, and the machine"):
        load_result(file, load(swing, "guessed", folder=tmp_path))


def test_what_is_no_saved_result(tmp_path: Path) -> None:
    (tmp_path / "no.nc").write_bytes(b"something else")
    for name, message in (
        ("no.nc", "was not written by this version"),
        ("run.csv", "come back from .nc files and .zarr stores alone"),
        ("none.nc", "there is no such file"),
    ):
        with pytest.raises(InputError, match=message):
            load_result(tmp_path / name)
    with pytest.raises(InputError, match="it must be a machine"):
        load_result(tmp_path / "no.nc", 3)  # type: ignore[arg-type]


def test_another_process_goes_on_with_the_same_bits(tmp_path: Path) -> None:
    machine = load("hard/contact_follower", "thrown")
    file = machine.simulate(0.8).save(tmp_path / "run.nc")
    program = (
        "import sys, numpy as np; from runtime import load, load_result;"
        "machine = load('hard/contact_follower', 'thrown');"
        "r = load_result(sys.argv[1]).resume(1.3, [0.9, 1.3]);"
        "print(r.samples.q.tobytes().hex())"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(file)], capture_output=True, text=True, check=True
    )
    whole = machine.simulate(1.3, [0.9, 1.3])
    assert done.stdout.strip() == whole.samples.q.tobytes().hex()
