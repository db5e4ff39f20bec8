"""Places where the equation of a constraint is not smooth end a run by name, and misses do not."""

from collections.abc import Callable
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from codegen import Model, t
from codegen.errors import AssemblyError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine

FORMULATIONS = ("cartesian", "reduced")
METHODS = ("dop853", "dopri5", "tsit5", "radau5", "bdf")
R, LENGTH, SPEED = 0.1, 2.5, 1.0


@pytest.fixture(scope="module")
def machine(workshop: Path) -> Callable[[str], Machine]:
    def loaded(name: str) -> Machine:
        model = Model(f"kink_{name}", gravity=(0, -9.81))
        p, effects = model.particle("p", mass=1.0), []
        start, guess = {p.x: 0.0, p.vx: 5.0}, {}
        if name == "ring":  # a rope through it, to a load on a rail
            q = model.particle("q", mass=3.0)
            model.absolute("rail", q, "x", 1.0)
            model.constraint("row", sp.sqrt((p.x - 3) ** 2 + (p.y - 2) ** 2) - q.y - 3)
            start = {p.x: 1.0, p.vx: 2.0, p.y: 1.0, p.vy: 1.0}
            guess = {q.y: np.sqrt(5) - 3}
        elif name == "bowl":
            effects = ["gravity"]
            model.constraint("row", p.y + sp.sqrt(1 - p.x**2))
        elif name == "post":  # a string that winds onto it
            span = sp.sqrt(p.x**2 + p.y**2 - R**2)
            turn = sp.atan2(-p.y, -p.x) - sp.atan2(R, span)
            model.constraint("row", span - R * turn - LENGTH)
            start, guess = {p.y: -R, p.vy: SPEED}, {p.x: -LENGTH, p.vx: 0.0}
        elif name == "arc":
            model.absolute("rail", p, "y", 0.0)
            q = model.particle("q", mass=1.0)
            model.absolute("rail_of_q", q, "x", 0.0)
            model.constraint("row", q.y - sp.asin(p.x))
            start = {p.x: 0.0, p.vx: 1.0}
        elif name == "slope":  # an angle by atan, which jumps where x comes to 0
            model.absolute("rail", p, "y", 1.0)
            q = model.particle("q", mass=1.0)
            model.absolute("rail_of_q", q, "x", 0.0)
            model.constraint("row", q.y - sp.atan(p.y / p.x))
            start = {p.x: -1.0, p.vx: 1.0}
        else:  # a track around the origin that closes
            turn = sp.atan2(p.y, p.x)
            model.constraint("row", sp.sqrt(p.x**2 + p.y**2) - 1 - sp.cos(3 * turn) / 5)
            start, guess = {p.y: 0.0, p.vy: 1.0}, {p.x: 1.2}
        model.scene("run", effects, start=start, guess=guess)
        return load(model, folder=workshop)

    return loaded


# name: outcome, instant, function in the message
ENDS = {
    "ring": (Outcome.DISCONTINUOUS, 1.0, "sqrt((p_x - 3)**2 + (p_y - 2)**2) comes to 0"),
    "bowl": (Outcome.NOT_FINITE, 0.394540059, "sqrt(1 - p_x**2) comes to 0"),
    "post": (Outcome.DISCONTINUOUS, 7.460536, "atan2(-p_y, -p_x) comes to its cut"),
    "slope": (Outcome.DISCONTINUOUS, 1.143058326, "the quotient in atan(p_y/p_x) comes to a pole"),
    "arc": (Outcome.NOT_FINITE, 1.3506438, "asin(p_x) comes to an end of its range"),
}


@pytest.mark.parametrize("name", ENDS)
def test_runs_end_at_a_kink_by_name(machine: Callable[[str], Machine], name: str) -> None:
    outcome, instant, said = ENDS[name]
    one = machine(name)
    for formulation, method in product(FORMULATIONS, METHODS):
        result = one.simulate(10.0, 201, method=method, formulation=formulation)
        assert result.outcome is outcome, (formulation, method)
        assert result.t[-1] == pytest.approx(instant, abs=3e-6)
        assert f"In joint 'row' {said}" in result.message
        assert ("rack_and_pinion" in result.message) == (name == "post")
        energy = result.energy("total")
        assert np.ptp(energy) < 1e-4 * max(1.0, np.abs(energy).max())


@pytest.mark.parametrize("formulation", FORMULATIONS)
def test_near_misses_go_on(machine: Callable[[str], Machine], formulation: str) -> None:
    """The load turns back within 1e-6 s, as the particle goes straight on by symmetry."""
    ring = machine("ring")
    for off in (1e-3, 1e-6):
        result = ring.simulate(2.0, 3, start={"p.y": 1.0 + off}, formulation=formulation)
        assert result.outcome is Outcome.OK
        np.testing.assert_allclose(result.q("q.y")[[0, 2]], np.sqrt(5) - 3, atol=2 * off)
        assert result.v("q.vy")[-1] == pytest.approx(np.sqrt(5), abs=2 * off + 1e-5)
    bowl = machine("bowl").simulate(3.0, start={"p.vx": 4.4294}, formulation=formulation)
    assert bowl.outcome is Outcome.OK  # up to 2e-4 below the rim
    assert np.ptp(bowl.energy("total")) < 1e-4


def test_a_function_that_does_not_count_turns_has_no_cut(machine: Callable[[str], Machine]) -> None:
    result = machine("track").simulate(20.0)
    assert result.outcome is Outcome.OK
    x, y = result.q("p.x"), result.q("p.y")
    assert np.unwrap(np.arctan2(y, x))[-1] > 2 * np.pi
    np.testing.assert_allclose(np.hypot(x, y), 1 + np.cos(3 * np.arctan2(y, x)) / 5, atol=1e-9)


@pytest.mark.parametrize("instants", [5, 8])
@pytest.mark.parametrize("off", [0.0, 1e-3])
def test_driven_machines_end_at_a_kink(workshop: Path, off: float, instants: int) -> None:
    model = Model(f"driven_kink_{'miss' if off else 'hit'}")
    p, q = model.particle("p", mass=1.0), model.particle("q", mass=3.0)
    model.absolute("rail", p, "x", off)
    model.absolute("rail_of_q", q, "x", 1.0)
    model.driver("lift", p.y, t - 1)
    model.constraint("rope", sp.sqrt(p.x**2 + p.y**2) - q.y - 3)
    model.scene("run", drivers=["lift"], guess={q.y: -2.0})
    driven = load(model, folder=workshop)
    for analysis in (driven.kinematics, driven.inverse_dynamics):
        result = analysis(np.linspace(0.0, 2.0, instants))
        if off:
            assert result.outcome is Outcome.OK
            assert result.v("q.vy")[-1] == pytest.approx(1.0, abs=1e-5)
        else:
            assert result.outcome is Outcome.DISCONTINUOUS
            assert result.t[-1] < 1.0
            assert "'rope' sqrt(p_x**2 + p_y**2) comes to 0" in result.message
            assert "at t = 1 s" in result.message


def test_a_guess_without_a_slope_is_left_and_a_start_is_refused(workshop: Path) -> None:
    model = Model("string_at_its_pin", gravity=(0, -9.81))
    p = model.particle("p", mass=1.0)
    model.constraint("rope", sp.sqrt(p.x**2 + p.y**2) - 1)
    model.scene("guessed", ["gravity"])
    model.scene("fixed", ["gravity"], start={p.x: 0.0, p.y: 0.0})
    result = load(model, "guessed", folder=workshop).simulate(1.0)
    assert result.outcome is Outcome.OK
    np.testing.assert_allclose(np.hypot(result.q("p.x"), result.q("p.y")), 1.0, atol=1e-9)
    with pytest.raises(AssemblyError, match="Φ_q of constraint 'rope' is nan"):
        load(model, "fixed", folder=workshop).simulate(1.0)


X, EPS = sp.symbols("x eps")
GENTLE = {  # y(x), and y'(x)
    "product": (X * sp.sqrt(X**2 + EPS**2) / 2, np.abs),
    "shifted": ((X + 0.3) * sp.sqrt((X + 0.3) ** 2 + EPS**2) / 2, lambda x: np.abs(x + 0.3)),
    "fourth": (sp.sqrt(X**4 + EPS**4) / 2, lambda x: x),
    "cosine": (sp.cos(sp.sqrt(X**2 + EPS**2)), lambda x: -np.sin(x)),
}


@pytest.mark.parametrize("name", GENTLE)
def test_runs_pass_a_root_at_which_no_slope_jumps(workshop: Path, name: str) -> None:
    equation, slope = GENTLE[name]
    model = Model(f"gentle_{name}", gravity=(0, -9.81))
    p, eps = model.particle("p", mass=1.5), model.parameter("eps", 0.0)
    model.constraint("wire", p.y - equation.subs({X: p.x, EPS: eps}))
    model.driver("push", p.x, t - 1)
    model.scene("run", ["gravity"], start={p.x: -1.0, p.vx: 4.5})
    model.scene("driven", ["gravity"], drivers=["push"], guess={p.x: -1.0})
    one, ends = load(model, "run", folder=workshop), []
    for formulation, method in [*product(("cartesian",), METHODS), ("reduced", "dop853")]:
        result = one.simulate(0.6, 31, method=method, formulation=formulation, rtol=1e-9)
        assert result.outcome is Outcome.OK, (formulation, method)
        assert np.ptp(result.energy("total")) < 1e-5
        assert result.q("p.x")[-1] > 0.5
        ends.append(result.q("p.x")[-1])
    assert np.ptp(ends) < 1e-6
    driven = load(model, "driven", folder=workshop).inverse_dynamics([0.5, 1.0, 1.5])
    assert driven.outcome is Outcome.OK
    np.testing.assert_allclose(driven.v("p.vy"), slope(driven.q("p.x")), atol=1e-9)


def _driven(workshop: Path, name: str) -> Machine:
    model = Model(f"lost_{name}")
    a, b = model.particle("a", mass=1.0), model.particle("b", mass=1.0)
    model.absolute("rail", a, "y", 0.0)
    if name == "meet":
        model.absolute("x", b, "x", 0.0)
        model.absolute("y", b, "y", 0.0)
        model.distance_driver("lost", b, a, 0.3 - 0.3 * t)
    else:
        functions = {"tan": sp.tan, "quotient": lambda x: 1 / (sp.pi / 2 - x), "log": sp.log}
        model.absolute("y", b, "y", 0.0)
        model.constraint("lost", a.x - functions[name](b.x))
        model.driver("push", b.x, 1 - t if name == "log" else 0.1 + t)
    model.scene("run", drivers=["lost" if name == "meet" else "push"], guess={a.x: 0.3, b.x: 0.5})
    return load(model, folder=workshop)


@pytest.mark.parametrize("name", ["meet", "tan", "quotient", "log"])
def test_driven_machines_end_at_once_where_points_meet_and_at_poles(
    workshop: Path, name: str
) -> None:
    machine = _driven(workshop, name)
    instant = 1.0 if name in ("meet", "log") else np.pi / 2 - 0.1
    outcome, said = Outcome.NOT_FINITE, "a slope grows without bound"
    if name == "meet":
        outcome, said = Outcome.DISCONTINUOUS, "a slope jumps"
        assert np.ptp(machine.kinematics(2.0).v("a.vx")) < 1e-9  # no row has the speed beyond
    for analysis in (machine.kinematics, machine.inverse_dynamics, machine.simulate):
        result = analysis(2.0)
        assert result.outcome is outcome
        assert f"'lost' {said}" in result.message
        assert instant - 0.01 < result.t[-1] < instant + 1e-9
        assert result.stats["steps"] < 100_000


@pytest.mark.parametrize("method", ["energy", "settling"])
def test_a_search_for_rest_names_the_kink_that_it_comes_to(workshop: Path, method: str) -> None:
    model = Model("rest_in_a_kink", gravity=(0, -9.81))
    p, eps = model.particle("p", mass=1.5), model.parameter("eps", 0.0)
    model.constraint("wire", p.y - sp.sqrt(p.x**2 + eps**2))
    model.scene("run", ["gravity"], guess={p.x: 0.5})
    rest = load(model, folder=workshop).equilibrium(method)
    assert rest.outcome is Outcome.UNBALANCED
    assert "In joint 'wire' sqrt(p_x**2 + eps**2) comes to 0" in rest.message


def test_runs_of_an_ensemble_end_at_a_kink(machine: Callable[[str], Machine]) -> None:
    done = machine("ring").ensemble(2.0, 3, starts={"p.y": np.array([1.0, 1.5])})
    assert list(done["outcome"].values) == ["DISCONTINUOUS", "OK"]


def test_sparse_instants_pass_no_kink_and_a_square_is_no_steep_place(workshop: Path) -> None:
    model = Model("kink_between_instants")
    p, q = model.particle("p", mass=1.0), model.particle("q", mass=1.0)
    for body in (p, q):
        model.absolute(f"rail_{body.name}", body, "y", 0)
    model.constraint("row", q.x - sp.sqrt((p.x**2 - 2 * p.x + 1).expand()))
    model.driver("pull", p.x, 1 + sp.sin(t))
    model.scene("driven", drivers=["pull"], guess={q.x: 1})
    driven = load(model, folder=workshop)
    for last in (4.0, 7.0, 20.0):
        result = driven.kinematics([0.5, last], t_start=0.5)
        assert result.outcome is Outcome.DISCONTINUOUS
        assert result.t.tolist() == [0.5]
        assert "comes to 0, where its slope jumps, at t = 3.14159" in result.message
    assert driven.kinematics([0.5, 3.1], t_start=0.5).outcome is Outcome.OK
