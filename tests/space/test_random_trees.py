"""Random trees, compiled: the equations in seven columns a body, and motions."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from runtime import load
from tests.random_mechanisms.spatial_declaration import coordinates, declare
from tests.random_mechanisms.spatial_dynamics import SpatialDense
from tests.random_mechanisms.spatial_generator import random_spatial_mechanism
from tests.random_mechanisms.spatial_motion import motion
from tests.random_mechanisms.spatial_statics import counted


@pytest.mark.parametrize("seed", [3, 4])
def test_equations_in_seven_columns_hold_with_the_multipliers(seed: int, workshop: Path) -> None:
    """M q̈ + Φ_qᵀ λ = Q and Φ_q q̈ = γ, with the multipliers of pᵀp = 1 among λ."""
    tree = random_spatial_mechanism(seed, "tree", "free")
    machine = load(declare(tree.parts, f"tree_{seed}"), folder=workshop)
    dense, (q, v) = SpatialDense(tree.parts), coordinates(tree.state)
    own = counted(dense, tree.state, dense.solve(tree.state))
    names = machine.coordinates.names[len(q) :]
    assert {*names} == {*own}
    q, v = (np.append(x, [own[name][k] for name in names]) for k, x in enumerate((q, v)))
    about, kernels, p = machine.description, machine.kernels, machine.parameter_values()
    n, m, modes = len(q), len(machine.constraints), np.zeros(0, np.int64)
    a, lam, forces, gamma = np.zeros(n), np.zeros(m), np.zeros(n), np.zeros(m)
    kernels.accelerations(0.0, q, v, p, modes, a, lam)
    kernels.applied_forces(0.0, q, v, p, modes, forces)
    kernels.acceleration_rhs(0.0, q, v, p, gamma)
    mass, slopes = np.zeros((n, n)), np.zeros((m, n))
    entries, values = np.zeros(len(about.mass_rows)), np.zeros(len(about.jacobian_rows))
    kernels.mass(q, p, entries)
    kernels.jacobian(0.0, q, p, values)
    mass[about.mass_rows, about.mass_columns] = entries
    slopes[about.jacobian_rows, about.jacobian_columns] = values
    size = float(np.abs(forces).max())
    assert_allclose(mass @ a + slopes.T @ lam, forces, rtol=0.0, atol=1e-12 * size)
    assert_allclose(slopes @ a, gamma, rtol=0.0, atol=1e-11 * float(np.abs(gamma).max()))
    at_speed, w = dense.system(tree.state, 0.0), np.hstack([tree.state.v, tree.state.w]).ravel()
    assert kernels.kinetic_energy(q, v, p) == pytest.approx(w @ at_speed.mass @ w / 2, rel=1e-13)


def test_the_motion_of_a_tree_is_that_of_newtons_and_eulers_equations(workshop: Path) -> None:
    tree = random_spatial_mechanism(3, "tree", "free")
    mechanism = tree.parts
    t = np.linspace(0.0, 0.5, 6)
    exact: list[Any] = motion(SpatialDense(mechanism), tree.state, t.tolist(), 1e-11)
    machine = load(declare(mechanism, "tree_3"), folder=workshop)
    names = (*machine.coordinates.names, *(row.velocity for row in machine.coordinates))
    q, v = coordinates(tree.state)
    start = machine.assemble(guess=dict(zip(names, [*q.tolist(), *v.tolist()], strict=True)))
    assert_allclose(start.q, q, rtol=0.0, atol=1e-12)
    result = machine.simulate(t[-1], t, start=start, rtol=1e-11, progress=False)
    for k, body in enumerate(mechanism.bodies):
        place = np.column_stack([result.q(f"{body.name}.{c}") for c in "xyz"])
        assert_allclose(place, [state.r[k] for state in exact], rtol=0.0, atol=1e-8)
        turned = [state.R[k] for state in exact]
        assert_allclose(result.rotation(body.name), turned, rtol=0.0, atol=1e-8)
