"""Sampled control against exact discrete solutions: steps end at samples, values keep between."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from sympy import Max, Min

from codegen import Model
from codegen.errors import InputError
from runtime import load, load_result
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.results.assembled_state import State

INERTIA, PERIOD, DELAY = 0.05, 0.01, 0.025
KP, KI, KD = 40.0, 60.0, 4.0


@pytest.fixture(scope="module")
def servo(workshop: Path) -> Callable[[str], Machine]:
    """An arm that a PID controller with saturation and anti-windup turns to 1 rad."""
    model = Model("servo_sampled")
    period = model.parameter("period", PERIOD, "s")
    arm = model.body("arm", mass=1.0, inertia=INERTIA)
    model.revolute("pin", model.ground.at(0, 0), arm.at(0, 0))
    error = 1 - arm.phi
    integral = model.sampled("sum", period, lambda s: Max(-0.5, Min(0.5, s + period * error)))
    torque = Max(-5, Min(5, KP * error + KI * integral - KD * arm.omega))
    late = Max(-5, Min(5, KP / 4 * error - KD / 4 * arm.omega))
    control = {
        "pid": model.sampled("u", period, torque, unit="N m"),
        "late": model.sampled("u_late", period, late, delay=DELAY, unit="N m"),
        "own": model.sampled("u_own", 0.01, unit="N m"),
        "slow": model.sampled("u_slow", 3 * period, error + 0 * integral, unit="N m"),
    }
    for name, u in control.items():
        model.torque(f"drive_{name}", on=arm, value=u)
        model.scene(name, [f"drive_{name}"], start={arm.phi: 0.0, arm.omega: 0.0})
    return lambda scene: load(model, scene, folder=workshop)


def turn(phi: float, omega: float, torque: float, h: float) -> tuple[float, float]:
    """The arm under a constant torque over the time h."""
    a = torque / INERTIA
    return phi + omega * h + a * h * h / 2, omega + a * h


def pid(count: int) -> np.ndarray:
    """Angle, speed, torque and sum at the samples, (count, 4)."""
    phi = omega = total = 0.0
    rows = []
    for _ in range(count):
        total = float(np.clip(total + PERIOD * (1 - phi), -0.5, 0.5))
        u = float(np.clip(KP * (1 - phi) + KI * total - KD * omega, -5, 5))
        rows.append((phi, omega, u, total))
        phi, omega = turn(phi, omega, u, PERIOD)
    return np.array(rows)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5", "bdf"])
def test_pid_with_saturation(
    servo: Callable[[str], Machine], method: str, formulation: str
) -> None:
    t = PERIOD * np.arange(200)
    r = servo("pid").simulate(2.0, t, method=method, formulation=formulation, rtol=1e-9)
    assert r.outcome is Outcome.OK
    names = ("u", "sum")
    got = np.column_stack([r.q("arm.phi"), r.v("arm.omega"), *map(r.y, names)])
    assert_allclose(got, pid(200), atol=1e-9)


def test_a_delay_of_several_periods(servo: Callable[[str], Machine]) -> None:
    step, count = PERIOD / 2, 400
    phi = omega = u = 0.0
    waiting, rows = [], []
    for k in range(count):
        if k % 2 and k >= 5:
            u = waiting[(k - 5) // 2]
        if k % 2 == 0:
            waiting.append(float(np.clip(KP / 4 * (1 - phi) - KD / 4 * omega, -5, 5)))
        rows.append((phi, omega, u))
        phi, omega = turn(phi, omega, u, step)
    r = servo("late").simulate(2.0, step * np.arange(count), rtol=1e-10)
    got = np.column_stack([r.q("arm.phi"), r.v("arm.omega"), r.y("u_late")])
    assert_allclose(got, rows, atol=1e-9)


def test_values_keep_between_samples(servo: Callable[[str], Machine]) -> None:
    t = np.linspace(0.0, 0.0999, 1000)
    r = servo("pid").simulate(0.1, t, rtol=1e-10)
    place = np.floor(t / PERIOD + 1e-9).astype(int)
    assert_allclose(r.y("u"), pid(10)[place, 2], atol=1e-12)


def test_a_function_of_ones_own(servo: Callable[[str], Machine]) -> None:
    calls = []

    def control(sample: object) -> float:
        calls.append(sample.t)  # type: ignore[attr-defined]
        q, v = sample.q("arm.phi"), sample.v("arm.phi")  # type: ignore[attr-defined]
        assert sample.y("u_own") == (0.0 if not seen else seen[-1])  # type: ignore[attr-defined]
        seen.append(float(np.clip(10 * (1 - q) - v, -5, 5)))
        return seen[-1]

    seen: list[float] = []
    r = servo("own").simulate(1.0, controllers={"u_own": control}, rtol=1e-10)
    assert_allclose(calls, 0.01 * np.arange(101), atol=1e-12)
    phi = omega = 0.0
    for u in seen[:-1]:
        phi, omega = turn(phi, omega, u, 0.01)
    assert_allclose([r.q("arm.phi")[-1], r.v("arm.omega")[-1]], [phi, omega], atol=1e-9)
    # A run that is taken again does not ask again, since a function may have a memory.
    assert r.at(r.t[::-1]).samples.v.tolist() == r.samples.v[::-1].tolist()
    assert len(calls) == 101
    r.resume(1.2)
    assert_allclose(calls, 0.01 * np.arange(121), atol=1e-12)


def test_controllers_are_asked_for_by_name(servo: Callable[[str], Machine]) -> None:
    with pytest.raises(InputError, match="'u_own' has no expression"):
        servo("own").simulate(1.0)
    with pytest.raises(InputError, match="sampled value without an expression 'u'"):
        servo("pid").simulate(1.0, controllers={"u": lambda sample: 0.0})
    with pytest.raises(InputError, match=r"u_own.*reduced"):
        servo("own").simulate(1.0, controllers={"u_own": lambda sample: 0.0}, formulation="reduced")
    with pytest.raises(ZeroDivisionError):
        servo("own").simulate(1.0, controllers={"u_own": lambda sample: 1 / 0})


def test_the_period_is_a_parameter_like_others(servo: Callable[[str], Machine]) -> None:
    few = servo("pid").simulate(1.0, [1.0], parameters={"period": 0.05})
    assert few.stats["steps"] < 60
    with pytest.raises(InputError, match=r"period is -0\.01 s"):
        servo("pid").simulate(1.0, parameters={"period": -0.01})


@pytest.fixture(scope="module")
def counter(workshop: Path) -> Callable[[str], Machine]:
    """A sum of 1 a sample, a value that reads it with a delay, and a push that does work."""
    model = Model("counter_sampled")
    delay = model.parameter("delay", 0.0, "s")
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    early = model.sampled("early", 0.1, lambda n: n + 1, delay=delay)
    sum_ = model.sampled("count", 0.1, lambda n: n + 1)
    reads = model.sampled("reads", 0.1, early)
    own = model.sampled("own", 0.1, unit="N")
    compiled = model.sampled("compiled", 0.1, 1 + mass.x, unit="N")
    start = {mass.x: 0.0, mass.vx: 0.0}
    model.force("push_own", mass, fx=own)
    model.force("push_compiled", mass, fx=compiled)
    model.scene("counts", [early, sum_, reads], start=start)
    for name in ("own", "compiled"):
        model.scene(name, [f"push_{name}"], start=start, outputs=["default", f"work(push_{name})"])
    return lambda scene: load(model, scene, folder=workshop)


def test_a_delay_that_is_a_parameter_of_value_0(counter: Callable[[str], Machine]) -> None:
    """Values of one instant read it as they read one without a delay, and else as it was."""
    now = counter("counts").simulate(0.57, [0.57])
    assert_allclose(now.y("reads"), now.y("early"), rtol=1e-15)
    late = counter("counts").simulate(0.57, [0.57], parameters={"delay": 0.05})
    assert_allclose(late.y("reads"), late.y("early") - 1, rtol=1e-15)


@pytest.mark.parametrize("instants", [[0.2, 0.3, 1.0], [0.25, 1.0]])
def test_a_sample_is_taken_once_where_a_run_starts_from_another(
    counter: Callable[[str], Machine], instants: list[float]
) -> None:
    """At 0, 0.1 … 1.0 s the sum is renewed, whether a run stops within, at one or before one."""
    machine = counter("counts")
    whole = machine.simulate(1.0, instants)
    assert whole.y("count")[-1] == 11
    for state in (whole.state(0.2), whole.state(0.3), whole.state(0.25), whole.state(0.0)):
        assert machine.simulate(1.0, [1.0], start=state).y("count") == 11
    for end in (0.2, 0.3, 0.25):
        first = machine.simulate(end)
        assert first.y("count")[-1] == 1 + np.floor(10 * end + 1e-9)
        assert machine.simulate(1.0, [1.0], start=first).y("count") == 11


@pytest.mark.parametrize("end", [0.3, 0.7, 1.0])  # 3 periods of 0.1 s end behind 0.3 s
@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_the_last_row_is_that_of_a_longer_run(
    counter: Callable[[str], Machine], tmp_path: Path, method: str, end: float
) -> None:
    machine = counter("counts")
    short, longer = (machine.simulate(x, [end / 2, end], method=method) for x in (end, 2 * end))
    assert short.y("count").tolist() == longer.y("count").tolist()
    assert short.a("mass.x")[-1] == pytest.approx(longer.a("mass.x")[-1])
    assert machine.simulate(end, "steps", method=method).y("count")[-1] == short.y("count")[-1]
    kept = load_result(short.save(tmp_path / "short.nc"), machine)
    further = machine.simulate(2 * end, [2 * end])
    for one in short, kept:
        assert one.at(end).y("count") == short.y("count")[-1]
        assert one.resume(2 * end, [2 * end]).y("count") == further.y("count")


def test_rows_of_a_run_whose_works_are_asked_for(counter: Callable[[str], Machine]) -> None:
    """An instant that rounding puts before a sample has the value of that sample, as without."""
    instants = np.linspace(0.0, 0.7, 8)
    pushed = counter("own").simulate(0.7, instants, controllers={"own": lambda sample: sample.t})
    np.testing.assert_allclose(pushed.y("own"), instants)


@pytest.mark.parametrize("delay", [0.05, 0.33])
@pytest.mark.parametrize("instant", [0.52, 0.5, 0.55, 0.6, 0.0])
def test_samples_that_wait_go_on_from_a_state(
    counter: Callable[[str], Machine], tmp_path: Path, instant: float, delay: float
) -> None:
    machine, given = counter("counts"), {"parameters": {"delay": delay}}
    later = [t for t in (0.53, 0.58, 0.61, 0.66, 0.83, 1.0) if t > instant]
    whole = machine.simulate(1.0, np.union1d(later, [instant]), **given)
    ended = machine.simulate(instant, **given) if instant else whole
    kept = load_result(whole.save(tmp_path / "whole.nc"), machine)
    states = [whole.state(instant), kept.state(instant)] + [ended.state()] * (instant > 0)
    for state in states:
        again = machine.simulate(1.0, later, start=state, **given)
        for name in ("early", "count", "reads"):
            assert again.y(name).tolist() == whole.at(later).y(name).tolist(), (name, instant)
        assert "wait for their delay" not in again.message
    if delay < 0.1:  # the states of later instants have theirs as well
        then = again.state(0.96)
        assert machine.simulate(1.0, [1.0], start=then, **given).y("early") == whole.y("early")[-1]


def test_samples_that_a_start_does_not_know_are_named(counter: Callable[[str], Machine]) -> None:
    machine, given = counter("counts"), {"parameters": {"delay": 0.05}}
    state = machine.simulate(0.52, **given).state()
    plain = State(state.t, state.q, state.v, state.coordinates)
    for start, other in ((plain, 0.05), (state, 0.06)):
        again = machine.simulate(1.0, start=start, parameters={"delay": other})
        assert "Samples of early that wait for their delay do not act" in again.message
    assert "wait for their delay" not in machine.simulate(1.0, start=plain).message


@pytest.fixture(scope="module")
def lift(workshop: Path) -> Machine:
    """A mass that rises and falls: its turns are counted, and how often it is above 1 m."""
    model = Model("lift_sampled", gravity=(0, -10))
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "x", 0.0)
    passed = model.sampled("passed", when=mass.y > 1, value=lambda n: n + 1)
    beat = model.sampled("beat", 0.25, lambda n: n + 1)
    model.force("pull", mass, fy=10 - 40 * mass.y + 1e-9 * (passed + beat))
    start = {mass.y: 2.0, mass.vy: 0.0}
    model.scene("counted", ["gravity", "pull"], start=start)
    return load(model, "counted", folder=workshop)


def test_a_condition_begins_to_hold_once(lift: Machine, tmp_path: Path) -> None:
    """y = 2 cos(2 √10 t): it is above 1 m from the start until t = 0.166 s, and from 0.83 s on."""
    whole = lift.simulate(2.2, [0.1, 0.9, 1.0, 2.2])
    assert whole.y("passed").tolist() == [1, 2, 2, 3]
    kept = load_result(whole.save(tmp_path / "lift.nc"), lift)
    for state in (whole.state(0.1), whole.state(0.9), kept.state(1.0), lift.simulate(1.0).state()):
        again = lift.simulate(2.2, [2.2], start=state)
        assert again.y("passed")[-1] == 3
    for result in (whole, kept):
        assert lift.simulate(2.5, [2.2], start=result).y("passed")[0] == 3
    values = {"mass.y": 2.0, "passed": 4.0}  # a start by values begins anew
    assert lift.simulate(0.1, [0.1], start=values).y("passed")[0] == 5


@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_a_row_at_an_event_is_what_follows_it(method: str, workshop: Path) -> None:
    """As the last row of a run that ends there: values, latches and the forces under them."""
    model = Model("passing")
    cart = model.particle("cart", mass=1.0)
    model.absolute("rail", cart, "y", 0.0)
    n = model.sampled("n", when=cart.x > 0.5, value=lambda n: n + 1)
    passed = model.latch("passed", when=cart.x > 0.5)
    model.force("push", cart, fx=2.0 * n, when=passed)
    model.force("drag", cart, fx=-0.5, when=cart.x > 0.5)
    model.scene("run", ["push", "drag"], start={cart.x: 0.0, cart.vx: 1.0})
    machine = load(model, "run", folder=workshop)
    short, long = machine.simulate(0.5, 6, method=method), machine.simulate(1.0, 11, method=method)
    for r, row in (short, -1), (long, 5):
        assert (r.y("n")[row], r.y("passed")[row]) == (1.0, 1.0)
        assert_allclose(r.a("cart.x")[row], 1.5)
    assert_allclose(short.resume(1.0).q("cart.x")[-1], 1.0 + 0.1875, rtol=1e-9)


def test_ends_of_steps_show_renewed_values(lift: Machine) -> None:
    for method in ("dop853", "bdf"):
        r = lift.simulate(1.1, "steps", method=method)
        ticks = [t for t in r.t if abs(4 * t - round(4 * t)) < 1e-12]
        assert np.round(ticks, 9).tolist() == [0, 0.25, 0.5, 0.75, 1]
        beats = r.y("beat")[np.isin(r.t, ticks)].tolist()
        assert beats == [1, 2, 3, 4, 5] == lift.simulate(1.1, ticks).y("beat").tolist()


def test_the_end_of_a_run_is_where_another_starts(counter: Callable[[str], Machine]) -> None:
    whole = counter("counts").simulate(1.0, [0.5])
    assert (whole.state().t, whole.state()["count"]) == (1.0, 11.0)
    assert counter("counts").simulate(2.0, start=whole).t[0] == 1.0
    assert whole.at(0.3).state().t == 0.3


def test_works_show_renewed_values_whoever_computes_them(counter: Callable[[str], Machine]) -> None:
    t = 0.1 * np.arange(11)
    law = {"own": lambda sample: 1 + sample.q("mass.x")}
    own = counter("own").simulate(1.0, t, controllers=law, rtol=1e-11)
    compiled = counter("compiled").simulate(1.0, t, rtol=1e-11)
    assert_allclose(own.y("own"), compiled.y("compiled"), rtol=1e-12)
    assert_allclose(own.y("own"), 1 + own.q("mass.x"), rtol=1e-12)
    assert_allclose(own.work("push_own"), compiled.work("push_compiled"), rtol=1e-9)
    assert_allclose(own.work("push_own"), own.v("mass.vx") ** 2 / 2, rtol=1e-9, atol=1e-12)


def test_answers_of_a_function_take_no_more_room_than_some(
    counter: Callable[[str], Machine], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("runtime.dynamics.controllers._MOST_ANSWERS", 4)
    r = counter("own").simulate(1.0, controllers={"own": lambda sample: 1.0})
    (function,) = r._motion.ready.controllers.values()
    assert 0 < len(function.answers) <= 4


def test_a_scene_without_sampled_values_has_no_word_of_them(workshop: Path) -> None:
    model = Model("unsampled")
    body = model.particle("body", 1.0)
    model.sampled("u", 0.01, body.x)
    model.scene("falls", start={body.x: 0.0, body.y: 0.0, body.vx: 0.0, body.vy: 0.0})
    path = load(model, folder=workshop).mechanism.path
    text = path.read_text(encoding="utf-8")
    assert not any(word in text for word in ("SAMPLED", "STATES", "clocks", "samples"))
