"""A body with a mass block that depends on the pose: its equations, and what refuses it by name."""

import cmath
import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.declare.symbols import CoordinateKind, declare_letter
from codegen.errors import ModelError
from codegen.lower.differentiation.program_tangents import tangent_program
from codegen.lower.interpreter import evaluate
from tests.codegen.elements.turned_body import turned_body
from tests.codegen.workbench import Interpreted, State, complex_gamma, complex_step, plain

POSES = [0.0, 0.7, math.pi / 2, math.pi, -2.4]
"""Among them those in which e0 or e1, and with it a gradient of e0² + e1² - 1, vanishes."""


def pendulum() -> Interpreted:
    model = Model("swing", gravity=(0, -9.81))
    body = turned_body(model, "bar", 2.0, 0.3, (0.2, -0.1))
    model.revolute("pin", model.ground.at(0, 0), body.at(-0.4, 0.1))
    model.scene("fall", effects=["gravity"])
    return Interpreted(model)


def mass(machine: Interpreted, s: State, functions=math) -> np.ndarray:
    values = machine.vector("mass", s, functions)
    found = np.zeros((machine.n, machine.n), dtype=values.dtype)
    pattern = machine.lowered.description.mass
    found[list(pattern.rows), list(pattern.columns)] = values
    return found


def state(phi: float) -> State:
    """On the constraints, turning."""
    e = np.array([math.cos(phi / 2), math.sin(phi / 2)])
    machine = pendulum()
    s = State(t=0.0, q=np.array([0.0, 0.0, *e]), v=np.zeros(4))
    phi_now = machine.vector("constraints", s)
    s.q[:2] -= phi_now[1:] * (1 if machine.jacobian(s)[1, 0] > 0 else -1)
    assert_allclose(machine.vector("constraints", s), 0.0, atol=1e-15)
    jacobian = machine.jacobian(s)
    null = np.linalg.svd(jacobian)[2][-1]
    return State(t=0.0, q=s.q, v=3.0 * null)


@pytest.mark.parametrize("phi", POSES)
def test_the_block_is_definite_and_every_pivot_exists(phi: float) -> None:
    machine, s = pendulum(), state(phi)
    block = mass(machine, s)
    assert np.linalg.eigvalsh(block).min() > 0.0
    assert np.count_nonzero(block - np.diag(np.diag(block))) > 4
    jacobian = machine.jacobian(s)
    whole = np.block([[block, jacobian.T], [jacobian, np.zeros((machine.m, machine.m))]])
    right = [machine.vector("applied_forces", s), machine.vector("acceleration_rhs", s)]
    expected = np.linalg.solve(whole, np.concatenate(right))
    a, lam = machine.solution(s)
    assert_allclose(np.concatenate([a, lam]), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("phi", POSES)
def test_the_inertia_force_is_that_of_lagrange(phi: float) -> None:
    """Q_v = T_q - Ṁ q̇ on the velocities that the body allows, and γ, by complex steps."""
    machine, s = pendulum(), state(phi)

    def energy(q: np.ndarray) -> np.ndarray:
        return np.array([machine.vector("kinetic_energy", State(t=0.0, q=q, v=s.v), cmath)])

    def momentum(q: np.ndarray) -> np.ndarray:
        return mass(machine, State(t=0.0, q=q, v=s.v), cmath) @ s.v

    gradient = complex_step(energy, s.q)[0]
    lagrange = gradient - complex_step(momentum, s.q) @ s.v
    still = State(t=0.0, q=s.q, v=np.zeros(machine.n))
    force = machine.vector("applied_forces", s) - machine.vector("applied_forces", still)
    free = np.eye(4) - np.outer(normal(s), normal(s))  # along the gradient λ takes the difference
    assert_allclose(free @ force, free @ lagrange, atol=1e-12)
    assert_allclose(machine.vector("acceleration_rhs", s), complex_gamma(machine, s), atol=1e-12)


@pytest.mark.parametrize("phi", POSES)
def test_derivatives_of_accelerations(phi: float) -> None:
    """Those of the derivatives' module against complex steps through the kernel itself."""
    machine, s = pendulum(), state(phi)
    program = tangent_program(machine.program)
    direction = np.random.default_rng(3).standard_normal((2, machine.n))
    inputs = {"t": 0.0, "q": plain(s.q), "v": plain(s.v), "p": machine.p, "modes": []}
    inputs |= {"dq": plain(direction[0]), "dv": plain(direction[1])}
    out = evaluate(program, "accelerations_tangent", inputs, math)["da"]

    def moved(h: np.ndarray) -> np.ndarray:
        at = State(t=0.0, q=s.q + h[0] * direction[0], v=s.v + h[0] * direction[1])
        return machine.flat("accelerations", at, cmath)["a"]

    expected = complex_step(moved, np.zeros(1))[:, 0]
    got = [out[k] for k in range(machine.n)]
    assert_allclose(got, expected, atol=1e-11 * np.abs(expected).max())


def normal(s: State) -> np.ndarray:
    return np.array([0.0, 0.0, *s.q[2:]]) / np.linalg.norm(s.q[2:])


def test_what_asks_for_an_angle_refuses_it_by_name() -> None:
    model = Model("angles")
    body = turned_body(model, "rod", 1.0, 0.1, (0.0, 0.0))
    other = model.body("other", 1.0, 0.1)
    model.weld("fixed", body.at(0, 0), other.at(0, 0))
    model.torsion_spring("coil", body, other, stiffness=1.0)
    model.revolute("pin", body.at(0, 0), other.at(0, 0))
    with pytest.raises(ModelError) as raised:
        Interpreted(model)
    text = str(raised.value)
    assert "weld 'fixed' asks for the angle of 'rod', which is oriented by x, y, e0, e1" in text
    assert "torsion spring 'coil' needs the angle of 'rod', which has none" in text
    assert "revolute" not in text.replace("such as revolute", "")


def test_a_letter_has_one_meaning() -> None:
    declare_letter("e0", CoordinateKind("e0dot", "1", 1.0))
    with pytest.raises(ValueError, match="'e0' or velocity 'e0dot' means something else"):
        declare_letter("e0", CoordinateKind("e0dot", "rad"))
    with pytest.raises(ValueError, match="means something else"):
        declare_letter("e9", CoordinateKind("vx", "m"))
