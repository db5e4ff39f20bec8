"""Square systems: the solution of Φ_q x = r, by whatever way its rows are taken."""

import math

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model, build
from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.corrections import Square
from codegen.lower.linear.sparse_row_elimination import Task
from codegen.lower.program import Kernel, Program, store


def solved(
    numbers: np.ndarray, symbolic: np.ndarray, right: np.ndarray
) -> tuple[np.ndarray, Program, Square]:
    """Solve with the entries marked in `symbolic` known at run time only, and the others now."""
    graph, n = Graph(), len(numbers)
    inputs = [graph.input("a", k, f"a_{k}") for k in range(n * n)]
    sides = [[graph.input("r", n * c + k, f"r_{c}_{k}") for k in range(n)] for c in range(2)]
    entries = {
        (i, k): inputs[n * i + k] if symbolic[i, k] else graph.constant(float(numbers[i, k]))
        for i in range(n)
        for k in range(n)
        if numbers[i, k]
    }
    system = Square(Task(graph, entries, sides))
    x = system.solve()
    names = [f"x_{k}" for k in range(2 * n)]
    outputs = store("x", x[0] + x[1], names)
    kernel = Kernel("solve", "x.", ("a", "r", "x"), outputs, tuple(system.checks), watched=True)
    program = Program(tuple(graph.values), (kernel,), (), 1e-9)
    inputs_given = {"a": numbers.ravel().tolist(), "r": right.ravel().tolist()}
    slots = evaluate(program, "solve", inputs_given, math)["x"]
    return np.array([slots[k] for k in range(2 * n)]).reshape(2, n), program, system


@pytest.mark.parametrize("size", [1, 2, 3, 4, 5, 7])
@pytest.mark.parametrize("known", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("seed", range(3))
def test_solutions_solve(size: int, known: float, seed: int) -> None:
    random = np.random.default_rng(100 * size + seed)
    while True:
        sparse = random.uniform(size=(size, size)) < 0.6
        numbers = np.where(sparse, random.uniform(-2, 2, (size, size)), 0.0)
        if np.linalg.svd(numbers, compute_uv=False)[-1] > 0.1:
            break
    right = random.uniform(-1, 1, (2, size))
    symbolic = random.uniform(size=(size, size)) >= known
    x, _, _ = solved(numbers, symbolic, right)
    assert_allclose(x @ numbers.T, right, atol=1e-10)


def test_rows_fall_into_the_smallest_sets() -> None:
    # A number gives x0; the loop of x1 and x2 follows from it, and x3 from all.
    numbers = np.array([[2.0, 0, 0, 0], [1, 1, 2, 0], [1, 2, 1, 0], [1, 1, 1, 3]])
    symbolic = np.array([[0, 0, 0, 0], *[[1, 1, 1, 1]] * 3], dtype=bool)
    x, _, system = solved(numbers, symbolic, np.ones((2, 4)))
    assert_allclose(x @ numbers.T, 1.0, atol=1e-14)
    assert [check.constraint for check in system.checks] == [2, 3]


def test_vanishing_determinant_is_weak() -> None:
    singular = np.array([[1.0, 2.0], [2.0, 4.0 + 1e-9]])
    for numbers, weak in ((singular, True), (np.array([[1.0, 2.0], [2.0, 1.0]]), False)):
        _, program, system = solved(numbers, np.ones((2, 2), dtype=bool), np.ones((2, 2)))
        (check,) = system.checks
        outputs = store("x", [check.pivot, check.reference], ["pivot", "reference"])
        watched = Kernel("solve", "check.", ("a", "x"), outputs)
        found = evaluate(
            Program(program.values, (watched,), (), 1e-9),
            "solve",
            {"a": numbers.ravel().tolist()},
            math,
        )["x"]
        assert (found[0] <= 1e-9 * found[1]) is weak


@pytest.mark.parametrize(
    "numbers",
    [
        [[1.0, 1.0], [1.0, 1.0]],
        [[0.1, 0.2, 1.0], [0.3, 0.6, 3.0], [0.0, 1.0, 1.0]],
        [[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
    ],
)
def test_rows_that_never_determine_all_are_left_to_others(numbers: list[list[float]]) -> None:
    graph = Graph()
    entries = {
        (i, k): graph.constant(x) for i, row in enumerate(numbers) for k, x in enumerate(row) if x
    }
    assert Square(Task(graph, entries, [[graph.one] * len(numbers)])).solve() is None


def test_redundant_kinematic_scene_is_told() -> None:
    model = Model("twice")
    body = model.body("body", mass=1.0, inertia=1.0)
    for name, letter in (("one", "x"), ("other", "x"), ("third", "y")):
        model.absolute(name, body, letter, 0)
    model.scene("still", analysis="kinematics")
    (scene,) = build(model, "still", check=True).scenes
    (note,) = scene.notes
    assert "only 2 are independent; redundant: other.x" in note
