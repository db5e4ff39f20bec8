"""Masses that vary: closed forms, another integrator, kinks of laws, contacts, refusals."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from sympy import Expr, Heaviside, Max, Min, Mod, Piecewise, cos, floor, sin

from codegen import Model, coordinate, t
from codegen.errors import ModelError, ParameterError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

METHODS = [(m, f) for m in ("dop853", "radau5", "bdf") for f in ("cartesian", "reduced")]
EXACT = {"rtol": 1e-12, "atol": 1e-14}
WORKS = ["default", "works"]


def car(name: str, law: object, folder: Path, **more: object) -> Machine:
    """A car on rails under a force of 50 N, into which rain falls."""
    model = Model(name)
    body = model.body("car", mass=law(model) if callable(law) else law, inertia=5.0)
    model.translational("rail", model.ground, body, axis=(1, 0))
    model.force("pull", on=body, fx=50.0)
    model.mass_flow("rain", body, velocity=(0, -9))
    model.scene("run", ["pull", "rain"], start={body.vx: 2.0}, outputs=WORKS, **more)
    return load(model, folder=folder)


def fill(model: Model) -> object:
    return model.table("fill", [0, 1, 2, 5], [100, 105, 130, 140], units=("s", "kg"))(t)


LAWS = {
    "line": 100 + 3 * t,
    "table": fill,
    "wave": 100 + 30 * sin(3 * t),
    "stops": 100 + 10 * Min(t, 2),
    "pieces": Piecewise((100, t < 1), (80 + 20 * t, t < 3), (140, True)),
    "heavy": 1e9 + 1e7 * t,
}


@pytest.mark.parametrize("law", LAWS)
def test_momentum_and_energy_of_a_car_that_fills(workshop: Path, law: str) -> None:
    r = car(f"fills_by_{law}", LAWS[law], workshop).simulate(5.0, **EXACT)
    assert r.outcome is Outcome.OK
    mass = r.q("car_matter.mass")
    assert_allclose(r.v("car.vx"), (mass[0] * 2 + 50 * r.t) / mass, rtol=1e-11)
    gain, book = r.energy() - r.energy()[0], r.work("rain") + r.work("pull")
    assert_allclose(gain, book, atol=1e-11 * r.energy().max())
    assert "impulse" not in r.message


def rope(name: str, folder: Path) -> Machine:
    """A rope that is lifted from a heap."""
    model = Model(name, gravity=(0, -9.81))
    body = model.particle("rope", mass=2.0 * coordinate("rope", "y"))
    model.absolute("line", body, "x", 0)
    model.force("hand", on=body, fy=30.0)
    model.mass_flow("heap", body, velocity=(0, 0))
    model.scene("lift", ["gravity", "hand", "heap"], start={body.y: 0.5, body.vy: 1.0})
    model.scene("rest", ["gravity", "hand", "heap"], guess={body.y: 1}, analysis="equilibrium")
    return load(model, "lift", folder=folder), load(model, "rest", folder=folder)


def test_rope_lifted_from_a_heap(workshop: Path) -> None:
    lift, rest = rope("lifted_rope", workshop)
    for method, formulation in METHODS:
        r = lift.simulate(1.5, method=method, formulation=formulation, **EXACT)
        y, v = r.q("rope.y"), r.v("rope.vy")
        first = (2 * y * v) ** 2 / 2 - 2 * (30 * y**2 / 2 - 2 * 9.81 * y**3 / 3)
        assert_allclose(first, first[0], rtol=1e-10)
    found = rest.equilibrium()
    assert_allclose(found["rope.y"], 30 / (2 * 9.81), rtol=1e-12)
    assert_allclose(found.frequencies, [np.sqrt(9.81 / found["rope.y"]) / (2 * np.pi)], rtol=1e-6)


def test_flow_that_is_a_state(workshop: Path) -> None:
    """ṁ = -k m of a valve: the mass is that at the start, and the integral of its flow."""
    model = Model("valve")
    flow = model.state("flow", rate=lambda flow: -0.5 * flow, start=-5.0, unit="kg/s")
    body = model.particle("tank", mass=10 + flow.coordinate)
    model.mass_flow("leak", body, relative=(-3, 0))
    model.scene("run", ["leak"], start={body.vx: 0.0})
    machine = load(model, folder=workshop)
    for method, formulation in METHODS:
        r = machine.simulate(2.0, method=method, formulation=formulation, **EXACT)
        assert_allclose(r.q("tank_matter.mass"), 10 * np.exp(-0.5 * r.t), rtol=1e-11)
        assert_allclose(r.v("tank.vx"), 3 * 0.5 * r.t, atol=1e-11)  # Tsiolkovsky's equation


# -- a slider-crank whose slider's mass varies -------------------------------------------------


@pytest.fixture(scope="module")
def crank(workshop: Path) -> tuple[Machine, Machine]:
    """Free, and driven at 12 rad/s."""
    model = Model("crank_with_a_varying_slider", gravity=(0, -9.81))
    crank = model.body("crank", mass=2.0, inertia=0.02)
    rod = model.body("rod", mass=0.5, inertia=0.01)
    slider = model.body("slider", mass=1.5 + sin(3 * t) / 2, inertia=0.01)
    model.revolute("O", model.ground, crank)
    model.revolute("A", crank.at(0.1, 0), rod.at(-0.2, 0))
    model.revolute("B", rod.at(0.2, 0), slider)
    model.translational("guide", model.ground, slider, axis=(1, 0))
    model.mass_flow("first", slider.at(0.03, 0), relative=(0.7, -0.4), share=0.3)
    model.mass_flow("second", slider, relative=(0.7, 0.9), share=0.7)
    model.driver("motor", crank.phi, 0.3 + 12 * t)
    acting, near = ["gravity", "first", "second"], {rod.x: 0.3, slider.x: 0.5}
    start = {crank.phi: 0.3, crank.omega: 12.0}
    model.scene("free", acting, start=start, guess=near, outputs=WORKS)
    model.scene("driven", acting, ["motor"], guess=near)
    return load(model, "free", folder=workshop), load(model, "driven", folder=workshop)


def terms(t: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """J, C and Q of J φ̈ + C φ̇² = Q, derived by hand."""
    a, length = 0.1, 0.4
    s, c = np.sin(phi), np.cos(phi)
    sine = a * s / length
    cosine = np.sqrt(1 - sine**2)
    b = a * c / (length * cosine)
    bb = (-a * s / length + sine * b**2) / cosine
    rod = np.array([-a * s - length / 2 * sine * b, a * c - length / 2 * cosine * b])
    bend = np.array([cosine * b**2 + sine * bb, -sine * b**2 + cosine * bb])
    rod_2 = np.array([-a * c, -a * s]) - length / 2 * bend
    slider, slider_2 = -a * s - length * sine * b, -a * c - length * bend[0]
    mass, flow = 1.5 + np.sin(3 * t) / 2, 1.5 * np.cos(3 * t)
    inertia = 0.02 + 0.5 * (rod**2).sum(axis=0) + 0.01 * b**2 + mass * slider**2
    bends = 0.5 * (rod * rod_2).sum(axis=0) + 0.01 * b * bb + mass * slider * slider_2
    return inertia, bends, -0.5 * 9.81 * rod[1] + flow * 0.7 * slider


@pytest.mark.parametrize(("method", "formulation"), METHODS)
def test_crank_beside_another_integrator(
    crank: tuple[Machine, Machine], method: str, formulation: str
) -> None:
    def rates(t: float, y: np.ndarray) -> list[float]:
        inertia, bends, force = terms(t, y[0])
        return [y[1], (force - bends * y[1] ** 2) / inertia]

    r = crank[0].simulate(1.0, method=method, formulation=formulation, **EXACT)
    other = solve_ivp(rates, (0, 1), [0.3, 12.0], "DOP853", r.t, rtol=1e-13, atol=1e-14).y
    assert_allclose(r.q("crank.phi"), other[0], atol=1e-10)
    assert_allclose(r.v("crank.omega"), other[1], rtol=1e-10)
    book = r.work("first") + r.work("second")
    assert_allclose(r.energy() - r.energy()[0], book, atol=1e-10)


@pytest.mark.parametrize(
    ("law", "flow"),
    [(5 + Min(t, 1), 1), (Max(2, 5 - 3 * t), -3), (Piecewise((4 + t, t < 1), (5, True)), 0)],
)
def test_one_side_of_a_kink_holds_for_velocity_force_and_torque(
    workshop: Path, law: Expr, flow: float
) -> None:
    """φ = sin t of a driven arm, at the instant of a kink; either side is right, not both."""
    model = Model(f"driven_by_{abs(flow)}", gravity=(0, -9.81))
    arm = model.body("arm", mass=law, inertia=0.3)
    model.revolute("pin", model.ground, arm.at(-0.4, 0))
    model.driver("turn", arm.phi, sin(t))
    model.mass_flow("feed", arm.at(0.2, 0), velocity=(1, 1))
    model.scene("run", ["gravity", "feed"], ["turn"], outputs=["default", "forces"])
    machine, at, mass = load(model, folder=workshop), [0.5, 1.0, 1.5], float(law.subs(t, 1))
    phi, omega, alpha = np.sin(1), np.cos(1), -np.sin(1)
    x, y = 0.6 * np.cos(phi), 0.6 * np.sin(phi)
    torque = (0.3 + mass * 0.16) * alpha + mass * 9.81 * 0.4 * np.cos(phi)
    torque -= flow * (x * (1 - omega * x) - y * (1 + omega * y))
    for r in machine.inverse_dynamics(at), machine.simulate(2.0, at):
        assert_allclose(r.v("arm_matter.mass")[1], flow, atol=1e-12)
        assert_allclose(r["feed.rate"][1], flow, atol=1e-12)
        assert_allclose(r.reaction("turn", "torque")[1], torque, rtol=1e-12)


def test_thrust_at_rest(workshop: Path) -> None:
    """A tank on a spring: k (y0 - y) = m g + ṁ u, ṁ = t y by its law at each position."""
    model = Model("tank_on_a_spring", gravity=(0, -9.81))
    tank = model.particle("tank", mass=5 + t**2 / 2 * coordinate("tank", "y"))
    model.absolute("guide", tank, "x", 0)
    model.spring("hold", model.ground.at(0, 2), tank, 100.0, free_length=1.0)
    model.mass_flow("jet", tank, relative=(0, -3))
    for analysis in "dynamics", "equilibrium":
        model.scene(analysis, ["gravity", "hold", "jet"], guess={tank.y: 0.4}, analysis=analysis)
        y = load(model, analysis, folder=workshop).equilibrium(t=2.0)["tank.y"]
        assert_allclose(y, (100 - 9.81 * 5) / (100 + 9.81 * 2 + 3 * 2), rtol=1e-11)


@pytest.mark.parametrize("law", [5 + Heaviside(t - 1), 5 + floor(t), 6 - Mod(t, 1)])
def test_steps_of_laws_end_runs(workshop: Path, law: Expr) -> None:
    r = car(f"steps_by_{law.func.__name__}_{len(str(law))}", law, workshop).simulate(2.0)
    assert r.outcome is Outcome.DISCONTINUOUS
    assert "'car_matter' jumps by 1 at t = 1 s" in r.message


def test_inverse_dynamics_of_the_crank(crank: tuple[Machine, Machine]) -> None:
    r = crank[1].inverse_dynamics(np.linspace(0, 2, 21))
    _, bends, force = terms(r.t, 0.3 + 12 * r.t)
    assert_allclose(r.reaction("motor", "torque"), bends * 144 - force, atol=1e-12)


# -- contacts, ends and refusals ---------------------------------------------------------------


def test_rate_that_jumps_on_a_closed_contact(workshop: Path) -> None:
    """The mass of a box that lies on a floor stops to grow, and no impact comes of it."""
    model = Model("box_that_fills", gravity=(0, -9.81))
    box = model.particle("box", mass=10 + Min(t, 1))
    model.contact("floor", model.ground, box, direction=(0, 1), restitution=0)
    model.mass_flow("sand", box, relative=(0, 0))
    start = {box.x: 0.0, box.y: 0.0, box.vx: 1.0, box.vy: 0.0}
    model.scene("run", ["gravity", "floor", "sand"], start=start, outputs=["default", "forces"])
    r = load(model, folder=workshop).simulate(2.0)
    assert r.outcome is Outcome.OK
    assert_allclose(r.q("box.y"), 0.0, atol=1e-12)
    assert_allclose(r.force("floor"), 9.81 * np.minimum(10 + r.t, 11), rtol=1e-9)


def test_impacts_take_the_masses_of_their_instant(workshop: Path) -> None:
    """A particle of 2 kg, as it is after a second, stops as it strikes another one of 2 kg."""
    model = Model("grows_and_strikes")
    one, other = model.particle("one", mass=1 + t), model.particle("other", mass=2.0)
    model.contact("strike", one, other, direction=(1, 0), restitution=1)
    model.mass_flow("dust", one, relative=(0, 0))
    start = {one.x: 0.0, one.vx: 1.0, other.x: 1.0, other.vx: 0.0}
    model.scene("run", ["strike", "dust"], start=start)
    r = load(model, folder=workshop).simulate(2.0)
    assert_allclose([r.v("one.vx")[-1], r.v("other.vx")[-1]], [0.0, 1.0], atol=1e-9)


@pytest.mark.parametrize("method", ["dop853", "radau5"])
def test_a_run_ends_before_a_mass_vanishes(workshop: Path, method: str) -> None:
    r = car("empties", 100 - 30 * t, workshop).simulate(5.0, method=method)
    assert r.ended_by == "car_exhausted"
    assert_allclose(r.t[-1], 10 / 3, atol=1e-8)
    assert np.isfinite(r.v("car.vx")).all()


def test_masses_that_are_not_positive_are_refused(workshop: Path) -> None:
    machine = car("begins_below_zero", 3 * t - 1, workshop)
    with pytest.raises(ParameterError, match=r"car_matter.mass is -1 kg at t = 0 s; it must be"):
        machine.simulate(1.0)
    r = machine.simulate(1.0, t_start=0.5)
    assert_allclose(r.v("car.vx")[-1], (2 * 0.5 + 50 * 0.5) / 2, rtol=1e-9)


def test_a_law_that_jumps_ends_the_run(workshop: Path) -> None:
    r = car("jumps", Piecewise((100, t < 1), (110, True)), workshop).simulate(2.0)
    assert r.outcome is Outcome.DISCONTINUOUS
    assert "'car_matter' jumps by 10 at t = 1 s" in r.message


def test_shares_that_vary_add_up_to_one(workshop: Path) -> None:
    model = Model("two_flows")
    body = model.body("tank", mass=10 + t, inertia=1.0)
    model.mass_flow("one", body, velocity=(0, 0), share=cos(body.phi) ** 2)
    model.mass_flow("other", body, velocity=(0, 0), share=sin(body.phi) ** 2)
    model.scene("run", ["one", "other"], start={body.vx: 1.0, body.omega: 2.0})
    r = load(model, folder=workshop).simulate(5.0, **EXACT)
    assert_allclose(r.v("tank.vx"), 10 / (10 + r.t), rtol=1e-11)


def test_shares_add_up_to_one(workshop: Path) -> None:
    model = Model("half_a_flow")
    body = model.particle("tank", mass=10 + t)
    model.mass_flow("leak", body, relative=(0, 0), share=0.5)
    model.scene("run", ["leak"])
    with pytest.raises(ModelError, match=r"of its mass flows that act add up to 0\.5"):
        load(model, folder=workshop)
