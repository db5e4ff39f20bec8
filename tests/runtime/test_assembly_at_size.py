"""Assembly of machines with many coordinates, by sparse factors in place of dense matrices."""

import numpy as np
import pytest

from codegen.errors import AssemblyError
from runtime.assembly.assemble import assemble
from runtime.assembly.joint_closing import Task
from runtime.assembly.redundancy import dependent_rows, is_clearly_independent, unit_rows
from runtime.linalg.least_norm import SPARSE_FROM, LeastNorm, least_norm_solver
from runtime.machine_facade import Machine
from runtime.mechanism import dense_equations
from runtime.mechanism.dense_equations import Equations
from tests.runtime import bars

SPARSE, DENSE = 0, 10**9


def task_of(machine: Machine, q: np.ndarray) -> Task:
    equations = Equations(machine.mechanism, np.zeros(0))
    ones = np.ones(equations.n)
    every = np.ones(equations.m, dtype=np.bool_)
    return Task(equations, 0.0, ones, np.ones(equations.m), every, ones > 0.0, ones)


def upright(loops: int) -> np.ndarray:
    """The start of a row of square loops, (3 (2 N + 1),)."""
    return bars.n_four_bar(loops).assemble().q


@pytest.mark.parametrize("machine", [bars.chain(20), bars.n_four_bar(12)], ids=["chain", "loops"])
def test_sparse_and_dense_assembly_agree(machine: Machine, monkeypatch: pytest.MonkeyPatch) -> None:
    names = [row.name for row in machine.mechanism.description.coordinates]
    free = [name for name in names if name.endswith((".x", ".y")) and "crank_0" not in name]
    random = np.random.default_rng(4)
    guess = {name: machine.assemble().q[names.index(name)] + random.normal(0.0, 0.05)
             for name in free}  # fmt: skip
    found = []
    for threshold in (DENSE, SPARSE):
        monkeypatch.setattr(dense_equations, "SPARSE_FROM", threshold)
        found.append(assemble(Equations(machine.mechanism, np.zeros(0)), guess=guess))
    dense, sparse = found
    assert np.abs(dense.q - sparse.q).max() < 1e-7  # where the search for the nearest one ends
    assert np.abs(dense.v - sparse.v).max() < 1e-6
    assert max(sparse.residual.values()) < 1e-14
    assert dense.degrees_of_freedom == sparse.degrees_of_freedom


def test_sparse_assembly_names_open_joints(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = bars.n_four_bar(4)
    for threshold in (DENSE, SPARSE):
        monkeypatch.setattr(dense_equations, "SPARSE_FROM", threshold)
        with pytest.raises(AssemblyError, match=r"leave joints open.*joint"):
            assemble(Equations(machine.mechanism, np.zeros(0)), start_at={"coupler_2.x": 7.0})


def test_large_assembly_makes_no_dense_matrix(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise AssertionError("a dense matrix of the constraints")

    machine = bars.n_four_bar(1 + SPARSE_FROM // 6)
    for method in ("_dense", "jacobian", "mass"):
        monkeypatch.setattr(Equations, method, refuse)
    begin = machine.assemble()
    assert begin.degrees_of_freedom == 1
    assert np.ptp(begin.v[3 + 3 :: 6]) < 1e-9  # all couplers move alike


def test_least_norm_agrees_with_dense_solution() -> None:
    random = np.random.default_rng(2)
    machine = bars.n_four_bar(6)
    task = task_of(machine, upright(6))
    matrix = unit_rows(task, upright(6) + random.normal(0.0, 0.1, task.equations.n))
    right = random.normal(size=task.equations.m)
    dense = least_norm_solver(matrix.toarray())(right)
    assert np.abs(LeastNorm(matrix).solve(right) - dense).max() < 1e-9 * np.abs(dense).max()


def test_least_norm_of_dependent_rows() -> None:
    matrix = unit_rows(task_of(bars.chain(5), np.zeros(15)), np.linspace(0.0, 1.0, 15))
    from scipy.sparse import vstack

    twice = vstack([matrix, matrix[:3]]).tocsr()
    right = np.random.default_rng(3).normal(size=10)
    right = np.append(right, right[:3])
    dense = least_norm_solver(twice.toarray())(right)
    assert np.abs(LeastNorm(twice).solve(right) - dense).max() < 1e-9
    assert LeastNorm(twice).least_singular_value() < 1e-6


@pytest.mark.parametrize("angle", [1.0, 0.1, 1e-3, 0.0])
def test_smallest_singular_value(angle: float, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(dense_equations, "SPARSE_FROM", SPARSE)
    loops = 5
    machine = bars.n_four_bar(loops)
    q = upright(loops).reshape(-1, 3)
    q[0::2, 2] = angle  # cranks; flat loops have lost a constraint each
    q[0::2, 0] = np.arange(loops + 1) + 0.5 * np.cos(angle)
    q[0::2, 1] = 0.5 * np.sin(angle)
    q[1::2, 0] = np.arange(loops) + 0.5 + np.cos(angle)
    q[1::2, 1] = np.sin(angle)
    task = task_of(machine, q.ravel())
    matrix = unit_rows(task, q.ravel())
    least = float(np.linalg.svd(matrix.toarray(), compute_uv=False)[-1])
    found = LeastNorm(matrix).least_singular_value()
    assert least - 1e-12 <= found <= 1.05 * least + 1e-6
    dependent = dependent_rows(matrix.toarray(), list(range(task.equations.m)))
    assert is_clearly_independent(task, q.ravel()) == (not dependent)


@pytest.mark.parametrize("family", [bars.chain, bars.n_four_bar])
def test_factors_grow_linearly(family: object) -> None:
    counts = []
    for size in (20, 40):
        machine = family(size)  # type: ignore[operator]
        q = machine.assemble().q
        counts.append(LeastNorm(unit_rows(task_of(machine, q), q)).factors)
    assert counts[1] < 2.2 * counts[0]
