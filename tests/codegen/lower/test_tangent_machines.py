"""Derivatives of whole machines on their constraints, against complex steps and Haug's formulas."""

import cmath
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.emit.module import Origin, tangents_text
from codegen.lower.differentiation.program_tangents import tangent_program
from codegen.lower.operation_count import operations
from codegen.lower.program import Program
from codegen.reading.model_file import read_model
from tests.codegen.directions import assembled, by_complex_step, by_tangent, dependent
from tests.codegen.elements.rubbing_slider_crank import rubbing_slider_crank
from tests.codegen.workbench import STEP, Interpreted, State, plain, python_functions


def library(name: str, scene: str) -> Callable[[Path], Interpreted]:
    return lambda root: Interpreted(read_model(root / "models" / f"{name}.py").model, scene)


def with_friction(count: int) -> Callable[[Path], Interpreted]:
    def made(root: Path) -> Interpreted:
        model = rubbing_slider_crank(count)
        guess = {"crank.phi": 0.8, "rod.x": 1.0, "rod.y": 0.2, "rod.phi": -0.4, "slider.x": 1.5}
        model.scene("run", effects=model.effects, guess=guess)
        return Interpreted(model, "run")

    return made


def drag_and_springs(root: Path) -> Interpreted:
    """A pendulum on a slider with forces of all smooth kinds, and without a single switch."""
    model = Model("smooth", gravity=(0.0, -9.81))
    cart, bob = model.body("cart", mass=2.0, inertia=0.3), model.body("bob", mass=1.0, inertia=0.1)
    model.translational("rail", model.ground, cart, axis=(1.0, 0.2))
    model.revolute("pin", cart.at(0.1, 0.0), bob.at(0.0, 0.7))
    ends = model.ground.at(-1.0, 0.0), bob.at(0.0, 0.0)
    model.spring("spring", *ends, stiffness=90.0, free_length=1.1, damping=2.0)
    model.force("drag", on=bob, fx=-0.3 * bob.vx * (bob.vx**2 + bob.vy**2) ** 0.5)
    model.scene("swing", effects=model.effects, guess={"bob.y": -0.7})
    return Interpreted(model, "swing")


MACHINES: dict[str, Callable[[Path], Interpreted]] = {
    "slider-crank": library("slider_crank", "compressor"),
    "driven slider-crank": library("slider_crank", "inverse_dynamics"),
    "massless rod": library("slider_crank", "compressor_massless_rod"),
    "quick return": library("quick_return", "shaper"),
    "valve lifter": library("valve_lifter", "inverse_dynamics"),
    "free follower": library("valve_lifter", "free_follower"),
    "coil spring": library("coil_spring", "impact"),
    "web cutter": library("web_cutter", "running"),
    "states of an arm": library("robot_arm", "integral"),
    "friction in one joint": with_friction(1),
    "friction in four joints": with_friction(4),
    "drag and springs": drag_and_springs,
}


@pytest.fixture(scope="module", params=MACHINES)
def machine(root: Path, request: pytest.FixtureRequest) -> Interpreted:
    return MACHINES[request.param](root)


@pytest.fixture(scope="module")
def tangents(machine: Interpreted) -> Program:
    return tangent_program(machine.program)


def agree(got: np.ndarray, expected: np.ndarray) -> None:
    assert_allclose(got, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max(initial=1e-30))


def test_accelerations(machine: Interpreted, tangents: Program) -> None:
    random = np.random.default_rng(3)
    for seed in range(3):
        s = assembled(machine, seed)
        for modes in ([0] * machine.s, [1] * machine.s, plain(random.integers(0, 2, machine.s))):
            dq, dv = random.standard_normal((2, machine.n))
            expected = by_complex_step(machine, "accelerations", ("a",), s, dq, dv, modes=modes)
            kernel = "accelerations_tangent"
            got = by_tangent(machine, tangents, kernel, ("da",), s, modes=modes, dq=dq, dv=dv)
            agree(got, expected)
            assert np.abs(got).max() > 0


def test_correction(machine: Interpreted, tangents: Program) -> None:
    """Also off the constraints, where it moves, and for weights of any kind."""
    random = np.random.default_rng(4)
    for seed in range(3):
        s = assembled(machine, seed)
        s.q = s.q + 1e-3 * random.standard_normal(machine.n)
        w = random.uniform(0.5, 2.0, machine.n)
        dq, dv = random.standard_normal((2, machine.n))
        arrays = ("dq", "dv")
        expected = by_complex_step(machine, "correction", arrays, s, dq, dv, w=w)
        more = {"w": w, "dq_in": dq, "dv_in": dv}
        got = by_tangent(machine, tangents, "correction_tangent", arrays, s, **more)
        for one, other in zip(got, expected, strict=True):
            agree(one, other)


def test_correction_gives_the_dependent_from_the_independent(
    machine: Interpreted, tangents: Program
) -> None:
    """H e_k by -Φ_u⁻¹ Φ_v, and the dependent velocities u̇ = -Φ_u⁻¹ (Φ_v v̇ + Φ_t) along it."""
    s = assembled(machine, 5)
    u = dependent(machine, s)
    w = np.zeros(machine.n)
    w[u] = 1.0
    nothing = np.zeros(machine.n)

    def along(dq: np.ndarray) -> np.ndarray:
        more = {"w": w, "dq_in": dq, "dv_in": nothing}
        return by_tangent(machine, tangents, "correction_tangent", ("dq", "dv"), s, **more)

    held = [k for k in range(machine.n) if k not in u]
    for k in held:
        unit = np.eye(machine.n)[k]
        column = unit + along(unit)[0]
        jacobian = machine.jacobian(s)
        exact = np.zeros(machine.n)
        exact[k], exact[u] = 1.0, np.linalg.solve(jacobian[:, u], -jacobian[:, k])
        assert_allclose(column, exact, rtol=1e-10, atol=1e-10 * np.abs(exact).max())
        moved = State(t=s.t, q=s.q + 1j * STEP * exact, v=s.v)
        turned = machine.jacobian(moved, cmath)
        right = machine.vector("velocity_rhs", moved, cmath) - turned[:, held] @ s.v[held]
        change = np.imag(np.linalg.solve(turned[:, u], right)) / STEP
        got = along(column)[1]
        assert_allclose(got[u], change, rtol=1e-9, atol=1e-9 * np.abs(change).max(initial=1.0))
        assert_allclose(got[held], 0.0, atol=0.0)


def test_text_computes_the_same_from_the_constants_of_the_main_module(
    machine: Interpreted, tangents: Program
) -> None:
    origin = Origin("linkwright", (("m.py", "0" * 64),), "0" * 64, "build")
    text = tangents_text(machine.lowered, tangents, origin, "0" * 64)
    functions = python_functions(text)
    assert dict(functions["OPERATIONS"]) == {
        k.name: operations(tangents, k) for k in tangents.kernels
    }
    p = [*machine.p, *[math.nan] * len(machine.program.constants)]
    python_functions(machine.text())["constants"](p)
    s, n = assembled(machine, 1), machine.n
    modes, dq, dv = (
        [1] * machine.s,
        [0.3 * k - 1 for k in range(n)],
        [1.7 - 0.2 * k for k in range(n)],
    )
    state = (s.t, plain(s.q), plain(s.v), p)
    out = [math.nan] * n
    functions["accelerations_tangent"](*state, modes, dq, dv, out)
    expected = by_tangent(machine, tangents, "accelerations_tangent", ("da",), s, dq=dq, dv=dv)
    assert_allclose(out, expected[0], rtol=1e-12, atol=1e-12 * np.abs(expected).max())
    w, out_q, out_v = [1.0] * n, [math.nan] * n, [math.nan] * n
    functions["correction_tangent"](*state, w, dq, dv, out_q, out_v)
    more = {"w": w, "dq_in": dq, "dv_in": dv}
    expected = by_tangent(machine, tangents, "correction_tangent", ("dq", "dv"), s, **more)
    assert_allclose([out_q, out_v], expected, rtol=1e-12, atol=1e-12 * np.abs(expected).max())
    functions["correction_tangent"](*state, w, dq, dv, dq, dv)  # in place
    assert (dq, dv) == (out_q, out_v)
