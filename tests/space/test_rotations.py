"""Rotation matrices, angular velocities and their derivatives in the graph, and for SymPy."""

import math
from itertools import product
from typing import Any

import numpy as np
import pytest
import sympy
from numpy.testing import assert_allclose

from codegen import Model
from codegen.declare.drawn_pose import attitude_of_axes, attitude_of_vector, rotation_of
from codegen.declare.rotation_entries import rotation_matrix, spin
from codegen.declare.symbols import coordinate
from codegen.derive.equations import derive
from codegen.lower.differentiation.derivative_along_motion import Direction
from codegen.lower.differentiation.gradient import Slopes
from codegen.lower.differentiation.turning import Turn
from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.lowered_scene import lower
from codegen.lower.program import Kernel, Op, Program, store
from runtime.mechanism.spins import rotation_matrices, spins
from tests.space.rotations import about, matrix_g, parameters_of, rotation, unit

P = [0.5, -0.1, 0.7, 0.5]
W = np.array([0.7, -1.1, 0.4])
RATES = (matrix_g(np.array(P)).T @ W / 2).tolist()


def values(graph: Graph, numbers: list[int]) -> list[float]:
    kernel = Kernel("values", "", (), store("out", numbers, [""] * len(numbers)))
    program = Program(tuple(graph.values), (kernel,), (), 0.0)
    out = evaluate(program, "values", {"q": P, "v": RATES, "p": []}, math)["out"]
    return [out[k] for k in range(len(numbers))]


def turn_of() -> tuple[Graph, Turn]:
    graph = Graph()
    q = [graph.input("q", k, f"e{k}") for k in range(4)]
    v = [graph.input("v", k, f"e{k}dot") for k in range(4)]
    return graph, Turn(graph, 0, 0, q, v)


def test_entries_are_those_of_the_rotation() -> None:
    graph, turn = turn_of()
    found = np.reshape(values(graph, [e for row in turn.entries for e in row]), (3, 3))
    assert_allclose(found, rotation(np.array(P)), rtol=0.0, atol=1e-15)
    assert_allclose(rotation_matrices(np.array(P)), rotation(np.array(P)), rtol=0.0, atol=1e-15)
    assert_allclose(values(graph, turn.omega), W, rtol=0.0, atol=1e-15)
    assert_allclose(spins(np.array(P), np.array(RATES)), W, rtol=0.0, atol=1e-15)


def test_sympy_differentiates_entries_as_what_they_are() -> None:
    p = tuple(coordinate("b", f"e{k}") for k in range(4))
    rates = tuple(e.rate for e in p)
    entries = [*rotation_matrix(p), *spin(p, rates)]
    for entry, symbol in product(entries, (*p, *rates)):
        assert sympy.expand(sympy.diff(entry, symbol) - sympy.diff(entry.polynomial(), symbol)) == 0
    assert rotation_matrix((1, 0, 0, 0)) == sympy.eye(3)


@pytest.mark.parametrize("first", [None, min, max])
def test_slopes_by_turns_and_derivatives_along_the_motion(first: Any) -> None:
    """Of (A s)ᵀ (A s'), (A s)_x³ and |A s + c|, against A ẽ_k and A ω̃, or ẽ_k A, by hand."""
    graph, turn = turn_of()
    s, other, c = np.array([0.3, -0.2, 0.5]), np.array([1.0, 2.0, -0.7]), np.array([0.2, 0.1, 3.0])

    def turned(vector: np.ndarray) -> list[int]:
        numbers = [graph.constant(x) for x in vector]
        return [graph.dot(row, numbers) for row in turn.entries]

    arm, far = turned(s), turned(other)
    fixed = [graph.add(a, graph.constant(x)) for a, x in zip(arm, c, strict=True)]
    made = [
        graph.mul(arm[0], far[1]), graph.power(arm[0], 3.0),
        graph.function(Op.SQRT, graph.dot(fixed, fixed)),
    ]  # fmt: skip
    a = rotation(np.array(P))

    def by_hand(matrix: np.ndarray) -> np.ndarray:
        x, y = matrix @ s, matrix @ other
        return np.array([x[0] * y[1], x[0] ** 3, np.linalg.norm(x + c)])

    in_ground = first is not None
    slopes = Slopes(graph, (), [turn], in_ground=in_ground)
    for k, value in enumerate(made):
        found = slopes.gradient({value: graph.one})
        step = 1e-6
        for axis, number in enumerate(turn.axes):
            e = np.eye(3)[axis]
            pair = [about(e, way * step) for way in (1, -1)]
            ends = [by_hand(by @ a if in_ground else a @ by)[k] for by in pair]
            by_difference = (ends[0] - ends[1]) / (2 * step)
            (slope,) = values(graph, [found.get(number, graph.zero)])
            assert slope == pytest.approx(by_difference, abs=1e-9)
    rates = dict(zip(turn.p, turn.rates, strict=True))
    motion = Direction(graph, rates, jets=turn.jets(in_ground=in_ground), first=first)
    jets = [motion.jet(value) for value in made]
    first = values(graph, [jet.first.value() for jet in jets])
    second = values(graph, [jet.second.value() for jet in jets])
    step, axis = 1e-4, W / np.linalg.norm(W)  # ω' constant: A(t) = A exp(ω̃ t)
    ahead, here, back = (by_hand(a @ about(axis, np.linalg.norm(W) * h)) for h in (step, 0, -step))
    assert_allclose(first, (ahead - back) / (2 * step), rtol=0.0, atol=1e-7)
    assert_allclose(second, (ahead - 2 * here + back) / step**2, rtol=0.0, atol=1e-6)


def test_an_equation_in_euler_parameters_has_the_columns_of_a_turn() -> None:
    """f·h = 0 of two bodies, written out in e0 ... e3, gives the accelerations of the joint."""
    found = []
    for written_out in (False, True):
        model = Model(f"axes_{written_out}", space=True, gravity=(0, 0, -9.81))
        a = model.body("a", 1.0, (1.0, 2.0, 2.5))
        b = model.body("b", 2.0, (1.0, 1.5, 2.0, 0.1, 0.2, -0.1))
        f, h = a.A[:, 0], b.A[:, 2]
        phi = f.dot(h)
        if written_out:
            phi = phi.xreplace({e: e.polynomial() for e in (*a.A, *b.A)})
        model.constraint("cross", phi)
        model.torque("twist", a, (0.3, 0.2 * a.omega_y, -0.1))
        model.scene("spin", effects=["gravity", "twist"])
        program = lower(derive(model, model.scenes["spin"])).program
        q, v = [], []
        rng = np.random.default_rng(4)
        first, second = about(unit(rng), 0.7), about(unit(rng), 1.1)
        second = np.column_stack([second[:, 0], np.cross(first[:, 0], second[:, 0]), np.zeros(3)])
        second[:, 1] /= np.linalg.norm(second[:, 1])
        second[:, 2] = np.cross(second[:, 0], second[:, 1])
        second = second[:, [2, 0, 1]]  # its z axis is perpendicular to f
        w_a, w_b = rng.normal(size=(2, 3))
        c = np.cross(first[:, 0], second[:, 2])
        w_b -= second.T @ c * (c @ (second @ w_b - first @ w_a)) / (c @ c)
        for matrix, w in ((first, w_a), (second, w_b)):
            p = parameters_of(matrix)
            q += [*rng.normal(size=3), *p]
            v += [*rng.normal(size=3), *(matrix_g(p).T @ w / 2)]
        arguments = {"t": 0.0, "q": q, "v": v, "p": []}
        phi_value = evaluate(program, "constraints", arguments, math)["phi"]
        assert max(map(abs, phi_value.values())) < 1e-12
        out = evaluate(program, "accelerations", arguments, math)
        found.append([*out["a"].values(), *out["lam"].values()])
    assert_allclose(found[1], found[0], rtol=0.0, atol=1e-11)
    assert np.abs(found[0]).max() > 0.1


@pytest.mark.parametrize("seed", range(5))
def test_attitudes_of_the_drawing(seed: int) -> None:
    rng = np.random.default_rng(seed)
    axis, angle = unit(rng), rng.uniform(0.1, 3.1)
    turned = about(axis, angle)
    by_vector = rotation_of(attitude_of_vector(angle * axis))
    by_axes = attitude_of_axes(2.0 * turned[:, 0], turned[:, 1] + 0.3 * turned[:, 0])
    assert by_axes is not None
    assert_allclose(by_vector, turned, rtol=0.0, atol=1e-14)
    assert_allclose(rotation_of(by_axes), turned, rtol=0.0, atol=1e-14)
    assert attitude_of_axes(axis, 3.0 * axis) is None


def test_half_turns_have_attitudes() -> None:
    for axis in np.eye(3):
        turned = 2 * np.outer(axis, axis) - np.eye(3)
        found = attitude_of_axes(turned[:, 0], turned[:, 1])
        assert found is not None
        assert_allclose(rotation_of(found), turned, rtol=0.0, atol=1e-14)


def test_forces_and_potentials_along_euler_parameters() -> None:
    """Q_p of a user has a part along p, which only the multiplier of pᵀp = 1 feels."""
    model = Model("pushed", space=True)
    body = model.body("b", 2.0, (1.0, 1.5, 2.0, 0.1, 0.2, -0.1))
    model.generalized_force("pull", {body.e1: 0.3 + body.x, body.e0: -0.7, body.y: 1.0})
    model.potential("well", 2 * body.e2**2 + body.e1 * body.z)
    model.scene("s", effects=["pull", "well"])
    lowered = lower(derive(model, model.scenes["s"]))
    q, v = [0.1, 0.2, -0.3, *P], [0.4, -0.5, 0.6, *RATES]
    arguments = {"t": 0.0, "q": q, "v": v, "p": []}

    def written(kernel: str, array: str) -> np.ndarray:
        out = evaluate(lowered.program, kernel, arguments, math)[array]
        return np.array([out[k] for k in range(len(out))])

    a, lam = written("accelerations", "a"), written("accelerations", "lam")
    pattern, mass = lowered.description.mass, np.zeros((7, 7))
    mass[list(pattern.rows), list(pattern.columns)] = written("mass", "values")
    p = np.array(P)
    slopes = np.array([0, 0, 0, *(2 * p)])
    assert_allclose(mass @ a + slopes * lam, written("applied_forces", "Q"), rtol=0.0, atol=1e-13)
    # n' = ½ G Q_p, by hand
    push = np.array([-0.7, 0.3 + q[0] - q[2], -4 * p[2], 0.0])
    j = np.array([[1.0, 0.1, 0.2], [0.1, 1.5, -0.1], [0.2, -0.1, 2.0]])
    expected = np.linalg.solve(j, matrix_g(p) @ push / 2 - np.cross(W, j @ W))
    assert_allclose(2 * matrix_g(p) @ a[3:], expected, rtol=0.0, atol=1e-13)
    assert lam[0] == pytest.approx(W @ j @ W + p @ push / 2, abs=1e-13)
