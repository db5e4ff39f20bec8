"""The tightest tolerance, where rounding rules, and the loosest, where only stability does."""

import numpy as np
import pytest

from models.hard.cases import find
from models.hard.suite.cell import Cell, Setting, Verdict, evaluate
from runtime import Outcome, Result
from tests.runtime.integrate.systems import relay, run_relay


def simulated(name: str, setting: Setting, rtol: float, most: int) -> tuple[Result, Cell]:
    """The run of a case in at most so many steps, and what is to be thought of it."""
    case = find(name)
    result = case.machine().simulate(
        case.t_end,
        case.instants(),
        method=setting.method,
        correction=setting.correction,
        rtol=rtol,
        parameters=dict(case.parameters),
        start=dict(case.start),
        max_steps=most,
        progress=False,
    )
    cell = evaluate(case, setting, rtol, result, 0.0)
    assert cell.verdict is Verdict.CORRECT, f"{cell.verdict}: {cell.note}"
    return result, cell


@pytest.mark.parametrize("name", ["ball_shaken", "follower_thrown"])
def test_bdf_follows_what_is_held_on_a_moving_surface(name: str) -> None:
    """A return to the surface by the last digit is no change for the past to be smooth in.

    From one tolerance to the next the steps grow by 10^(3/6) = 3.2; twice that is allowed.
    """
    setting = Setting("bdf", "step")
    coarse, _ = simulated(name, setting, 1e-9, 10_000)
    _, cell = simulated(name, setting, 1e-12, 30_000)
    assert cell.steps < 6.4 * coarse.stats["steps"]
    assert cell.rejected < 0.1 * cell.steps


@pytest.mark.parametrize("name", ["mass_ratio_light", "mass_ratio_even", "mass_ratio_heavy"])
@pytest.mark.parametrize("rtol", [1e-9, 1e-12])
def test_what_baumgarte_leaves_alone_is_the_same_whatever_the_masses(
    name: str, rtol: float
) -> None:
    """A drift of 1e4 roundings of a length of 3 m is pulled at, beside 1e8 kg as beside 1e-8 kg."""
    _, cell = simulated(name, Setting("dop853", "baumgarte"), rtol, 20_000)
    assert cell.residual < 1e-11
    assert cell.rejected < 0.01 * cell.steps


def test_a_stiff_spring_stays_asleep_at_a_loose_tolerance() -> None:
    """Its 5000 Hz are beyond what the error sees, but within what the method damps."""
    result, cell = simulated("stiff_soft", Setting("dopri5", "step"), 1e-3, 500_000)
    assert cell.error < 1e-10
    assert np.abs(result.q("first.x") - 1.0).max() < 1e-6
    assert cell.drift < 1e-3
    assert cell.rejected < 0.001 * cell.steps


@pytest.mark.parametrize("method", ["dopri5", "tsit5"])
@pytest.mark.parametrize("rtol", [1e-1, 1e-2, 1e-3])
@pytest.mark.parametrize("damping", [0.0, 1e-3, 2e-2])
def test_no_vibration_grows_at_any_tolerance(damping: float, rtol: float, method: str) -> None:
    """A thousand swings, of which the first may grow by a tenth before the steps are shortened.

    Accuracy alone permits steps of 1.5 rad at 1e-2, and 40 000 times the amplitude at the end.
    """
    swinging = relay(stiffness=1e4, damping=2.0 * damping * 100.0)
    run = run_relay(swinging, 1.0, 0.0, 60.0, method=method, rtol=rtol, tolerance=rtol)
    assert run.outcome is Outcome.OK
    largest = np.abs(run.q[:, 0])
    assert largest.max() < 1.15
    if method == "dopri5":  # tsit5 permits so slow a growth that the tenth is reached at the end
        assert largest[-100:].max() <= 1.01 * largest[50:150].max()


@pytest.mark.parametrize("method", ["dopri5", "tsit5"])
@pytest.mark.parametrize("rtol", [1e-2, 1e-3])
def test_many_vibrations_together_do_not_grow_either(rtol: float, method: str) -> None:
    """Twenty masses for a hundred seconds, in steps near the edge for the fastest.

    By accuracy alone the energy becomes 1e7 times as large at 1e-2, and 3000 times at 1e-3.
    """
    case = find("spring_chain")
    result = case.machine().simulate(100.0, method=method, rtol=rtol, progress=False)
    energy = result.energy()
    assert result.outcome is Outcome.OK
    assert energy.max() < 1.3 * energy[0]


@pytest.mark.parametrize("method", ["dopri5", "tsit5"])
def test_what_is_damped_steps_as_far_as_its_damping_permits(method: str) -> None:
    """On the real axis, and far from the imaginary one, the method's own error is enough."""
    damped = relay(constant=1e6, stiffness=1e6, damping=1000.0)
    run = run_relay(damped, 0.0, 0.0, 5.0, method=method, rtol=1e-2, tolerance=1e-2)
    assert run.outcome is Outcome.OK
    assert abs(run.q[-1, 0] - 1.0) < 0.02
    # Of 1000 rad/s; a vibration without damping would have to be stepped by less than one radian.
    early = run.t < 0.03
    assert 1000.0 * np.diff(run.t[early]).max() > 2.0
