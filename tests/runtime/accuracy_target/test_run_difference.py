"""The difference of two runs: how it is scaled and grows, and when two runs are no evidence."""

import numpy as np
import pytest

from codegen.errors import AnalysisError
from runtime.accuracy_target.error_norms import group_magnitude
from runtime.accuracy_target.run_comparison import (
    Difference,
    difference,
    safe_share,
    sufficient_ratio,
    tenfold_time,
)
from runtime.accuracy_target.runs import quantities_of
from runtime.core.outcomes import Outcome
from runtime.machine_facade import Machine


def growing(error: np.ndarray, t: np.ndarray) -> Difference:
    return Difference(t, error[:, None], np.ones(1))


def test_exponential_growth_differs_from_powers_of_time() -> None:
    t = np.linspace(0.0, 10.0, 401)
    wave = 1.0 + 0.5 * np.sin(30.0 * t)
    assert tenfold_time(growing(1e-11 * 10.0 ** (t / 1.5) * wave, t)) == pytest.approx(1.5, rel=0.1)
    for power in (0, 1, 2, 3):
        assert tenfold_time(growing(1e-8 * t**power * wave, t)) is None
    assert tenfold_time(growing(np.zeros(401), t)) is None


@pytest.mark.parametrize("ratio", [0.3, 0.1, 0.01, 1e-3, 1e-5])
def test_an_error_that_scatters_by_a_factor_of_four_is_not_underestimated(ratio: float) -> None:
    """Two runs whose tolerances are near may err alike: little is concluded from them."""
    assert safe_share(ratio) >= min(1.0, 4.0 * ratio)
    assert safe_share(ratio) >= ratio**0.8
    assert safe_share(sufficient_ratio(ratio)) == pytest.approx(ratio)


def test_errors_are_scaled_by_size_and_value(thrown: Machine) -> None:
    description = thrown.description
    sizes = np.full(len(description.coordinates), 2.0)
    chosen = quantities_of(description, ("upper.x", "hinge.fx"), sizes)
    assert not chosen.are_states
    t = np.array([0.0, 1.0])
    first, second = np.array([[1.0, 8.0], [1.0, 0.0]]), np.array([[1.5, 10.0], [1.0, 0.0]])
    found = difference(t, first, second, chosen)
    np.testing.assert_allclose(found.scaled, [[0.5 / 3.5, 2.0 / 20.0], [0.0, 0.0]])
    np.testing.assert_allclose(found.scales, [2.0, 10.0])
    assert found.within(0.2) == 2
    assert found.within(0.1) == 0


def test_nan_in_one_run_only_is_a_difference(thrown: Machine) -> None:
    chosen = quantities_of(thrown.description, ("hinge.fx",), np.ones(6))
    t, nan = np.array([0.0, 1.0]), np.nan
    found = difference(t, np.array([[nan], [1.0]]), np.array([[nan], [nan]]), chosen)
    assert found.scaled[0, 0] == 0.0
    assert np.isinf(found.scaled[1, 0])


def test_an_instant_without_a_number_hides_no_other(thrown: Machine) -> None:
    """Reactions are nan at a singular position; the instants around it are compared as ever."""
    chosen = quantities_of(thrown.description, ("hinge.fx",), np.ones(6))
    t, first = np.array([0.0, 1.0, 2.0]), np.array([[8.0], [np.nan], [5.0]])
    found = difference(t, first, first + 2.0, chosen)
    np.testing.assert_allclose(found.scaled[:, 0], [0.1, 0.0, 2.0 / 17.0])
    whole = difference(t, first, first + 2.0, chosen, np.array([90.0]))
    np.testing.assert_allclose(whole.scaled[:, 0], [0.02, 0.0, 2.0 / 97.0])


def test_parts_of_a_force_are_measured_by_the_force(thrown: Machine) -> None:
    result = thrown.simulate(0.5, [0.25, 0.5], progress=False)
    most = [np.abs(result.series(f"hinge.{part}")[0]).max() for part in ("fx", "fy")]
    assert max(most) > min(most) > 0.0
    chosen = quantities_of(thrown.description, ("hinge.fx", "hinge.fy", "total"), np.ones(6))
    energies = np.abs(result.samples.energy).max()
    np.testing.assert_allclose(chosen.wholes(result), [max(most), max(most), energies])
    assert group_magnitude(result, "upper.x") == 0.0


@pytest.mark.parametrize(("method", "longest"), [("dop853", 0.01), ("dopri5", 0.003)])
def test_errors_that_the_longest_step_bounds_are_estimated_too(
    thrown: Machine, method: str, longest: float
) -> None:
    """Two runs with the same steps agree, and are off alike."""
    times = np.linspace(0.0, 8.0, 101)
    found = thrown.simulate(
        8.0, times, accuracy=0.1, max_step=longest, method=method, progress=False
    )
    exact = thrown.simulate(8.0, times, rtol=1e-13, progress=False)
    reached = found.accuracy
    assert reached.runs[1].steps > reached.runs[0].steps
    worst = max(
        (np.abs(x - y) / (row.scale + np.abs(y))).max()
        for row in reached.quantities
        for x, y in [(found.series(row.name)[0], exact.series(row.name)[0])]
    )
    assert worst / 10.0 < reached.estimated < 0.1


def test_the_result_ends_with_the_shorter_run(pendulum_point: Machine) -> None:
    """The tighter run uses up its steps before the looser one: the rest is not delivered."""
    for steps in (160, 250):
        found = pendulum_point.simulate(20.0, accuracy=1e-5, max_steps=steps, progress=False)
        checked = pendulum_point.simulate(
            20.0, rtol=found.accuracy.runs[-1].rtol, max_steps=steps, progress=False
        )
        assert checked.outcome is Outcome.MAX_STEPS
        assert found.outcome is Outcome.INACCURATE
        assert found.t[-1] <= checked.t[-1]
        assert found.accuracy.horizon == found.t[-1]
        assert "ends before (MAX_STEPS)" in found.message


def test_a_single_accurate_instant_is_kept(thrown: Machine) -> None:
    found = thrown.simulate(30.0, [10.0, 30.0], accuracy=1e-6, progress=False)
    assert found.outcome is Outcome.INACCURATE
    assert found.t.tolist() == [10.0]
    with pytest.raises(AnalysisError, match=r"first instant, t = 30 s"):
        thrown.simulate(30.0, [30.0], accuracy=1e-6, progress=False)


def test_rounding_does_not_fall_with_the_tolerance(thrown: Machine) -> None:
    reached = thrown.simulate(0.05, [0.05], accuracy=1e-10, progress=False).accuracy
    assert 0.0 < reached.estimated < 2e-13
    assert reached.estimated == reached.runs[-1].difference
