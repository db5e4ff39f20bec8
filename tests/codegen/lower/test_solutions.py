"""The solving kernels against NumPy's dense solutions, whatever the order of elimination."""

import math
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen import Model
from codegen.lower.constant_hoisting import with_constants
from codegen.lower.interpreter import evaluate
from codegen.lower.kernels.accelerations import dynamics_kernel
from codegen.lower.linear.factorization import Strategy
from codegen.lower.scene_graph import SceneGraph
from codegen.reading.model_file import read_model
from tests.codegen.workbench import A, Interpreted, State, plain, python_functions, random_machine

STRATEGIES: tuple[Strategy, ...] = ("substitute", "mixed", "schur", "leaves")


@pytest.fixture(scope="module")
def slider_crank(root: Path) -> Model:
    return read_model(root / "models" / "slider_crank.py").model


def dense(machine: Interpreted, s: State, modes: list[int]) -> np.ndarray:
    """(q̈, λ) by LAPACK from the whole (n + m)-square system."""
    jacobian = machine.jacobian(s)
    zero = np.zeros((machine.m, machine.m))
    matrix = np.block([[machine.mass(s), jacobian.T], [jacobian, zero]])
    right = [
        machine.vector("applied_forces", s, modes=modes),
        machine.vector("acceleration_rhs", s),
    ]
    return np.linalg.solve(matrix, np.concatenate(right))


def by_strategy(machine: Interpreted, s: State, modes: list[int], strategy: Strategy) -> np.ndarray:
    graph = SceneGraph(machine.equations)
    kernel = dynamics_kernel(graph, strategy, tuple(range(graph.m)))
    program = with_constants(graph.graph, (kernel,), len(machine.p))
    inputs = {"t": s.t, "q": plain(s.q), "v": plain(s.v), "p": machine.p, "modes": modes}
    out = evaluate(program, "accelerations", inputs, math)
    parts = [out["a"], out.get("lam", {})]
    return np.array([part[k] for part in parts for k in range(len(part))])


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("seed", range(8))
def test_random_machines(seed: int, strategy: Strategy) -> None:
    model, s = random_machine(seed, closed=seed % 2 == 0)
    machine = Interpreted(model)
    expected = dense(machine, s, [])
    scale = np.abs(expected).max()
    got = by_strategy(machine, s, [], strategy)
    assert_allclose(got, expected, rtol=1e-10, atol=1e-10 * scale)


def assembled(machine: Interpreted, crank: float, omega: float) -> State:
    """The slider-crank on its constraints, turned by `crank`."""
    rod = -math.asin(2 * math.sin(crank) / 3.5)
    middle = 2 * np.array([math.cos(crank), math.sin(crank)]) + A(rod) @ [1.75, 0]
    end = middle + A(rod) @ [1.75, 0]
    s = State(t=0.0, q=np.array([0, 0, crank, *middle, rod, *end, 0]), v=np.zeros(machine.n))
    s.v[2] = omega
    held = np.ones(machine.n)
    held[2] = float(machine.m == machine.n)  # a driver sets the crank's velocity
    s = machine.corrected(s, held)
    assert np.abs(machine.vector("constraints", s)).max() < 1e-14
    return s


@pytest.mark.parametrize("strategy", STRATEGIES)
@pytest.mark.parametrize("modes", [[0, 0, 0, 0], [0, 1, 1, 1], [0, 0, 1, 1], [1, 1, 1, 1]])
def test_slider_crank(slider_crank: Model, strategy: Strategy, modes: list[int]) -> None:
    machine = Interpreted(slider_crank, "compressor")
    for crank in (0.3, 2.0, 3.5, 5.9):
        s = assembled(machine, crank, 30.0)
        expected = dense(machine, s, modes)
        got = by_strategy(machine, s, modes, strategy)
        assert_allclose(got, expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())


def test_the_cheapest_strategy_is_taken(slider_crank: Model) -> None:
    machine = Interpreted(slider_crank, "compressor")
    assert machine.lowered.strategy in {"substitute", "mixed"}
    s = assembled(machine, 1.0, 20.0)
    a, lam = machine.solution(s, modes=[0, 1, 1, 1])
    expected = dense(machine, s, [0, 1, 1, 1])
    assert_allclose([*a, *lam], expected, rtol=1e-10, atol=1e-10 * np.abs(expected).max())


def test_kinematic_scene_has_the_accelerations_of_the_driven_motion(slider_crank: Model) -> None:
    machine = Interpreted(slider_crank, "kinematics")
    s = assembled(machine, math.pi / 4, 2 * math.pi)
    a = machine.flat("accelerations", s)["a"]
    expected = np.linalg.solve(machine.jacobian(s), machine.vector("acceleration_rhs", s))
    assert_allclose(a, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(6))
def test_correction_is_the_weighted_least_change(seed: int) -> None:
    model, s = random_machine(seed)
    machine = Interpreted(model)
    random = np.random.default_rng(seed)
    s = State(t=s.t, q=s.q + 0.01 * random.standard_normal(machine.n), v=s.v)
    jacobian = machine.jacobian(s)
    independent = []
    for w in (np.ones(machine.n), random.uniform(0.1, 2, machine.n), partition(jacobian)):
        S = jacobian @ np.diag(w) @ jacobian.T
        phi = machine.vector("constraints", s)
        rate = jacobian @ s.v - machine.vector("velocity_rhs", s)
        out = machine.flat("correction", s, w=w)
        for got, right in ((out["dq"], phi), (out["dv"], rate)):
            expected = -w * (jacobian.T @ np.linalg.solve(S, right))
            assert_allclose(got, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
            assert_allclose(got[w == 0], 0, atol=0)
        independent.append(int((w == 0).sum()))
    assert independent == [0, 0, machine.n - machine.m]


def partition(jacobian: np.ndarray) -> np.ndarray:
    """Weights 0 on n - m independent coordinates, chosen by pivoting."""
    from scipy.linalg import qr

    _, _, order = qr(jacobian, pivoting=True)
    w = np.zeros(jacobian.shape[1])
    w[order[: jacobian.shape[0]]] = 1.0
    return w


def test_correction_repeated_closes_the_mechanism() -> None:
    model, s = random_machine(1)
    machine = Interpreted(model)
    s = State(t=s.t, q=s.q + 0.05, v=s.v)
    sizes = []
    for _ in range(6):
        sizes.append(np.abs(machine.vector("constraints", s)).max())
        s = machine.corrected(s)
    assert sizes[0] > 1e-3
    assert sizes[-1] < 1e-14


# The return values of the kernels are those of the emitted text.


def run(machine: Interpreted, kernel: str, s: State, *more: list[float]) -> int:
    functions = python_functions(machine.text())
    p = [*machine.p, *[0.0] * len(machine.program.constants)]
    functions["constants"](p)
    out = [0.0] * machine.n, [0.0] * max(machine.m, machine.n)
    return functions[kernel](s.t, plain(s.q), plain(s.v), p, *more, *out)


def four_bar(width: float) -> tuple[Interpreted, State]:
    """A parallelogram of bars 1 - width - 1, lying flat: its two branches meet there."""
    model = Model("four_bar", gravity=(0, -9.81))
    lengths = (1.0, width, 1.0)
    bars = [model.body(f"bar{k}", mass=1.0, inertia=0.1) for k in range(3)]
    ends = [(b.at(-h / 2, 0), b.at(h / 2, 0)) for b, h in zip(bars, lengths, strict=True)]
    model.revolute("A", model.ground.at(0, 0), ends[0][0])
    model.revolute("B", ends[0][1], ends[1][0])
    model.revolute("C", ends[1][1], ends[2][0])
    model.revolute("D", ends[2][1], model.ground.at(width, 0))
    upright = {"bar0.phi": np.pi / 2, "bar0.y": 0.5, "bar1.x": width / 2, "bar1.y": 1.0}
    upright |= {"bar2.x": width, "bar2.y": 0.5, "bar2.phi": -np.pi / 2}
    model.scene("fall", ["gravity"], guess=upright)
    flat = [0.5, 0, 0, 1 + width / 2, 0, 0, 0.5 + width, 0, np.pi]
    return Interpreted(model), State(t=0.0, q=np.array(flat), v=np.zeros(9))


def test_flat_parallelogram_names_a_weak_constraint() -> None:
    machine, flat = four_bar(2.0)
    assert np.abs(machine.vector("constraints", flat)).max() < 1e-15
    jacobian = machine.jacobian(flat)
    assert np.linalg.matrix_rank(jacobian) == 7
    answer = run(machine, "accelerations", flat, [])
    assert 1 <= answer <= 8
    others = np.delete(jacobian, answer - 1, axis=0)
    assert np.linalg.matrix_rank(others) == 7  # the one named is one of those that depend
    assert 1 <= run(machine, "correction", flat, [1.0] * 9) <= 8
    upright = State(t=0.0, q=np.array([0, 0.5, np.pi / 2, 1, 1, 0, 2, 0.5, -np.pi / 2]), v=flat.v)
    assert run(machine, "accelerations", upright, []) == 0
    assert run(machine, "correction", upright, [1.0] * 9) == 0


def test_correction_that_may_move_nothing_says_so() -> None:
    model = Model("held")
    body = model.body("body", mass=1.0, inertia=1.0)
    model.absolute("height", body, "y", 1.0)
    model.absolute("angle", body, "phi", 0.0)
    machine = Interpreted(model)
    s = machine.state(0)
    functions = python_functions(machine.text())
    out = [0.0] * 3, [0.0] * 3
    arguments = (s.t, plain(s.q), plain(s.v), [])
    assert functions["correction"](*arguments, [0.0, 1.0, 1.0], *out) == 0
    with np.errstate(all="ignore"):
        held = np.array([1.0, 1.0, 0.0])
        assert functions["correction"](*arguments, held, *out) == 2


def test_parameters_and_constants_are_as_if_built_with_them(slider_crank: Model) -> None:
    machine = Interpreted(slider_crank, "compressor")
    s = assembled(machine, 1.0, 20.0)
    changed = {"J1": 900.0, "rod_length": 2.9, "motor_torque": 1e4}
    p = [changed.get(d.name, d.value) for d in machine.equations.parameters]
    assert len(machine.program.constants) > 0
    frozen = slider_crank.altered(scenes={})
    names = slider_crank.scenes["compressor"]
    frozen.scene("other", names.effects, parameters=changed, frozen=True)
    rebuilt = Interpreted(frozen, "other")
    assert not rebuilt.program.constants
    one, other = machine.solution(s, p=p, modes=[0] * 4), rebuilt.solution(s, modes=[0] * 4)
    assert_allclose(np.concatenate(one), np.concatenate(other), rtol=1e-11, atol=1e-8)
    before = machine.solution(s, modes=[0] * 4)
    assert np.abs(before[0] - one[0]).max() > 1
