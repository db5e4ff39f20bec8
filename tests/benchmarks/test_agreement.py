"""The generated kernels and their hand-written twins give the same numbers."""

import json
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from benchmarks import compressor, kernels, reduced
from benchmarks.__main__ import save
from benchmarks.hand import slider_crank as hand
from benchmarks.states import consistent, modes_at, turn_of_the_crank
from codegen import build
from codegen.files.generated_modules import import_generated


@pytest.fixture(scope="session")
def module(request: pytest.FixtureRequest) -> object:
    """The library's compressor, kept in pytest's cache while it does not change."""
    folder: Path = request.config.cache.mkdir("benchmarks")
    report = build("slider_crank", scene="compressor", out=folder / "generated")
    return import_generated(report.paths[0])


def test_states_satisfy_the_constraints(module: object) -> None:
    p = kernels.parameters(module)
    q, v, modes = turn_of_the_crank(64, p[1])
    phi, values, g = np.zeros(8), np.zeros(18), np.zeros(4)
    for k in range(64):
        module.constraints(0.0, q[k], p, phi)
        assert np.abs(phi).max() < 1e-14
        jacobian = np.zeros((8, 9))
        module.jacobian(0.0, q[k], p, values)
        jacobian[list(module.JACOBIAN_ROWS), list(module.JACOBIAN_COLUMNS)] = values
        assert np.abs(jacobian @ v[k]).max() < 1e-12
        module.switching(0.0, q[k], v[k], p, g)
        clear = np.abs(g) > 1e-9
        assert list(modes[k][clear]) == list((g > 0)[clear])
    assert {tuple(row) for row in modes} >= {(0, 1, 1, 1), (0, 0, 1, 1), (0, 1, 1, 0)}


def test_twins_agree(module: object) -> None:
    found = kernels.differences(module)
    assert set(found) == {"jacobian", "acceleration_rhs", "accelerations"}
    assert max(found.values()) < 1e-12


@pytest.mark.parametrize("length", [2.2, 3.5, 9.0])
@pytest.mark.parametrize("inertia", [225.0, 900.0])
def test_twins_agree_for_other_parameters(module: object, length: float, inertia: float) -> None:
    p = kernels.parameters(module)
    p[:2] = inertia, length
    module.constants(p)
    phi = np.linspace(0.1, 6.2, 23)
    q, v = consistent(phi, 20 + phi, length)
    modes = modes_at(q, v)
    lam, ours, theirs = np.zeros(8), np.zeros(9), np.zeros(9)
    for k in range(len(phi)):
        assert module.accelerations(0.0, q[k], v[k], p, modes[k], ours, lam) == 0
        assert hand.crank_acceleration(0.0, q[k], v[k], p, modes[k], theirs, lam) == 0
        assert_allclose(ours[2], theirs[2], rtol=1e-12, atol=1e-10)


def test_lambdified_equation_is_the_hand_written_one() -> None:
    alpha, slider = reduced.equations()
    p, lam, a = np.array([450.0, 3.5, 41450.0, 0.0, 1.0]), np.zeros(8), np.zeros(9)
    q, v, modes = turn_of_the_crank(40, 3.5)
    for k in range(40):
        hand.crank_acceleration(0.0, q[k], v[k], p, modes[k], a, lam)
        x = slider(q[k, 2])[0]
        piece = int(3 - modes[k, :3].sum())
        force = reduced.gas(piece, x) if modes[k, 3] else 0.0
        assert_allclose(alpha(q[k, 2], v[k, 2], force), a[2], rtol=1e-11, atol=1e-10)
        assert_allclose(x, q[k, 6], rtol=1e-13)


def test_scipy_follows_the_reference() -> None:
    t, phi = compressor.reference()
    until = t <= 0.3
    run = reduced.simulate(t[until], 1e-10, 1e-10)
    assert run.phi.shape == t[until].shape
    assert_allclose(run.phi, phi[until], atol=1e-6)
    assert run.restarts == 3


def test_scipy_without_care_follows_it_too() -> None:
    t, phi = compressor.reference()
    until = t <= 0.3
    run = reduced.plain(t[until], 1e-10, 1e-10)
    assert_allclose(run.phi, phi[until], atol=1e-6)
    assert run.restarts == 0


def test_operations_of_the_twins_are_counted_from_their_source() -> None:
    assert kernels.operations(hand.jacobian) == 9  # r/2, two sines and cosines, four products
    assert kernels.operations(hand.acceleration_rhs) > 9
    assert kernels.operations(hand.crank_acceleration) > 50


def test_results_are_written_with_their_versions(tmp_path: Path) -> None:
    path = save("kernels", [{"ratio": 1.5}], tmp_path / "results")
    record = json.loads(path.read_text())
    assert record["rows"] == [{"ratio": 1.5}]
    assert {"python", "numba", "numpy", "scipy", "sympy", "processor"} <= set(record["versions"])


def test_measurement_reports_all_twins(module: object) -> None:
    rows = kernels.measure_twins(module, 2_000, 1)
    assert [row.generated for row in rows] == ["jacobian", "acceleration_rhs", "accelerations"]
    assert all(row.difference < 1e-12 for row in rows)
    assert [row.operations for row in rows] == [dict(module.OPERATIONS)[r.generated] for r in rows]


def test_all_ways_to_run_the_compressor_follow_the_reference() -> None:
    ours, plain, careful = compressor.measure(0)
    assert ours.method == "runtime, dop853"
    assert plain.method.startswith("SciPy")
    assert careful.method.startswith("SciPy")
    assert ours.error < 1e-7
    assert plain.error < 1e-5
    assert careful.error < 1e-6
    assert ours.evaluations > 100
