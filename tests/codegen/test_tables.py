"""Functions given by points: the spline, its derivatives, what is compiled, and bad points."""

import cmath
import math
from pathlib import Path
from typing import Any

import numpy as np
import pint
import pytest
import sympy
from numpy.testing import assert_allclose
from scipy.interpolate import CubicSpline

from codegen import Model, ModelError, t
from codegen.reading.scene_selection import valid_scenes
from codegen.tables.piecewise_cubic import fit
from runtime import load
from runtime.core.outcomes import Outcome
from tests.codegen.workbench import (
    Interpreted,
    State,
    complex_gamma,
    complex_step,
    python_functions,
)

pytestmark = pytest.mark.filterwarnings("ignore::codegen.errors.TableWarning")  # of random data

RANDOM = np.random.default_rng(5)
X = np.sort(RANDOM.uniform(-1, 2, 12))
Y = RANDOM.normal(size=12)
CLOSED = np.append(Y[:-1], Y[0])


def test_periodic_one_repeats_and_an_open_one_ends() -> None:
    closed, end = (
        fit("c", X.tolist(), CLOSED.tolist(), True),
        fit("o", X.tolist(), Y.tolist(), False),
    )
    period = X[-1] - X[0]
    for at in (X[0] + 0.3, X[0]):
        assert_allclose(closed(at + 3 * period), closed(at), rtol=1e-12)
        assert_allclose(closed(at - period, 1), closed(at, 1), rtol=1e-11)
    assert_allclose(end(X[-1] + 1e-12), Y[-1], rtol=1e-9)
    assert math.isnan(end(X[-1] + 0.1))
    assert math.isnan(end(X[0] - 0.1, 2))


def driven() -> Model:
    """A body whose pose follows tables in every way that one may."""
    model = Model("driven")
    body = model.body("body", mass=1.0, inertia=1.0)
    law = model.table("law", X, Y, kind="spline")
    wave = model.table("wave", X, CLOSED, periodic=True, kind="spline")
    model.driver("lift", body.x + wave(3 * body.phi) ** 2, law(t / 3) * sympy.sin(t))
    model.driver("turn", body.phi, 5 * wave(7 * t))
    model.force("pull", body, fx=wave(body.x) * body.vx)
    return model


def test_derivatives_of_tables_by_complex_steps() -> None:
    machine = Interpreted(driven())
    for seed in range(5):
        s = machine.state(seed)

        def phi(q: np.ndarray, s: State = s) -> np.ndarray:
            return machine.vector("constraints", State(t=s.t, q=q, v=s.v), cmath)

        assert_allclose(machine.jacobian(s), complex_step(phi, s.q), rtol=1e-12, atol=1e-13)
        gamma = complex_gamma(machine, s)
        assert_allclose(machine.vector("acceleration_rhs", s), gamma, rtol=1e-11, atol=1e-11)
        rate = complex_step(lambda at, s=s: phi(s.q, State(t=at[0], q=s.q, v=s.v)), np.array([s.t]))
        assert_allclose(machine.vector("velocity_rhs", s), -rate[:, 0], rtol=1e-11, atol=1e-12)


def test_generated_text_looks_up_what_the_table_says() -> None:
    machine = Interpreted(driven())
    text = machine.text()
    functions = python_functions(text)
    table = fit("law", X.tolist(), Y.tolist(), False)
    for at in np.linspace(X[0], X[-1], 37):
        assert_allclose(functions["table_0"](at), table(at), rtol=1e-13, atol=1e-13)
        assert_allclose(functions["table_0_d2"](at), table(at, 2), rtol=1e-12, atol=1e-11)
    assert math.isnan(functions["table_0"](X[-1] + 1.0))
    assert text.count("np.array(") == 10  # law, wave and the branches, the knots of wave
    assert Interpreted(driven()).text() == text


def test_machine_follows_a_measured_motion(tmp_path: Path) -> None:
    instants = np.linspace(0, 2, 41)
    model = Model("measured", gravity=(0, -9.81))
    arm = model.body("arm", mass=2.0, inertia=0.5)
    model.revolute("pin", model.ground.at(0, 0), arm.at(-0.5, 0))
    law = model.table("law", instants, np.sin(2 * instants), kind="spline")
    model.driver("turn", arm.phi, law(t))
    model.scene("driven", ["gravity"], ["turn"])
    machine = load(model, folder=tmp_path)
    at = np.linspace(0, 2, 301)
    run = machine.inverse_dynamics(at)
    spline = CubicSpline(instants, np.sin(2 * instants))
    assert_allclose(run.q("arm.phi"), spline(at), atol=1e-13)
    assert_allclose(run.a("arm.phi"), spline(at, 2), atol=1e-11)
    torque = (0.5 + 2 * 0.25) * spline(at, 2) + 2 * 9.81 * 0.5 * np.cos(spline(at))
    assert_allclose(run.reaction("turn", "torque"), torque, atol=1e-11)


def test_names_of_tables_cannot_meet_those_of_the_module() -> None:
    """Each is read where its own name, or that of a derivative, is something else's."""
    model = Model("names")
    body = model.body("body", mass=1.0, inertia=1.0)
    points = [0.0, 1.0, 2.0, 3.0, 4.0]
    names = ("lift", "lift_d1", "lift_at", "Lift", "mass", "jacobian", "table_0")
    for k, name in enumerate(names, 1):
        law = model.table(name, points, [k * x * x for x in points], kind="spline")
        model.force(f"push_{k}", body, fx=law(t) * body.y**k)
    model.parameter("TABLE_0_X", 1.0)
    functions = python_functions(Interpreted(model).text())
    q, v, out = np.array([0.0, 2.0, 0.0]), np.zeros(3), np.zeros(3)
    p = np.array([1.0, *np.zeros(len(functions["CONSTANTS"]))])
    functions["constants"](p)
    functions["applied_forces"](1.5, q, v, p, np.zeros(0, np.int64), out)
    assert_allclose(out[0], sum(k * 2.25 * 2.0**k for k in range(1, 8)), rtol=1e-12)


def test_table_of_a_number_is_a_number() -> None:
    model = Model("numbers")
    law = model.table("law", [0, 1, 2, 3], [0, 1, 4, 9], units=("s", "kg"), kind="spline")
    assert law(1.5) == law(1500 * pint.application_registry.ms) == 2.25
    with pytest.raises(ModelError, match="called with 4; give a number from its first"):
        law(4)
    assert model.body("body", mass=law(1.5), inertia=1.0).mass == 2.25


def test_table_converts_quantities() -> None:
    unit = pint.application_registry
    model = Model("units")
    x, y = [k * unit.ms for k in range(5)], [k * k * unit.mm for k in range(5)]
    law = model.table("law", x, y, units=("s", "m"), kind="spline")
    assert_allclose(law.table(0.0015), 2.25e-3, rtol=1e-12)


def test_cam_through_points_is_the_curve_they_lie_on() -> None:
    model = Model("cam")
    cam, follower = model.body("cam", 1.0, 1.0), model.body("follower", 1.0, 1.0)
    angles = np.linspace(0, 2 * np.pi, 48, endpoint=False)
    points = [(0.02 * np.cos(a), 0.03 * np.sin(a)) for a in angles]
    curve = model.curve_through("oval", cam, points)
    lift = model.cam_flat_follower("lift", curve, follower)
    assert valid_scenes(model, None)
    machine = Interpreted(model)
    s = machine.state(1)
    assert_allclose(machine.jacobian(s)[1, :2], 0, atol=0)
    assert lift.alpha.name == "lift_alpha"
    x, y = (float(c.table(1.0)) for c in (curve.x, curve.y))
    assert_allclose((x / 0.02) ** 2 + (y / 0.03) ** 2, 1, atol=1e-5)


def test_motion_that_runs_off_its_table_says_so(tmp_path: Path) -> None:
    model = Model("short")
    arm = model.body("arm", mass=1.0, inertia=1.0)
    model.revolute("pin", model.ground.at(0, 0), arm)
    law = model.table("law", [0.0, 0.3, 0.6, 1.0], [0.0, 0.2, 0.5, 0.4], kind="spline")
    model.driver("turn", arm.phi, law(t))
    model.scene("driven", drivers=["turn"])
    run = load(model, folder=tmp_path).kinematics(np.linspace(0, 1.5, 31))
    assert run.failed
    assert run.outcome is Outcome.OUT_OF_RANGE
    assert "Table 'law' of 'turn' is left at t = 1: its points go from 0 to 1." in run.message
    assert_allclose(run.t[-1], 1.0, atol=1e-6)


def tabled(units: tuple[str, str] = ("s", "m")) -> tuple[Model, Any, Any]:
    model = Model("units")
    body = model.body("body", 1.0, 1.0)
    law = model.table("law", [0, 1, 2, 3], [0, 1, 4, 9], units=units)
    return model, body, law


@pytest.mark.parametrize("units", [("", ""), ("s", "N")])
def test_tables_of_their_unit_or_without_are_taken(units: tuple[str, str]) -> None:
    model, body, law = tabled(units)
    model.force("pull", on=body, fx=law(t), fy=5 * law(3.5 * t))
    assert valid_scenes(model, None)


def test_a_period_adds_the_row_that_closes_it() -> None:
    """Also where the last row is the closing one, to the rounding of its abscissa."""
    model, turns = Model("cycle"), 4 * math.pi
    degrees = np.arange(0, 720, 10.0)
    values = 1 + 9 * np.exp(-(((degrees - 400) / 40) ** 2))
    whole = np.append(degrees, 720.0), np.append(values, values[0])
    tables = [
        model.table("closed", np.radians(whole[0]), whole[1], periodic=True),
        model.table("open", np.radians(degrees), values, period=turns),
        model.table("rounded", np.round(np.radians(whole[0]), 4), whole[1], period=4 * sympy.pi),
    ]
    body = model.body("body")
    for table in tables:
        assert table(body.phi) != 0  # it may be taken at an angle
        assert table.table.length == pytest.approx(turns, rel=1e-15)
        at = np.radians(400) + 1000 * turns
        assert table.table(at) == pytest.approx(10.0, rel=1e-6)
    assert not model.problems
