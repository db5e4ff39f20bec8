"""Implicit methods on machines of the library: tolerances kept, and what stiffness costs."""

from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
import pytest

from codegen.reading.model_file import read_model
from runtime import Machine, Result, load
from runtime.core.outcomes import Outcome
from runtime.integrate.method import IMPLICIT
from runtime.mechanism.dense_equations import Equations, magnitudes
from tests.runtime.integrate.systems import ACCURATE_IMPLICIT
from tests.runtime.mechanisms import write_whole

DECADES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


@dataclass
class Run:
    """A machine with a motion, and the same motion with a tighter tolerance than any."""

    machine: Machine
    t_end: float

    def __post_init__(self) -> None:
        self.instants = np.linspace(0.0, self.t_end, 21)
        self.exact = both(self.simulate("dop853", 2e-14))
        first = self.exact[0, : self.exact.shape[1] // 2]
        sizes = magnitudes(
            Equations(self.machine.mechanism, self.machine.parameter_values()), 0.0, first
        )
        sizes = np.broadcast_to(sizes, (2, first.size)).ravel()
        self.scale = np.minimum(1.0, sizes) + np.abs(self.exact).max(axis=0)

    def simulate(self, method: str, rtol: float) -> Result:
        result = self.machine.simulate(
            self.t_end, self.instants, method=method, rtol=rtol, progress=False
        )
        assert result.outcome == Outcome.OK, result.message
        return result

    def error(self, result: Result) -> float:
        """The largest at any sample; root mean square, over the size of each coordinate."""
        parts = (both(result) - self.exact) / self.scale
        return float(np.sqrt(np.mean(parts**2, axis=1)).max())


def both(result: Result) -> np.ndarray:
    return np.hstack([result.samples.q, result.samples.v])


RUNS = {
    "compressor without gas": ("slider_crank", "compressor", "gas", 0.5),
    "quick return": ("quick_return", "shaper", "", 1.0),
    "four-bar": ("four_bar", "constant_torque", "", 1.0),
    "coil spring": ("coil_spring", "surge", "", 3.0),
    "pendulum": ("hard/pendulum", "bar", "", 10.0),
}


@pytest.fixture(scope="module", params=sorted(RUNS))
def run(request: pytest.FixtureRequest, root: Path, workshop: Path) -> Run:
    name, scene, without, t_end = RUNS[request.param]
    path = root / "models" / f"{name}.py"
    if not without:
        return Run(load(path, scene), t_end)
    model = read_model(path).model
    return Run(load(model, model.scene(scene).without(without), folder=workshop), t_end)


@pytest.mark.parametrize("rtol", DECADES)
@pytest.mark.parametrize("method", [*ACCURATE_IMPLICIT, "dop853", "dopri5"])
def test_the_error_is_the_tolerance(run: Run, method: str, rtol: float) -> None:
    assert 0.01 <= run.error(run.simulate(method, rtol)) / rtol <= 100.0


DRIVEN = """
from codegen import Model, t

model = Model("idle", gravity=(0, -9.81))
crank = model.body("crank", mass=1.0, inertia=0.1)
coupler = model.body("coupler", mass=1.0, inertia=1.0)
rocker = model.body("rocker", mass=1.0, inertia=1.0)
bob = model.body("bob", mass=1.0, inertia=0.01)
model.revolute("A", model.ground.at(0, 0), crank.at(-0.5, 0))
model.revolute("B", crank.at(0.5, 0), coupler.at(-1.5, 0))
model.revolute("C", coupler.at(1.5, 0), rocker.at(1.5, 0))
model.revolute("D", model.ground.at(3, 0), rocker.at(-1.5, 0))
model.driver("motor", crank.phi, 30 * t)
model.revolute("hinge", model.ground.at(0, 9), bob.at(-9.0, 0))
model.scene("idling", ["gravity"], ["motor"], start={bob.phi: -1.5, bob.omega: 0.0},
            guess={crank.x: 0.5, coupler.x: 2.0, coupler.y: 1.4, coupler.phi: 1.23,
                   rocker.x: 2.5, rocker.y: 1.4, rocker.phi: 1.9})
"""


@pytest.mark.parametrize("rtol", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("method", ["bdf", "radau5"])
def test_steps_follow_what_a_driver_moves(workshop: Path, method: str, rtol: float) -> None:
    # A slow pendulum beside a linkage that is driven fast. Nothing of the linkage is integrated;
    # with steps as long as the pendulum alone would permit it ends assembled the other way.
    path = workshop / "models" / "idle.py"
    write_whole(path, DRIVEN)
    times = np.linspace(0.0, 2.0, 997)
    result = load(path, "idling", folder=workshop).simulate(
        2.0, times, method=method, rtol=rtol, progress=False
    )
    assert result.outcome == Outcome.OK, result.message
    # C lies on the upper side of BD, 3 m from both.
    along = 3.0 - np.cos(30.0 * times) - 1j * np.sin(30.0 * times)
    arm = 0.5 * along - 1j * np.sqrt(9.0 - 0.25 * np.abs(along) ** 2) * along / np.abs(along)
    assert np.abs(np.exp(1j * result.q("rocker.phi")) + arm / 3.0).max() < 1e-12


@pytest.fixture(scope="module")
def stiff_train(root: Path) -> dict[str, Result]:
    """The valve train, its cam turned slowly, its follower pressed on by the spring.

    The contact is 1e8 N/m, and damped as much as its own vibration needs. The follower starts where
    the preload of 75 N presses it to.
    """
    machine = load(root / "models" / "valve_lifter.py", "free_follower")
    parameters = {"K": 1e8, "C": 1e4, "speed": 300 * 2 * pi / 60}
    pressed = 0.0125 - 0.0025 + 0.075 - 75.0 / 1e8
    return {
        method: machine.simulate(
            0.4,
            np.linspace(0.0, 0.4, 201),
            method=method,
            rtol=1e-7,
            parameters=parameters,
            start={"pushrod.y": pressed},
        )
        for method in ("dop853", "bdf", "radau5", "auto")
    }


@pytest.mark.parametrize("method", ["bdf", "radau5"])
def test_stiff_train_takes_a_tenth_of_the_steps(
    stiff_train: dict[str, Result], method: str
) -> None:
    explicit, implicit = stiff_train["dop853"], stiff_train[method]
    assert implicit.outcome == Outcome.OK, implicit.message
    assert 10 * implicit.stats["steps"] <= explicit.stats["steps"]
    difference = implicit.samples.q - explicit.samples.q
    assert np.abs(difference).max() < 1e-6 * np.abs(explicit.samples.q[:, 1:]).max()


def test_auto_changes_over(stiff_train: dict[str, Result]) -> None:
    result, explicit = stiff_train["auto"], stiff_train["dop853"]
    assert result.stats["method_changes"] == 1
    assert "dop853 from t = 0 s, radau5 from t = " in result.message
    assert 10 * result.stats["steps"] <= explicit.stats["steps"]
    assert np.abs(result.samples.q - explicit.samples.q).max() < 1e-7


@pytest.mark.parametrize("method", IMPLICIT)
def test_events_are_those_of_explicit_methods(root: Path, method: str) -> None:
    machine = load(root / "models" / "quick_return.py", "shaper")
    explicit = machine.simulate(2.0, method="dop853", rtol=1e-12)
    implicit = machine.simulate(2.0, method=method, rtol=1e-9)
    assert [e.name for e in implicit.events] == [e.name for e in explicit.events]
    assert len(explicit.events) >= 8
    for ours, theirs in zip(implicit.events, explicit.events, strict=True):
        assert ours.time == pytest.approx(theirs.time, abs=1e-7)
        assert ours.direction == theirs.direction


@pytest.mark.parametrize("method", ["bdf", "radau5", "dop853"])
def test_a_start_on_a_surface_costs_no_steps(root: Path, method: str) -> None:
    # The gap is zero, but for rounding of a size that nothing in the run has shown yet.
    machine = load(root / "models" / "valve_lifter.py", "free_follower")
    result = machine.simulate(0.001, method=method, rtol=1e-8, progress=False)
    assert not result.events
    assert np.diff(result.t).min() > 1e-9


@pytest.mark.parametrize("rtol", [1e-4, 1e-8])
@pytest.mark.parametrize("method", ["bdf", "radau5"])
def test_a_contact_that_lets_go_has_no_impacts(root: Path, method: str, rtol: float) -> None:
    # The gap opens with the third power of time: at first by less than the error of a step.
    machine = load(root / "models" / "hard" / "contact_follower.py", "thrown")
    exact = machine.simulate(0.05, method="dop853", rtol=1e-12, progress=False)
    result = machine.simulate(0.05, method=method, rtol=rtol, progress=False)
    assert [e.what for e in result.events] == [e.what for e in exact.events] == ["began", "impact"]
    for ours, theirs in zip(result.events, exact.events, strict=True):
        assert ours.time == pytest.approx(theirs.time, abs=rtol)


@pytest.mark.parametrize("correction", ["stage", "projection", "baumgarte", "hybrid"])
@pytest.mark.parametrize("method", ["bdf", "radau5"])
def test_all_ways_back_onto_the_constraints(root: Path, method: str, correction: str) -> None:
    machine = load(root / "models" / "four_bar.py", "constant_torque")
    plain = machine.simulate(0.5, [0.5], method="dop853", rtol=1e-12)
    other = machine.simulate(0.5, [0.5], method=method, rtol=1e-8, correction=correction)
    assert other.outcome == Outcome.OK, other.message
    assert np.abs(other.samples.q - plain.samples.q).max() < 3e-6


@pytest.mark.parametrize("method", ACCURATE_IMPLICIT)
def test_errors_fall_with_the_tolerance_where_derivatives_change(
    library: Callable[[str, str], Machine], method: str
) -> None:
    """Steps that end after one iteration see nothing of how fast Newton's method converges.

    The compressor's derivatives change along every turn, and its Newton matrices with them.
    """
    machine, instants = library("slider_crank", "compressor"), np.linspace(0.0, 2.0, 201)
    with_flywheel = {"parameters": {"J1": 900.0}, "progress": False}
    exact = both(machine.simulate(2.0, instants, rtol=1e-14, correction="stage", **with_flywheel))
    for rtol in (1e-7, 1e-9, 1e-10, 1e-11):
        result = machine.simulate(
            2.0, instants, rtol=rtol, method=method, formulation="reduced", **with_flywheel
        )
        error = np.abs(both(result) - exact) / (1.0 + np.abs(exact))
        assert error.max() < 5e3 * rtol
