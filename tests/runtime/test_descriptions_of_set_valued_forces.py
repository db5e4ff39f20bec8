"""What a machine says of its frictions and contacts, and the folders in the names of models."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from codegen.files.library_folders import find_model_file
from runtime import load
from runtime.machine_facade import Machine


def full(machine: Machine) -> np.ndarray:
    """The declared parameters with the constants behind them."""
    told = machine.description
    p = np.zeros(len(told.parameters) + len(told.constants))
    p[: len(told.parameters)] = [row.default for row in told.parameters]
    machine.kernels.constants(p)
    return p


def test_contact_is_described_with_its_switch(root: Path, tmp_path: Path) -> None:
    machine = load("hard/bouncing_ball", folder=tmp_path)
    assert machine.path.parent == root / "generated"
    told = machine.description
    assert told.switches["plate"].kind == "contact"
    assert told.rigid["plate"].switch == told.switches.index("plate")
    p = full(machine)
    out = np.full((3, 1), np.nan)
    machine.kernels.restitution(p, out[0])
    machine.kernels.contact_scale(p, out[1])
    machine.kernels.gap_accelerations(
        0.0, np.zeros(2), np.zeros(2), np.array([1.0, -3.0]), p, out[2]
    )
    assert_allclose(out[:, 0], [0.5, 0.4 * 9.81, -3.0])
    reaction = np.full(1, np.nan)
    for mode, force in ((0, 0.4 * 9.81), (1, 0.0)):
        machine.kernels.switched_reactions(
            0.0, np.zeros(2), np.zeros(2), p, np.array([mode]), np.zeros(0), reaction
        )
        assert_allclose(reaction, force)


def test_flight_reports_no_reaction(tmp_path: Path) -> None:
    run = load("hard/bouncing_ball", folder=tmp_path).simulate(0.4, [0.0, 0.2, 0.4], rtol=1e-10)
    assert_allclose(run.q("ball.y"), 1.1 - 9.81 / 2 * run.t**2, rtol=1e-12)
    assert_allclose(run.reaction("plate", "force"), 0.0)


def test_sliding_block_reports_its_friction(tmp_path: Path) -> None:
    """Against its belt, where the friction is that of mode 1."""
    machine = load("hard/belt_block", folder=tmp_path)
    assert machine.description.switches["belt"].kind == "friction"
    run = machine.simulate(0.02, [0.0, 0.02], parameters={"speed": -0.1}, rtol=1e-10)
    assert_allclose(run.reaction("belt", "force"), -0.2 * 9.81, rtol=1e-12)
    assert_allclose(run.data["power"].sel(source="belt"), -0.2 * 9.81 * run.v("block.x"))


def test_bounds_of_static_friction_follow_its_parameters(tmp_path: Path) -> None:
    machine = load("hard/belt_block", folder=tmp_path)
    low, high = np.full(1, np.nan), np.full(1, np.nan)
    machine.kernels.holds(full(machine), low, high)
    assert_allclose([low[0], high[0]], [-0.25, 1.25])


def test_machine_without_any_has_plain_bounds_and_no_contact(pendulum: Machine) -> None:
    low, high, out = np.full(2, np.nan), np.full(2, np.nan), np.full(2, 7.0)
    kernels = pendulum.kernels
    kernels.holds(np.zeros(1), low, high)
    assert_allclose([low, high], [[0, 0], [1, 1]])
    kernels.restitution(np.zeros(1), out)
    kernels.contact_scale(np.zeros(1), out)
    kernels.gap_accelerations(0.0, *[np.zeros(1)] * 4, out)
    kernels.switched_reactions(0.0, *[np.zeros(1)] * 3, np.zeros(1, np.int64), np.zeros(1), out)
    assert_allclose(out, 7.0)
    assert pendulum.description.rigid == ()
    assert {row.kind for row in pendulum.description.switches} <= {"condition"}


def test_names_with_folders_are_models_and_bare_names_stay(
    root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert find_model_file("hard/belt_block") == root / "models" / "hard" / "belt_block.py"
    assert find_model_file("slider_crank") == root / "models" / "slider_crank.py"
    own = tmp_path / "models" / "hard" / "belt_block.py"
    own.parent.mkdir(parents=True)
    own.write_text("from codegen import Model\nmodel = Model('mine')\n")
    assert find_model_file("hard/belt_block") == own
