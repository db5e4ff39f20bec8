"""Implicit methods on machines of the library: tolerances kept, and what stiffness costs."""

from dataclasses import dataclass
from math import pi
from pathlib import Path

import numpy as np
import pytest

from runtime import Machine, Result, load
from runtime.analyses.equations import Equations
from runtime.analyses.magnitudes import magnitudes

PENDULUM = (
    "from codegen import Model\n"
    "model = Model('long_pendulum', gravity=(0, -9.81))\n"
    "bob = model.body('bob', mass=1.0, inertia=0.01)\n"
    "model.revolute('hinge', model.ground.at(0, 0), bob.at(-1.0, 0))\n"
    "model.scene('swing', effects=['gravity'], start={bob.phi: 0.0, bob.omega: 0.0})\n"
)
DECADES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


@dataclass
class Run:
    """A machine with a motion, and the same motion with ten times tighter a tolerance than any."""

    machine: Machine
    t_end: float
    parameters: dict[str, float]

    def __post_init__(self) -> None:
        self.exact = self.simulate("dop853", 2e-14)
        first = self.exact.samples.q[0]
        sizes = magnitudes(Equations(self.machine, self.machine.parameter_values()), 0.0, first)
        both = np.broadcast_to(sizes, (2, len(first)))
        self.scale = np.hstack(
            [
                np.minimum(1.0, size) + np.abs(values).max(axis=0)
                for size, values in zip(
                    both, (self.exact.samples.q, self.exact.samples.v), strict=True
                )
            ]
        )

    def simulate(self, method: str, rtol: float) -> Result:
        return self.machine.simulate(
            self.t_end, [0.0, self.t_end], method=method, rtol=rtol, parameters=self.parameters
        )

    def error(self, result: Result) -> float:
        """At the end, over the size of each coordinate and velocity: root mean square."""
        here, there = (np.hstack([r.samples.q[-1], r.samples.v[-1]]) for r in (result, self.exact))
        return float(np.sqrt(np.mean(((here - there) / self.scale) ** 2)))


RUNS = {
    "pendulum": ("", "swing", 10.0, {}),
    "slider_crank": ("slider_crank", "compressor", 0.5, {"gas_scale": 0.0}),
    "quick_return": ("quick_return", "shaper", 1.0, {}),
    "four_bar": ("four_bar", "constant_torque", 1.0, {}),
    "coil_spring": ("coil_spring", "surge", 3.0, {}),
}


@pytest.fixture(scope="module", params=sorted(RUNS))
def run(request: pytest.FixtureRequest, root: Path, workshop: Path) -> Run:
    model, scene, t_end, parameters = RUNS[request.param]
    path = root / "models" / f"{model}.py"
    if not model:
        path = workshop / "models" / "long_pendulum.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(PENDULUM)
    return Run(load(path, scene, folder=workshop), t_end, parameters)


# At 1e-12 a multistep method of order five takes ten thousand steps, and their rounding takes part
# where dependent coordinates are recovered: it has seven decades less a half.
@pytest.mark.parametrize(("method", "rtol"), [
    *((method, rtol) for method in ("dop853", "dopri5", "radau5", "auto") for rtol in DECADES),
    *(("bdf", rtol) for rtol in (1e-4, 1e-6, 1e-8, 1e-10, 3e-12)),
])  # fmt: skip
def test_the_error_is_the_tolerance(run: Run, method: str, rtol: float) -> None:
    result = run.simulate(method, rtol)
    assert result.outcome.ok, result.message
    assert 0.01 <= run.error(result) / rtol <= 100.0 or run.error(result) < 1e-14


@pytest.fixture(scope="module")
def stiff_train(root: Path, workshop: Path) -> dict[str, Result]:
    """The valve train, its cam turned slowly, its follower pressed on by the spring.

    The contact is 1e8 N/m, and damped as much as its own vibration needs. The follower starts where
    the preload of 75 N presses it to.
    """
    machine = load(root / "models" / "valve_lifter.py", "free_follower", folder=workshop)
    parameters = {"K": 1e8, "C": 1e4, "speed": 300 * 2 * pi / 60}
    pressed = 0.0125 - 0.0025 + 0.075 - 75.0 / 1e8
    return {
        method: machine.simulate(
            0.4,
            np.linspace(0.0, 0.4, 201),
            method=method,
            rtol=1e-7,
            parameters=parameters,
            guess={"pushrod.y": pressed},
        )
        for method in ("dop853", "bdf", "radau5", "auto")
    }


@pytest.mark.parametrize("method", ["bdf", "radau5"])
def test_stiff_train_takes_a_tenth_of_the_steps(
    stiff_train: dict[str, Result], method: str
) -> None:
    explicit, implicit = stiff_train["dop853"], stiff_train[method]
    assert implicit.outcome.ok, implicit.message
    assert 10 * implicit.stats["steps"] <= explicit.stats["steps"]
    difference = implicit.samples.q - explicit.samples.q
    assert np.abs(difference).max() < 1e-6 * np.abs(explicit.samples.q[:, 1:]).max()


def test_auto_changes_over(stiff_train: dict[str, Result]) -> None:
    result, explicit = stiff_train["auto"], stiff_train["dop853"]
    assert result.stats["method_changes"] == 1
    assert "dop853 from t = 0 s, radau5 from t = " in result.message
    assert 10 * result.stats["steps"] <= explicit.stats["steps"]
    assert np.abs(result.samples.q - explicit.samples.q).max() < 1e-7


@pytest.mark.parametrize("method", ["bdf", "radau5", "auto"])
def test_events_are_those_of_explicit_methods(root: Path, workshop: Path, method: str) -> None:
    machine = load(root / "models" / "quick_return.py", "shaper", folder=workshop)
    explicit = machine.simulate(2.0, method="dop853", rtol=1e-12)
    implicit = machine.simulate(2.0, method=method, rtol=1e-9)
    assert [e.name for e in implicit.events] == [e.name for e in explicit.events]
    assert len(explicit.events) >= 8
    for ours, theirs in zip(implicit.events, explicit.events, strict=True):
        assert ours.time == pytest.approx(theirs.time, abs=1e-7)
        assert ours.direction == theirs.direction


@pytest.mark.parametrize("correction", ["stage", "projection", "baumgarte", "hybrid"])
@pytest.mark.parametrize("method", ["bdf", "radau5"])
def test_all_ways_back_onto_the_constraints(
    root: Path, workshop: Path, method: str, correction: str
) -> None:
    machine = load(root / "models" / "four_bar.py", "constant_torque", folder=workshop)
    plain = machine.simulate(0.5, [0.5], method="dop853", rtol=1e-12)
    other = machine.simulate(0.5, [0.5], method=method, rtol=1e-8, correction=correction)
    assert other.outcome.ok, other.message
    assert np.abs(other.samples.q - plain.samples.q).max() < 3e-6


def test_what_lacks_derivatives_is_refused() -> None:
    from codegen.errors import InputError
    from runtime.integrate.problem import Options
    from runtime.integrate.run import integrate
    from tests.runtime.integrate.systems import PENDULUM as WITHOUT
    from tests.runtime.integrate.systems import pendulum_problem

    with pytest.raises(InputError, match="needs the derivatives of the kernels"):
        integrate(WITHOUT, pendulum_problem(0.3, 0.0, 1.0), Options(method="radau5"))
