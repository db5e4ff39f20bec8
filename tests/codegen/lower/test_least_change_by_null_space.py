"""`correction` against fifty digits, where weights are far apart or zero."""

from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen.lower.graph import Graph
from codegen.lower.interpreter import evaluate
from codegen.lower.linear.least_change import NullSpace
from codegen.lower.linear.sparse_row_elimination import Task
from codegen.lower.operation_count import operations
from codegen.reading.model_file import read_model
from tests.codegen.workbench import Interpreted, State, plain, python_functions

SPREAD = 1e12

MACHINES = [
    ("slider_crank", "compressor"),
    ("four_bar", "constant_torque"),
    ("quick_return", "shaper"),
    ("gear_slider", "train_running"),
    ("rack_and_pinion", "running"),
    ("web_cutter", "running"),
]


@pytest.fixture(scope="module", params=MACHINES, ids=lambda pair: pair[0])
def machine(request: Any, root: Path) -> Interpreted:
    name, scene = request.param
    return Interpreted(read_model(root / "models" / f"{name}.py").model, scene)


def exact(machine: Interpreted, s: State, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(dq, dv) by W Φ_qᵀ (Φ_q W Φ_qᵀ)⁻¹ in fifty digits, from the kernels that state Φ and Φ_q."""
    number = np.vectorize(mp.mpf, otypes=[object])
    precise = {"t": mp.mpf(s.t), "q": list(number(s.q)), "v": list(number(s.v))}
    precise |= {"p": [mp.mpf(x) for x in machine.p], "modes": [1] * machine.s}
    program, pattern = machine.program, machine.lowered.description.jacobian

    def vector(kernel: str, array: str) -> Any:
        out = evaluate(program, kernel, precise, mp)[array]
        return mp.matrix([out[k] for k in range(len(out))])

    jacobian = mp.zeros(machine.m, machine.n)
    places = zip(pattern.rows, pattern.columns, strict=True)
    for (i, k), value in zip(places, vector("jacobian", "values"), strict=True):
        jacobian[i, k] = value
    W = mp.diag([mp.mpf(x) for x in w])
    rate = jacobian * mp.matrix(precise["v"]) - vector("velocity_rhs", "nu")
    found = []
    for right in (vector("constraints", "phi"), rate):
        mu = mp.lu_solve(jacobian * W * jacobian.T, -right)
        found.append(np.array([float(x) for x in W * jacobian.T * mu]))
    return found[0], found[1]


def close(machine: Interpreted, s: State, w: np.ndarray, rtol: float) -> None:
    """The interpreter and the emitted text against fifty digits, in parts of the whole change."""
    with mp.workdps(50 + 26):
        expected = exact(machine, s, w)
    got = machine.flat("correction", s, w=w)
    functions = python_functions(machine.text())
    p = [*machine.p, *[0.0] * len(machine.program.constants)]
    functions["constants"](p)
    out = [0.0] * machine.n, [0.0] * machine.n
    functions["correction"](s.t, plain(s.q), plain(s.v), p, plain(w), *out)
    for change, text, right in zip((got["dq"], got["dv"]), out, expected, strict=True):
        size = np.abs(right).max()
        assert_allclose(change, right, rtol=0, atol=rtol * size)
        assert_allclose(text, right, rtol=0, atol=rtol * size)
        assert not np.any(change[w == 0.0])


@pytest.mark.parametrize("seed", range(6))
def test_no_digits_are_lost_where_weights_lie_far_apart(machine: Interpreted, seed: int) -> None:
    random = np.random.default_rng(seed)
    s = State(t=0.1, q=random.uniform(-1, 1, machine.n), v=random.uniform(-1, 1, machine.n))
    close(machine, s, SPREAD ** random.uniform(-1, 1, machine.n), rtol=1e-11)
    close(machine, s, SPREAD ** random.choice([-1.0, 0.0, 1.0], machine.n), rtol=1e-11)


@pytest.mark.parametrize("seed", range(3))
def test_a_weight_of_zero_holds_a_coordinate(machine: Interpreted, seed: int) -> None:
    random = np.random.default_rng(seed)
    s = State(t=0.1, q=random.uniform(-1, 1, machine.n), v=random.uniform(-1, 1, machine.n))
    names = [q.name for q in machine.equations.coordinates]
    w = SPREAD ** random.uniform(-0.1, 0.1, machine.n)
    w[next(k for k, name in enumerate(names) if name.endswith("_phi"))] = 0.0
    close(machine, s, w, rtol=1e-10)


def test_the_compressor_takes_few_operations(root: Path) -> None:
    machine = Interpreted(read_model(root / "models" / "slider_crank.py").model, "compressor")
    (kernel,) = (k for k in machine.program.kernels if k.name == "correction")
    assert operations(machine.program, kernel) <= 160


def test_a_coordinate_that_follows_two_is_left_to_the_elimination() -> None:
    graph = Graph()
    w = [graph.input("w", k, f"w_{k}") for k in range(3)]
    entries = {(0, k): graph.one for k in range(3)}
    assert NullSpace(Task(graph, entries, [[graph.one]], w)).solve() is None
