"""Stops and clearances: forces by hand, motions in closed form or by an independent solution."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from codegen import Model
from runtime import Outcome, Result, load
from runtime.mechanism.series_table import quantity_of
from runtime.mechanism.table_rows import ReactionRow
from tests.codegen.elements.test_library_forces import (
    S_I,
    S_J,
    SEEDS,
    balanced,
    ends,
    momenta,
    pair,
    slopes_agree,
)
from tests.codegen.workbench import A, Interpreted

TOLERANCE = {"rtol": 1e-10, "atol": 1e-11}


def simulated(model: Model, folder: Path, t_end: float = 2.0, **more: float) -> Result:
    instants = np.linspace(0, t_end, 101)
    given = {"rtol": 1e-11, "atol": 1e-12} | more
    run = load(model, folder=folder).simulate(t_end, instants, **given)
    assert run.outcome is Outcome.OK, run.message
    return run


# -- stops ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("speed", [-0.3, 0.1, 2.0])
@pytest.mark.parametrize("angle", [-0.7, 0.2, 1.3])
def test_stop_of_an_angle_by_hand(angle: float, speed: float) -> None:
    model, first, second = pair()
    pin = model.revolute("pin", first.at(*S_I), second.at(*S_J))
    model.stop("limit", pin, lower=-0.5, upper=1.0, stiffness=30.0, damping=4.0)
    machine = Interpreted(model)
    s = machine.state(2)
    s.q[5], s.v[5] = s.q[2] + angle, s.v[2] + speed
    beyond = angle - 1.0 if angle > 1.0 else angle + 0.5 if angle < -0.5 else 0.0
    torque = (30 * beyond + 4 * speed) if beyond else 0.0
    torque = max(torque, 0.0) if beyond > 0 else min(torque, 0.0)
    modes = [int(g > 0) for g in machine.vector("switching", s)]
    found = machine.vector("applied_forces", s, modes=modes)
    assert_allclose(found, [0, 0, torque, 0, 0, -torque], **TOLERANCE)
    stored = machine.vector("potential", s, modes=modes)
    assert_allclose(stored, 15 * beyond**2, **TOLERANCE)
    slopes_agree(machine, s, modes=modes)
    balanced(machine, s, modes=modes)


@pytest.mark.parametrize("kind", ["translational", "revolute_translational", "expression"])
def test_stop_of_a_travel_by_hand(kind: str) -> None:
    model, first, second = pair()
    places = first.at(*S_I), second.at(*S_J)
    if kind == "expression":
        bar = model.spring("bar", *places, damping=1.0)
        of = bar.length
    else:
        of = getattr(model, kind)("guide", *places, axis=(3, 4))
    model.stop("limit", of, upper=-10.0, stiffness=30.0)
    model.scene("alone", ["limit"])
    machine = Interpreted(model, "alone")
    for seed in SEEDS:
        s = machine.state(seed)
        (d, _), (_, phi, _, _) = ends(s), s.body(0)
        travel = np.linalg.norm(d) if kind == "expression" else A(phi) @ [0.6, 0.8] @ d
        assert_allclose(machine.vector("potential", s), 15 * (travel + 10) ** 2, **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-10)


@pytest.mark.parametrize("law", [{"stiffness": 50.0}, {"restitution": 0.0}])
@pytest.mark.parametrize(
    ("of", "quantity", "units"),
    [
        ("angle", "torque", ("rad/s", "N m")), ("length", "force", ("m/s", "N")),
        ("twice", "force", ("1/s", "")),
    ],
)  # fmt: skip
def test_stop_of_an_expression_has_its_force(
    of: str, quantity: str, units: tuple[str, str], law: dict[str, float]
) -> None:
    """With the unit that follows from the coordinates, and without one where none does."""
    model, first, second = pair()
    s = {
        "angle": second.phi - first.phi, "length": second.x - first.x,
        "twice": 2 * (second.phi - first.phi),
    }[of]  # fmt: skip
    model.stop("limit", s, lower=-0.5, upper=0.5, **law)
    model.scene("run", ["limit"], outputs=[f"{quantity}(limit)", "rates"])
    rows = [ReactionRow(*row) for row in Interpreted(model).lowered.description.reactions]
    sides = 1 if "restitution" in law else 2
    assert sorted((quantity_of(row), row.unit) for row in rows) == sorted(
        [("rate", units[0]), (quantity, units[1])] * sides
    )


def test_slider_between_stops_that_yield(tmp_path: Path) -> None:
    """Free over 2 L, then half a swing at a stop, in closed form; the energy is kept."""
    model = Model("slider")
    body = model.body("body", mass=2.0, inertia=1.0)
    guide = model.translational("guide", model.ground, body, axis=(1, 0))
    model.stop("ends", guide, lower=-0.1, upper=0.1, stiffness=800.0)
    model.scene("run", ["ends"], start={body.x: 0.0, body.vx: 0.5})
    run = simulated(model, tmp_path)
    frequency = np.sqrt(800.0 / 2.0)
    free, half = 0.2 / 0.5, np.pi / frequency
    time = (run.t + free / 2) % (2 * (free + half))
    sign = np.where(time < free + half, 1.0, -1.0)
    time = time % (free + half)
    beyond = 0.1 + 0.5 / frequency * np.sin(frequency * (time - free))
    expected = sign * np.where(time < free, -0.1 + 0.5 * time, beyond)
    assert_allclose(run.q("body.x"), expected, atol=1e-8)
    assert_allclose(run.energy(), run.energy()[0], rtol=1e-9)


def test_damped_stop_lets_go_where_its_damper_would_hold(tmp_path: Path) -> None:
    """The contact ends at k s + c ṡ = 0, before s = 0; the speed there is that of the rebound."""
    model = Model("rebound")
    wheel = model.body("wheel", mass=1.0, inertia=0.5)
    pin = model.revolute("pin", model.ground.at(0, 0), wheel)
    model.stop("limit", pin, upper=0.0, stiffness=200.0, damping=6.0)
    model.scene("run", ["limit"], start={wheel.phi: -0.1, wheel.omega: 1.0})
    run = simulated(model, tmp_path, 1.0)
    decay, frequency = 6.0 / (2 * 0.5), np.sqrt(200 / 0.5 - (6.0 / (2 * 0.5)) ** 2)

    def depth(time: float) -> tuple[float, float]:
        s, c = np.sin(frequency * time), np.cos(frequency * time)
        shrunk = np.exp(-decay * time) / frequency
        return shrunk * s, shrunk * (frequency * c - decay * s)

    ended = brentq(
        lambda time: 200 * depth(time)[0] + 6 * depth(time)[1],
        0.5 * np.pi / frequency, np.pi / frequency, xtol=1e-14,
    )  # fmt: skip
    place, speed = depth(ended)
    assert speed < 0 < place
    later = run.t > 0.1 + ended
    assert_allclose(run.v("wheel.phi")[later], speed, rtol=1e-9)
    expected = place + speed * (run.t[later] - 0.1 - ended)
    assert_allclose(run.q("wheel.phi")[later], expected, atol=1e-9)


@pytest.mark.parametrize("restitution", [1.0, 0.5])
def test_slider_between_rigid_stops(tmp_path: Path, restitution: float) -> None:
    """Each impact leaves e of the speed; the times of the n-th are a geometric series."""
    model = Model("rigid")
    body = model.body("body", mass=2.0, inertia=1.0)
    guide = model.translational("guide", model.ground, body, axis=(1, 0))
    model.stop("ends", guide, lower=-0.1, upper=0.3, restitution=restitution)
    model.scene("run", ["ends"], start={body.x: 0.0, body.vx: 1.0})
    run = simulated(model, tmp_path, 2.5)
    time, place, speed = 0.0, 0.0, 1.0
    expected = np.zeros_like(run.t)
    while time < run.t[-1]:
        here = run.t >= time
        expected[here] = place + speed * (run.t[here] - time)
        limit = 0.3 if speed > 0 else -0.1
        time += (limit - place) / speed
        place, speed = limit, -restitution * speed
    assert_allclose(run.q("body.x"), expected, atol=1e-9)


def test_pendulum_rests_on_a_rigid_stop(tmp_path: Path) -> None:
    """It falls on a stop of its angle without rebound, and the stop bears its moment."""
    model = Model("rest", gravity=(0, -9.81))
    bar = model.body("bar", mass=2.0, inertia=0.4)
    pin = model.revolute("pin", model.ground.at(0, 0), bar.at(-1, 0))
    model.stop("rest", pin, lower=-0.6, upper=2.0, restitution=0.0)
    start = {bar.phi: 0.0, bar.omega: 0.0}
    asked = ["torque(rest)", "gap(rest)", "rate(rest)"]
    model.scene("run", ["gravity", "rest"], start=start, guess={bar.x: 1.0}, outputs=asked)
    run = simulated(model, tmp_path)
    assert_allclose(run.q("bar.phi")[-1], -0.6, atol=1e-10)
    moment = 2 * 9.81 * np.cos(0.6)  # of the weight, 1 m from the pin
    assert_allclose(run.torque("rest")[-1], moment, rtol=1e-8)
    units = {row.name: row.unit for row in run.description.reactions}
    assert units == {"rest.torque": "N m", "rest.gap": "rad", "rest.rate": "rad/s"}


# -- clearance ------------------------------------------------------------------------------------


def rubbing(**given: float) -> tuple[Model, Interpreted]:
    model, first, second = pair()
    numbers = {"damping": 0.3, "coefficient": 0.2, "creep": 0.5, "radius": 0.7} | given
    model.clearance_joint("pin", first.at(*S_I), second.at(*S_J), 0.4, 50.0, **numbers)
    return model, Interpreted(model)


def test_clearance_joint_by_hand() -> None:
    """The normal force and the friction at the contact, on both bodies."""
    _, machine = rubbing()
    for seed in SEEDS:
        s = machine.state(seed)
        d, v = ends(s)
        e = np.linalg.norm(d)
        n = d / e
        across = np.array([-n[1], n[0]])
        push = 50.0 * (e - 0.4) ** 1.5 * (1 + 0.3 * (n @ v))
        slip = across @ v + 0.7 * s.v[5] - (e + 0.7) * s.v[2]
        on_j = -push * n - 0.2 * push * np.tanh(slip / 0.5) * across
        contact = s.q[3:5] + A(s.q[5]) @ S_J + 0.7 * n
        expected = []
        for k, force in ((0, -on_j), (3, on_j)):
            arm = contact - s.q[k : k + 2]
            expected += [*force, arm[0] * force[1] - arm[1] * force[0]]
        assert machine.vector("switching", s)[0] > 0
        assert_allclose(machine.vector("applied_forces", s), expected, **TOLERANCE)
        assert_allclose(momenta(machine, s), np.zeros(3), atol=1e-9)
        balanced(machine, s)
        assert_allclose(machine.vector("applied_forces", s, modes=[0]), np.zeros(6), atol=0)


@pytest.mark.parametrize("method", ["dop853", "bdf"])
def test_nothing_is_undefined_where_the_centres_coincide(tmp_path: Path, method: str) -> None:
    """At e = 0 the direction of the eccentricity is 0/0: at rest there, and on the way through."""
    model = Model("centre")
    shaft, other = (model.body(n, mass=1.0, inertia=2e-3) for n in ("shaft", "other"))
    for name, body in (("pin", shaft), ("axle", other)):
        model.clearance_joint(name, model.ground, body, 2e-3, 1e5, damping=2.0, coefficient=0.3,
                              creep=0.01, radius=0.02)  # fmt: skip
    zero = dict.fromkeys((*shaft.coordinates, *other.coordinates), 0.0)
    start = zero | {q.rate: 0.0 for q in zero} | {shaft.omega: 5.0, other.vx: 0.01}
    model.scene("run", ["pin", "axle"], start=start)
    instants = np.linspace(0, 0.1, 3)
    run = load(model, folder=tmp_path).simulate(0.1, instants, method=method, rtol=1e-9)
    assert run.outcome is Outcome.OK, run.message
    assert_allclose(run.q("shaft.phi"), 5.0 * run.t, rtol=1e-8)
    assert_allclose(run.q("other.x"), 0.01 * run.t, rtol=1e-8)
    for name in ("pin", "axle"):
        assert_allclose(run.power(name), 0.0, atol=0)
    assert_allclose(run.a("shaft.x"), 0.0, atol=0)
    assert np.isfinite(run.energy()).all()


def test_journal_bounces_through_the_centre_of_its_bearing(tmp_path: Path) -> None:
    """It starts where the eccentricity is 0; its depth follows from the energy of its speed."""
    model = Model("bounce")
    journal = model.particle("journal", mass=0.5)
    model.clearance_joint("pin", model.ground, journal, 1e-3, 1e7)
    start = {journal.x: 0.0, journal.y: 0.0, journal.vx: 0.06, journal.vy: 0.08}
    asked = ["energy", "default", "length(pin)", "gap(pin)", "penetration(pin)", "force(pin)"]
    model.scene("run", ["pin"], start=start, outputs=asked)
    run = simulated(model, tmp_path, 0.1, atol=1e-14)
    along = 0.6 * run.q("journal.x") + 0.8 * run.q("journal.y")
    assert_allclose(0.8 * run.q("journal.x") - 0.6 * run.q("journal.y"), 0, atol=1e-12)
    exchanged = 1e7 * np.maximum(np.abs(along) - 1e-3, 0.0) ** 2.5 / 2.5
    assert exchanged.max() > 1e-4
    assert_allclose(run.energy() + exchanged, run.energy()[0], rtol=1e-7)

    def rates(_: float, state: np.ndarray) -> list[float]:
        x, v = state
        return [v, -np.sign(x) * 1e7 * max(abs(x) - 1e-3, 0.0) ** 1.5 / 0.5]

    assert_allclose(run.length("pin"), np.abs(along), atol=1e-12)
    assert_allclose(run.gap("pin"), 1e-3 - np.abs(along), atol=1e-12)
    depth = np.maximum(np.abs(along) - 1e-3, 0.0)
    assert_allclose(run.penetration("pin"), depth, atol=1e-12)
    assert_allclose(run.force("pin", "normal"), 1e7 * depth**1.5, rtol=1e-6, atol=1e-6)

    other = solve_ivp(rates, (0, 0.1), [0.0, 0.1], "DOP853", run.t, rtol=1e-12, atol=1e-16,
                      max_step=1e-5)  # fmt: skip
    assert_allclose(along, other.y[0], atol=1e-9)
    assert len(run.events) >= 4


def test_journal_whirls_with_friction_as_independent_equations_say(tmp_path: Path) -> None:
    model = Model("whirl", gravity=(0, -9.81))
    shaft = model.body("shaft", mass=1.0, inertia=2e-4)
    model.clearance_joint("pin", model.ground, shaft, 2e-3, 5e7, damping=2.0, coefficient=0.3,
                          creep=0.01, radius=0.02)  # fmt: skip
    start = {shaft.x: 0.0, shaft.y: 0.0, shaft.phi: 0.0}
    start |= {shaft.vx: 0.2, shaft.vy: 0.1, shaft.omega: 80.0}
    model.scene("run", ["gravity", "pin"], start=start, outputs=["default", "force(pin)"])
    run = simulated(model, tmp_path, 0.1, atol=1e-13)

    def rates(_: float, state: np.ndarray) -> list[float]:
        (x, y, _), (vx, vy, omega) = state[:3], state[3:]
        e = np.hypot(x, y)
        fx = fy = torque = 0.0
        if e > 2e-3:
            nx, ny = x / e, y / e
            push = 5e7 * (e - 2e-3) ** 1.5 * (1 + 2.0 * (nx * vx + ny * vy))
            slip = nx * vy - ny * vx + 0.02 * omega
            drag = -0.3 * push * np.tanh(slip / 0.01)
            fx, fy, torque = -push * nx - drag * ny, -push * ny + drag * nx, 0.02 * drag
        return [vx, vy, omega, fx, fy - 9.81, torque / 2e-4]

    begun = [0.0, 0.0, 0.0, 0.2, 0.1, 80.0]
    other = solve_ivp(rates, (0, 0.1), begun, "DOP853", run.t, rtol=1e-12, atol=1e-14,
                      max_step=2e-6)  # fmt: skip
    assert np.ptp(other.y[5]) > 1
    state = np.vstack([run.samples.q.T, run.samples.v.T])
    drag = [rates(0.0, column)[5] * 2e-4 / 0.02 for column in state.T]
    assert np.ptp(drag) > 1
    assert_allclose(run.force("pin", "friction"), drag, rtol=1e-7, atol=1e-7)
    assert_allclose(run.q("shaft.x"), other.y[0], atol=1e-8)
    assert_allclose(run.q("shaft.y"), other.y[1], atol=1e-8)
    assert_allclose(run.v("shaft.phi"), other.y[5], atol=1e-4)


def test_shaft_rests_at_the_depth_that_bears_it(tmp_path: Path) -> None:
    """K δ^1.5 = m g, below the centre."""
    model = Model("rest", gravity=(0, -9.81))
    shaft = model.particle("shaft", mass=3.0)
    model.clearance_joint("pin", model.ground, shaft, 1e-3, 2e6)
    model.scene("run", ["gravity", "pin"], start={shaft.x: 0.0, shaft.y: -1.05e-3})
    rest = load(model, folder=tmp_path).equilibrium()
    depth = (3.0 * 9.81 / 2e6) ** (2 / 3)
    assert_allclose(rest.q("shaft.y"), -1e-3 - depth, rtol=1e-7)
