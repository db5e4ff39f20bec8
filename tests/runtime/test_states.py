"""States of first order: by every method and formulation, against closed forms."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from sympy import Max, Min

from codegen import Model
from codegen.errors import AnalysisError, InputError, ModelError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

R, L, K, J, C = 2.0, 0.01, 0.1, 0.002, 0.001
METHODS = ("dop853", "dopri5", "tsit5", "radau5", "bdf", "auto")


def motor(name: str) -> Model:
    """A rotor driven by a motor with the voltage 12 V, its current a state."""
    model = Model(name)
    resistance = model.parameter("resistance", R, "ohm")
    rotor = model.body("rotor", mass=1.0, inertia=J)
    model.revolute("shaft", model.ground.at(0, 0), rotor.at(0, 0))
    current = model.state(
        "current", lambda i: (12 - resistance * i - K * rotor.omega) / L, start=1.0, unit="A"
    )
    model.torque("drive", on=rotor, value=K * current)
    model.torque("drag", on=rotor, value=-C * rotor.omega)
    model.scene("spin", ["drive", "drag"], start={rotor.phi: 0.0, rotor.omega: 0.0})
    model.scene("coast", ["drag"], start={rotor.phi: 0.0, rotor.omega: 10.0})
    model.scene("watched", ["drag", current], start={rotor.phi: 0.0, rotor.omega: 10.0})
    return model


@pytest.fixture(scope="module")
def spin(workshop: Path) -> Machine:
    return load(motor("motor_states"), "spin", folder=workshop)


def exact(t: np.ndarray) -> np.ndarray:
    """Current and speed of `motor` at instants, (k, 2)."""
    matrix = np.array([[-R / L, -K / L], [K / J, -C / J]])
    final = -np.linalg.solve(matrix, [12 / L, 0.0])
    return np.array([final + expm(matrix * s) @ ([1.0, 0.0] - final) for s in t])


@pytest.mark.parametrize("formulation", ["cartesian", "reduced"])
@pytest.mark.parametrize("method", METHODS)
def test_a_motor_with_current_as_state(spin: Machine, method: str, formulation: str) -> None:
    r = spin.simulate(
        1.0, [0.004, 0.1, 1.0], method=method, formulation=formulation, rtol=1e-10, max_step=0.01
    )
    assert r.outcome is Outcome.OK
    got = np.column_stack([r.y("current"), r.v("rotor.omega")])
    assert_allclose(got, exact(r.t), rtol=2e-8)


def test_a_state_has_no_energy_and_its_own_unit(spin: Machine) -> None:
    r = spin.simulate(0.2, np.linspace(0.0, 0.2, 41), rtol=1e-10)
    assert_allclose(r.energy("kinetic"), 0.5 * J * r.v("rotor.omega") ** 2, rtol=1e-13)
    row = spin.coordinates["current.integral"]
    assert (row.unit, row.velocity_unit, row.acceleration_unit) == ("A s", "A", "A/s")
    assert {row.name for row in spin.description.powers} == {"drive", "drag"}


def test_its_rate_stands_among_accelerations(spin: Machine) -> None:
    r = spin.simulate(0.2, [0.1], rtol=1e-10)
    i, omega = r.y("current"), r.v("rotor.omega")
    assert_allclose(r.a("current"), (12 - R * i - K * omega) / L, rtol=1e-9)


def test_parameters_of_a_rate_change_from_run_to_run(spin: Machine) -> None:
    r = spin.simulate(30.0, [30.0], parameters={"resistance": 4.0})
    assert_allclose(r.y("current"), 12 * C / (4 * C + K * K), rtol=1e-6)


def test_a_scene_has_the_states_that_it_needs_or_names() -> None:
    model = motor("motor_scenes")
    assert model.scenes["spin"].states == ("current",)
    assert model.scenes["coast"].states == ()
    assert model.scenes["watched"].states == ("current",)
    assert model.scenes["spin"].without("drive").states == ()


def test_a_run_may_start_elsewhere(spin: Machine) -> None:
    r = spin.simulate(0.1, [0.0, 0.1], start={"current": 3.0})
    assert_allclose(r.y("current")[0], 3.0)


def test_saturation_switches_as_forces_do(workshop: Path) -> None:
    model = Model("saturated_states")
    mass = model.particle("mass", 1.0)
    model.absolute("rail", mass, "y", 0.0)
    error = 1.0 - mass.x
    integral = model.state("integral_of_error", lambda s: Max(-0.5, Min(0.5, error)))
    model.force("act", mass, fx=2.0 * integral - 0.5 * mass.vx)
    model.scene("runs", ["act"], start={mass.x: 0.0, mass.vx: 0.0})

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [y[1], 2.0 * y[2] - 0.5 * y[1], float(np.clip(1.0 - y[0], -0.5, 0.5))]

    r = load(model, folder=workshop).simulate(6.0, [2.0, 4.0, 6.0], rtol=1e-11)
    reference = solve_ivp(
        rates, (0, 6), [0.0] * 3, "DOP853", r.t, rtol=1e-12, atol=1e-13, max_step=0.003
    )
    assert_allclose(r.q("mass.x"), reference.y[0], atol=1e-8)
    assert_allclose(r.y("integral_of_error"), reference.y[2], atol=1e-8)
    assert len(r.events) >= 2


def test_states_that_contain_one_another(workshop: Path) -> None:
    model = Model("oscillating_states")
    mass = model.particle("mass", 1.0)
    x, y = model.state("x1", start=1.0), model.state("x2")
    model.state_equation(x, y)
    model.state_equation(y, -4.0 * x)
    model.force("act", mass, fx=x)
    model.scene("runs", ["act"], start={mass.x: 0.0, mass.y: 0.0, mass.vx: 0.0, mass.vy: 0.0})
    r = load(model, folder=workshop).simulate(5.0, [1.0, 5.0], rtol=1e-11)
    assert_allclose(r.y("x1"), np.cos(2 * r.t), atol=1e-9)
    assert_allclose(r.q("mass.x"), (1 - np.cos(2 * r.t)) / 4, atol=1e-9)


def test_other_analyses_are_refused_by_name(spin: Machine) -> None:
    for question in (lambda: spin.kinematics([0.0]), lambda: spin.inverse_dynamics([0.0])):
        with pytest.raises(AnalysisError, match=r"current follow.*without\('current'\)"):
            question()


def test_wrong_declarations_are_noted_together() -> None:
    model = Model("wrong_states")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.state("a", rate=1.0, unit="furlong", nominal=0.0)
    lost = model.state("b")
    model.state_equation(body.omega, 1.0)
    model.state("c", rate=lambda c: None)
    model.state("body", rate=1.0)
    model.torque("turn", on=body, value=lost)
    model.potential("stored", 0.5 * lost**2)
    model.scene("runs", ["turn", "stored"])
    from codegen import build

    with pytest.raises(ModelError) as caught:
        build(model, compile=False)
    text = str(caught.value)
    for part in (
        "unit 'furlong' is no SI unit", "nominal of state 'a' is 0", "state_equation(body_omega",
        "the function answers None", "name is already that of a body", "state 'b' has no rate",
        "contains the velocity b_value",
    ):  # fmt: skip
        assert part in text, part


def test_a_run_starts_from_a_scene_without_its_states(workshop: Path) -> None:
    model = motor("motor_from_rest")
    rotor = model.bodies["rotor"]
    model.torsion_spring("hold", model.ground, rotor, stiffness=2.0, free_angle=0.3)
    model.scene("rest", ["hold"])
    rest = load(model, "rest", folder=workshop).equilibrium()
    r = load(model, "spin", folder=workshop).simulate(0.1, [0.0, 0.1], start=rest)
    assert_allclose([r.q("rotor.phi")[0], r.y("current")[0]], [0.3, 1.0], atol=1e-8)
    other = Model("lacking_states")
    other.particle("mass", 1.0)
    other.scene("runs")
    free = load(other, folder=workshop)
    with pytest.raises(InputError, match=r"lacks mass\.x"):
        free.simulate(0.1, start=rest)


@pytest.mark.parametrize("form", ["body", "link", "lumped"])
def test_states_beside_a_coupler(form: str, workshop: Path) -> None:
    """A motor turns a crank with a rod: in every form of the rod as with parts of one's own."""
    got = []
    for own in (True, False):
        model = Model(f"motor_coupler_{form}_{'own' if own else 'coupler'}")
        crank = model.body("crank", mass=1.0, inertia=J)
        slider = model.particle("slider", mass=0.5)
        model.revolute("shaft", model.ground.at(0, 0), crank.at(0, 0))
        model.absolute("rail", slider, "y", 0.0)
        pin, parts = crank.at(0.1, 0), {}
        if not own:
            model.coupler("rod", pin, slider, 0.4, mass=0.2, inertia=0.01)
            parts = {"couplers": {"rod": form}}
        elif form == "body":
            rod = model.body("rod", mass=0.2, inertia=0.01)
            model.revolute("rod_i", pin, rod.at(-0.2, 0))
            model.revolute("rod_j", rod.at(0.2, 0), slider.at(0, 0))
        else:
            model.distance("rod", pin, slider.at(0, 0), 0.4)
            if form == "lumped":
                for half, where in (("half_i", pin), ("half_j", slider.at(0, 0))):
                    model.revolute(half + "_pin", where, model.particle(half, mass=0.1).at(0, 0))
        current = model.state("current", unit="A")
        model.state_equation(current, 100 * (12 - 2 * current - K * crank.omega))
        fast = model.latch("fast", when=crank.omega > 5)
        held = model.sampled("held", 0.01, 0.01 * current)
        model.torque("drive", on=crank, value=K * current - held)
        model.torque("brake", on=crank, value=-0.02, when=fast)
        start = {crank.phi: 0.5, crank.omega: 0.0}
        guess = {slider.x: 0.5, "rod.x": 0.3, "rod.phi": -0.1}
        if form != "body":
            guess = {slider.x: 0.5}
        model.scene("turn", ["drive", "brake"], start=start, guess=guess, **parts)
        r = load(model, "turn", folder=workshop).simulate(0.5, rtol=1e-11)
        assert r.outcome is Outcome.OK
        got.append([r.q("crank.phi"), r.v("slider.vx"), r.y("current"), r.y("held")])
    assert_allclose(got[0], got[1], rtol=1e-9, atol=1e-10)
