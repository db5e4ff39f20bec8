"""Functions of the position that peak in a narrow range of it: no step passes over the peak."""

from collections.abc import Callable
from itertools import pairwise
from math import cos, pi, sqrt
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from numpy.testing import assert_allclose
from scipy.integrate import quad

from codegen import Model
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

METHODS = ("dop853", "dopri5", "bdf", "radau5")


def pulse(x: sp.Expr, at: float, width: float) -> sp.Expr:
    return sp.exp(-(((x - at) / width) ** 2))


@pytest.fixture(scope="module")
def particle(workshop: Path) -> Callable[..., Machine]:
    """A particle of 1 kg at 1 m/s along x, under a force or in a potential."""

    def loaded(name: str, force: object = None, potential: object = None) -> Machine:
        model = Model(f"narrow_{name}")
        p = model.particle("p", mass=1.0)
        model.absolute("rail", p, "y", 0.0)
        if force is not None:
            model.force("act", p, fx=force(p.x, p.vx))  # type: ignore[operator]
        if potential is not None:
            model.potential("act", potential(p.x))  # type: ignore[operator]
        model.scene("runs", ["act"], start={p.x: 0.0, p.vx: 1.0})
        return load(model, folder=workshop)

    return loaded


# Between them a quadrature sees all of the forces.
EDGES = sorted(
    at + side * 10.0**k for at in (3.0, 5.0, 7.0) for k in range(-6, 0) for side in (-1, 1)
)
FORCES: dict[str, Callable[..., sp.Expr]] = {
    "weak": lambda x: 10 * pulse(x, 5.0, 1e-3),
    "strong": lambda x: 100 * pulse(x, 5.0, 1e-2),
    "far": lambda x: 1e4 * pulse(x, 5.0, 1e-6),
    "tanh": lambda x: 0.2 * (1 - sp.tanh(((x - 5) / 1e-2) ** 2)),
    "lorentz": lambda x: 1 / (1 + ((x - 5) / 1e-3) ** 2),
    "sech": lambda x: 10 / sp.cosh((x - 5) / 2e-2) ** 2,
    "twice": lambda x: 10 * pulse(x, 3.0, 1e-3) + 10 * pulse(x, 7.0, 1e-4),
    "power": lambda x: 10 * (1 - ((x - 5) / 20) ** 2) ** 5000,
    "kink": lambda x: 10 * sp.exp(-abs(x - 5) / 1e-3),
    "beside a kink": lambda x: 10 * pulse(abs(x - 1), 4.0, 1e-3),
    "pair of steps": lambda x: sp.tanh((x - 5) / 1e-3) - sp.tanh((x - 5.01) / 1e-3),
    "softened": lambda x: 1e-9 / ((x - 5) ** 2 + 1e-6) ** sp.Rational(3, 2),
}


@pytest.mark.parametrize("name", FORCES)
def test_work_of_a_narrow_force(particle: Callable[..., Machine], name: str) -> None:
    x = sp.Symbol("x", real=True)
    f = sp.lambdify(x, FORCES[name](x), "numpy")
    machine = particle(name.replace(" ", "_"), force=lambda x, v: FORCES[name](x))
    for method in METHODS:
        result = machine.simulate(10.0, method=method, rtol=1e-9, progress=False)
        assert result.outcome is Outcome.OK
        end = result.q("p.x")[-1]
        edges = [b for b in EDGES if b < end]
        with np.errstate(over="ignore"):
            work = sum(quad(f, a, b, epsabs=1e-13)[0] for a, b in pairwise([0.0, *edges, end]))
        assert_allclose(result.v("p.x")[-1], sqrt(1 + 2 * work), rtol=1e-6)


def test_a_narrow_brake(particle: Callable[..., Machine]) -> None:
    # v dv/dx = -50 v g(x): the speed falls by the area of 50 g
    machine = particle("brake", force=lambda x, v: -50 * v * pulse(x, 5.0, 1e-2))
    for method in METHODS:
        result = machine.simulate(10.0, method=method, rtol=1e-9, progress=False)
        assert_allclose(result.v("p.x")[-1], 1 - 0.5 * sqrt(pi), rtol=1e-6)


POTENTIALS: dict[str, tuple[Callable[..., sp.Expr], float]] = {
    "barrier": (lambda x: pulse(x, 5.0, 1e-2), -1.0),
    "hill": (lambda x: 0.3 * pulse(x, 5.0, 1e-3), 1.0),
    "well": (lambda x: -pulse(x, 5.0, 1e-2), 1.0),
    "step": (lambda x: 0.3 * (1 + sp.tanh((x - 5) / 1e-3)) / 2, sqrt(0.4)),
}


@pytest.mark.parametrize("name", POTENTIALS)
def test_narrow_potentials(particle: Callable[..., Machine], name: str) -> None:
    potential, speed = POTENTIALS[name]
    machine = particle(name, potential=potential)
    for method in METHODS:
        result = machine.simulate(10.0, method=method, rtol=1e-9, progress=False)
        assert result.outcome is Outcome.OK
        assert_allclose(result.v("p.x")[-1], speed, rtol=1e-6)
    # How long it is in the well, or on the hill, is a question of steps as well.
    usual, fine = (
        machine.simulate(10.0, rtol=1e-9, max_step=h, progress=False) for h in (None, 1e-3)
    )
    assert_allclose(usual.q("p.x")[-1], fine.q("p.x")[-1], atol=2e-8)


@pytest.mark.parametrize("method", ["dop853", "dopri5"])
def test_a_window_between_two_logistic_functions(
    particle: Callable[..., Machine], method: str
) -> None:
    # Its exponentials have factors of e^(5/w), which SymPy writes outside.
    def rises(x: sp.Expr, at: float) -> sp.Expr:
        return 1 / (1 + sp.exp(-(x - at) / 1e-2))

    machine = particle("window", force=lambda x, v: 10 * (rises(x, 5.0) - rises(x, 5.05)))
    result = machine.simulate(10.0, method=method, rtol=1e-9, progress=False)
    assert_allclose(result.v("p.x")[-1], sqrt(1 + 2 * 10 * 0.05), rtol=1e-6)


@pytest.mark.parametrize("place", ["factor", "exponent"])
def test_a_window_between_two_steps_of_parameters(workshop: Path, place: str) -> None:
    model = Model(f"narrow_window_of_a_{place}")
    p = model.particle("p", mass=1.0)
    model.absolute("rail", p, "y", 0.0)
    k = model.parameter("k", 2.0, sign="positive")
    rises: dict[str, Callable[[sp.Expr], sp.Expr]] = {
        "factor": lambda u: 1 / (1 + k * sp.exp(-u)),
        "exponent": lambda u: (1 + sp.exp(-u)) ** (-k),
    }
    rise, width = rises[place], 1e-3
    model.force("act", p, fx=30 * (rise((p.x - 5) / width) - rise((p.x - 5.01) / width)))
    model.scene("runs", ["act"], start={p.x: 0.0, p.vx: 1.0})
    machine = load(model, folder=workshop)
    speed = sqrt(1 + 2 * 30 * 0.01)
    for method in ("dop853", "dopri5"):
        result = machine.simulate(8.0, method=method, rtol=1e-9, progress=False)
        assert_allclose(result.v("p.x")[-1], speed, rtol=1e-6)


def test_powers_of_a_number_below_zero_do_not_stop_a_build(workshop: Path) -> None:
    # (-2)^x is real where x is whole, and the other term keeps the sum from a pole.
    model = Model("narrow_below_zero")
    p = model.particle("p", mass=1.0)
    model.force("act", p, fx=1 / (3 + sp.Integer(-2) ** p.x))
    model.scene("rests", ["act"], start={p.x: 2.0})
    assert load(model, folder=workshop).description.peaks


@pytest.mark.parametrize("method", METHODS)
def test_every_notch_of_a_ratchet(particle: Callable[..., Machine], method: str) -> None:
    # A first step would span many notches, in each of which the particle is faster.
    machine = particle("ratchet", potential=lambda x: -(sp.sin(x) ** 20_000))
    result = machine.simulate(20.0, method=method, rtol=1e-9, progress=False)
    fine = machine.simulate(20.0, max_step=1e-3, rtol=1e-9, progress=False)
    assert fine.q("p.x")[-1] - 20.0 > 0.05
    assert_allclose(result.q("p.x")[-1], fine.q("p.x")[-1], atol=1e-6)


def test_passing_by_at_a_distance(workshop: Path) -> None:
    # In the plane, beside the peak: what acts is small beside what acts elsewhere.
    model = Model("narrow_beside")
    p = model.particle("p", mass=1.0)
    width, beside = 1e-2, 2e-2
    field = sp.exp(-((p.x - 5) ** 2 + p.y**2) / width**2)
    model.force("act", p, fy=field * 1e2)
    model.scene("runs", ["act"], start={p.x: 0.0, p.y: beside, p.vx: 1.0})
    result = load(model, folder=workshop).simulate(10.0, progress=False)
    fine = load(model, folder=workshop).simulate(10.0, max_step=1e-3, rtol=1e-10, progress=False)
    assert fine.v("p.y")[-1] > 0.03
    assert_allclose(result.v("p.y")[-1], fine.v("p.y")[-1], rtol=1e-6)


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
def test_a_body_that_turns_past_a_catch(workshop: Path, formulation: str) -> None:
    model = Model("narrow_turning")
    body = model.body("a", mass=1.0, inertia=2.0)
    model.revolute("pin", model.ground.at(0, 0), body)
    model.torque("catch", on=body, value=50 * pulse(body.phi, 1.0, 1e-3))
    # The same of a point of the body, whose coordinates follow from the angle.
    model.force("spur", body.at(0.5, 0), fx=100 * pulse(body.at(0.5, 0).x, 0.5 * cos(2.0), 1e-3))
    for name, effects in (("angle", ["catch"]), ("point", ["spur"])):
        model.scene(name, effects, start={body.phi: 0.0, body.omega: 1.0})
    for name, work in (("angle", 50e-3 * sqrt(pi)), ("point", -100e-3 * sqrt(pi))):
        machine = load(model, name, folder=workshop)
        result = machine.simulate(2.5, formulation=formulation, progress=False)
        assert_allclose(result.v("a.phi")[-1], sqrt(1 + work), rtol=1e-6)


def test_a_bump_of_a_law_between_coordinates(workshop: Path) -> None:
    # x follows y but for a bump, over which energy is kept: the speed behind it is the same.
    model = Model("narrow_bump", gravity=(0, -9.81))
    p = model.particle("p", mass=1.0)
    model.constraint("road", p.y - 0.01 * pulse(p.x, 5.0, 1e-2))
    model.scene("runs", ["gravity"], start={p.x: 0.0, p.vx: 1.0})
    machine = load(model, folder=workshop)
    result = machine.simulate(10.0, progress=False)
    fine = machine.simulate(10.0, max_step=1e-3, rtol=1e-10, progress=False)
    assert 10.0 - fine.q("p.x")[-1] > 1e-3  # it loses time there
    assert_allclose(result.q("p.x")[-1], fine.q("p.x")[-1], rtol=1e-7)


def test_the_cost_has_a_bound(particle: Callable[..., Machine]) -> None:
    machine = particle("cost", force=lambda x, v: 10 * pulse(x, 5.0, 1e-3))
    result = machine.simulate(10.0, progress=False)
    assert result.stats["rhs_evaluations"] < 3000
    # Where the motion stays away from it nothing is paid.
    away = machine.simulate(4.9, progress=False)
    assert away.stats["rhs_evaluations"] < 300


def test_only_what_may_peak_is_watched(workshop: Path) -> None:
    model = Model("not_peaked")
    p = model.particle("p", mass=1.0)
    model.potential("wide", p.x**2 * sp.cos(p.y) + sp.sqrt(1 + p.x**2) + 1 / (6 - p.x))
    model.scene("runs", ["wide"], start={p.vx: 1.0})
    machine = load(model, folder=workshop)
    assert not machine.description.peaks
    assert "peak_arguments" not in machine.description.kernels


def test_parts_that_move_fast_together_are_not_slowed_down(workshop: Path) -> None:
    # The difference of two angles is known as well as the angles are, however fast they turn.
    model = Model("clutch")
    start = {}
    bodies = []
    for k, inertia in enumerate((1.0, 2.0)):
        body = model.body(f"shaft_{k}", mass=1.0, inertia=inertia)
        model.revolute(f"bearing_{k}", model.ground.at(float(k), 0), body)
        start |= {body.phi: 0.0, body.omega: 100.0}
        bodies.append(body)
    slip = (bodies[0].phi - bodies[1].phi) / 1e-3
    model.torque("clutch_0", on=bodies[0], value=-5 * sp.tanh(slip))
    model.torque("clutch_1", on=bodies[1], value=5 * sp.tanh(slip))
    model.torque("drive", on=bodies[0], value=1.0)
    model.scene("runs", ["clutch_0", "clutch_1", "drive"], start=start)
    machine = load(model, folder=workshop)
    result = machine.simulate(20.0, progress=False)
    assert result.stats["steps"] + result.stats["rejected"] < 1600  # the vibration takes 1343
    turns = result.v("shaft_0.phi")[-1] + 2 * result.v("shaft_1.phi")[-1]
    assert_allclose(turns, 300.0 + 20.0, rtol=1e-7)


def test_ordinary_functions_of_a_distance_cost_no_step(workshop: Path) -> None:
    model = Model("orbit")
    p = model.particle("p", mass=1.0)
    model.potential("attraction", -1 / sp.sqrt(p.x**2 + p.y**2))
    model.scene("runs", ["attraction"], start={p.x: 1.0, p.vy: 0.4})
    machine = load(model, folder=workshop)
    assert machine.description.peaks == (("attraction", "power", -0.5),)
    result = machine.simulate(100.0, progress=False)
    assert result.stats["steps"] + result.stats["rejected"] < 2300  # the orbit takes 2175


def test_a_direction_through_its_own_point_is_passed(particle: Callable[..., Machine]) -> None:
    # x/|x| by a quotient, without pieces: a peak of a width of 1e-15, which is a jump to any step.
    machine = particle("direction", force=lambda x, v: (x - 0.5) / sp.sqrt((x - 0.5) ** 2 + 1e-30))
    result = machine.simulate(1.5, progress=False)
    assert result.outcome is Outcome.OK
    energy = result.v("p.x")[-1] ** 2 / 2 - (abs(result.q("p.x")[-1] - 0.5) - 0.5)
    assert_allclose(energy, 0.5, rtol=1e-6)


def test_steps_of_exponentials_are_cheap_to_pass(particle: Callable[..., Machine]) -> None:
    # Below the line stands a number that grows to e^1000, which no cubic follows.
    machine = particle(
        "sech", force=lambda x, v: 1 / (sp.exp((x - 5) / 1e-2) + sp.exp((5 - x) / 1e-2))
    )
    result = machine.simulate(10.0, rtol=1e-9, progress=False)
    assert_allclose(result.v("p.x")[-1], sqrt(1 + 2 * 0.5e-2 * pi), rtol=1e-8)
    assert result.stats["steps"] + result.stats["rejected"] < 150  # 48; by its power 1342
