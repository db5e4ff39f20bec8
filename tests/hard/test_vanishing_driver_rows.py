"""Drivers whose slope vanishes on the way: the motion goes on smoothly, or ends by name."""

import numpy as np
import pytest
import sympy as sp

import linkwright as lw
from linkwright import AnalysisError, Machine, Model, Outcome
from runtime.singularity.scaled_constraints import SHORTEST, ScaledConstraints


@pytest.fixture(scope="module")
def hinges(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Machine]:
    """A hinge in the plane and one in space; sin of the angle is driven as sin 2t: φ = 2t."""
    plane = Model("plane", gravity=(0, -9.81))
    bar = plane.body("a", 2.0, 0.2)
    plane.revolute("A", plane.ground.at(0, 0), bar.at(-0.4, 0))
    space = Model("space", space=True, gravity=(0, 0, -9.81))
    block = space.body("a", 2.0, (0.1, 0.2, 0.3), at=(0.4, 0, 0))
    space.revolute("A", space.ground, block, at=(0, 0, 0), axis=(0, 1, 0))
    for model, sine in ((plane, sp.sin(bar.phi)), (space, block.A[0, 2])):
        model.driver("d", sine, sp.sin(2 * lw.t))
        model.driver("e", sine, sp.Rational(6, 5) * lw.t)
        model.scene("turn", ["gravity"], drivers=["d"])
        model.scene("lock", ["gravity"], drivers=["e"])
    folder = tmp_path_factory.mktemp("hinges")
    return {
        f"{model.name} {scene}": lw.load(model, scene, folder=folder)
        for model in (plane, space)
        for scene in ("turn", "lock")
    }


@pytest.mark.parametrize(("kind", "speed"), [("plane", "a.omega"), ("space", "a.omega_y")])
def test_motion_is_continuous_at_any_number_of_instants(
    hinges: dict[str, Machine], kind: str, speed: str
) -> None:
    machine = hinges[f"{kind} turn"]
    for end, count in [(2.0, 21), (2.0, 51), (2.0, 401), (6.0, 29), (6.0, 85), (6.0, 401)]:
        run = machine.kinematics(end, count, progress=False)
        assert run.outcome is Outcome.OK, count
        assert run[speed] == pytest.approx(2.0, abs=1e-8)
        passed = [row.time for row in run.singular]
        expected = np.arange(np.pi / 4, end, np.pi / 2)
        assert passed == pytest.approx(expected, abs=1e-9)
    run = machine.inverse_dynamics(2.0, 51, progress=False)
    assert run[speed] == pytest.approx(2.0, abs=1e-8)


@pytest.mark.parametrize("kind", ["plane", "space"])
def test_end_of_the_reach_is_a_lock_up(hinges: dict[str, Machine], kind: str) -> None:
    """The driver demands a sine of 1 at t = 5/6 s."""
    run = hinges[f"{kind} lock"].kinematics(2.0, 51, progress=False)
    assert run.outcome is Outcome.LOCKED
    assert run.t[-1] == pytest.approx(5 / 6, abs=1e-9)
    assert "driver e asks for what the machine cannot reach" in run.message


def test_simulation_names_no_kink(hinges: dict[str, Machine]) -> None:
    """A row that vanishes turns about without a jump."""
    run = hinges["space turn"].simulate(2.0, 51, progress=False)
    assert run.outcome is not Outcome.DISCONTINUOUS
    assert "slope jumps" not in run.message
    assert run["a.omega_y"] == pytest.approx(2.0, abs=1e-3)


@pytest.fixture(scope="module")
def cosines(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Machine]:
    """Hinges whose angle is ψ = off + w t beyond where the driver's row vanishes, by cos ψ."""
    plane = Model("plane", gravity=(0, -9.81))
    bar = plane.body("a", 2.0, 0.2)
    plane.revolute("A", plane.ground.at(0, 0), bar.at(-0.4, 0))
    space = Model("space", space=True, gravity=(0, 0, -9.81))
    block = space.body("a", 2.0, (0.1, 0.2, 0.3), at=(0.4, 0, 0))
    space.revolute("A", space.ground, block, at=(0, 0, 0), axis=(0, 1, 0))
    crank = Model("crank", space=True, gravity=(0, 0, -9.81))
    arm = crank.body("a", 2.0, (0.1, 0.2, 0.3), at=(0.4, 0, 0))
    crank.revolute("A", crank.ground, arm, at=(0, 0, 0), axis=(0, 1, 0))
    laws = []
    for model in (plane, space, crank):
        psi = model.parameter("off", 0.0, "rad") + model.parameter("w", 2.0, "rad/s") * lw.t
        laws.append(sp.cos(psi))
    plane.driver("d", sp.sin(bar.phi), laws[0])
    space.driver("d", block.A[0, 2], laws[1])
    crank.point_driver("d", arm.at(0.1, 0, 0), "x", laws[2] / 2)
    folder = tmp_path_factory.mktemp("cosines")
    for model in (plane, space, crank):
        model.scene("turn", ["gravity"], drivers=["d"])
    return {model.name: lw.load(model, folder=folder) for model in (plane, space, crank)}


def start_at(kind: str, off: float) -> tuple[dict[str, float], str]:
    """Start values of the position ψ = off, and the name of dψ/dt."""
    angle = off if kind == "crank" else np.pi / 2 + off
    if kind == "plane":
        return {"a.phi": angle}, "a.omega"
    return {"a.e0": np.cos(angle / 2), "a.e2": np.sin(angle / 2)}, "a.omega_y"


@pytest.mark.parametrize("w", [2.0, -2.0])
@pytest.mark.parametrize("kind", ["plane", "space", "crank"])
def test_start_beside_a_vanishing_row_goes_on_smoothly_or_is_refused(
    cosines: dict[str, Machine], kind: str, w: float
) -> None:
    """Within 1e-7 rad of it only start velocities tell the two motions ψ = off ± w t apart."""
    sizes = 10.0 ** np.arange(-8, -1)
    for off in (*-sizes, 0.0, *sizes):
        start, speed = start_at(kind, off)
        values = {"off": float(off), "w": w}
        known = start | {speed: w}
        if abs(off) < 2e-8:
            with pytest.raises(AnalysisError, match="2 motions meet"):
                cosines[kind].kinematics(2.0, 21, start=start, parameters=values)
        for given in (known, start if abs(off) > 2e-7 else known):
            run = cosines[kind].kinematics(2.0, 21, start=given, parameters=values)
            assert run.outcome is Outcome.OK, off
            assert run[speed] == pytest.approx(w, abs=1e-6), off


@pytest.mark.parametrize("kind", ["plane", "space", "crank"])
def test_instants_at_and_beside_a_vanishing_row_may_be_asked_for(
    cosines: dict[str, Machine], kind: str
) -> None:
    near = 10.0 ** np.arange(-12, -5)
    for off in (-1.0, -0.777, -0.3, -0.05, -0.003):
        there = -off / 2.0
        start, speed = start_at(kind, off)
        start, values = start | {speed: 2.0}, {"off": off}
        grid = np.linspace(0.0, 2.0, 41)
        beside = [[0.0, there + d, 2.0] for d in (*-near, 0.0, *near)]
        turns = [0.0, *(there + np.arange(4) * np.pi / 2)]
        for t in (*beside, turns, np.union1d(grid, there), [0.0, there], [0.0, there, 1.1 * there]):
            run = cosines[kind].kinematics(t, start=start, parameters=values, progress=False)
            assert run.outcome is Outcome.OK
            assert run[speed] == pytest.approx(2.0, abs=1e-6), (off, t)


@pytest.mark.parametrize("kind", ["plane", "space"])
def test_simulation_passes_a_vanishing_row_or_names_it(
    cosines: dict[str, Machine], kind: str
) -> None:
    for off in (-0.3, -1.0):
        start, speed = start_at(kind, off)
        run = cosines[kind].simulate(2.0, 21, start=start, parameters={"off": off}, progress=False)
        assert run[speed] == pytest.approx(2.0, abs=1e-6)
        if run.outcome is not Outcome.OK:
            assert kind == "space"
            assert run.outcome is Outcome.SINGULAR
            assert run.t[-1] == pytest.approx(-off / 2.0, abs=1e-3)
            assert "driver d.motion" in run.message


def test_slopes_without_bound_say_nothing_of_the_length_of_a_row() -> None:
    def jacobian(_t: float, _q: np.ndarray, _p: np.ndarray, slopes: np.ndarray) -> None:
        slopes[:] = -np.inf, 3.0, np.nan, np.inf, 4.0

    rows, columns = np.array([0, 0, 1, 1, 1]), np.array([0, 1, 0, 1, 2])
    constraints = ScaledConstraints(
        lambda *_: None, jacobian, lambda *_: None, rows, columns, np.zeros(0), np.ones(3),
        np.arange(2), 2,
    )  # fmt: skip
    lengths = constraints.least_lengths(0.0, np.zeros(3), np.ones(3), np.array([True, True]))
    assert lengths == pytest.approx(SHORTEST * np.array([3.0, 4.0]))
