"""The search for singular positions of large machines: against the dense one, and its growth."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from runtime.machine_facade import Machine
from runtime.mechanism.dense_equations import Equations
from runtime.singularity import scaled_constraints
from runtime.singularity.motion_polynomial import Motion, taylor
from runtime.singularity.scaled_constraints import ScaledConstraints
from runtime.singularity.schur_complement import count_weak
from runtime.singularity.search_function_table import set_units
from runtime.singularity.singular_position_near_motion import Singularity, SingularPositions
from runtime.singularity.sparse_complement import (
    Complement,
    SparseJacobian,
    count_above,
    singular_values,
)
from runtime.singularity.sparse_root_search import (
    differentiate,
    entries_at,
    group,
    largest_lost_gap,
)
from tests.runtime import bars

TURNING = -5.0  # rad/s
SPARSE, DENSE = 0, 10**9
DIFFERENCES = 1e-9  # error of derivatives by central differences


def parallel(machine: Machine, angle: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """q, v and a with all cranks at one angle, turning at a constant speed."""
    q, v, a = np.zeros((3, len(machine.coordinates)))
    c, s = np.cos(angle), np.sin(angle)
    for j, row in enumerate(machine.coordinates):
        body, axis = row.name.split(".")
        kind, number = body.split("_")
        reach, foot = (0.5, float(number)) if kind == "crank" else (1.0, int(number) - 0.5)
        if axis == "x":
            q[j], v[j], a[j] = foot + reach * c, -reach * s * TURNING, -reach * c * TURNING**2
        elif axis == "y":
            q[j], v[j], a[j] = reach * s, reach * c * TURNING, -reach * s * TURNING**2
        elif kind == "crank":
            q[j], v[j] = angle, TURNING
    return q, v, a


def scaled(machine: Machine) -> ScaledConstraints:
    equations = Equations(machine.mechanism, machine.parameter_values())
    return equations.scaled(
        1.0 / np.sqrt(equations.masses(equations.still)), np.arange(equations.m)
    )


def found(
    machine: Machine, motion: Motion, s: float, threshold: int, patch: pytest.MonkeyPatch
) -> Singularity | None:
    patch.setattr(scaled_constraints, "SPARSE_FROM", threshold)
    return SingularPositions(scaled(machine)).find(motion, s)


def complement(machine: Machine, angle: float, weak: int) -> tuple[SparseJacobian, Complement]:
    """Of the position with all cranks at one angle; and its z in the Jacobian's units."""
    constraints = scaled(machine)
    jacobian = SparseJacobian(constraints)
    z = position(machine, angle)
    set_units(jacobian.table, -TURNING, z)
    left = jacobian.eliminate(z, jacobian.order(jacobian.entries(z), 0.0), weak)
    assert left is not None
    return jacobian, left


def position(machine: Machine, angle: float) -> np.ndarray:
    return np.append(parallel(machine, angle)[0] / scaled(machine).scale, 0.0)


@pytest.mark.parametrize("loops", [1, 2, 5])
@pytest.mark.parametrize("angle", [0.0, 0.1, 0.3, np.pi + 0.2])
def test_sparse_and_dense_searches_agree(
    loops: int, angle: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    machine = bars.n_four_bar(loops)
    level = 0.0 if angle < 1.0 else np.pi
    motion, s = taylor(0.0, *parallel(machine, angle)), 1.02 * (level - angle) / TURNING
    dense, sparse = (found(machine, motion, s, t, monkeypatch) for t in (DENSE, SPARSE))
    assert dense is not None
    assert sparse is not None
    assert sparse.lost == dense.lost == loops
    assert sparse.t == pytest.approx(dense.t, abs=1e-12)
    assert sparse.gap < 1e-13
    assert sparse.rate == pytest.approx(dense.rate, rel=1e-7)
    assert sparse.astray == pytest.approx(dense.astray, abs=DIFFERENCES)
    np.testing.assert_allclose(sparse.q, dense.q, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(sparse.rows, dense.rows, rtol=0.0, atol=1e-9)
    speed = float(np.linalg.norm(dense.veer)) + abs(TURNING)
    np.testing.assert_allclose(sparse.veer, dense.veer, rtol=0.0, atol=DIFFERENCES * speed)
    assert abs(sparse.direction @ dense.direction) == pytest.approx(1.0, abs=1e-8)


@pytest.mark.parametrize("error", [1e-5, 1e-3])
def test_a_position_that_is_missed_is_missed_by_as_much(
    error: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second pivot on the ground is displaced; which joint stays open depends on the pivots."""
    right = bars.n_four_bar(1)
    hinges = [
        bars.Hinge("A0", -1, 0.0, 0, -0.5),
        bars.Hinge("B0", 0, 0.5, 1, -0.5),
        bars.Hinge("C1", 2, 0.5, 1, 0.5),
        bars.Hinge("A1", -1, 1.0 + error, 2, -0.5),
    ]
    wrong = bars.machine("wide", ["crank_0", "coupler_1", "crank_1"], hinges, {})
    motion = taylor(0.0, *parallel(right, 0.1))
    dense, sparse = (found(wrong, motion, 0.02, t, monkeypatch) for t in (DENSE, SPARSE))
    assert dense is not None
    assert sparse is not None
    assert dense.gap > 0.1 * error
    assert sparse.gap == pytest.approx(dense.gap, rel=1e-9)
    np.testing.assert_allclose(sparse.q, dense.q, rtol=0.0, atol=1.01 * error)


def test_nothing_is_found_where_nothing_is_near(monkeypatch: pytest.MonkeyPatch) -> None:
    machine = bars.n_four_bar(3)
    motion = taylor(0.0, *parallel(machine, 1.5))
    assert found(machine, motion, 0.0, SPARSE, monkeypatch) is None


def test_vectors_and_complement_are_those_of_the_jacobian() -> None:
    machine = bars.n_four_bar(4)
    jacobian, left = complement(machine, 0.2, 4)
    z = position(machine, 0.2)
    dense, places = jacobian.matrix(jacobian.entries(z)).toarray(), jacobian.shape
    u, n = left.left.toarray(), left.null.toarray()
    assert u.shape == (places[0], 4)
    assert n.shape == (places[1], places[1] - places[0] + 4)
    np.testing.assert_allclose(np.linalg.norm(u, axis=0), 1.0)
    np.testing.assert_allclose(np.linalg.norm(n, axis=0), 1.0)
    np.testing.assert_allclose(u.T @ dense @ n, left.between.toarray(), atol=1e-14)
    assert np.linalg.matrix_rank(dense @ n, tol=1e-12) == 4
    np.testing.assert_allclose(u.T @ jacobian.gaps(z), left.lost, atol=1e-14)


def test_derivatives_of_the_complement_are_those_along_one_null_vector_at_a_time() -> None:
    machine = bars.n_four_bar(4)
    jacobian, left = complement(machine, 0.2, 4)
    z = position(machine, 0.2)
    forms = differentiate(jacobian, z, left.left, left.null)
    null, whole = left.null.toarray(), np.zeros((4, left.null.shape[1], left.null.shape[1]))
    for g in range(null.shape[1]):
        delta = 1e-5 * null[:, g]
        ahead, behind = (jacobian.matrix(jacobian.entries(z + s * delta)) for s in (1.0, -1.0))
        whole[:, g] = (left.left.T @ (ahead - behind) @ left.null).toarray() / 2e-5
    sparse = np.zeros_like(whole)
    sparse[forms.left, forms.null] = forms.slopes.toarray()
    assert np.abs(whole).max() > 0.1
    np.testing.assert_allclose(sparse, whole, atol=1e-9)


def test_groups_share_no_row() -> None:
    pattern = np.random.default_rng(2).random((30, 20)) < 0.1
    groups = group(csr_array(pattern.astype(float)))
    assert groups.min() == 0
    for k in range(groups.max() + 1):
        assert pattern[:, groups == k].sum(axis=1).max() <= 1


def test_entries_at_their_places_and_zero_elsewhere() -> None:
    dense = np.array([[0.0, 2.0, 0.0], [3.0, 0.0, 4.0]])
    rows, columns = np.array([0, 0, 1]), np.array([0, 1, 2])
    np.testing.assert_array_equal(entries_at(csr_array(dense), rows, columns), [0.0, 2.0, 4.0])


@pytest.mark.parametrize("angle", [0.0, 0.02, 0.2])
def test_singular_values_are_known_to_a_tenth(angle: float) -> None:
    left = complement(bars.n_four_bar(6), angle, 6)[1]
    u, n = (np.linalg.cholesky((w.T @ w).toarray()) for w in (left.left, left.null))
    between = np.linalg.solve(n, np.linalg.solve(u, left.between.toarray()).T)
    exact = np.sort(np.clip(np.linalg.svd(between, compute_uv=False), 1e-9, 1.0))
    close = singular_values(left)
    np.testing.assert_allclose(close, exact, rtol=0.1)
    assert count_weak(close[::-1]) == count_weak(exact[::-1])
    level = float(np.sqrt(exact[2] * exact[3])) if exact[3] > 1.01 * exact[2] else 2.0
    assert count_above(left, level) == np.sum(exact > level)


def test_the_gap_is_that_between_orthonormal_vectors() -> None:
    left = complement(bars.n_four_bar(3), 0.2, 3)[1]
    lost = np.array([0.0, 1e-3, 0.0])
    gap = largest_lost_gap(left._replace(lost=lost))
    squared = lost @ np.linalg.solve((left.left.T @ left.left).toarray(), lost)
    assert np.sqrt(squared / 3.0) <= gap <= np.sqrt(squared) * (1.0 + 1e-12)


def test_numbers_and_evaluations_of_a_search_grow_linearly(monkeypatch: pytest.MonkeyPatch) -> None:
    """At and near the level position, of the vectors, their products and the derivatives."""
    calls = []
    evaluated = SparseJacobian.entries
    monkeypatch.setattr(
        SparseJacobian, "entries", lambda self, z: (calls.append(1), evaluated(self, z))[1]
    )
    for angle in (0.0, 0.05):
        sizes, evaluations = [], []
        for loops in (20, 40):
            machine = bars.n_four_bar(loops)
            jacobian, left = complement(machine, angle, loops)
            calls.clear()
            forms = differentiate(jacobian, position(machine, angle), left.left, left.null)
            evaluations.append(len(calls))
            matrices = left.left, left.null, left.between, forms.slopes, left.null.T @ left.null
            sizes.append([matrix.nnz for matrix in matrices])
        assert evaluations[0] == evaluations[1] < 20
        assert all(more <= 2.05 * few for few, more in zip(*sizes, strict=True))


def test_a_large_search_evaluates_as_often_as_a_small_one(monkeypatch: pytest.MonkeyPatch) -> None:
    calls = []
    evaluated = SparseJacobian.entries
    monkeypatch.setattr(
        SparseJacobian, "entries", lambda self, z: (calls.append(1), evaluated(self, z))[1]
    )
    counts = []
    for loops in (5, 40):
        machine = bars.n_four_bar(loops)
        calls.clear()
        motion = taylor(0.0, *parallel(machine, 0.1))
        position = found(machine, motion, 0.02, SPARSE, monkeypatch)
        assert position is not None
        assert position.lost == loops
        counts.append(len(calls))
    assert counts[1] <= counts[0] + 4
