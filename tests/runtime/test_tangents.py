"""Derivatives of a loaded machine: what they compute, and when their file is trusted."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numba import types
from numpy.testing import assert_allclose

import codegen
from codegen.errors import AnalysisError, GeneratedFileError, SupersededError
from codegen.files.generated_modules import companion_path
from codegen.reading.model_file import read_model
from runtime import load
from runtime.core.jit import ADDRESSES, compiled
from runtime.core.kernel_abi import accelerations_tangent_of, correction_tangent_of
from runtime.integrate.wiring import wire
from runtime.machine_facade import Machine
from runtime.mechanism.system import Tangents
from tests.codegen.directions import assembled, by_complex_step, dependent
from tests.codegen.workbench import Interpreted

STONE = (
    "from codegen import Model\n"
    "model = Model('stone')\n"
    "stone = model.body('stone', mass=model.parameter('m', 2.0, unit='kg'), inertia=1.0)\n"
    "model.force('drag', on=stone, fx=-3.0 * stone.vx - 8.0 * stone.x**3)\n"
    "model.scene('windy', effects=['drag'])\n"
    "model.scene('calm', effects=[], analysis='kinematics')\n"
)


@pytest.fixture
def stone(tmp_path: Path) -> Path:
    """A folder with a model file of one body."""
    path = tmp_path / "models" / "stone.py"
    path.parent.mkdir()
    path.write_text(STONE)
    return tmp_path


def slope(tangents: Tangents, machine: Machine, x: float) -> float:
    """∂v̇x/∂x of the stone at x."""
    q, v, dq, dv, da = (np.zeros(3) for _ in range(5))
    q[0], dq[0] = x, 1.0
    p, modes = machine.parameter_values(), np.zeros(0, dtype=np.int64)
    assert tangents.accelerations_tangent(0.0, q, v, p, modes, dq, dv, da) is None
    return float(da[0])


# What they compute


@pytest.fixture(scope="module", params=["slider_crank compressor", "valve_lifter free_follower"])
def pair(root: Path, request: pytest.FixtureRequest) -> tuple[Machine, Interpreted]:
    """A machine of the library in machine code, and interpreted."""
    name, scene = request.param.split()
    path = root / "models" / f"{name}.py"
    return load(path, scene), Interpreted(read_model(path).model, scene)


def test_compiled_derivatives_are_those_of_the_complex_step(
    pair: tuple[Machine, Interpreted],
) -> None:
    machine, same = pair
    n, p, random = same.n, machine.parameter_values(), np.random.default_rng(7)
    for seed in range(4):
        s = assembled(same, seed)
        modes = random.integers(0, 2, same.s)
        w = random.uniform(0.5, 2.0, n)
        dq, dv = random.standard_normal((2, n))
        da, out_q, out_v = np.full((3, n), np.nan)
        state = (s.t, s.q, s.v, p)
        machine.mechanism.tangents.accelerations_tangent(*state, modes, dq, dv, da)
        (exact,) = by_complex_step(same, "accelerations", ("a",), s, dq, dv, modes=modes)
        assert_allclose(da, exact, rtol=1e-11, atol=1e-11 * np.abs(exact).max())
        machine.mechanism.tangents.correction_tangent(*state, w, dq, dv, out_q, out_v)
        expected = by_complex_step(same, "correction", ("dq", "dv"), s, dq, dv, w=w)
        for got, exact in zip((out_q, out_v), expected, strict=True):
            assert_allclose(got, exact, rtol=1e-11, atol=1e-11 * np.abs(exact).max())


def test_independent_coordinates_carry_the_dependent_ones(
    pair: tuple[Machine, Interpreted],
) -> None:
    """The motion along a column of H keeps Φ and, with its velocities, Φ_q q̇ to second order."""
    machine, same = pair
    n, p, kernels = same.n, machine.parameter_values(), machine.kernels
    s = assembled(same, 2)
    told, nothing, w = machine.description, np.zeros(n), np.zeros(n)
    w[dependent(same, s)] = 1.0

    def gaps(step: float) -> tuple[float, float]:
        worst = np.zeros(2)
        for k in np.flatnonzero(w == 0.0):
            column, dv, unused = np.zeros((3, n))
            unit = np.eye(n)[k]
            state = (s.t, s.q, s.v, p)
            machine.mechanism.tangents.correction_tangent(*state, w, unit, nothing, column, unused)
            column += unit
            machine.mechanism.tangents.correction_tangent(*state, w, column, nothing, unused, dv)
            phi, rates, values = np.zeros(same.m), np.zeros(same.m), np.zeros(same.m * n)
            q, v = s.q + step * column, s.v + step * dv
            kernels.constraints(s.t, q, p, phi)
            kernels.velocity_rhs(s.t, q, p, rates)
            kernels.jacobian(s.t, q, p, values)
            for i, j, entry in zip(told.jacobian_rows, told.jacobian_columns, values, strict=False):
                rates[i] -= entry * v[j]
            worst = np.maximum(worst, [np.abs(phi).max(), np.abs(rates).max()])
        return float(worst[0]), float(worst[1])

    coarse, fine = gaps(1e-3), gaps(1e-4)
    for one, other in zip(coarse, fine, strict=True):
        assert other < max(one / 50.0, 1e-12)  # a wrong column's would fall by 10; rounding


def test_compiled_loops_take_them_out_of_the_table_of_a_run(stone: Path) -> None:
    machine = load("stone", folder=stone)
    system = replace(machine.mechanism.system, **machine.mechanism.tangents._asdict())
    run = wire(system, "dopri5", machine.parameter_values(), 1)

    @compiled(types.none(ADDRESSES, types.int64[::1], types.float64[:, ::1], types.float64[::1]))
    def call(table, modes, rows, p):
        q, v, w, dq, da = rows[0], rows[1], rows[2], rows[3], rows[4]
        accelerations_tangent_of(table)(0.0, q, v, p, modes, dq, v, da)
        correction_tangent_of(table)(0.0, q, v, p, w, dq, v, rows[5], rows[6])

    rows = np.full((7, 3), np.nan)
    rows[:4] = 0.0
    rows[0, 0], rows[3, 0] = 0.5, 1.0
    call(run.table, np.zeros(0, dtype=np.int64), rows, machine.parameter_values())
    assert rows[4, 0] == slope(machine.mechanism.tangents, machine, 0.5) == -24.0 * 0.5**2 / 2.0
    assert not rows[5:].any()  # nothing constrains the stone


# When their file is trusted


def test_built_when_first_asked_for(stone: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    machine = load("stone", folder=stone)
    path = companion_path(machine.path, "tangents")
    assert not path.exists()
    tangents = machine.mechanism.tangents
    assert path.is_file()
    assert slope(tangents, machine, 2.0) == -48.0
    assert machine.mechanism.tangents is tangents

    def refuse(*_: object, **__: object) -> None:
        raise AssertionError("built again")

    monkeypatch.setattr(codegen, "build", refuse, raising=False)
    again = load("stone", folder=stone).mechanism.tangents
    assert again.accelerations_tangent is tangents.accelerations_tangent


def test_stale_ones_are_built_anew(stone: Path) -> None:
    old = load("stone", folder=stone)
    assert slope(old.mechanism.tangents, old, 1.0) == -12.0
    model = stone / "models" / "stone.py"
    path = companion_path(old.path, "tangents")
    before = path.read_bytes()
    codegen.build(model, out=old.path.parent, compile=False)
    assert path.read_bytes() == before
    model.write_text(STONE.replace("8.0", "16.0"))
    machine = load("stone", folder=stone)
    assert slope(machine.mechanism.tangents, machine, 1.0) == -24.0
    path.write_bytes(before)  # sound in itself, but of the other model
    machine = load("stone", folder=stone)
    assert slope(machine.mechanism.tangents, machine, 1.0) == -24.0


def test_machine_that_is_no_longer_its_model_says_so(stone: Path) -> None:
    machine = load("stone", folder=stone)
    model = stone / "models" / "stone.py"
    model.write_text(STONE.replace("8.0", "16.0"))
    with pytest.raises(SupersededError, match=r"scene 'windy' was loaded.*Load the machine again"):
        _ = machine.mechanism.tangents
    fresh = load("stone", folder=stone)
    assert slope(fresh.mechanism.tangents, fresh, 1.0) == -24.0


def test_edited_file_is_refused_with_the_way_out(stone: Path) -> None:
    machine = load("stone", folder=stone)
    source = stone / "models" / "stone.py"
    codegen.build(source, "windy", machine.path.parent, tangents=True, compile=False)
    path = companion_path(machine.path, "tangents")
    path.write_text(path.read_text() + "# by hand\n")
    with pytest.raises(GeneratedFileError, match="edited by hand") as caught:
        _ = machine.mechanism.tangents
    command = f"{stone / 'models' / 'stone.py'} --scene windy --out {path.parent} --tangents"
    assert f"linkwright build {command}" in str(caught.value)


def test_model_of_the_running_program(tmp_path: Path) -> None:
    model = codegen.Model("swing")
    bob = model.body("bob", mass=2.0, inertia=1.0)
    model.force("spring", on=bob, fx=-3.0 * bob.x)
    machine = load(model, folder=tmp_path)
    assert slope(machine.mechanism.tangents, machine, 1.0) == -1.5
    model.force("wind", on=bob, fy=1.0)
    later = load(model, folder=tmp_path)
    assert slope(later.mechanism.tangents, later, 1.0) == -1.5


def test_kinematic_scene_has_none(stone: Path) -> None:
    machine = load("stone", "calm", folder=stone)
    with pytest.raises(AnalysisError, match=r"stone/calm is kinematic: no masses move in it"):
        _ = machine.mechanism.tangents


def test_machine_without_its_model_has_none(stone: Path) -> None:
    loaded = load("stone", folder=stone)
    bare = Machine(replace(loaded.mechanism, origin=None))
    with pytest.raises(AnalysisError, match=r"stone/windy was put together without its model"):
        _ = bare.mechanism.tangents
