"""Runs with tables: steps end at knots, and a run that leaves a table says so, at its instant."""

from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad
from sympy import Abs, Piecewise

from codegen import Effect, Model, element, t
from codegen.errors import AnalysisError
from codegen.tables.piecewise_cubic import Kind, Table
from runtime import load, load_result
from runtime.core.outcomes import Outcome

pytestmark = pytest.mark.filterwarnings("ignore::codegen.errors.TableWarning")  # of random data

RANDOM = np.random.default_rng(3)
X = np.linspace(0, 12, 25)
Y = RANDOM.normal(size=25)
START, SPEED, END = 1.03, 3.0, 2.0


def pushed(law: Any, model: Model, start: float = START, speed: float = SPEED) -> Model:
    """One kilogramme on a line under a force by table of its place."""
    cart = model.particle("cart", mass=1.0)
    model.force("push", cart, fx=law(cart.x))
    state = {cart.x: start, cart.y: 0.0, cart.vx: speed, cart.vy: 0.0}
    model.scene("run", ["push"], start=state)
    return model


def work(table: Table, a: float, b: float) -> float:
    """∫ F dx, piece by piece."""
    total = 0.0
    for (left, right), row in zip(pairwise(table.knots), table.rows, strict=True):
        low, high = max(left, min(a, b)), min(right, max(a, b))
        if high > low:
            powers = [row[k] / (k + 1) for k in range(4)]
            total += sum(
                c * ((high - left) ** (k + 1) - (low - left) ** (k + 1))
                for k, c in enumerate(powers)
            )
    return total if b >= a else -total


def time_to(table: Table, place: float) -> float:
    """∫ dx/v with v² = v0² + 2 W, from knot to knot."""
    inner = [x for x in table.knots if START < x < place]
    edges = [START, *inner, place]
    return sum(
        quad(
            lambda x: (SPEED**2 + 2 * work(table, START, x)) ** -0.5, a, b, epsabs=0, epsrel=1e-13
        )[0]
        for a, b in pairwise(edges)
    )


@pytest.mark.parametrize("kind", ["linear", "pchip", "akima", "spline"])
@pytest.mark.parametrize("method", ["dop853", "dopri5", "radau5"])
def test_steps_end_at_knots(kind: Kind, method: str, tmp_path: Path) -> None:
    """At rtol 1e-8 the error was 4e-7 to 3e-6 while steps went over the knots."""
    model = Model("cart")
    law = model.table("law", X, Y, kind=kind)
    machine = load(pushed(law, model), folder=tmp_path)
    run = machine.simulate(END, t_eval="steps", method=method)
    assert not run.failed
    place = float(run.q("cart.x")[-1])
    assert_allclose(time_to(law.table, place), END, atol=4e-8)
    reached = run.q("cart.x")
    passed = [x for x in law.table.knots if START < x < place]
    assert len(passed) > 8
    if kind == "linear":
        for knot in passed:
            assert np.abs(reached - knot).min() < 1e-12
    assert not run.events
    assert run.stats["events"] == 0


@pytest.mark.parametrize("kind", ["linear", "pchip", "spline"])
@pytest.mark.parametrize("backwards", [False, True])
def test_run_that_leaves_its_table_ends_there_by_name(
    kind: Kind, backwards: bool, tmp_path: Path
) -> None:
    model = Model("cart")
    law = model.table("road", X, np.full(25, 0.5) + 0.1 * np.sin(X), kind=kind)
    speed = -SPEED if backwards else SPEED
    run = load(pushed(law, model, speed=speed), folder=tmp_path).simulate(20.0)
    assert run.outcome is Outcome.OUT_OF_RANGE
    end = 0.0 if backwards else 12.0
    assert_allclose(run.q("cart.x")[-1], end, atol=1e-12)
    if not backwards:
        assert_allclose(run.t[-1], time_to(law.table, 12.0), atol=1e-7)
    told = f"Table 'road' of 'push' is left at cart_x = {end:g}: its points go from 0 to 12."
    assert told in run.message
    assert 'beyond="hold"' in run.message


def test_run_goes_on_where_its_table_holds_or_goes_on(tmp_path: Path) -> None:
    for beyond, force in (("hold", lambda x: 3.0), ("extrapolate", lambda x: 3.0 + (x - 3.0))):
        model = Model(f"cart_{beyond}")
        law = model.table("law", [0, 1, 3], [1, 1, 3], kind="linear", beyond=beyond)  # type: ignore[arg-type]
        run = load(pushed(law, model, start=0.5), folder=tmp_path).simulate(2.0)
        assert not run.failed
        place, speed = run.q("cart.x")[-1], run.v("cart.vx")[-1]
        known = SPEED**2 / 2 + work(law.table, 0.5, 3.0) + quad(force, 3.0, place)[0]
        assert_allclose(speed**2 / 2, known, rtol=1e-8)


def test_start_at_the_end_of_a_table(tmp_path: Path) -> None:
    """Inwards it is no exit, and at rest neither."""
    model = Model("cart")
    law = model.table("law", X, 0.0 * X + 0.5, kind="pchip")
    machine = load(pushed(law, model, start=0.0), folder=tmp_path)
    run = machine.simulate(1.0)
    assert not run.failed
    assert_allclose(run.q("cart.x")[-1], 3.0 + 0.25, rtol=1e-9)
    out = machine.simulate(1.0, guess=None, parameters=None)
    assert not out.failed


@pytest.mark.parametrize("method", ["dop853", "bdf"])
@pytest.mark.parametrize(("last", "end"), [(1.0, 1.0), (0.3, 0.1 * 3)])
def test_run_and_table_of_time_that_end_together(
    last: float, end: float, method: str, tmp_path: Path
) -> None:
    """Also where rounding puts the end of the run behind that of the table."""
    model = Model("cart")
    cart = model.particle("cart", mass=2.0)
    law = model.table("law", [0.0, last / 2, last], [0.0, 1.0, 0.5], kind="linear")
    model.force("push", cart, fx=law(t))
    start = {cart.x: 0, cart.y: 0, cart.vx: 0, cart.vy: 0}
    model.scene("run", ["push"], start=start, outputs=["default", "forces"])
    machine = load(model, folder=tmp_path)
    run = machine.simulate(end, method=method)
    assert run.outcome is Outcome.OK, run.message
    assert run.t[-1] == end
    assert_allclose(run.v("cart.vx")[-1], 0.3125 * last, rtol=1e-9)
    assert_allclose(run.at(end).force("push", "fx"), 0.5, rtol=1e-12)
    beyond = run.resume(2 * end)
    assert beyond.outcome is Outcome.OUT_OF_RANGE
    assert f"Table 'law' of 'push' is left at t = {last:g}: its points" in beyond.message


@pytest.mark.parametrize("begin", [-1.0, -0.7, -0.3])
def test_run_and_table_of_time_that_end_together_at_zero(begin: float, tmp_path: Path) -> None:
    """Rounding is that of the start, which the end at t = 0 does not tell."""
    model = Model("cart")
    cart = model.particle("cart", mass=2.0)
    law = model.table("law", [begin, begin / 2, 0.0], [0.0, 1.0, 0.5], kind="linear")
    model.force("push", cart, fx=law(t))
    start = {cart.x: 0, cart.y: 0, cart.vx: 0, cart.vy: 0}
    model.scene("run", ["push"], start=start)
    run = load(model, folder=tmp_path).simulate(0.0, t_start=begin)
    assert run.outcome is Outcome.OK, run.message
    assert run.t[-1] == 0.0
    assert_allclose(run.v("cart.vx")[-1], -0.3125 * begin, rtol=1e-9)


def driven(law: Any, model: Model) -> Model:
    arm = model.body("arm", mass=1.0, inertia=1.0)
    model.revolute("pin", model.ground, arm)
    model.driver("turn", arm.phi, 2 * t)
    model.torque("load", arm, law(arm.phi))
    model.scene("driven", ["load"], ["turn"])
    return model


def test_inverse_dynamics_beyond_a_table_says_so(tmp_path: Path) -> None:
    model = Model("arm")
    law = model.table("load_curve", [0, 1, 2, 3], [0, 1, 0, 1])
    run = load(driven(law, model), folder=tmp_path).inverse_dynamics(np.linspace(0, 2, 21))
    assert run.outcome is Outcome.OUT_OF_RANGE
    assert "no results beyond t = 1.5 s; the last row is that of t = 1.5 s." in run.message
    assert (
        "Table 'load_curve' of 'load' is left at arm_phi = 3: its points go from 0" in run.message
    )
    assert_allclose(-run.reaction("turn", "torque"), [law.table(0.2 * k) for k in range(16)])


def test_kinematics_asks_for_no_table_of_forces(tmp_path: Path) -> None:
    model = Model("arm")
    law = model.table("load_curve", [0, 1, 2, 3], [0, 1, 0, 1])
    run = load(driven(law, model), folder=tmp_path).kinematics(np.linspace(0, 2, 21))
    assert run.outcome is Outcome.OK
    assert_allclose(run.q("arm.phi"), 2 * run.t)
    assert_allclose(run.a("arm.phi"), 0.0, atol=1e-12)
    assert "From t = 1.6 s on some forces, reactions or energies are not numbers" in run.message


def test_constraint_that_leaves_its_table_says_so(tmp_path: Path) -> None:
    model = Model("cam")
    cam, pin = model.body("cam", 1.0, 1.0), model.body("pin", 1.0, 1.0)
    model.revolute("axle", model.ground, cam)
    model.translational("guide", model.ground, pin, axis=(0, 1))
    lift = model.table("lift", [0, 1, 2, 3], [0, 0.1, 0.2, 0.1], kind="spline")
    model.constraint("follows", pin.y - lift(cam.phi))
    model.driver("turn", cam.phi, 2 * t)
    model.scene("driven", drivers=["turn"])
    model.scene("free", start={cam.phi: 0.5, cam.omega: 2.0})
    run = load(model, "driven", folder=tmp_path).kinematics(np.linspace(0, 2, 21))
    free = load(model, "free", folder=tmp_path).simulate(20.0)
    for one in (run, free):
        assert one.outcome is Outcome.OUT_OF_RANGE
        assert "Table 'lift' of 'follows' is left at cam_phi = " in one.message
        assert_allclose(one.q("cam.phi")[-1], 3.0, atol=0.21)


@pytest.mark.parametrize("method", ["energy", "settling"])
def test_equilibrium_beyond_a_table_says_so(method: str, tmp_path: Path) -> None:
    model = Model("hanging", gravity=(0, -9.81))
    weight = model.particle("weight", mass=1.0)
    pull = model.table("pull", [-1, -0.5, 0, 0.5], [4.0, 2.0, 0.0, -1.0])
    model.force("spring", weight, fy=pull(weight.y), fx=-weight.x)
    model.force("damper", weight, fx=-weight.vx, fy=-weight.vy)
    model.scene("rest", ["gravity", "spring", "damper"], start={weight.x: 0, weight.y: 0.0})
    machine = load(model, folder=tmp_path)
    rest = machine.equilibrium(method=method)
    assert rest.outcome is Outcome.OUT_OF_RANGE
    assert "Table 'pull' of 'spring' is left at weight_y = " in rest.message
    with pytest.raises(AnalysisError, match="at the start position Table 'pull' of 'spring' is"):
        machine.equilibrium(method=method, guess={"weight.y": 3.0})


def test_law_of_motion_by_table(tmp_path: Path) -> None:
    """Accelerations of pchip jump at knots, which are events; between them they are the table's."""
    model = Model("arm")
    arm = model.body("arm", mass=1.0, inertia=2.0)
    model.revolute("pin", model.ground, arm)
    law = model.table("law", [0, 0.5, 1.0, 1.5, 2.0], [0, 0.1, 0.6, 0.7, 0.7])
    model.driver("turn", arm.phi, law(t))
    model.scene("driven", drivers=["turn"])
    machine = load(model, folder=tmp_path)
    at = np.linspace(0.01, 1.97, 67)
    run = machine.inverse_dynamics(at)
    assert not run.failed
    assert_allclose(run.q("arm.phi"), [law.table(x) for x in at], atol=1e-12)
    assert_allclose(run.reaction("turn", "torque"), [2 * law.table(x, 2) for x in at], atol=1e-9)
    swung = machine.simulate(2.0)
    assert not swung.failed
    assert_allclose(swung.q("arm.phi")[-1], 0.7, atol=1e-9)


@element
class TableSpring(Effect):
    """A force by table of a length, along it."""

    kind = "spring by table"
    name: str
    body: Any
    force: Any

    def pulls(self, bodies: Any) -> Any:
        length = (self.body.x**2 + self.body.y**2) ** 0.5
        return ((length, self.force(length)),)


def test_force_by_table_of_a_length(tmp_path: Path) -> None:
    """Its work is the integral of the table, wherever the body goes."""
    model = Model("planet")
    body = model.particle("body", mass=2.0)
    law = model.table("law", [0.2, 0.5, 1, 1.5, 2, 4], [5, 1, 2, 2.5, 6, 8])
    model.add(TableSpring("spring", body, law))
    start = {body.x: 1.2, body.y: 0.0, body.vx: 0.4, body.vy: 1.1}
    model.scene("orbit", ["spring"], start=start)
    run = load(model, folder=tmp_path).simulate(20.0)
    assert not run.failed
    x, y, vx, vy = (run.q("body.x"), run.q("body.y"), run.v("body.vx"), run.v("body.vy"))
    energy = vx**2 + vy**2 + [work(law.table, 1.2, r) for r in np.hypot(x, y)]
    assert_allclose(energy, energy[0], rtol=1e-7)
    assert_allclose(x * vy - y * vx, 1.2 * 1.1, rtol=1e-7)


def rider(kind: Kind, beyond: str) -> Model:
    """A mass on a tyre that never pulls, above a road by table of the time."""
    model = Model("rider", gravity=(0, -9.81))
    knots, heights = [0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 2.0], [0, 0, 0.01, 0.03, 0.04, 0.0, 0, 0]
    road = model.table("road", knots, heights, units=("s", "m"), kind=kind, beyond=beyond)
    mass = model.particle("mass", mass=1.0)
    model.contact("tyre", gap=mass.y - road(t), stiffness=1e3, damping=10.0, may_pull=False)
    start = {mass.x: 0.0, mass.vx: 0.0, mass.y: -9.81e-3, mass.vy: 0.0}
    outputs = ["force(tyre)", "gap(tyre)", "rate(tyre)"]
    model.scene("ride", ["gravity", "tyre"], start=start, outputs=outputs)
    return model


@pytest.mark.parametrize("kind", ["linear", "pchip", "spline"])
@pytest.mark.parametrize("beyond", ["stop", "hold"])
def test_contact_above_a_road_switches_where_it_opens_and_closes(
    kind: Kind, beyond: str, tmp_path: Path
) -> None:
    """And nowhere else: no branch of the table has events of its own."""
    run = load(rider(kind, beyond), "ride", folder=tmp_path).simulate(1.9, rtol=1e-9, atol=1e-11)
    assert run.outcome is Outcome.OK
    gap, force = run.gap("tyre"), run.force("tyre")
    push = -(1e3 * gap + 10.0 * run.rate("tyre"))
    assert_allclose(force, np.where(gap < 0, np.maximum(push, 0), 0), atol=1e-7)
    assert (gap > 1e-3).any()
    # Each opening and each closing has an event of the damper and one of the gap.
    touching = force > 0
    changes = np.count_nonzero(touching[1:] != touching[:-1])
    assert changes >= 3
    if kind != "linear":  # at whose knots the rate jumps
        assert len(run.events) == 2 * changes


def test_condition_on_a_table_alone_ends_a_run_beyond_it(tmp_path: Path) -> None:
    model = Model("gate")
    table = model.table("hill", [0.0, 1.0, 2.0], [0.0, 1.0, 0.0])
    cart = model.particle("cart", mass=1.0)
    model.force("push", cart, fx=1.0, when=table(cart.x) > 0.5)
    state = {cart.x: 0.1, cart.y: 0.0, cart.vx: 1.0, cart.vy: 0.0}
    model.scene("run", ["push"], start=state)
    run = load(model, "run", folder=tmp_path).simulate(5.0)
    assert run.outcome is Outcome.OUT_OF_RANGE
    assert run.q("cart.x")[-1] == pytest.approx(2.0, abs=1e-9)


@pytest.mark.parametrize("analysis", ["inverse dynamics", "simulation", "saved"])
@pytest.mark.parametrize("form", ["linear", "Abs", "Piecewise"])
def test_momentum_is_that_of_forces_and_of_impulses_where_the_rate_of_a_law_jumps(
    tmp_path: Path, analysis: str, form: str
) -> None:
    """A cart of 2 kg, whose velocity jumps by 0.4 N s / 2 kg at the first point of the table."""
    model = Model("cart")
    cart = model.body("cart", mass=2.0, inertia=1.0)
    model.translational("guide", model.ground, cart)
    points = [0, 0.1, 0.2, 0.3, 0.4, 0.5], [0, 0.01, 0.04, 0.05, 0.03, 0]
    law = {
        "linear": model.table("law", *points, units=("s", "m"), kind="linear")(t),
        "Abs": Abs(t - 0.25) + t**2,
        "Piecewise": Piecewise((t, t < 0.2), (0.2 + (t - 0.2) ** 2 / 2, True)),
    }[form]
    model.driver("feed", cart.x, law)
    model.scene("run", drivers=["feed"])
    machine = load(model, folder=tmp_path)
    analyse = machine.simulate if analysis == "simulation" else machine.inverse_dynamics
    run = analyse(0.5, 501)
    if analysis == "saved":
        run.save(tmp_path / "run.nc")
        run = load_result(tmp_path / "run.nc")
    assert run.outcome is Outcome.OK
    impulses = [event.impulse["feed.fx"] for event in run.events if event.impulse]
    if form == "linear":
        assert_allclose(impulses, [0.4, -0.4, -0.6, -0.2], rtol=1e-12)
    assert f"rate of the law in 'feed' jumps at {len(impulses)} instant" in run.message
    force, speed = run.reaction("feed", "fx"), run.v("cart.vx")
    gained = sum(impulses) + np.trapezoid(force, run.t)
    assert_allclose(2 * (speed[-1] - speed[0]), gained, atol=2e-3 if form == "Piecewise" else 1e-12)
