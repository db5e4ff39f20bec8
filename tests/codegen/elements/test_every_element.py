"""Laws that every kind of element obeys: the library's, and one of a user's own."""

import cmath
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen.declare.element import Constraint, Frame, JointReaction
from codegen.declare.symbols import Parameter
from codegen.elements.registry import kinds_of_elements
from codegen.reference.pages import Example, example_of
from tests.codegen.elements.drum import StringOnDrum, winch
from tests.codegen.workbench import Interpreted, State, along, complex_gamma, complex_step

OWN = StringOnDrum.kind
KINDS = (*(name for name, kind in kinds_of_elements().items() if not kind.is_user_defined), OWN)
TOLERANCE = {"rtol": 1e-11, "atol": 1e-11}
SEEDS = range(4)

TIED = {
    "absolute": "to the ground",
    "constraint": "to the coordinates that it is written in",
    "driver": "to the global angle that it prescribes",
    "point driver": "to the ground",
    "force": "to whatever exerts it",
    "generalized force": "to whatever exerts it",
    "gravity": "to the earth",
    "potential": "to the global angle that it is written in",
    "torque": "to whatever exerts it",
}
"""Kinds that push a pair of bodies from outside."""

TURNING = {
    "relative": "the global axes that keep x_j - x_i bear its moment",
    "belt": "the ground that carries the bearings bears its moment",
    "elastic belt": "the ground that carries the bearings bears its moment",
    "gear with backlash": "the ground that carries the bearings bears its moment",
    "screw": "the spindle, a third body, bears its moment",
}
"""Kinds that keep a pair's linear momentum alone."""


LINKS = ("distance", "revolute-revolute")


@cache
def example(kind: str) -> Example:
    return example_of(kind, winch() if kind == OWN else None)


@cache
def machine(kind: str) -> Interpreted:
    return Interpreted(example(kind).model)


def names(*roles: str) -> list[str]:
    registered = kinds_of_elements()
    return [name for name in KINDS if registered[name].role in roles]


def balance(q: np.ndarray, forces: np.ndarray) -> np.ndarray:
    """Force on the pair, and moment about the origin."""
    (x, y, _), (fx, fy, n) = (part[:6].reshape(2, 3).T for part in (q, forces))
    return np.array([fx.sum(), fy.sum(), (n + x * fy - y * fx).sum()])


def fitting(kind: str, seed: int) -> State:
    """A random state at which the element's equations and their rates hold."""
    return fitting_state(machine(kind), seed)


def fitting_state(made: Interpreted, seed: int) -> State:
    """A random state at which the constraints and their rates hold, by Newton's method."""
    for attempt in range(20):
        s = made.state(1000 * seed + attempt)
        for _ in range(30):
            s = made.corrected(s) if made.m else s
        if np.abs(made.vector("constraints", s)).max(initial=0.0) < 1e-13:
            return s
    raise AssertionError("no constraints close from any of 20 random states")


def multipliers(kind: str, seed: int) -> np.ndarray:
    return np.random.default_rng(100 + seed).uniform(-2, 2, machine(kind).m)


@pytest.mark.parametrize("kind", names("joint", "driver"))
@pytest.mark.parametrize("seed", SEEDS)
def test_derivatives_are_those_of_the_equations(kind: str, seed: int) -> None:
    made = machine(kind)
    s = made.state(seed)

    def phi(q: np.ndarray) -> np.ndarray:
        return made.vector("constraints", State(t=s.t, q=q, v=s.v), cmath)

    def later(h: complex) -> np.ndarray:
        return made.vector("constraints", State(t=s.t + h, q=s.q, v=s.v), cmath)

    assert_allclose(made.jacobian(s), complex_step(phi, s.q), **TOLERANCE)
    assert_allclose(made.vector("velocity_rhs", s), -along(later), **TOLERANCE)
    assert_allclose(made.vector("acceleration_rhs", s), complex_gamma(made, s), **TOLERANCE)


@pytest.mark.parametrize("kind", names("joint", "driver"))
@pytest.mark.parametrize("seed", SEEDS)
def test_reaction_is_the_force_of_the_multipliers(kind: str, seed: int) -> None:
    made, element = machine(kind), example(kind).element
    assert isinstance(element, Constraint)
    s, lam = made.state(seed), multipliers(kind, seed)
    rows = made.lowered.description.reactions
    values = made.vector("reactions", s, lam=lam)
    told = [x for row, x in zip(rows, values, strict=True) if row[0] == element.name]
    forces = -made.jacobian(s).T @ lam
    statement = element.statement()
    if not isinstance(statement.reaction, JointReaction):
        rates = made.jacobian(s) @ s.v
        assert_allclose(np.dot(told, rates), forces @ s.v, **TOLERANCE)
        return
    frame: Frame = statement.reaction.on
    bound = SimpleNamespace(**{c: statement.bindings[getattr(frame, c)] for c in ("x", "y", "phi")})
    columns = [made.equations.coordinates.index(c) for c in (bound.x, bound.y, bound.phi)]
    fx, fy, torque = told
    arm = statement.reaction.arm or frame.A * frame.s
    ux, uy, ax, ay = (
        number(made, s, e.xreplace(statement.bindings))
        for e in (*statement.reaction.direction, *arm)
    )
    size = ux**2 + uy**2
    if kind not in LINKS:
        assert_allclose(size, 1)
    # Where a link is off its length, the axis is too.
    force = statement.reaction.sign / size * np.array([ux * fx - uy * fy, uy * fx + ux * fy])
    couple = statement.reaction.sign * torque + ax * force[1] - ay * force[0]
    assert_allclose([*force, couple], forces[columns], **TOLERANCE)


def number(made: Interpreted, s: State, expression: sympy.Expr) -> float:
    values = dict(zip(made.equations.coordinates, s.q, strict=True))
    values |= {Parameter(p.name, real=True): p.value for p in made.equations.parameters}
    return float(sympy.sympify(expression).subs(values))


@pytest.mark.parametrize("kind", [name for name in KINDS if name not in TIED])
@pytest.mark.parametrize("seed", SEEDS)
def test_a_free_pair_keeps_its_momentum(kind: str, seed: int) -> None:
    made, s = machine(kind), fitting(kind, seed)
    for modes in [[1] * made.s, [0] * made.s]:
        accelerations, _ = made.solution(s, modes=modes)
        rates = balance(s.q, made.mass(s) @ accelerations)
        scale = 1 + np.abs(accelerations).max()
        assert_allclose(rates[: 2 if kind in TURNING else 3] / scale, 0, atol=1e-11)


@pytest.mark.parametrize("kind", sorted(TIED))
def test_what_is_tied_to_the_world_does_not(kind: str) -> None:
    made = machine(kind)
    rates = []
    for seed in SEEDS:
        s = made.state(seed)
        pushed = made.vector("applied_forces", s)
        if made.m:
            pushed = pushed - made.jacobian(s).T @ multipliers(kind, seed)
        rates.append(balance(s.q, pushed))
    assert np.abs(rates).max() > 1e-3


@pytest.mark.parametrize("kind", names("joint", "driver"))
@pytest.mark.parametrize("seed", SEEDS)
def test_accelerations_obey_the_constraints(kind: str, seed: int) -> None:
    made = machine(kind)
    s = made.state(seed)
    accelerations, _ = made.solution(s)
    gamma = made.vector("acceleration_rhs", s)
    assert_allclose(made.jacobian(s) @ accelerations, gamma, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("kind", names("force"))
@pytest.mark.parametrize("seed", SEEDS)
def test_gradient_is_that_of_the_potential(kind: str, seed: int) -> None:
    made = machine(kind)
    s = made.state(seed)

    def energy(q: np.ndarray) -> np.ndarray:
        return made.vector("potential", State(t=s.t, q=q, v=s.v), cmath)

    (terms,) = (e.terms for e in made.equations.effects if e.terms.watched is None)
    if terms.potential is not None:
        slopes = complex_step(energy, s.q)
        assert np.abs(slopes).max() > 0
        assert_allclose(made.vector("potential_gradient", s), slopes, **TOLERANCE)


@pytest.mark.parametrize("kind", names("force"))
def test_a_force_does_something(kind: str) -> None:
    """Its forces, or its friction with a joint that is loaded, move the pair in some mode."""
    made = machine(kind)
    s = made.state(1)
    modes = [[mode] * made.s for mode in (1, 0)]
    assert max(np.abs(made.solution(s, modes=m)[0]).max() for m in modes) > 1e-3


@pytest.mark.parametrize("kind", names("joint", "driver"))
def test_own_coordinates_are_determined_by_their_rows(kind: str) -> None:
    made, element = machine(kind), example(kind).element
    statement = element.statement()
    rows = made.jacobian(made.state(3))
    for row, q in statement.own:
        column = made.equations.coordinates.index(q)
        assert rows[statement.rows.index(row), column] != 0
