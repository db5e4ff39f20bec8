"""Rest where potentials balance coordinate by coordinate, at edges, in flutter, and nowhere."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

from codegen import Model
from codegen.errors import AnalysisError, ParameterError
from runtime import load
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine
from runtime.mechanism.dense_equations import Equations
from runtime.progress_bar import silent
from runtime.statics.energy_minimisation import StaticEquations, minimise
from runtime.statics.rest_stability import Stability

METHODS = pytest.mark.parametrize("method", ["energy", "settling"])
G = 9.81


@pytest.fixture(scope="module")
def hung(workshop: Path) -> Machine:
    """A mass on a vertical guide and a spring."""
    model = Model("hung", gravity=(0, -G))
    mass = model.body("mass", mass=1.3, inertia=1)
    k = model.parameter("k", 100.0, unit="N/m")
    model.translational("guide", model.ground, mass, axis=(0, 1))
    model.potential("spring", k * mass.y**2 / 2)
    model.scene("hang", ["gravity", "spring"], guess={mass.y: 0.3})
    return load(model, folder=workshop)


@METHODS
@pytest.mark.parametrize("exponent", range(-2, 9))
def test_mass_on_a_spring(hung: Machine, method: str, exponent: int) -> None:
    """Weight and spring leave no force in any coordinate; that is rest, and not 0 / 0."""
    k = 10.0**exponent
    rest = hung.equilibrium(method, parameters={"k": k})
    assert rest.outcome is Outcome.OK
    assert rest.stable
    assert rest["mass.y"] == pytest.approx(-1.3 * G / k, rel=1e-12)
    np.testing.assert_allclose(rest.frequencies, np.sqrt(k / 1.3) / (2 * np.pi), rtol=1e-7)


@pytest.mark.parametrize("off", [1e-3, 1e-6, 1e-9, -1e-9])
@pytest.mark.parametrize("exponent", [-2, 2, 8])
def test_position_beside_rest_does_not_pass(hung: Machine, off: float, exponent: int) -> None:
    k = 10.0**exponent
    equations = Equations(hung.mechanism, hung.parameter_values({"k": k}))
    rest = StaticEquations(equations, 0.0, equations.scale(0.3))
    exact, beside = -1.3 * G / k, np.zeros(3)
    assert rest.position(np.array([0.0, exact, 0.0])).balanced
    beside[1] = exact + off * max(abs(exact), 1e-3)
    assert not rest.position(beside).balanced


def test_soft_direction_beside_a_stiff_one_is_judged_by_its_own_stiffness(workshop: Path) -> None:
    model = Model("unequal")
    body = model.body("body", mass=1, inertia=1)
    model.potential("springs", 1e8 * body.x**2 + 1e-2 * body.y**2 + body.phi**2)
    model.scene("rest", ["springs"], guess={body.y: 0.5})
    machine = load(model, folder=workshop)
    equations = Equations(machine.mechanism, machine.parameter_values())
    rest = StaticEquations(equations, 0.0, np.ones(3))
    assert not rest.position(np.array([0.0, 1e-6, 0.0])).balanced
    assert minimise(rest, np.array([0.2, 0.5, 0.1]), silent).balanced
    assert abs(machine.equilibrium()["body.y"]) < 1e-12


@METHODS
def test_body_and_masses_on_springs(workshop: Path, method: str) -> None:
    model = Model("afloat", gravity=(0, -G))
    first, second = (model.body(name, mass=1, inertia=0.2) for name in ("first", "second"))
    model.potential("soft", 15 * (first.x**2 + first.y**2) + first.phi**2)
    model.potential("hook", 17 * (second.y - first.y + 0.3) ** 2 + second.x**2 + second.phi**2)
    model.scene("hang", ["gravity", "soft", "hook"])
    rest = load(model, folder=workshop).equilibrium(method)
    assert rest.outcome is Outcome.OK
    assert rest.stable
    assert rest["first.y"] == pytest.approx(-2 * G / 30, rel=1e-12)
    assert rest["second.y"] == pytest.approx(-2 * G / 30 - 0.3 - G / 34, rel=1e-12)


@pytest.fixture(scope="module")
def contact(workshop: Path) -> Machine:
    """A mass that falls onto a spring which only pushes."""
    model = Model("contact", gravity=(0, -10))
    mass = model.body("mass", mass=1, inertia=1)
    k = model.parameter("k", 1000.0, unit="N/m")
    model.translational("guide", model.ground, mass, axis=(0, 1))
    model.potential("floor", sp.Piecewise((k * mass.y**2 / 2, mass.y < 0), (0, True)))
    model.scene("fall", ["gravity", "floor"], guess={mass.y: 3.0})
    return load(model, "fall", folder=workshop)


@METHODS
@pytest.mark.parametrize("k", [1e3, 1e8])
def test_contact_carries_the_weight(contact: Machine, method: str, k: float) -> None:
    """At 1e8 N/m the contact is thinner than the first difference step."""
    rest = contact.equilibrium(method, parameters={"k": k})
    assert rest.outcome is Outcome.OK
    assert rest.stable
    assert rest["mass.y"] == pytest.approx(-10.0 / k, rel=1e-9)
    np.testing.assert_allclose(rest.frequencies, np.sqrt(k) / (2 * np.pi), rtol=1e-6)


def test_edge_is_told(workshop: Path) -> None:
    model = Model("play")
    body = model.body("body", mass=1, inertia=1)
    stop = sp.Piecewise((50 * (body.x - 1) ** 2, body.x > 1), (0, True))
    model.potential("V", stop + 5 * body.y**2 + body.phi**2 / 2)
    model.scene("rest", ["V"])
    machine = load(model, folder=workshop)
    rest = machine.equilibrium(guess={"body.x": 1.0})
    assert rest.outcome is Outcome.OK
    assert rest.stability is Stability.UNKNOWN
    assert "one side only" in rest.message
    assert "of V" in rest.message
    assert len(rest.frequencies) == 0
    inside = machine.equilibrium(guess={"body.x": 0.2})
    assert inside.stability is Stability.INDIFFERENT
    assert len(inside.frequencies) == 2


@METHODS
def test_kink_is_found_and_not_passed_off_as_balance(workshop: Path, method: str) -> None:
    """V = |x|: the machine stands in the kink, where neither side balances."""
    model = Model("kink")
    body = model.body("body", mass=1, inertia=1)
    model.potential("V", sp.Abs(body.x))
    model.potential("rest", body.y**2 + body.phi**2)
    model.scene("fall", ["V", "rest"], guess={body.x: 0.7})
    rest = load(model, folder=workshop).equilibrium(method)
    assert rest.outcome is Outcome.UNBALANCED
    assert rest["body.x"] == pytest.approx(0.0, abs=1e-9)
    assert "on the boundary of" in rest.message
    assert "the forces jump" in rest.message


@METHODS
def test_what_falls_is_named_and_stays(make: Callable[..., Machine], method: str) -> None:
    rest = make("loose", "loose").equilibrium(method)
    assert rest.outcome is Outcome.UNBALANCED
    assert "nothing holds the machine in stone.y, which ran away" in rest.message
    assert rest["stone.y"] == 0.0


@pytest.mark.parametrize(("push", "flutters"), [(0.5, False), (2.5, True), (3.5, True)])
def test_flutter_has_no_frequencies(workshop: Path, push: float, flutters: bool) -> None:
    """Ziegler's column under a follower force: complex pairs are oscillations that grow."""
    model = Model("ziegler")
    first, second = (model.body(name, mass=1, inertia=1e-6) for name in ("first", "second"))
    follower = model.parameter("P", 1.0)
    model.revolute("A", model.ground.at(0, 0), first.at(-1, 0))
    model.revolute("B", first.at(0, 0), second.at(-1, 0))
    model.potential("springs", first.phi**2 / 2 + (second.phi - first.phi) ** 2 / 2)
    model.force("follower", second, fx=-follower, frame="body")
    model.scene("column", ["springs", "follower"])
    rest = load(model, folder=workshop).equilibrium(parameters={"P": push})
    assert rest.outcome is Outcome.OK
    assert rest.stability is (Stability.UNSTABLE if flutters else Stability.STABLE)
    assert len(rest.frequencies) == (0 if flutters else 2)
    assert ("flutter" in rest.message) is flutters


@pytest.mark.parametrize("rho", [-1.0, 0.0, 1e200])
def test_impossible_masses_name_body_and_parameters(workshop: Path, rho: float) -> None:
    model = Model("dense")
    value = model.parameter("rho", 1.0)
    model.parameter("idle", 1.0)
    body = model.body("block", mass=2 * value, inertia=value**2)
    model.force("push", body, fx=1.0)
    model.scene("free", ["push"])
    machine = load(model, folder=workshop)
    with pytest.raises(ParameterError) as caught:
        machine.simulate(1.0, parameters={"rho": rho})
    text = str(caught.value)
    assert ("the mass of block is -2 kg" if rho < 0 else "the inertia of block is") in text
    assert f"Given are rho = {rho:g}: give other values" in text
    assert "idle" not in text
    for analysis in (machine.equilibrium, lambda **given: machine.inverse_dynamics([0.0], **given)):
        with pytest.raises(ParameterError, match="block"):
            analysis(parameters={"rho": rho})


def test_a_start_at_a_pole_is_refused_without_a_warning_of_numpy(workshop: Path) -> None:
    """Forces and slopes of potentials are infinite there, with opposite signs."""
    model = Model("at_a_pole")
    p = model.particle("p", mass=1.0)
    model.constraint("rail", p.y)
    model.potential("V", 1 / p.x + p.x**2)
    model.force("F", p, fx=1 / p.x**2)
    model.scene("s", ["V", "F"], guess={p.x: 0.0})
    with pytest.raises(AnalysisError, match="not finite"):
        load(model, folder=workshop).equilibrium("settling")
