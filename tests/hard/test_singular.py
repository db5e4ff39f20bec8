"""Four-bars in a row through their level positions, where constraints cease to be independent.

On the branch of continuous velocity all cranks stay parallel, and the machine is one pendulum that
turns over: its angle is known in closed form, and from a reference that is not ours.
"""

import re

import numpy as np
import pytest

from models.hard.cases import find
from models.hard.suite.case import ROOT, table
from models.hard.suite.linkages import crank_angle, crank_growth, equal_rods_angle
from runtime import Machine, Outcome, Result, load
from runtime.integrate.method import EXPLICIT
from tests.hard.start_values import start_and_guess
from tests.runtime.integrate.systems import ACCURATE


@pytest.fixture(scope="module")
def machines() -> dict[int, Machine]:
    """Rows of one loop and of two."""
    return {loops: find(f"n_four_bar_{loops}").machine() for loops in (1, 2)}


@pytest.fixture(scope="module")
def five_bar() -> Machine:
    return load("hard/five_bar", "fall", folder=ROOT)


def level(loops: int, omega: float) -> dict[str, float]:
    """The row with all bars in a line, the cranks turning at `omega`."""
    state = {}
    for k in range(loops + 1):
        name = f"crank_{k}"
        state |= {f"{name}.x": k + 0.5, f"{name}.y": 0.0, f"{name}.phi": 0.0}
        state |= {f"{name}.vx": 0.0, f"{name}.vy": omega / 2, f"{name}.omega": omega}
    for k in range(1, loops + 1):
        name = f"coupler_{k}"
        state |= {f"{name}.x": k + 0.5, f"{name}.y": 0.0, f"{name}.phi": 0.0}
        state |= {f"{name}.vx": 0.0, f"{name}.vy": omega, f"{name}.omega": 0.0}
    return state


def level_positions(loops: int) -> int:
    """How often the bars are in a line within 20 s."""
    turned = np.pi / 2 - crank_angle(loops, np.array([20.0]))[0]
    return int(np.floor(turned / np.pi + 0.5))


def assert_parallel(run: Result, loops: int) -> None:
    """Every loop is a parallelogram at every sample, before and behind every crossing."""
    assert run.outcome is Outcome.OK, run.message
    for k in range(1, loops + 1):
        np.testing.assert_allclose(run.q(f"coupler_{k}.phi"), 0.0, atol=1e-9)
        np.testing.assert_allclose(run.q(f"crank_{k}.phi"), run.q("crank_0.phi"), atol=1e-9)
    assert run.samples.residual[:, 0].max() < 1e-10


def drift(run: Result) -> float:
    """Change of the energy over the largest kinetic energy."""
    return float(np.ptp(run.energy()) / run.energy("kinetic").max())


def upper_joint(run: Result) -> np.ndarray:
    """B0, shape (k, 2)."""
    angle = run.q("crank_0.phi")
    return np.column_stack([np.cos(angle), np.sin(angle)])


def test_the_closed_form_is_the_reference() -> None:
    """The reference was integrated by others; its ten loops too."""
    for loops in (2, 10):
        rows = table(f"n_four_bar_{loops}.csv")
        np.testing.assert_allclose(
            crank_angle(loops, rows[:, 0]), np.pi / 2 - rows[:, 1], atol=1e-13
        )
        assert level_positions(loops) == 20


@pytest.mark.parametrize("loops", [1, 2])
@pytest.mark.parametrize("method", ACCURATE)
@pytest.mark.parametrize(("rtol", "near", "kept"), [(1e-3, 8.0, 0.1), (1e-6, 1e-2, 1e-4)])
def test_loose_tolerances_stay_on_the_branch(
    machines: dict[int, Machine], loops: int, method: str, rtol: float, near: float, kept: float
) -> None:
    """An error of the energy grows 2000-fold in 20 s; 1e-3 is beyond the horizon by then."""
    times = np.linspace(0.0, 20.0, 401)
    run = machines[loops].simulate(20.0, times, method=method, rtol=rtol, progress=False)
    assert_parallel(run, loops)
    assert np.abs(run.q("crank_0.phi") - crank_angle(loops, times)).max() < near
    assert drift(run) < kept


@pytest.mark.parametrize("loops", [1, 2])
@pytest.mark.parametrize("method", ACCURATE)
def test_twenty_crossings_to_the_bar(machines: dict[int, Machine], loops: int, method: str) -> None:
    rows = table("n_four_bar_2.csv")
    run = machines[loops].simulate(20.0, rows[:, 0], method=method, rtol=1e-10, progress=False)
    assert_parallel(run, loops)
    assert run.stats["singular_crossings"] == level_positions(loops)
    assert "on the branch on which the velocity is continuous" in run.message
    assert drift(run) < 1e-8
    if loops == 2:
        assert np.abs(upper_joint(run) - rows[:, 3:5]).max() < 1e-7
    # What one step of the whole error would have become by then.
    off = np.abs(run.q("crank_0.phi") - crank_angle(loops, rows[:, 0]))
    assert (off < 2e-10 * crank_growth(loops, rows[:, 0])).all()
    # The steps across are like others: nothing collapses, hardly one is tried in vain.
    assert run.stats["rejected"] < 0.1 * run.stats["steps"]


@pytest.mark.parametrize("method", ["bdf", "radau5", "auto"])
@pytest.mark.parametrize(("rtol", "near"), [(1e-6, 1e-2), (1e-9, 1e-5)])
def test_implicit_methods_cross(
    machines: dict[int, Machine], method: str, rtol: float, near: float
) -> None:
    """The explicit method leads them across; behind a crossing they go on themselves."""
    times = np.linspace(0.0, 20.0, 101)
    run = machines[2].simulate(20.0, times, method=method, rtol=rtol, progress=False)
    assert_parallel(run, 2)
    assert np.abs(run.q("crank_0.phi") - crank_angle(2, times)).max() < near
    if method != "auto":
        assert run.stats["singular_crossings"] == 20
        assert run.stats["factorizations"] > 200


@pytest.mark.parametrize("loops", [1, 2])
@pytest.mark.parametrize("omega", [-2.0, 7.0])
@pytest.mark.parametrize("method", [*EXPLICIT, "bdf"])
def test_a_start_in_the_level_position(
    machines: dict[int, Machine], loops: int, omega: float, method: str
) -> None:
    machine = machines[loops]
    start = machine.assemble(**start_and_guess(machine, level(loops, omega)))
    assert len(start.singular) == loops
    assert start.redundant == ()
    run = machine.simulate(
        1.0, np.linspace(0.0, 1.0, 21), start=start, method=method, rtol=1e-9, progress=False
    )
    assert_parallel(run, loops)
    assert drift(run) < 1e-7


def test_a_start_that_is_on_no_branch_ends_by_name(machines: dict[int, Machine]) -> None:
    """Level, with the first crank alone turning: between the branches."""
    begin = start_and_guess(machines[2], level(2, 0.0) | {"crank_0.omega": -1.0})
    run = machines[2].simulate(1.0, **begin, progress=False)
    assert run.outcome is Outcome.SINGULAR
    assert "its velocity is off them by" in run.message
    assert run.site.startswith("prepare_start: start velocity off every branch")


@pytest.mark.parametrize("excess", [0.0, 1e-3, -1e-3])
@pytest.mark.parametrize("method", [*EXPLICIT, "radau5"])
def test_five_bars_against_the_reference(five_bar: Machine, excess: float, method: str) -> None:
    """With the last crank too long or too short the second loop misses the position, and bends."""
    if excess == 0.0:
        times = np.linspace(0.0, 10.0, 21)
        exact = np.repeat(crank_angle(2, times)[:, None], 3, axis=1)
    else:
        rows = table(f"five_bar_{'longer' if excess > 0.0 else 'shorter'}.csv")
        times, exact = rows[:, 0], rows[:, 1:4]
    run = five_bar.simulate(
        10.0, times, method=method, rtol=1e-10, parameters={"excess": excess}, progress=False
    )
    assert run.outcome is Outcome.OK, run.message
    angles = np.column_stack([run.q(f"crank_{k}.phi") for k in range(3)])
    assert np.abs(angles - exact).max() < 1e-6
    assert drift(run) < 1e-8
    assert run.samples.residual[:, 0].max() < 1e-10
    # What is met is counted, what is missed is not.
    met = {0.0: 10, 1e-3: 5, -1e-3: 0}
    assert run.stats["singular_crossings"] == met[excess]


def test_a_miss_below_rounding_names_the_tolerance_that_would_do() -> None:
    machine = load("hard/equal_rods", "spin", folder=ROOT)
    longer = {"rod_length": 1.0 + 1e-10}
    run = machine.simulate(1.0, parameters=longer, rtol=1e-8, progress=False)
    assert run.outcome is Outcome.SINGULAR
    advice = re.search(
        r"; loosen rtol to about (\S+), or make the lengths agree exactly\.$", run.message
    )
    assert advice is not None, run.message
    assert "Remove the constraint" not in run.message
    assert run.site.startswith("_follow_miss: a bend too narrow for the tolerance, of ")
    wider = machine.simulate(1.0, parameters=longer, rtol=float(advice[1]), progress=False)
    assert wider.outcome is Outcome.OK, wider.message
    assert wider.site == ""


def test_a_driven_simulation_that_locks_up_points_to_kinematics() -> None:
    machine = load("hard/equal_rods", "driven", folder=ROOT)
    run = machine.simulate(1.0, parameters={"rod_length": 0.99}, progress=False)
    assert run.outcome is Outcome.SINGULAR
    assert "A driver may ask for more than the joints permit" in run.message
    assert "`kinematics` names the lock-up" in run.message


def test_equal_rods_pass_upright() -> None:
    """Crank and rod as long as each other: the slider goes on through the crank's bearing."""
    machine = load("hard/equal_rods", "spin", folder=ROOT)
    times = np.linspace(0.0, 10.0, 21)
    run = machine.simulate(10.0, times, rtol=1e-10, progress=False)
    assert run.outcome is Outcome.OK, run.message
    np.testing.assert_allclose(run.q("crank.phi"), equal_rods_angle(times), rtol=0, atol=1e-8)
    np.testing.assert_allclose(run.q("slider.x"), 2 * np.cos(run.q("crank.phi")), atol=1e-9)
    assert run.stats["singular_crossings"] >= 5
