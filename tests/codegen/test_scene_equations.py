"""The equations of a scene as matrices: those of its kernels, and of a pendulum by hand."""

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model, t
from codegen.reading.model_file import read_model
from tests.codegen.workbench import Interpreted


def closeness(found: np.ndarray, expected: np.ndarray, size: float = 1.0) -> None:
    assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * size)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    ("machine", "scene"),
    [("slider_crank", "compressor"), ("quick_return", "shaper"), ("film_follower", "motor")],
)
def test_they_are_those_of_the_kernels(machine: str, scene: str, seed: int) -> None:
    model = read_model(machine).model
    found, compiled = model.equations(scene), Interpreted(model, scene)
    state = compiled.state(seed)
    if compiled.s:
        state = compiled.on_its_sides(state)
    a, lam = compiled.solution(state)
    values = [state.t, *state.q, *state.v, *lam]
    symbols = [t, *found.q, *found.v, *found.lam]

    def at(matrix: sympy.Matrix) -> np.ndarray:
        function = sympy.lambdify(symbols, matrix.subs(found.parameters), "numpy")
        return np.array(function(*values), dtype=float)

    closeness(at(found.Phi)[:, 0], compiled.vector("constraints", state))
    closeness(at(found.Phi_q), compiled.jacobian(state))
    closeness(at(found.nu)[:, 0], compiled.vector("velocity_rhs", state))
    closeness(at(found.gamma)[:, 0], compiled.vector("acceleration_rhs", state), 10.0)
    m, slopes, force = at(found.M), at(found.Phi_q), at(found.Q)[:, 0]
    size = abs(m * a).max() + abs(slopes * lam[:, None]).max() + abs(force).max()
    closeness(m @ a + slopes.T @ lam, force, 10.0 * size)
    assert len(found.constraints) == len(lam)


def pendulum() -> Model:
    model = Model("pendulum", gravity=(0, -9.81))
    length = model.parameter("length", 1.5, unit="m")
    bob = model.body("bob", mass=2.0, inertia=0.1)
    hinge = model.revolute("hinge", model.ground.at(0, 0), bob.at(-length, 0))
    model.friction("rub", hinge, 0.3, creep=0.01, radius=0.02)
    model.scene("swing", effects=["gravity"])
    model.scene("rubbing", effects=["gravity", "rub"], parameters={length: 2.0})
    return model


def test_a_pendulum_by_hand() -> None:
    model = pendulum()
    found = model.equations()
    bob, length = model.bodies["bob"], model.parameters["length"].symbol
    x, y, phi, omega = bob.x, bob.y, bob.phi, bob.omega
    c, s = sympy.cos(phi), sympy.sin(phi)
    assert found.q == sympy.Matrix([x, y, phi])
    assert found.v == sympy.Matrix([bob.vx, bob.vy, omega])
    assert sympy.diag(2.0, 2.0, 0.1) == found.M
    assert found.constraints == (("hinge", "x"), ("hinge", "y"))
    sign = 1 if found.Phi[0].coeff(x) == 1 else -1
    assert sympy.expand(
        sign * found.Phi - sympy.Matrix([x - length * c, y - length * s])
    ).is_zero_matrix
    slopes = sympy.Matrix([[1, 0, length * s], [0, 1, -length * c]])
    assert sympy.expand(sign * found.Phi_q - slopes).is_zero_matrix
    gamma = -sympy.Matrix([length * c, length * s]) * omega**2
    assert sympy.expand(sign * found.gamma - gamma).is_zero_matrix
    assert found.nu.is_zero_matrix
    assert sympy.Matrix([0, -2.0 * 9.81, 0]) == found.Q
    assert found.parameters == {length: 1.5}


def test_a_friction_has_the_multipliers_of_its_joint() -> None:
    found = pendulum().equations("rubbing")
    assert set(found.lam) <= found.Q.free_symbols
    assert list(found.parameters.values()) == [2.0]


def test_notebooks_show_matrices_and_the_sizes_of_large_ones() -> None:
    shown = pendulum().equations()._repr_latex_()
    assert shown.startswith("$$\n\\begin{aligned}\nq &= ")
    assert r"\Phi_q &= \left[\begin{matrix}" in shown
    assert r"\sin \phi_{\mathrm{bob}}" in shown
    large = read_model("quick_return").model.equations("shaper")._repr_latex_()
    assert r"M &= \text{15 × 15, 15 entries are not 0}" in large
    kinematic = read_model("slider_crank").model.equations("kinematics")
    assert kinematic.M.is_zero_matrix
